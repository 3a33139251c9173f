// The HTTP server over a house of fakes: what it answers, and that requests come to an end whatever
// clients do.
#include "http_fixture.h"

#include "base/clock.h"

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

// Bad requests

static const struct {
    int status;
    const char *request;
} bad[] = {
    {404, "GET /nothing HTTP/1.1\r\n" HTTP_END},
    {404, "GET /v1/ HTTP/1.1\r\n" HTTP_END},
    {404, "GET /v1/scenes/ HTTP/1.1\r\n" HTTP_END},
    {404, "GET /v1/scenes/attic HTTP/1.1\r\n" HTTP_END},
    {404, "GET /v1/jobs/none HTTP/1.1\r\n" HTTP_END},
    {404, "GET /v1/jobs/none/frame.exr?wait=done HTTP/1.1\r\n" HTTP_END},
    {404, "GET /v1/jobs/none/tiles HTTP/1.1\r\n" HTTP_END},
    {404, "GET /v1/jobs/none/events HTTP/1.1\r\n" HTTP_END},
    {404, "GET /v1/jobs/a%2Fb/a/b/c/d/e/f/g HTTP/1.1\r\n" HTTP_END},
    {404, "GET http://localhost/nothing HTTP/1.1\r\n" HTTP_END},
    {200, "GET http://localhost/healthz HTTP/1.1\r\n" HTTP_END},
    {400, "GET /v1/scenes/%zz HTTP/1.1\r\n" HTTP_END},
    {400, "GET /v1/scenes/a%00b HTTP/1.1\r\n" HTTP_END},
    {400, "GET /v1/scenes/%ff HTTP/1.1\r\n" HTTP_END},
    {400, "GET /v1/jobs?a=%4 HTTP/1.1\r\n" HTTP_END},
    {405, "PATCH /v1/scenes HTTP/1.1\r\n" HTTP_END},
    {405, "BREW /v1/jobs HTTP/1.1\r\n" HTTP_END},
    {421, "GET /healthz HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n"},
    {421, "GET /healthz HTTP/1.1\r\nHost: localhost.evil.example\r\nConnection: close\r\n\r\n"},
    {421, "GET /healthz HTTP/1.1\r\nHost: 127.evil.example\r\nConnection: close\r\n\r\n"},
    {200, "GET /healthz HTTP/1.1\r\nHost: 127.0.0.1:99\r\nConnection: close\r\n\r\n"},
    {400, "GET /healthz HTTP/1.1\r\nConnection: close\r\n\r\n"},
    {422, "GET /v1/jobs?colour=red HTTP/1.1\r\n" HTTP_END},
    {422, "GET /v1/scenes/room?format=blend HTTP/1.1\r\n" HTTP_END},
    {422, "GET /v1/scenes/room?format=native&format=native HTTP/1.1\r\n" HTTP_END},
    {422, "GET /v1/jobs/none/tiles?since=-1 HTTP/1.1\r\n" HTTP_END},
    {422, "GET /v1/jobs/none/tiles?since= HTTP/1.1\r\n" HTTP_END},
    {422, "GET /v1/jobs/none/frame.png?exposure=1e9 HTTP/1.1\r\n" HTTP_END},
    {422, "GET /v1/jobs/none/frame.png?exposure=nan HTTP/1.1\r\n" HTTP_END},
    {422, "GET /v1/jobs/none/frame.exr?outputs=beauty,smell HTTP/1.1\r\n" HTTP_END},
    {422, "GET /v1/jobs/none/matte.png HTTP/1.1\r\n" HTTP_END},
    {422, "GET /v1/jobs/none/pick?x=1 HTTP/1.1\r\n" HTTP_END},
    {409, "DELETE /v1/scenes/room HTTP/1.1\r\n" HTTP_END},
    {412, "DELETE /v1/scenes/room HTTP/1.1\r\nIf-Match: \"b\"\r\n" HTTP_END},
    {412,
     "PUT /v1/scenes/room HTTP/1.1\r\nIf-None-Match: *\r\nContent-Length: 2\r\n" HTTP_END "{}"},
    {412, "PUT /v1/scenes/attic HTTP/1.1\r\nIf-Match: *\r\nContent-Length: 2\r\n" HTTP_END "{}"},
    {400, "PUT /v1/scenes/room HTTP/1.1\r\nContent-Length: 0\r\n" HTTP_END},
    {400, "PUT /v1/scenes/room HTTP/1.1\r\nContent-Type: model/gltf-binary\r\nContent-Length: "
          "6\r\n" HTTP_END "glTFxx"},
    {413, "PUT /v1/scenes/room HTTP/1.1\r\nContent-Length: 100001\r\n" HTTP_END},
    {413, "GET /healthz HTTP/1.1\r\nContent-Length: 1\r\n" HTTP_END "x"},
    {415, "POST /v1/jobs HTTP/1.1\r\nContent-Length: 2\r\n" HTTP_END "{}"},
    {415,
     "POST /v1/jobs HTTP/1.1\r\nContent-Type: application/jsonp\r\nContent-Length: 2\r\n" HTTP_END
     "{}"},
    {415,
     "PUT /v1/scenes/room HTTP/1.1\r\nContent-Type: text/html\r\nContent-Length: 2\r\n" HTTP_END
     "{}"},
    {415, "PUT /v1/scenes/room HTTP/1.1\r\nContent-Encoding: gzip\r\nContent-Length: 2\r\n" HTTP_END
          "{}"},
    {400,
     "POST /v1/jobs HTTP/1.1\r\nContent-Type: application/json\r\nContent-Length: 1\r\n" HTTP_END
     "{"},
    {422, "POST /v1/jobs HTTP/1.1\r\nIdempotency-Key: a b\r\nContent-Type: application/json\r\n"
          "Content-Length: 16\r\n" HTTP_END "{\"scene\":\"room\"}"},
    {400, "PUT /v1/scenes/room HTTP/1.1\r\nContent-Length: -1\r\n" HTTP_END},
    {400, "PUT /v1/scenes/room HTTP/1.1\r\nContent-Length: 1x\r\n" HTTP_END},
};

