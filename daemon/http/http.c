#include "http/http.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/thread.h"
#include "http/accept.h"
#include "http/board.h"
#include "http/dispatch.h"
#include "http/events.h"
#include "http/frames.h"
#include "http/record.h"
#include "http/stream.h"

#include <assert.h>
#include <errno.h>
#include <math.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>

// The library's own limit only keeps it alive: what is over ours gets an answer. It holds per
// thread.
#define MOST_CONNECTIONS (GLINT_HTTP_THREADS * 131072u)
#define FRAME_BYTES ((size_t)256 << 20)
#define CARE_SECONDS 0.2 // between looks after streams
// Of sending tiles in one round, of which there are up to 500 a second: an eighth of a core.
#define TILE_SECONDS 0.00025
#define CONNECTION_BYTES ((size_t)65536) // a request's header has to fit

bool glint_http_enter(glint_http *http)
{
    pthread_mutex_lock(&http->mutex);
    const bool open = !http->stopping;
    http->suspended += open;
    pthread_mutex_unlock(&http->mutex);
    return open;
}

void glint_http_leave(glint_http *http)
{
    pthread_mutex_lock(&http->mutex);
    http->suspended--;
    pthread_cond_broadcast(&http->changed);
    pthread_mutex_unlock(&http->mutex);
}

bool glint_http_draining(glint_http *http)
{
    pthread_mutex_lock(&http->mutex);
    const bool draining = http->draining;
    pthread_mutex_unlock(&http->mutex);
    return draining;
}

bool glint_http_job_ended(glint_http *http, const char *job)
{
    struct glint_job_view view;
    const glint_status st = glint_jobs_view(http->jobs, job, &view, NULL);
    if (st)
        return st != GLINT_E_BUSY;
    const enum glint_job_state state = view.state;
    glint_jobs_release(http->jobs, &view);
    return state >= GLINT_JOB_DONE;
}

static void job_changed(void *user)
{
    glint_http *h = user;
    if (!atomic_load(&h->readers)) // whoever comes later sees the change
        return;
    uint64_t none = 0;
    // Relaxed: only a time. Of several changes before a round the first one's counts.
    atomic_compare_exchange_strong_explicit(&h->cause_us, &none, glint_topics_clock(),
                                            memory_order_relaxed, memory_order_relaxed);
    glint_watch_wake(h->watch);
}

static void round_of_watch(void *user)
{
    glint_http *h = user;
    const uint64_t cause_us = atomic_exchange_explicit(&h->cause_us, 0, memory_order_relaxed);
    glint_topics_round(h, cause_us ? cause_us : glint_topics_clock());
    glint_streams_serve(h, GLINT_STREAM_EVENTS, NULL, INFINITY);
    glint_dispatch_parked(h);
    glint_boards_round(h);
    if (glint_streams_serve(h, GLINT_STREAM_TILES, NULL, glint_now() + TILE_SECONDS))
        glint_watch_wake(h->watch);
    if (glint_http_draining(h))
        glint_streams_wake_all(h);
    if (glint_now() < h->cared_at + CARE_SECONDS)
        return;
    glint_streams_look_after(h);
    h->cared_at = glint_now();
}

static void on_connection(void *user, struct MHD_Connection *connection, void **client,
                          enum MHD_ConnectionNotificationCode code)
{
    glint_http *h = user;
    if (code == MHD_CONNECTION_NOTIFY_CLOSED) {
        glint_watch_remove(h->watch, (uint64_t)(uintptr_t)*client);
        return;
    }
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    const struct glint_http_limits limits = glint_http_limits(h);
    MHD_set_connection_option(connection, MHD_CONNECTION_OPTION_TIMEOUT,
                              (unsigned)(limits.idle_seconds + 0.999));
    *client = (void *)(uintptr_t)glint_watch_add(h->watch, info->connect_fd, limits.header_seconds);
}

// The library decodes paths and queries for callers that cannot tell %2F from a slash; we can.
static size_t leave_escaped(void *user, struct MHD_Connection *connection, char *text)
{
    (void)user;
    (void)connection;
    return strlen(text);
}

static void log_library(void *user, const char *format, va_list args)
{
    (void)user;
    char line[256];
    vsnprintf(line, sizeof line, format, args);
    line[strcspn(line, "\n")] = 0;
    glint_log(GLINT_LOG_DEBUG, "http", NULL, NULL, "%s", line);
}

