// The HTTP server over a house of fakes: what it answers, and that streams, waiting requests and
// shutdown come to an end whatever clients do.
#include "fake_house.h"

#include "base/clock.h"
#include "http/http.h"
#include "protocol/exr.h"
#include "protocol/multipart.h"

#include <arpa/inet.h>
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

#define TILES 6
#define PATIENCE 20.0 // seconds until a condition that must come counts as missing

static struct fake_house house;
static glint_metrics *metrics;
static glint_http *http;
static int port;

static int listen_anywhere(void)
{
    struct sockaddr_in a = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t length = sizeof a;
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(0, bind(fd, (struct sockaddr *)&a, sizeof a));
    assert_int_equal(0, listen(fd, 64));
    assert_int_equal(0, getsockname(fd, (struct sockaddr *)&a, &length));
    port = ntohs(a.sin_port);
    return fd;
}

static int serve(double idle_seconds, double ping_seconds)
{
    struct glint_error err = {0};
    assert_int_equal(GLINT_OK, glint_metrics_create(&metrics, &err));
    const struct glint_http_params params = {.listen_fd = listen_anywhere(),
                                             .jobs = house.jobs,
                                             .store = house.store,
                                             .devices = house.devices,
                                             .metrics = metrics,
                                             .version = "0",
                                             .limits = {.job_bytes = 4096,
                                                        .scene_bytes = 100000,
                                                        .connections = 20,
                                                        .streams = 8,
                                                        .header_seconds = 0.3,
                                                        .idle_seconds = idle_seconds,
                                                        .ping_seconds = ping_seconds}};
    assert_int_equal(GLINT_OK, glint_http_create(&http, &params, &err));
    return 0;
}

static int start(void **state)
{
    (void)state;
    fake_house_open(&house, TILES);
    return serve(0, 0);
}

static int start_impatient(void **state)
{
    (void)state;
    fake_house_open(&house, TILES);
    return serve(1, 0.3);
}

static int stop(void **state)
{
    (void)state;
    glint_http_destroy(&http);
    glint_metrics_destroy(&metrics);
    fake_house_close(&house);
    return 0;
}

static int dial(void)
{
    struct sockaddr_in a = {.sin_family = AF_INET,
                            .sin_addr.s_addr = htonl(INADDR_LOOPBACK),
                            .sin_port = htons((uint16_t)port)};
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(0, connect(fd, (struct sockaddr *)&a, sizeof a));
    return fd;
}

static void say(int fd, const char *text)
{
    for (size_t left = strlen(text); left;) {
        const ssize_t n = send(fd, text, left, MSG_NOSIGNAL);
        if (n < 0)
            return; // refused early
        text += n;
        left -= (size_t)n;
    }
}

// Everything until `last` came or the server closes; malloc'd and terminated.
static char *hear_until(int fd, const char *last)
{
    size_t used = 0, capacity = 1 << 16;
    char *text = malloc(capacity);
    for (;;) {
        struct pollfd p = {.fd = fd, .events = POLLIN};
        assert_int_equal(1, poll(&p, 1, (int)(PATIENCE * 1e3)));
        const ssize_t n = recv(fd, text + used, capacity - used - 1, 0);
        if (n <= 0)
            break;
        used += (size_t)n;
        if (last && memmem(text, used, last, strlen(last)))
            break;
        if (used + 1 == capacity)
            text = realloc(text, capacity *= 2);
    }
    text[used] = 0;
    return text;
}

static char *hear(int fd)
{
    char *text = hear_until(fd, NULL);
    close(fd);
    return text;
}

static int status_of(const char *answer)
{
    int status = 0;
    sscanf(answer, "HTTP/1.1 %d", &status);
    return status;
}

static char *ask(const char *request)
{
    const int fd = dial();
    say(fd, request);
    return hear(fd);
}

#define END "Host: localhost\r\nConnection: close\r\n\r\n"

static char *get(const char *target)
{
    char request[1024];
    snprintf(request, sizeof request, "GET %s HTTP/1.1\r\n" END, target);
    return ask(request);
}