static void bad_requests_get_their_status(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char *answer = http_ask(bad[i].request);
        if (http_status(answer) != bad[i].status)
            print_message("# %.60s...\n# -> %.300s\n", bad[i].request, answer);
        assert_int_equal(bad[i].status, http_status(answer));
        free(answer);
    }
}

static void a_refused_method_names_the_allowed_ones(void **state)
{
    (void)state;
    char *answer = http_ask("POST /v1/scenes/room HTTP/1.1\r\n" HTTP_END);
    assert_int_equal(405, http_status(answer));
    assert_non_null(strstr(answer, "Allow: GET, HEAD, PUT, PATCH, DELETE\r\n"));
    assert_non_null(strstr(answer, "Content-Type: application/problem+json\r\n"));
    free(answer);
}

static void problems_carry_the_request_id(void **state)
{
    (void)state;
    char *answer = http_ask("GET /x HTTP/1.1\r\nX-Request-Id: mine-7\r\n" HTTP_END);
    assert_non_null(strstr(answer, "X-Request-Id: mine-7\r\n"));
    assert_non_null(strstr(answer, "\"request_id\":\"mine-7\""));
    free(answer);
}

static void an_unknown_matte_is_a_fault_of_its_parameter(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], target[128];
    http_submit_prepared(id);
    snprintf(target, sizeof target, "/v1/jobs/%s/matte.png?name=torus&name=cone", id);
    char *answer = http_get(target);
    assert_int_equal(404, http_status(answer));
    assert_non_null(strstr(answer, "\"pointer\":\"\",\"detail\":\"name: no object \\\"cone\\\""));
    free(answer);
}

