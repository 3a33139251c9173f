// The streams of the HTTP server over a house of fakes: what readers get, slow ones too, and that
// streams come to an end whatever clients do.
#include "http_fixture.h"

#include "base/clock.h"
#include "protocol/exr.h"
#include "protocol/multipart.h"

#include <poll.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmocka.h>

struct parts {
    unsigned count[HTTP_TILES];
    uint64_t newest[HTTP_TILES]; // Glint-Seq
    float value[HTTP_TILES];     // of the newest's pixels
    uint64_t last;
    bool ordered;
};

static glint_status take_part(void *user, const struct glint_multipart_head *head,
                              const uint8_t *body)
{
    struct parts *p = user;
    struct glint_frame *frame;
    const uint32_t t = head->tile[0] / 64;
    assert_true(head->has_tile && t < HTTP_TILES);
    assert_int_equal(GLINT_OK, glint_exr_read(&frame, body, head->length, NULL));
    p->ordered &= head->sequence > p->last;
    p->last = p->newest[t] = head->sequence;
    p->value[t] = glint_frame_find(frame, "R")[0];
    p->count[t]++;
    glint_frame_destroy(&frame);
    return GLINT_OK;
}

// A reader of the tile stream that takes what it is told to take.
struct client {
    int fd;
    struct parts parts;
    glint_multipart_reader *reader;
    char raw[1 << 16]; // what of a chunk has come
    size_t length;
    bool headers, over;
};

static void open_stream(struct client *c, const char *id, const char *query)
{
    char request[256];
    const struct glint_multipart_params params = {.content_type = GLINT_MULTIPART_TYPE,
                                                  .max_part_bytes = 1 << 20,
                                                  .part = take_part,
                                                  .user = &c->parts};
    *c = (struct client){.fd = http_dial(), .parts.ordered = true};
    assert_int_equal(GLINT_OK, glint_multipart_reader_create(&c->reader, &params, NULL));
    snprintf(request, sizeof request, "GET /v1/jobs/%s/tiles%s HTTP/1.1\r\nHost: localhost\r\n\r\n",
             id, query);
    http_say(c->fd, request);
}

static void close_stream(struct client *c)
{
    glint_multipart_reader_destroy(&c->reader);
    close(c->fd);
}

// Consumes complete chunks of the chunked coding. False: it needs more bytes.
static bool take_chunk(struct client *c)
{
    char *line = memmem(c->raw, c->length, "\r\n", 2);
    if (!line)
        return false;
    const size_t head = (size_t)(line - c->raw) + 2, size = strtoul(c->raw, NULL, 16);
    if (c->length < head + size + 2)
        return false;
    assert_int_equal(GLINT_OK, glint_multipart_feed(c->reader, c->raw + head, size, NULL));
    c->over = !size;
    c->length -= head + size + 2;
    memmove(c->raw, c->raw + head + size + 2, c->length);
    return !c->over;
}

static void read_some(struct client *c)
{
    struct pollfd p = {.fd = c->fd, .events = POLLIN};
    assert_int_equal(1, poll(&p, 1, (int)(HTTP_PATIENCE * 1e3)));
    const ssize_t n = recv(c->fd, c->raw + c->length, sizeof c->raw - c->length, 0);
    assert_true(n > 0);
    c->length += (size_t)n;
    if (!c->headers) {
        char *end = memmem(c->raw, c->length, "\r\n\r\n", 4);
        if (!end)
            return;
        assert_int_equal(200, http_status(c->raw));
        c->headers = true;
        c->length -= (size_t)(end + 4 - c->raw);
        memmove(c->raw, end + 4, c->length);
    }
    while (take_chunk(c))
        ;
}

static void a_finished_job_streams_every_tile_once_and_ends(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES];
    struct client c;
    http_submit_prepared(id);
    fake_job_render(http_house.jobs, id, UINT32_MAX);
    fake_job_render(http_house.jobs, id, 2);
    fake_job_set_state(http_house.jobs, id, GLINT_JOB_DONE);
    open_stream(&c, id, "");
    while (!c.over)
        read_some(&c);
    for (int t = 0; t < HTTP_TILES; t++)
        assert_int_equal(1, c.parts.count[t]);
    assert_true(c.parts.ordered);
    assert_true(glint_multipart_ended(c.reader));
    // Tiles 0..5 had versions 1..6, then tile 2 version 7: 2 comes last, after 5.
    assert_true(c.parts.newest[5] < c.parts.newest[2]);
    char query[40];
    snprintf(query, sizeof query, "?since=%llu", (unsigned long long)c.parts.newest[4]);
    close_stream(&c);
    open_stream(&c, id, query);
    while (!c.over)
        read_some(&c);
    for (int t = 0; t < HTTP_TILES; t++)
        assert_int_equal(t == 2 || t == 5, c.parts.count[t]);
    close_stream(&c);
}