static char *post_job(const char *json)
{
    char request[4096];
    snprintf(
        request, sizeof request,
        "POST /v1/jobs HTTP/1.1\r\nContent-Type: application/json\r\nContent-Length: %zu\r\n" END
        "%s",
        strlen(json), json);
    return ask(request);
}

static void submit(char id[GLINT_JOB_ID_BYTES])
{
    char *answer = post_job("{\"scene\":\"room\"}");
    assert_int_equal(202, status_of(answer));
    assert_non_null(strstr(answer, "Location: /v1/jobs/"));
    free(answer);
    fake_job_last(house.jobs, id);
}

static void submit_prepared(char id[GLINT_JOB_ID_BYTES])
{
    submit(id);
    fake_job_prepare(house.jobs, id);
}

static double metric(const char *name)
{
    char *text = get("/metrics");
    const char *line = strstr(text, name);
    // HELP and TYPE come first; the sample line starts with the name.
    while (line && line[-1] != '\n')
        line = strstr(line + 1, name);
    const double value = line ? strtod(line + strlen(name), NULL) : -1;
    free(text);
    return value;
}

static void await_metric(const char *name, double value)
{
    const double until = glint_now() + PATIENCE;
    while (metric(name) != value)
        assert_true(glint_now() < until);
}

// Bad requests

