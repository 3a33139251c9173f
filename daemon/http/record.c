#include "http/record.h"

#include "base/clock.h"
#include "base/log.h"
#include "http/routes.h"

#include <arpa/inet.h>
#include <assert.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CLASSES 6

struct glint_record {
    glint_metrics *metrics;
    // By row of the table of routes, behind them those that match none. NULL: not met yet. Relaxed:
    // two threads that make one at a time get the same.
    _Atomic(glint_metric *) requests[GLINT_MAX_ROUTES + 1][CLASSES];
    glint_metric *seconds, *sent;
};

glint_status glint_record_create(struct glint_record **out, glint_metrics *metrics,
                                 struct glint_error *err)
{
    static const double bound[] = {0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30, 100};
    struct glint_record *record = *out = calloc(1, sizeof *record);
    if (!record)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for metrics");
    record->metrics = metrics;
    record->seconds = glint_metrics_histogram(
        metrics, "http_request_seconds",
        "Time from the header of a request to the end of its answer, streams left out.", bound,
        sizeof bound / sizeof *bound, NULL, 0);
    record->sent = glint_metrics_counter(metrics, "http_sent_bytes_total",
                                         "Bytes of answers' bodies.", NULL, 0);
    return GLINT_OK;
}

void glint_record_destroy(struct glint_record **record)
{
    free(*record);
    *record = NULL;
}

static glint_metric *name_series(const struct glint_record *record, const struct glint_route *route,
                                 int class)
{
    const char status[] = {(char)('0' + class), 'x', 'x', '\0'};
    const struct glint_label label[] = {{"method", route ? route->method : ""},
                                        {"route", route ? route->pattern : ""},
                                        {"status", status}};
    return glint_metrics_counter(
        record->metrics, "http_requests_total",
        "Requests by route and class of status; no route: it matched none.", label, 3);
}

static void count(struct glint_request *r)
{
    struct glint_record *record = r->http->record;
    const size_t row = r->route ? (size_t)(r->route - glint_route_table) : GLINT_MAX_ROUTES;
    const int class = r->status / 100;
    assert(row <= GLINT_MAX_ROUTES && class < CLASSES);
    _Atomic(glint_metric *) *series = &record->requests[row][class];
    glint_metric *metric = atomic_load_explicit(series, memory_order_acquire);
    if (!metric) {
        metric = name_series(record, r->route, class);
        atomic_store_explicit(series, metric, memory_order_release);
    }
    glint_metric_add(metric, 1);
    glint_metric_add(record->sent, (double)r->sent);
    if (!r->streams)
        glint_metric_observe(record->seconds, glint_now() - r->started);
}

static void say_peer(struct glint_request *r, char out[INET6_ADDRSTRLEN])
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(r->connection, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
    const struct sockaddr *at = info ? info->client_addr : NULL;
    *out = '\0';
    if (at && at->sa_family == AF_INET)
        inet_ntop(AF_INET, &((const struct sockaddr_in *)(const void *)at)->sin_addr, out,
                  INET6_ADDRSTRLEN);
    else if (at && at->sa_family == AF_INET6)
        inet_ntop(AF_INET6, &((const struct sockaddr_in6 *)(const void *)at)->sin6_addr, out,
                  INET6_ADDRSTRLEN);
}

// Nothing but ids: what else a client writes there could pass for other fields of the line.
static bool is_job(const char *text)
{
    return strspn(text, "0123456789abcdef") == GLINT_JOB_ID_BYTES - 1 &&
           !text[GLINT_JOB_ID_BYTES - 1];
}

static const char *job_of(const struct glint_request *r)
{
    if (*r->job)
        return r->job;
    const bool named = r->route && !strncmp(r->route->pattern, "/v1/jobs/{}", 11);
    return named && is_job(r->argument[0]) ? r->argument[0] : NULL;
}

// Looking is of interest to who debugs; changes, and who was turned away, to everybody.
static enum glint_log_level level_of(const struct glint_request *r)
{
    const bool refused = r->status == MHD_HTTP_UNAUTHORIZED || r->status == MHD_HTTP_FORBIDDEN;
    const bool looks = !strcmp(r->method, "GET") || !strcmp(r->method, "HEAD");
    return looks && !refused ? GLINT_LOG_DEBUG : GLINT_LOG_INFO;
}

static const char *or_null(const char *text)
{
    return *text ? text : NULL;
}

static void write_line(struct glint_request *r, bool complete)
{
    char trace[33], status[12], sent[24], seconds[32], peer[INET6_ADDRSTRLEN] = "";
    snprintf(trace, sizeof trace, "%.32s", r->trace + GLINT_TRACE_ID);
    snprintf(status, sizeof status, "%d", r->status);
    snprintf(sent, sizeof sent, "%" PRIu64, r->sent);
    snprintf(seconds, sizeof seconds, "%.6f", glint_now() - r->started);
    if (!r->http->loopback)
        say_peer(r, peer);
    const struct glint_log_field field[] = {
        {.name = "job_id", .text = job_of(r)},
        {.name = "request_id", .text = r->id},
        {.name = "trace_id", .text = trace},
        {.name = "client", .text = or_null(r->client_name)},
        {.name = "peer", .text = or_null(peer)},
        {.name = "method", .text = r->method, .said = true},
        {.name = "path", .text = r->url, .said = true},
        {.name = "status", .text = status, .number = true, .said = true},
        {.name = "bytes", .text = sent, .number = true, .said = true},
        {.name = "seconds", .text = seconds, .number = true, .said = true},
    };
    glint_log_event(level_of(r), "http", field, sizeof field / sizeof *field,
                    "%s %.256s: %d, %s bytes in %s s%s", r->method, r->url ? r->url : "", r->status,
                    sent, seconds, complete ? "" : ", connection lost");
}

void glint_record_request(struct glint_request *r, bool complete)
{
    count(r);
    if (level_of(r) != GLINT_LOG_DEBUG || glint_log_enabled("http"))
        write_line(r, complete);
}