static void head_of_a_stream_has_no_body(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], request[256];
    http_submit_prepared(id);
    snprintf(request, sizeof request, "HEAD /v1/jobs/%s/tiles HTTP/1.1\r\n" HTTP_END, id);
    char *answer = http_ask(request);
    assert_int_equal(200, http_status(answer));
    assert_string_equal("\r\n\r\n", strstr(answer, "\r\n\r\n"));
    free(answer);
}

static void a_stream_opened_before_the_first_pixel_gets_it(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES];
    struct client c;
    http_submit(id);
    open_stream(&c, id, "");
    fake_job_prepare(http_house.jobs, id);
    fake_job_render(http_house.jobs, id, 3);
    while (!c.parts.count[3])
        read_some(&c);
    fake_job_render(http_house.jobs, id, 3);
    while (c.parts.value[3] != 2)
        read_some(&c);
    close_stream(&c);
}

static void a_slow_reader_skips_versions_but_ends_with_the_newest(void **state)
{
    (void)state;
    enum { ROUNDS = 3000 };
    char id[GLINT_JOB_ID_BYTES];
    struct client c;
    http_submit_prepared(id);
    open_stream(&c, id, "");
    for (int i = 0; i < ROUNDS; i++)
        fake_job_render(http_house.jobs, id, UINT32_MAX);
    fake_job_set_state(http_house.jobs, id, GLINT_JOB_DONE);
    while (!c.over)
        read_some(&c);
    for (int t = 0; t < HTTP_TILES; t++) {
        assert_in_range(c.parts.count[t], 1, ROUNDS - 1);
        assert_true(c.parts.value[t] == (float)(((ROUNDS - 1) * HTTP_TILES + t + 1) % 1024));
    }
    assert_true(c.parts.ordered);
    close_stream(&c);
}

static void tiles_that_change_while_others_are_listed_come_once_and_later(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES];
    struct client c;
    http_submit_prepared(id);
    fake_job_render(http_house.jobs, id, UINT32_MAX);
    open_stream(&c, id, "");
    while (!c.parts.count[HTTP_TILES - 1])
        read_some(&c);
    fake_job_race(http_house.jobs, id, 3);
    while (c.parts.count[3] < 2)
        read_some(&c);
    fake_job_set_state(http_house.jobs, id, GLINT_JOB_DONE);
    while (!c.over && c.parts.ordered)
        read_some(&c);
    assert_true(c.parts.ordered);
    for (int t = 0; t < HTTP_TILES; t++)
        assert_int_equal(t == 0 || t == 3 || t == HTTP_TILES - 1 ? 2 : 1, c.parts.count[t]);
    assert_true(c.parts.value[0] == HTTP_TILES + 2);
    assert_true(c.parts.value[HTTP_TILES - 1] == HTTP_TILES + 3);
    close_stream(&c);
}

static void a_reader_that_takes_nothing_is_ended(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES];
    struct client c;
    http_submit_prepared(id);
    open_stream(&c, id, "");
    http_await_metric("glint_http_streams ", 1);
    const double until = glint_now() + HTTP_PATIENCE;
    while (http_metric("glint_http_streams ") > 0) {
        fake_job_render(http_house.jobs, id, UINT32_MAX);
        assert_true(glint_now() < until);
    }
    close_stream(&c);
}

static void a_reader_that_waits_for_long_is_not(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES];
    struct client c;
    http_submit_prepared(id);
    open_stream(&c, id, "");
    const double until = glint_now() + 2.5; // twice what a reader may be silent for, and more
    while (glint_now() < until)
        assert_true(poll(NULL, 0, 100) == 0);
    fake_job_render(http_house.jobs, id, 3);
    while (!c.parts.count[3])
        read_some(&c);
    close_stream(&c);
}

static void a_cursor_of_another_time_starts_from_the_first_tile(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES];
    struct client c;
    http_submit_prepared(id);
    fake_job_render(http_house.jobs, id, UINT32_MAX);
    fake_job_set_state(http_house.jobs, id, GLINT_JOB_DONE);
    open_stream(&c, id, "?since=9000000000000000000");
    while (!c.over)
        read_some(&c);
    for (int t = 0; t < HTTP_TILES; t++)
        assert_int_equal(1, c.parts.count[t]);
    close_stream(&c);
}