static const struct {
    int status;
    const char *request;
} bad[] = {
    {404, "GET /nothing HTTP/1.1\r\n" END},
    {404, "GET /v1/ HTTP/1.1\r\n" END},
    {404, "GET /v1/scenes/ HTTP/1.1\r\n" END},
    {404, "GET /v1/scenes/attic HTTP/1.1\r\n" END},
    {404, "GET /v1/jobs/none HTTP/1.1\r\n" END},
    {404, "GET /v1/jobs/none/frame.exr?wait=done HTTP/1.1\r\n" END},
    {404, "GET /v1/jobs/none/tiles HTTP/1.1\r\n" END},
    {404, "GET /v1/jobs/none/events HTTP/1.1\r\n" END},
    {404, "GET /v1/jobs/a%2Fb/a/b/c/d/e/f/g HTTP/1.1\r\n" END},
    {404, "GET http://localhost/nothing HTTP/1.1\r\n" END},
    {200, "GET http://localhost/healthz HTTP/1.1\r\n" END},
    {400, "GET /v1/scenes/%zz HTTP/1.1\r\n" END},
    {400, "GET /v1/scenes/a%00b HTTP/1.1\r\n" END},
    {400, "GET /v1/scenes/%ff HTTP/1.1\r\n" END},
    {400, "GET /v1/jobs?a=%4 HTTP/1.1\r\n" END},
    {405, "PATCH /v1/scenes HTTP/1.1\r\n" END},
    {405, "BREW /v1/jobs HTTP/1.1\r\n" END},
    {421, "GET /healthz HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n"},
    {421, "GET /healthz HTTP/1.1\r\nHost: localhost.evil.example\r\nConnection: close\r\n\r\n"},
    {421, "GET /healthz HTTP/1.1\r\nHost: 127.evil.example\r\nConnection: close\r\n\r\n"},
    {200, "GET /healthz HTTP/1.1\r\nHost: 127.0.0.1:99\r\nConnection: close\r\n\r\n"},
    {400, "GET /healthz HTTP/1.1\r\nConnection: close\r\n\r\n"},
    {422, "GET /v1/jobs?colour=red HTTP/1.1\r\n" END},
    {422, "GET /v1/scenes/room?format=blend HTTP/1.1\r\n" END},
    {422, "GET /v1/scenes/room?format=native&format=native HTTP/1.1\r\n" END},
    {422, "GET /v1/jobs/none/tiles?since=-1 HTTP/1.1\r\n" END},
    {422, "GET /v1/jobs/none/tiles?since= HTTP/1.1\r\n" END},
    {422, "GET /v1/jobs/none/frame.png?exposure=1e9 HTTP/1.1\r\n" END},
    {422, "GET /v1/jobs/none/frame.png?exposure=nan HTTP/1.1\r\n" END},
    {422, "GET /v1/jobs/none/frame.exr?outputs=beauty,smell HTTP/1.1\r\n" END},
    {422, "GET /v1/jobs/none/matte.png HTTP/1.1\r\n" END},
    {422, "GET /v1/jobs/none/pick?x=1 HTTP/1.1\r\n" END},
    {409, "DELETE /v1/scenes/room HTTP/1.1\r\n" END},
    {412, "DELETE /v1/scenes/room HTTP/1.1\r\nIf-Match: \"b\"\r\n" END},
    {412, "PUT /v1/scenes/room HTTP/1.1\r\nIf-None-Match: *\r\nContent-Length: 2\r\n" END "{}"},
    {412, "PUT /v1/scenes/attic HTTP/1.1\r\nIf-Match: *\r\nContent-Length: 2\r\n" END "{}"},
    {400, "PUT /v1/scenes/room HTTP/1.1\r\nContent-Length: 0\r\n" END},
    {400,
     "PUT /v1/scenes/room HTTP/1.1\r\nContent-Type: model/gltf-binary\r\nContent-Length: 6\r\n" END
     "glTFxx"},
    {413, "PUT /v1/scenes/room HTTP/1.1\r\nContent-Length: 100001\r\n" END},
    {413, "GET /healthz HTTP/1.1\r\nContent-Length: 1\r\n" END "x"},
    {415, "POST /v1/jobs HTTP/1.1\r\nContent-Length: 2\r\n" END "{}"},
    {415,
     "POST /v1/jobs HTTP/1.1\r\nContent-Type: application/jsonp\r\nContent-Length: 2\r\n" END "{}"},
    {415,
     "PUT /v1/scenes/room HTTP/1.1\r\nContent-Type: text/html\r\nContent-Length: 2\r\n" END "{}"},
    {415,
     "PUT /v1/scenes/room HTTP/1.1\r\nContent-Encoding: gzip\r\nContent-Length: 2\r\n" END "{}"},
    {400,
     "POST /v1/jobs HTTP/1.1\r\nContent-Type: application/json\r\nContent-Length: 1\r\n" END "{"},
    {422, "POST /v1/jobs HTTP/1.1\r\nIdempotency-Key: a b\r\nContent-Type: application/json\r\n"
          "Content-Length: 16\r\n" END "{\"scene\":\"room\"}"},
    {400, "PUT /v1/scenes/room HTTP/1.1\r\nContent-Length: -1\r\n" END},
    {400, "PUT /v1/scenes/room HTTP/1.1\r\nContent-Length: 1x\r\n" END},
};

static void bad_requests_get_their_status(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char *answer = ask(bad[i].request);
        if (status_of(answer) != bad[i].status)
            print_message("# %.60s...\n# -> %.300s\n", bad[i].request, answer);
        assert_int_equal(bad[i].status, status_of(answer));
        free(answer);
    }
}

static void a_refused_method_names_the_allowed_ones(void **state)
{
    (void)state;
    char *answer = ask("POST /v1/scenes/room HTTP/1.1\r\n" END);
    assert_int_equal(405, status_of(answer));
    assert_non_null(strstr(answer, "Allow: GET, HEAD, PUT, PATCH, DELETE\r\n"));
    assert_non_null(strstr(answer, "Content-Type: application/problem+json\r\n"));
    free(answer);
}

static void problems_carry_the_request_id(void **state)
{
    (void)state;
    char *answer = ask("GET /x HTTP/1.1\r\nX-Request-Id: mine-7\r\n" END);
    assert_non_null(strstr(answer, "X-Request-Id: mine-7\r\n"));
    assert_non_null(strstr(answer, "\"request_id\":\"mine-7\""));
    free(answer);
}