static void every_bad_parameter_is_named(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], target[128];
    http_submit_prepared(id);
    snprintf(target, sizeof target, "/v1/jobs/%s/frame.png?exposure=x&tonemap=y&output=z", id);
    char *answer = http_get(target);
    assert_int_equal(422, http_status(answer));
    assert_non_null(strstr(answer, "exposure: x"));
    assert_non_null(strstr(answer, "tonemap: y"));
    assert_non_null(strstr(answer, "output: there is no output \\\"z\\\""));
    free(answer);
}

static void a_job_of_three_faults_is_told_all_three(void **state)
{
    (void)state;
    char *answer = http_post_job("{\"scene\":\"attic\",\"resolution\":[0,1],\"max_bounce\":3}");
    assert_int_equal(422, http_status(answer));
    assert_non_null(strstr(answer, "\"pointer\":\"/scene\""));
    assert_non_null(strstr(answer, "\"pointer\":\"/resolution"));
    assert_non_null(strstr(answer, "\"pointer\":\"/max_bounce\""));
    free(answer);
}

static void a_body_that_grows_past_the_limit_is_refused(void **state)
{
    (void)state;
    const int fd = http_dial();
    char chunk[4097];
    memset(chunk, 'x', 4096);
    chunk[4096] = 0;
    http_say(fd, "PUT /v1/scenes/room HTTP/1.1\r\nTransfer-Encoding: chunked\r\n" HTTP_END);
    for (int i = 0; i < 30; i++) {
        http_say(fd, "1000\r\n");
        http_say(fd, chunk);
        http_say(fd, "\r\n");
    }
    http_say(fd, "0\r\n\r\n");
    char *answer = http_hear(fd);
    assert_int_equal(413, http_status(answer));
    free(answer);
}

static void unchanged_resources_are_not_sent_again(void **state)
{
    (void)state;
    char *first = http_get("/v1/scenes/room"), etag[80] = "", request[256];
    assert_int_equal(200, http_status(first));
    assert_int_equal(1, sscanf(strstr(first, "ETag: "), "ETag: %79[^\r]", etag));
    snprintf(request, sizeof request,
             "GET /v1/scenes/room HTTP/1.1\r\nIf-None-Match: \"x\", W/%s\r\n" HTTP_END, etag);
    char *second = http_ask(request);
    assert_int_equal(304, http_status(second));
    free(first);
    free(second);
}

static void head_has_the_length_and_no_body(void **state)
{
    (void)state;
    char *answer = http_ask("HEAD /healthz HTTP/1.1\r\n" HTTP_END);
    assert_int_equal(200, http_status(answer));
    assert_non_null(strstr(answer, "Content-Length: 15\r\n")); // {"status":"ok"}
    assert_string_equal("\r\n\r\n", strstr(answer, "\r\n\r\n"));
    free(answer);
}

// Frames

static void a_frame_before_its_first_pixels_is_tried_later(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], target[128];
    http_submit(id);
    snprintf(target, sizeof target, "/v1/jobs/%s/frame.exr", id);
    char *answer = http_get(target);
    assert_int_equal(503, http_status(answer));
    assert_non_null(strstr(answer, "Retry-After: "));
    free(answer);
}

static void a_finished_frame_has_one_digest_and_serves_ranges(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], request[512], etag[80];
    http_submit_prepared(id);
    fake_job_render(http_house.jobs, id, UINT32_MAX);
    fake_job_set_state(http_house.jobs, id, GLINT_JOB_DONE);
    snprintf(request, sizeof request, "/v1/jobs/%s/frame.exr?outputs=beauty", id);
    char *whole = http_get(request);
    assert_int_equal(200, http_status(whole));
    assert_non_null(strstr(whole, "Repr-Digest: sha-256=:"));
    assert_int_equal(1, sscanf(strstr(whole, "ETag: "), "ETag: %79[^\r]", etag));
    free(whole);
    snprintf(request, sizeof request,
             "GET /v1/jobs/%s/frame.exr?outputs=beauty HTTP/1.1\r\n"
             "Range: bytes=0-3\r\nIf-Range: %s\r\n" HTTP_END,
             id, etag);
    char *part = http_ask(request);
    assert_int_equal(206, http_status(part));
    assert_memory_equal("\x76\x2f\x31\x01", strstr(part, "\r\n\r\n") + 4, 4); // OpenEXR's magic
    free(part);
    snprintf(request, sizeof request,
             "GET /v1/jobs/%s/frame.exr?outputs=beauty HTTP/1.1\r\n"
             "Range: bytes=99999999-\r\n" HTTP_END,
             id);
    part = http_ask(request);
    assert_int_equal(416, http_status(part));
    assert_non_null(strstr(part, "Content-Range: bytes */"));
    free(part);
}