static void a_client_without_chunks_gets_its_stream_too(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], request[256];
    http_submit_prepared(id);
    snprintf(request, sizeof request, "GET /v1/jobs/%s/events HTTP/1.0\r\n" HTTP_END, id);
    const int fd = http_dial();
    http_say(fd, request);
    char *answer = http_hear_until(fd, "\"warnings\":[]}\n\n");
    assert_non_null(strstr(answer, "\r\n\r\nretry: 2000\n\nid: "));
    free(answer);
    fake_job_set_state(http_house.jobs, id, GLINT_JOB_DONE);
    answer = http_hear(fd);
    assert_non_null(strstr(answer, "event: done\n"));
    assert_string_equal("\n\n", answer + strlen(answer) - 2); // no end of a last chunk
    free(answer);
}

static void clients_that_leave_idle_streams_are_noticed(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES];
    struct client c[4];
    http_submit_prepared(id);
    for (int i = 0; i < 4; i++)
        open_stream(&c[i], id, "");
    http_await_metric("glint_http_streams ", 4);
    for (int i = 0; i < 4; i++)
        close_stream(&c[i]);
    http_await_metric("glint_http_streams ", 0);
}

static void clients_that_leave_amid_tiles_are_noticed(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES];
    http_submit_prepared(id);
    for (int i = 0; i < 20; i++) {
        struct client c;
        open_stream(&c, id, "");
        fake_job_render(http_house.jobs, id, UINT32_MAX);
        if (i % 2)
            read_some(&c);
        close_stream(&c);
        fake_job_render(http_house.jobs, id, UINT32_MAX);
        if (i % 4 == 3)
            http_await_metric("glint_http_streams ", 0); // no more than 8 at a time are allowed
    }
}

static void streams_over_the_limit_are_told_to_come_back(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], target[128];
    struct client c[8];
    http_submit_prepared(id);
    for (int i = 0; i < 8; i++)
        open_stream(&c[i], id, "");
    http_await_metric("glint_http_streams ", 8);
    snprintf(target, sizeof target, "/v1/jobs/%s/tiles", id);
    char *answer = http_get(target);
    assert_int_equal(503, http_status(answer));
    free(answer);
    for (int i = 0; i < 8; i++)
        close_stream(&c[i]);
}

// Events

static char *events(const char *id, const char *header)
{
    char request[256];
    snprintf(request, sizeof request, "GET /v1/jobs/%s/events HTTP/1.1\r\n%s" HTTP_END, id, header);
    return http_ask(request);
}

static void events_tell_the_state_and_end_when_done(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], request[256], header[64];
    http_submit_prepared(id);
    snprintf(request, sizeof request, "GET /v1/jobs/%s/events HTTP/1.1\r\n" HTTP_END, id);
    const int fd = http_dial();
    http_say(fd, request);
    char *answer = http_hear_until(fd, "\"warnings\":[]}\n\n");
    assert_non_null(strstr(answer, "retry: 2000\n\n"));
    assert_non_null(strstr(answer, "event: state\ndata: {\"id\":\"job0\",\"state\":\"queued\""));
    free(answer);
    fake_job_warn(http_house.jobs, id, "a clash");
    fake_job_set_state(http_house.jobs, id, GLINT_JOB_DONE);
    answer = http_hear(fd);
    const char *warning = strstr(answer, "event: warning\ndata: {\"detail\":\"a clash\"}");
    const char *done = strstr(answer, "event: done\ndata: {\"id\":\"job0\",\"state\":\"done\"");
    assert_true(warning && done && warning < done);
    unsigned long long last = 0;
    for (const char *p = answer; (p = strstr(p, "\nid: ")); p += 5)
        last = strtoull(p + 5, NULL, 10);
    free(answer);

    snprintf(header, sizeof header, "Last-Event-ID: %llu\r\n", last - 1);
    answer = events(id, header); // only the last event is missing
    assert_non_null(strstr(answer, "event: done\n"));
    assert_null(strstr(answer, "event: state\n"));
    free(answer);
    snprintf(header, sizeof header, "Last-Event-ID: %llu\r\n", last);
    answer = events(id, header);
    assert_int_equal(204, http_status(answer));
    free(answer);
    answer = events(id, "Last-Event-ID: 5\r\n");
    assert_non_null(strstr(answer, "event: reset\n"));
    free(answer);
}

static void silence_is_broken_by_comments(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], request[256];
    http_submit_prepared(id);
    snprintf(request, sizeof request, "GET /v1/jobs/%s/events HTTP/1.1\r\n" HTTP_END, id);
    const int fd = http_dial();
    http_say(fd, request);
    char *answer = http_hear_until(fd, "\n: ping\n\n");
    assert_non_null(strstr(answer, "event: state\n"));
    free(answer);
    answer = http_hear_until(fd, ": ping\n\n");
    assert_null(strstr(answer, "event:"));
    free(answer);
    close(fd);
}