static void an_unknown_matte_is_a_fault_of_its_parameter(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], target[128];
    submit_prepared(id);
    snprintf(target, sizeof target, "/v1/jobs/%s/matte.png?name=torus&name=cone", id);
    char *answer = get(target);
    assert_int_equal(404, status_of(answer));
    assert_non_null(strstr(answer, "\"pointer\":\"\",\"detail\":\"name: no object \\\"cone\\\""));
    free(answer);
}

static void every_bad_parameter_is_named(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], target[128];
    submit_prepared(id);
    snprintf(target, sizeof target, "/v1/jobs/%s/frame.png?exposure=x&tonemap=y&output=z", id);
    char *answer = get(target);
    assert_int_equal(422, status_of(answer));
    assert_non_null(strstr(answer, "exposure: x"));
    assert_non_null(strstr(answer, "tonemap: y"));
    assert_non_null(strstr(answer, "output: there is no output \\\"z\\\""));
    free(answer);
}

static void a_job_of_three_faults_is_told_all_three(void **state)
{
    (void)state;
    char *answer = post_job("{\"scene\":\"attic\",\"resolution\":[0,1],\"max_bounce\":3}");
    assert_int_equal(422, status_of(answer));
    assert_non_null(strstr(answer, "\"pointer\":\"/scene\""));
    assert_non_null(strstr(answer, "\"pointer\":\"/resolution"));
    assert_non_null(strstr(answer, "\"pointer\":\"/max_bounce\""));
    free(answer);
}

static void a_body_that_grows_past_the_limit_is_refused(void **state)
{
    (void)state;
    const int fd = dial();
    char chunk[4097];
    memset(chunk, 'x', 4096);
    chunk[4096] = 0;
    say(fd, "PUT /v1/scenes/room HTTP/1.1\r\nTransfer-Encoding: chunked\r\n" END);
    for (int i = 0; i < 30; i++) {
        say(fd, "1000\r\n");
        say(fd, chunk);
        say(fd, "\r\n");
    }
    say(fd, "0\r\n\r\n");
    char *answer = hear(fd);
    assert_int_equal(413, status_of(answer));
    free(answer);
}

static void unchanged_resources_are_not_sent_again(void **state)
{
    (void)state;
    char *first = get("/v1/scenes/room"), etag[80] = "", request[256];
    assert_int_equal(200, status_of(first));
    assert_int_equal(1, sscanf(strstr(first, "ETag: "), "ETag: %79[^\r]", etag));
    snprintf(request, sizeof request,
             "GET /v1/scenes/room HTTP/1.1\r\nIf-None-Match: \"x\", W/%s\r\n" END, etag);
    char *second = ask(request);
    assert_int_equal(304, status_of(second));
    free(first);
    free(second);
}

static void head_has_the_length_and_no_body(void **state)
{
    (void)state;
    char *answer = ask("HEAD /healthz HTTP/1.1\r\n" END);
    assert_int_equal(200, status_of(answer));
    assert_non_null(strstr(answer, "Content-Length: 15\r\n")); // {"status":"ok"}
    assert_string_equal("\r\n\r\n", strstr(answer, "\r\n\r\n"));
    free(answer);
}

// Frames

static void a_frame_before_its_first_pixels_is_tried_later(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], target[128];
    submit(id);
    snprintf(target, sizeof target, "/v1/jobs/%s/frame.exr", id);
    char *answer = get(target);
    assert_int_equal(503, status_of(answer));
    assert_non_null(strstr(answer, "Retry-After: "));
    free(answer);
}