static void waiting_ends_with_the_job(void **state)
{
    (void)state;
    char id[GLINT_JOB_ID_BYTES], request[256];
    http_submit(id);
    snprintf(request, sizeof request,
             "GET /v1/jobs/%s/frame.exr?wait=done&outputs=beauty HTTP/1.1\r\n" HTTP_END, id);
    const int done = http_dial();
    http_say(done, request);
    fake_job_prepare(http_house.jobs, id);
    fake_job_render(http_house.jobs, id, UINT32_MAX);
    fake_job_set_state(http_house.jobs, id, GLINT_JOB_DONE);
    char *answer = http_hear(done);
    assert_int_equal(200, http_status(answer));
    free(answer);

    http_submit_prepared(id);
    snprintf(request, sizeof request, "GET /v1/jobs/%s/frame.exr?wait=done HTTP/1.1\r\n" HTTP_END,
             id);
    const int cancelled = http_dial(); // not before: a header that does not come is cut off
    http_say(cancelled, request);
    fake_job_set_state(http_house.jobs, id, GLINT_JOB_CANCELLED);
    answer = http_hear(cancelled);
    assert_int_equal(409, http_status(answer));
    free(answer);
}

// Dawdlers and crowds

static void a_header_that_drips_is_cut_off(void **state)
{
    (void)state;
    const int fd = http_dial();
    const double begin = glint_now();
    struct pollfd p = {.fd = fd, .events = POLLIN};
    do { // a byte every 10 ms keeps any idle timeout from passing
        http_say(fd, "G");
        assert_true(glint_now() < begin + HTTP_PATIENCE);
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
        fd[i] = http_dial();
    char *answer = http_get("/healthz");
    const int status = http_status(answer);
    assert_true(status == 503 || status == 200);
    free(answer);
    for (int i = 0; i < 20; i++)
        close(fd[i]);
    return status == 503;
}

static void connections_over_the_limit_are_told_to_come_back(void **state)
{
    (void)state;
    const double until = glint_now() + HTTP_PATIENCE;
    while (!a_crowd_is_noticed()) // the server may not have seen all of it yet
        assert_true(glint_now() < until);
}

// The end

static void stopping_waits_for_a_long_import(void **state)
{
    (void)state;
    const int fd = http_dial();
    fake_store_gate(http_house.store, false);
    http_say(fd, "PUT /v1/scenes/room HTTP/1.1\r\nContent-Length: 2\r\n" HTTP_END "{}");
    http_await_metric("glint_http_received_bytes_total ", 2);
    assert_false(glint_http_drain(http_server, 0));
    fake_store_gate(http_house.store, true);
    glint_http_destroy(&http_server);
    close(fd);
}

int main(void)
{
    signal(SIGPIPE, SIG_IGN);
#define CLAIM(name) cmocka_unit_test_setup_teardown(name, http_start, http_stop)
#define STRICT(name) cmocka_unit_test_setup_teardown(name, http_start_strict, http_stop)
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
        STRICT(a_header_that_drips_is_cut_off),
        CLAIM(connections_over_the_limit_are_told_to_come_back),
        CLAIM(stopping_waits_for_a_long_import),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