static void an_event_that_was_overwritten_is_answered_with_all(void **state)
{
    (void)state;
    enum { CHANGES = 300 }; // more than are kept
    char id[GLINT_JOB_ID_BYTES], request[256], header[64];
    http_submit_prepared(id);
    snprintf(request, sizeof request, "GET /v1/jobs/%s/events HTTP/1.1\r\n" HTTP_END, id);
    const int fd = http_dial();
    http_say(fd, request);
    char *answer = http_hear_until(fd, "\"warnings\":[]}\n\n");
    const unsigned long long first = strtoull(strstr(answer, "\nid: ") + 5, NULL, 10);
    free(answer);
    for (int i = 0; i < CHANGES; i++) {
        const bool odd = i % 2;
        fake_job_set_state(http_house.jobs, id, odd ? GLINT_JOB_PAUSED : GLINT_JOB_RENDERING);
        free(http_hear_until(fd, odd ? "\"state\":\"paused\"" : "\"state\":\"rendering\""));
    }
    close(fd);
    fake_job_set_state(http_house.jobs, id, GLINT_JOB_DONE);
    snprintf(header, sizeof header, "Last-Event-ID: %llu\r\n", first);
    answer = events(id, header);
    assert_non_null(strstr(answer, "event: reset\ndata: {\"id\":\"job0\",\"state\":\"done\""));
    assert_non_null(strstr(answer, "event: done\n"));
    assert_null(strstr(answer, "event: state\n"));
    free(answer);
}

static unsigned long long newest_event(const char *id, const char *header, const char *name)
{
    char *answer = events(id, header);
    unsigned long long last = 0;
    assert_non_null(strstr(answer, name));
    for (const char *p = answer; (p = strstr(p, "\nid: ")); p += 5)
        last = strtoull(p + 5, NULL, 10);
    free(answer);
    return last;
}

// The same job is there after it, as it is where jobs are kept.
static void events_after_a_restart_are_newer_than_all_before(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], header[64];
    http_submit_prepared(id);
    fake_job_set_state(http_house.jobs, id, GLINT_JOB_DONE);
    const unsigned long long before = newest_event(id, "", "event: done\n");
    glint_http_destroy(&http_server);
    http_serve_again();
    snprintf(header, sizeof header, "Last-Event-ID: %llu\r\n", before);
    assert_true(newest_event(id, header, "event: reset\n") > before + 1);
}

static void draining_ends_streams_and_waits(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], request[256];
    struct client c;
    http_submit_prepared(id);
    open_stream(&c, id, "");
    http_await_metric("glint_http_streams ", 1);
    snprintf(request, sizeof request, "GET /v1/jobs/%s/frame.exr?wait=done HTTP/1.1\r\n" HTTP_END,
             id);
    const int waiting = http_dial();
    http_say(waiting, request);
    http_await_metric("glint_http_connections ", 3); // the stream, the wait and this one
    assert_true(glint_http_drain(http_server, HTTP_PATIENCE));
    char *answer = http_hear(waiting);
    assert_int_equal(503, http_status(answer));
    free(answer);
    while (!c.over)
        read_some(&c);
    close_stream(&c);
}

int main(void)
{
    signal(SIGPIPE, SIG_IGN);
#define CLAIM(name) cmocka_unit_test_setup_teardown(name, http_start, http_stop)
#define IMPATIENT(name) cmocka_unit_test_setup_teardown(name, http_start_impatient, http_stop)
    const struct CMUnitTest tests[] = {
        CLAIM(a_finished_job_streams_every_tile_once_and_ends),
        CLAIM(head_of_a_stream_has_no_body),
        CLAIM(a_stream_opened_before_the_first_pixel_gets_it),
        CLAIM(a_slow_reader_skips_versions_but_ends_with_the_newest),
        CLAIM(tiles_that_change_while_others_are_listed_come_once_and_later),
        CLAIM(a_cursor_of_another_time_starts_from_the_first_tile),
        CLAIM(a_client_without_chunks_gets_its_stream_too),
        IMPATIENT(a_reader_that_takes_nothing_is_ended),
        IMPATIENT(a_reader_that_waits_for_long_is_not),
        CLAIM(clients_that_leave_idle_streams_are_noticed),
        CLAIM(clients_that_leave_amid_tiles_are_noticed),
        CLAIM(streams_over_the_limit_are_told_to_come_back),
        CLAIM(events_tell_the_state_and_end_when_done),
        IMPATIENT(silence_is_broken_by_comments),
        CLAIM(an_event_that_was_overwritten_is_answered_with_all),
        CLAIM(events_after_a_restart_are_newer_than_all_before),
        CLAIM(draining_ends_streams_and_waits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