static void a_finished_frame_has_one_digest_and_serves_ranges(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], request[512], etag[80];
    submit_prepared(id);
    fake_job_render(house.jobs, id, UINT32_MAX);
    fake_job_set_state(house.jobs, id, GLINT_JOB_DONE);
    snprintf(request, sizeof request, "/v1/jobs/%s/frame.exr?outputs=beauty", id);
    char *whole = get(request);
    assert_int_equal(200, status_of(whole));
    assert_non_null(strstr(whole, "Repr-Digest: sha-256=:"));
    assert_int_equal(1, sscanf(strstr(whole, "ETag: "), "ETag: %79[^\r]", etag));
    free(whole);
    snprintf(request, sizeof request,
             "GET /v1/jobs/%s/frame.exr?outputs=beauty HTTP/1.1\r\n"
             "Range: bytes=0-3\r\nIf-Range: %s\r\n" END,
             id, etag);
    char *part = ask(request);
    assert_int_equal(206, status_of(part));
    assert_memory_equal("\x76\x2f\x31\x01", strstr(part, "\r\n\r\n") + 4, 4); // OpenEXR's magic
    free(part);
    snprintf(request, sizeof request,
             "GET /v1/jobs/%s/frame.exr?outputs=beauty HTTP/1.1\r\n"
             "Range: bytes=99999999-\r\n" END,
             id);
    part = ask(request);
    assert_int_equal(416, status_of(part));
    assert_non_null(strstr(part, "Content-Range: bytes */"));
    free(part);
}

static void waiting_ends_with_the_job(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], request[256];
    submit(id);
    snprintf(request, sizeof request,
             "GET /v1/jobs/%s/frame.exr?wait=done&outputs=beauty HTTP/1.1\r\n" END, id);
    const int done = dial(), cancelled = dial();
    say(done, request);
    fake_job_prepare(house.jobs, id);
    fake_job_render(house.jobs, id, UINT32_MAX);
    fake_job_set_state(house.jobs, id, GLINT_JOB_DONE);
    char *answer = hear(done);
    assert_int_equal(200, status_of(answer));
    free(answer);

    submit_prepared(id);
    snprintf(request, sizeof request, "GET /v1/jobs/%s/frame.exr?wait=done HTTP/1.1\r\n" END, id);
    say(cancelled, request);
    fake_job_set_state(house.jobs, id, GLINT_JOB_CANCELLED);
    answer = hear(cancelled);
    assert_int_equal(409, status_of(answer));
    free(answer);
}

// Streams

struct parts {
    unsigned count[TILES];
    uint64_t newest[TILES]; // Glint-Seq
    float value[TILES];     // of the newest's pixels
    uint64_t last;
    bool ordered;
};

static glint_status take_part(void *user, const struct glint_multipart_head *head,
                              const uint8_t *body)
{
    struct parts *p = user;
    struct glint_frame *frame;
    const uint32_t t = head->tile[0] / 64;
    assert_true(head->has_tile && t < TILES);
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
    *c = (struct client){.fd = dial(), .parts.ordered = true};
    assert_int_equal(GLINT_OK, glint_multipart_reader_create(&c->reader, &params, NULL));
    snprintf(request, sizeof request, "GET /v1/jobs/%s/tiles%s HTTP/1.1\r\nHost: localhost\r\n\r\n",
             id, query);
    say(c->fd, request);
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
    assert_int_equal(1, poll(&p, 1, (int)(PATIENCE * 1e3)));
    const ssize_t n = recv(c->fd, c->raw + c->length, sizeof c->raw - c->length, 0);
    assert_true(n > 0);
    c->length += (size_t)n;
    if (!c->headers) {
        char *end = memmem(c->raw, c->length, "\r\n\r\n", 4);
        if (!end)
            return;
        assert_int_equal(200, status_of(c->raw));
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
    submit_prepared(id);
    fake_job_render(house.jobs, id, UINT32_MAX);
    fake_job_render(house.jobs, id, 2);
    fake_job_set_state(house.jobs, id, GLINT_JOB_DONE);
    open_stream(&c, id, "");
    while (!c.over)
        read_some(&c);
    for (int t = 0; t < TILES; t++)
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
    for (int t = 0; t < TILES; t++)
        assert_int_equal(t == 2 || t == 5, c.parts.count[t]);
    close_stream(&c);
}

static void head_of_a_stream_has_no_body(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], request[256];
    submit_prepared(id);
    snprintf(request, sizeof request, "HEAD /v1/jobs/%s/tiles HTTP/1.1\r\n" END, id);
    char *answer = ask(request);
    assert_int_equal(200, status_of(answer));
    assert_string_equal("\r\n\r\n", strstr(answer, "\r\n\r\n"));
    free(answer);
}

