#include "http_fixture.h"

#include "base/clock.h"

#include <arpa/inet.h>
#include <poll.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmocka.h>

struct fake_house http_house;
static glint_metrics *metrics;
glint_http *http_server;
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

static int serve(double header_seconds, double idle_seconds, double ping_seconds)
{
    struct glint_error err = {0};
    assert_int_equal(GLINT_OK, glint_metrics_create(&metrics, &err));
    const struct glint_http_params params = {.listen_fd = listen_anywhere(),
                                             .jobs = http_house.jobs,
                                             .store = http_house.store,
                                             .devices = http_house.devices,
                                             .metrics = metrics,
                                             .version = "0",
                                             .limits = {.job_bytes = 4096,
                                                        .scene_bytes = 100000,
                                                        .connections = 20,
                                                        .streams = 8,
                                                        .header_seconds = header_seconds,
                                                        .idle_seconds = idle_seconds,
                                                        .ping_seconds = ping_seconds}};
    assert_int_equal(GLINT_OK, glint_http_create(&http_server, &params, &err));
    return 0;
}

int http_start(void **state)
{
    (void)state;
    fake_house_open(&http_house, HTTP_TILES);
    return serve(0, 0, 0);
}

int http_start_strict(void **state)
{
    (void)state;
    fake_house_open(&http_house, HTTP_TILES);
    return serve(0.3, 0, 0);
}

int http_start_impatient(void **state)
{
    (void)state;
    fake_house_open(&http_house, HTTP_TILES);
    return serve(0, 1, 0.3);
}

void http_serve_again(void)
{
    glint_metrics_destroy(&metrics);
    serve(0, 0, 0);
}

int http_stop(void **state)
{
    (void)state;
    glint_http_destroy(&http_server);
    glint_metrics_destroy(&metrics);
    fake_house_close(&http_house);
    return 0;
}

int http_dial(void)
{
    struct sockaddr_in a = {.sin_family = AF_INET,
                            .sin_addr.s_addr = htonl(INADDR_LOOPBACK),
                            .sin_port = htons((uint16_t)port)};
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(0, connect(fd, (struct sockaddr *)&a, sizeof a));
    return fd;
}

void http_say(int fd, const char *text)
{
    for (size_t left = strlen(text); left;) {
        const ssize_t n = send(fd, text, left, MSG_NOSIGNAL);
        if (n < 0)
            return; // refused early
        text += n;
        left -= (size_t)n;
    }
}

char *http_hear_until(int fd, const char *last)
{
    size_t used = 0, capacity = 1 << 16;
    char *text = malloc(capacity);
    for (;;) {
        struct pollfd p = {.fd = fd, .events = POLLIN};
        assert_int_equal(1, poll(&p, 1, (int)(HTTP_PATIENCE * 1e3)));
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

char *http_hear(int fd)
{
    char *text = http_hear_until(fd, NULL);
    close(fd);
    return text;
}

int http_status(const char *answer)
{
    int status = 0;
    sscanf(answer, "HTTP/1.1 %d", &status);
    return status;
}

char *http_ask(const char *request)
{
    const int fd = http_dial();
    http_say(fd, request);
    return http_hear(fd);
}

char *http_get(const char *target)
{
    char request[1024];
    snprintf(request, sizeof request, "GET %s HTTP/1.1\r\n" HTTP_END, target);
    return http_ask(request);
}

char *http_post_job(const char *json)
{
    char request[4096];
    snprintf(request, sizeof request,
             "POST /v1/jobs HTTP/1.1\r\nContent-Type: application/json\r\nContent-Length: "
             "%zu\r\n" HTTP_END "%s",
             strlen(json), json);
    return http_ask(request);
}

void http_submit(char id[GLINT_JOB_ID_BYTES])
{
    char *answer = http_post_job("{\"scene\":\"room\"}");
    assert_int_equal(202, http_status(answer));
    assert_non_null(strstr(answer, "Location: /v1/jobs/"));
    free(answer);
    fake_job_last(http_house.jobs, id);
}

void http_submit_prepared(char id[GLINT_JOB_ID_BYTES])
{
    http_submit(id);
    fake_job_prepare(http_house.jobs, id);
}

double http_metric(const char *name)
{
    char *text = http_get("/metrics");
    const char *line = strstr(text, name);
    // HELP and TYPE come first; the sample line starts with the name.
    while (line && line[-1] != '\n')
        line = strstr(line + 1, name);
    const double value = line ? strtod(line + strlen(name), NULL) : -1;
    free(text);
    return value;
}

void http_await_metric(const char *name, double value)
{
    const double until = glint_now() + HTTP_PATIENCE;
    while (http_metric(name) != value)
        assert_true(glint_now() < until);
}