static bool is_loopback(int fd)
{
    struct sockaddr_storage any;
    socklen_t length = sizeof any;
    if (getsockname(fd, (struct sockaddr *)&any, &length))
        return false;
    if (any.ss_family == AF_INET6)
        return IN6_IS_ADDR_LOOPBACK(&((struct sockaddr_in6 *)&any)->sin6_addr);
    return any.ss_family == AF_INET &&
           ntohl(((struct sockaddr_in *)&any)->sin_addr.s_addr) >> 24 == 127;
}

static const struct {
    const char *name, *thread;
    unsigned threads, capacity;
} lanes[GLINT_LANES] = {
    [GLINT_LANE_CALL] = {"call", "http-call", 2, 256},
    [GLINT_LANE_LOAD] = {"load", "http-load", 2, 16},
    [GLINT_LANE_EDIT] = {"edit", "http-edit", 2, 64},
    // A job that ends brings all who wait for it.
    [GLINT_LANE_FRAME] = {"frame", "http-frame", 2, 4096},
    [GLINT_LANE_STREAM] = {"stream", "http-stream", 2, GLINT_MAX_STREAMS}, // at most a task each
};

static glint_status start_lanes(glint_http *h, struct glint_error *err)
{
    glint_status st = GLINT_OK;
    for (int i = 0; !st && i < GLINT_LANES; i++)
        if (lanes[i].name)
            st = glint_offload_create(&h->lane[i], lanes[i].thread, lanes[i].threads,
                                      lanes[i].capacity, err);
    return st;
}

static void refresh_metrics(void *user)
{
    glint_http *h = user;
    pthread_mutex_lock(&h->lists);
    const uint32_t streams =
        h->streams[GLINT_STREAM_EVENTS].count + h->streams[GLINT_STREAM_TILES].count;
    pthread_mutex_unlock(&h->lists);
    glint_metric_set(h->open_streams, streams);
    for (int i = 0; i < GLINT_LANES; i++)
        if (h->lane[i])
            glint_metric_set(h->waiting[i], (double)glint_offload_waiting(h->lane[i]));
    glint_metric_set(h->sent, (double)atomic_load_explicit(&h->tiles_sent, memory_order_relaxed));
    glint_metric_set(h->skipped,
                     (double)atomic_load_explicit(&h->tiles_skipped, memory_order_relaxed));
    glint_metric_set(h->open_connections, glint_watch_clients(h->watch));
}

static void start_metrics(glint_http *h)
{
    glint_metrics *m = h->metrics;
    h->received =
        glint_metrics_counter(m, "http_received_bytes_total", "Bytes of request bodies.", NULL, 0);
    h->open_connections = glint_metrics_gauge(m, "http_connections", "Open connections.", NULL, 0);
    h->open_streams = glint_metrics_gauge(m, "http_streams", "Open streams.", NULL, 0);
    for (int i = 0; i < GLINT_LANES; i++) {
        const struct glint_label label = {"lane", lanes[i].name};
        if (lanes[i].name)
            h->waiting[i] = glint_metrics_gauge(m, "http_waiting",
                                                "Requests that wait for a thread.", &label, 1);
    }
    h->sent =
        glint_metrics_counter(m, "http_tiles_sent_total", "Tiles that were streamed.", NULL, 0);
    h->skipped = glint_metrics_counter(
        m, "http_tiles_skipped_total",
        "Versions that a client of a stream did not get because a newer one had come.", NULL, 0);
    glint_metrics_on_read(m, refresh_metrics, h);
}