static void a_stream_opened_before_the_first_pixel_gets_it(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES];
    struct client c;
    submit(id);
    open_stream(&c, id, "");
    fake_job_prepare(house.jobs, id);
    fake_job_render(house.jobs, id, 3);
    while (!c.parts.count[3])
        read_some(&c);
    fake_job_render(house.jobs, id, 3);
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
    submit_prepared(id);
    open_stream(&c, id, "");
    for (int i = 0; i < ROUNDS; i++)
        fake_job_render(house.jobs, id, UINT32_MAX);
    fake_job_set_state(house.jobs, id, GLINT_JOB_DONE);
    while (!c.over)
        read_some(&c);
    for (int t = 0; t < TILES; t++) {
        assert_in_range(c.parts.count[t], 1, ROUNDS - 1);
        assert_true(c.parts.value[t] == (float)(((ROUNDS - 1) * TILES + t + 1) % 1024));
    }
    assert_true(c.parts.ordered);
    close_stream(&c);
}

static void a_reader_that_takes_nothing_is_ended(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES];
    struct client c;
    submit_prepared(id);
    open_stream(&c, id, "");
    await_metric("glint_http_streams ", 1);
    const double until = glint_now() + PATIENCE;
    while (metric("glint_http_streams ") > 0) {
        fake_job_render(house.jobs, id, UINT32_MAX);
        assert_true(glint_now() < until);
    }
    close_stream(&c);
}

static void a_reader_that_waits_for_long_is_not(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES];
    struct client c;
    submit_prepared(id);
    open_stream(&c, id, "");
    const double until = glint_now() + 2.5; // twice what a reader may be silent for, and more
    while (glint_now() < until)
        assert_true(poll(NULL, 0, 100) == 0);
    fake_job_render(house.jobs, id, 3);
    while (!c.parts.count[3])
        read_some(&c);
    close_stream(&c);
}

static void a_cursor_of_another_time_starts_from_the_first_tile(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES];
    struct client c;
    submit_prepared(id);
    fake_job_render(house.jobs, id, UINT32_MAX);
    fake_job_set_state(house.jobs, id, GLINT_JOB_DONE);
    open_stream(&c, id, "?since=9000000000000000000");
    while (!c.over)
        read_some(&c);
    for (int t = 0; t < TILES; t++)
        assert_int_equal(1, c.parts.count[t]);
    close_stream(&c);
}

static void a_client_without_chunks_gets_its_stream_too(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], request[256];
    submit_prepared(id);
    snprintf(request, sizeof request, "GET /v1/jobs/%s/events HTTP/1.0\r\n" END, id);
    const int fd = dial();
    say(fd, request);
    char *answer = hear_until(fd, "\"warnings\":[]}\n\n");
    assert_non_null(strstr(answer, "\r\n\r\nretry: 2000\n\nid: "));
    free(answer);
    fake_job_set_state(house.jobs, id, GLINT_JOB_DONE);
    answer = hear(fd);
    assert_non_null(strstr(answer, "event: done\n"));
    assert_string_equal("\n\n", answer + strlen(answer) - 2); // no end of a last chunk
    free(answer);
}

static void clients_that_leave_idle_streams_are_noticed(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES];
    struct client c[4];
    submit_prepared(id);
    for (int i = 0; i < 4; i++)
        open_stream(&c[i], id, "");
    await_metric("glint_http_streams ", 4);
    for (int i = 0; i < 4; i++)
        close_stream(&c[i]);
    await_metric("glint_http_streams ", 0);
}

static void clients_that_leave_amid_tiles_are_noticed(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES];
    submit_prepared(id);
    for (int i = 0; i < 20; i++) {
        struct client c;
        open_stream(&c, id, "");
        fake_job_render(house.jobs, id, UINT32_MAX);
        if (i % 2)
            read_some(&c);
        close_stream(&c);
        fake_job_render(house.jobs, id, UINT32_MAX);
        if (i % 4 == 3)
            await_metric("glint_http_streams ", 0); // no more than 8 at a time are allowed
    }
}

static void streams_over_the_limit_are_told_to_come_back(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], target[128];
    struct client c[8];
    submit_prepared(id);
    for (int i = 0; i < 8; i++)
        open_stream(&c[i], id, "");
    await_metric("glint_http_streams ", 8);
    snprintf(target, sizeof target, "/v1/jobs/%s/tiles", id);
    char *answer = get(target);
    assert_int_equal(503, status_of(answer));
    free(answer);
    for (int i = 0; i < 8; i++)
        close_stream(&c[i]);
}

// Events

static char *events(const char *id, const char *header)
{
    char request[256];
    snprintf(request, sizeof request, "GET /v1/jobs/%s/events HTTP/1.1\r\n%s" END, id, header);
    return ask(request);
}

static void events_tell_the_state_and_end_when_done(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], request[256], header[64];
    submit_prepared(id);
    snprintf(request, sizeof request, "GET /v1/jobs/%s/events HTTP/1.1\r\n" END, id);
    const int fd = dial();
    say(fd, request);
    char *answer = hear_until(fd, "\"warnings\":[]}\n\n");
    assert_non_null(strstr(answer, "retry: 2000\n\n"));
    assert_non_null(strstr(answer, "event: state\ndata: {\"id\":\"job0\",\"state\":\"queued\""));
    free(answer);
    fake_job_warn(house.jobs, id, "a clash");
    fake_job_set_state(house.jobs, id, GLINT_JOB_DONE);
    answer = hear(fd);
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
    assert_int_equal(204, status_of(answer));
    free(answer);
    answer = events(id, "Last-Event-ID: 5\r\n");
    assert_non_null(strstr(answer, "event: reset\n"));
    free(answer);
}

static void silence_is_broken_by_comments(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], request[256];
    submit_prepared(id);
    snprintf(request, sizeof request, "GET /v1/jobs/%s/events HTTP/1.1\r\n" END, id);
    const int fd = dial();
    say(fd, request);
    char *answer = hear_until(fd, "\n: ping\n\n");
    assert_non_null(strstr(answer, "event: state\n"));
    free(answer);
    answer = hear_until(fd, ": ping\n\n");
    assert_null(strstr(answer, "event:"));
    free(answer);
    close(fd);
}

static void an_event_that_was_overwritten_is_answered_with_all(void **state)
{
    (void)state;
    enum { CHANGES = 300 }; // more than are kept
    char id[GLINT_JOB_ID_BYTES], request[256], header[64];
    submit_prepared(id);
    snprintf(request, sizeof request, "GET /v1/jobs/%s/events HTTP/1.1\r\n" END, id);
    const int fd = dial();
    say(fd, request);
    char *answer = hear_until(fd, "\"warnings\":[]}\n\n");
    const unsigned long long first = strtoull(strstr(answer, "\nid: ") + 5, NULL, 10);
    free(answer);
    for (int i = 0; i < CHANGES; i++) {
        const bool odd = i % 2;
        fake_job_set_state(house.jobs, id, odd ? GLINT_JOB_PAUSED : GLINT_JOB_RENDERING);
        free(hear_until(fd, odd ? "\"state\":\"paused\"" : "\"state\":\"rendering\""));
    }
    close(fd);
    fake_job_set_state(house.jobs, id, GLINT_JOB_DONE);
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
    submit_prepared(id);
    fake_job_set_state(house.jobs, id, GLINT_JOB_DONE);
    const unsigned long long before = newest_event(id, "", "event: done\n");
    glint_http_destroy(&http);
    glint_metrics_destroy(&metrics);
    assert_int_equal(0, serve(0, 0));
    snprintf(header, sizeof header, "Last-Event-ID: %llu\r\n", before);
    assert_true(newest_event(id, header, "event: reset\n") > before + 1);
}

// Dawdlers and crowds