static glint_status start_library(glint_http *h, bool secure, struct glint_error *err)
{
    const unsigned flags = MHD_USE_EPOLL_INTERNAL_THREAD | MHD_USE_NO_LISTEN_SOCKET |
                           MHD_ALLOW_SUSPEND_RESUME | MHD_USE_ITC | MHD_USE_ERROR_LOG |
                           (secure ? MHD_USE_TLS : 0);
    const struct MHD_OptionItem tls[] = {
        {MHD_OPTION_HTTPS_CERT_CALLBACK, 0, glint_tls_callback()},
        {MHD_OPTION_HTTPS_PRIORITIES, 0, (void *)glint_tls_priorities()},
        {MHD_OPTION_END, 0, NULL}};
    const struct MHD_OptionItem *const extra = secure ? tls : tls + 2;
    h->mhd = MHD_start_daemon(
        flags, 0, NULL, NULL, glint_dispatch_request, h, MHD_OPTION_EXTERNAL_LOGGER, log_library,
        NULL, MHD_OPTION_THREAD_POOL_SIZE, (unsigned)GLINT_HTTP_THREADS,
        MHD_OPTION_CONNECTION_LIMIT, MOST_CONNECTIONS, MHD_OPTION_CONNECTION_MEMORY_LIMIT,
        CONNECTION_BYTES, MHD_OPTION_NOTIFY_COMPLETED, glint_dispatch_completed, h,
        MHD_OPTION_NOTIFY_CONNECTION, on_connection, h, MHD_OPTION_UNESCAPE_CALLBACK, leave_escaped,
        h, MHD_OPTION_ARRAY, extra, MHD_OPTION_END);
    return h->mhd ? GLINT_OK : glint_fail(err, GLINT_E_IO, "", "the HTTP library does not start");
}

glint_status glint_http_create(glint_http **out, const struct glint_http_params *params,
                               struct glint_error *err)
{
    assert(out && params && params->jobs && params->store && params->devices && params->metrics);
    *out = NULL;
    glint_http *h = calloc(1, sizeof *h);
    if (!h)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the server");
    h->jobs = params->jobs;
    h->store = params->store;
    h->devices = params->devices;
    h->metrics = params->metrics;
    h->tokens = params->tokens;
    h->version = params->version;
    h->loopback = is_loopback(params->listen_fd);
    pthread_mutex_init(&h->lists, NULL);
    pthread_mutex_init(&h->mutex, NULL);
    glint_http_set_limits(h, &params->limits);
    glint_condition_init(&h->changed);

    glint_status st = glint_frames_create(&h->frames, 32, FRAME_BYTES, err);
    if (!st)
        st = glint_boards_create(&h->boards, err);
    if (!st)
        st = glint_topics_create(&h->topics, err);
    if (!st)
        st = start_lanes(h, err);
    if (!st)
        st = glint_record_create(&h->record, h->metrics, err);
    if (!st)
        st = glint_watch_create(&h->watch, round_of_watch, h, err);
    if (!st) {
        start_metrics(h);
        st = start_library(h, params->tls, err);
    }
    if (!st)
        st = glint_accept_start(&h->accept, h->mhd, params->listen_fd, err);
    if (st) {
        glint_http_destroy(&h);
        return st;
    }
    glint_jobs_on_change(h->jobs, job_changed, h);
    *out = h;
    return GLINT_OK;
}

bool glint_http_drain(glint_http *http, double seconds)
{
    const double until = glint_now() + seconds;
    pthread_mutex_lock(&http->mutex);
    const bool first = !http->draining;
    http->draining = true;
    pthread_mutex_unlock(&http->mutex);
    if (first)
        glint_accept_stop(&http->accept);
    glint_watch_wake(http->watch);
    pthread_mutex_lock(&http->mutex);
    while (http->requests && glint_condition_wait(&http->changed, &http->mutex, until)) {
    }
    const bool idle = !http->requests;
    pthread_mutex_unlock(&http->mutex);
    return idle;
}

// The library aborts the process if it is stopped while a connection is suspended.
static void stop_library(glint_http *h)
{
    glint_jobs_on_change(h->jobs, NULL, NULL);
    glint_http_drain(h, 0);
    pthread_mutex_lock(&h->mutex);
    h->stopping = true;
    pthread_mutex_unlock(&h->mutex);
    glint_streams_abort(h);
    pthread_mutex_lock(&h->mutex);
    while (h->suspended)
        pthread_cond_wait(&h->changed, &h->mutex);
    pthread_mutex_unlock(&h->mutex);
    MHD_stop_daemon(h->mhd);
}

void glint_http_destroy(glint_http **http)
{
    glint_http *h = *http;
    *http = NULL;
    if (!h)
        return;
    if (h->mhd)
        stop_library(h);
    for (int i = 0; i < GLINT_LANES; i++)
        glint_offload_destroy(&h->lane[i]);
    glint_watch_destroy(&h->watch);
    glint_topics_destroy(&h->topics);
    glint_boards_destroy(&h->boards);
    glint_record_destroy(&h->record);
    glint_frames_destroy(&h->frames);
    pthread_cond_destroy(&h->changed);
    pthread_mutex_destroy(&h->mutex);
    pthread_mutex_destroy(&h->lists);
    free(h);
}