static void a_header_that_drips_is_cut_off(void **state)
{
    (void)state;
    const int fd = dial();
    const double begin = glint_now();
    struct pollfd p = {.fd = fd, .events = POLLIN};
    do { // a byte every 10 ms keeps any idle timeout from passing
        say(fd, "G");
        assert_true(glint_now() < begin + PATIENCE);
    } while (!poll(&p, 1, 10));
    assert_true(glint_now() - begin >= 0.3);
    char byte;
    assert_true(recv(fd, &byte, 1, 0) <= 0);
    close(fd);
}

// Whether somebody is told so beside 20 connections that are silent, for as long as they may be.
static bool a_crowd_is_noticed(void)
{
    int fd[20];
    for (int i = 0; i < 20; i++)
        fd[i] = dial();
    char *answer = get("/healthz");
    const int status = status_of(answer);
    assert_true(status == 503 || status == 200);
    free(answer);
    for (int i = 0; i < 20; i++)
        close(fd[i]);
    return status == 503;
}

static void connections_over_the_limit_are_told_to_come_back(void **state)
{
    (void)state;
    const double until = glint_now() + PATIENCE;
    while (!a_crowd_is_noticed()) // the server may not have seen all of it yet
        assert_true(glint_now() < until);
}

// The end

static void draining_ends_streams_and_waits(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], request[256];
    struct client c;
    submit_prepared(id);
    open_stream(&c, id, "");
    await_metric("glint_http_streams ", 1);
    snprintf(request, sizeof request, "GET /v1/jobs/%s/frame.exr?wait=done HTTP/1.1\r\n" END, id);
    const int waiting = dial();
    say(waiting, request);
    await_metric("glint_http_connections ", 3); // the stream, the wait and this one
    assert_true(glint_http_drain(http, PATIENCE));
    char *answer = hear(waiting);
    assert_int_equal(503, status_of(answer));
    free(answer);
    while (!c.over)
        read_some(&c);
    close_stream(&c);
}

static void stopping_waits_for_a_long_import(void **state)
{
    (void)state;
    const int fd = dial();
    fake_store_gate(house.store, false);
    say(fd, "PUT /v1/scenes/room HTTP/1.1\r\nContent-Length: 2\r\n" END "{}");
    await_metric("glint_http_received_bytes_total ", 2);
    assert_false(glint_http_drain(http, 0));
    fake_store_gate(house.store, true);
    glint_http_destroy(&http);
    close(fd);
}

int main(void)
{
    signal(SIGPIPE, SIG_IGN);
#define CLAIM(name) cmocka_unit_test_setup_teardown(name, start, stop)
#define IMPATIENT(name) cmocka_unit_test_setup_teardown(name, start_impatient, stop)
    const struct CMUnitTest tests[] = {
        CLAIM(bad_requests_get_their_status),
        CLAIM(a_refused_method_names_the_allowed_ones),
        CLAIM(problems_carry_the_request_id),
        CLAIM(every_bad_parameter_is_named),
        CLAIM(an_unknown_matte_is_a_fault_of_its_parameter),
        CLAIM(a_job_of_three_faults_is_told_all_three),
        CLAIM(a_body_that_grows_past_the_limit_is_refused),
        CLAIM(unchanged_resources_are_not_sent_again),
        CLAIM(head_has_the_length_and_no_body),
        CLAIM(a_frame_before_its_first_pixels_is_tried_later),
        CLAIM(a_finished_frame_has_one_digest_and_serves_ranges),
        CLAIM(waiting_ends_with_the_job),
        CLAIM(a_finished_job_streams_every_tile_once_and_ends),
        CLAIM(head_of_a_stream_has_no_body),
        CLAIM(a_stream_opened_before_the_first_pixel_gets_it),
        CLAIM(a_slow_reader_skips_versions_but_ends_with_the_newest),
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
        CLAIM(a_header_that_drips_is_cut_off),
        CLAIM(connections_over_the_limit_are_told_to_come_back),
        CLAIM(draining_ends_streams_and_waits),
        CLAIM(stopping_waits_for_a_long_import),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
