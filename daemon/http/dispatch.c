#include "http/dispatch.h"

#include "base/clock.h"
#include "http/answer.h"
#include "http/record.h"
#include "http/routes.h"

#include <assert.h>
#include <math.h>
#include <string.h>

static enum MHD_Result queue(struct glint_request *r)
{
    if (r->close || glint_http_draining(r->http))
        glint_answer_header(r, "Connection", "close");
    return MHD_queue_response(r->connection, (unsigned)r->status, r->response);
}

static void refuse_busy(struct glint_request *r, const char *why)
{
    struct glint_error err = {0};
    glint_fail(&err, GLINT_E_BUSY, "", "%s", why);
    glint_answer_error(r, &err);
}

// The request belongs to the library's thread from here on.
static void resume(struct glint_request *r)
{
    glint_http *h = r->http;
    MHD_resume_connection(r->connection);
    glint_http_leave(h);
}

static void client_left(void *user)
{
    struct glint_request *r = user;
    atomic_store_explicit(&r->left, true, memory_order_relaxed);
}

static void park(struct glint_request *r)
{
    glint_http *h = r->http;
    glint_watch_attend(h->watch, r->client, client_left, NULL, r);
    pthread_mutex_lock(&h->lists);
    r->next_parked = h->first_parked;
    h->first_parked = r;
    atomic_fetch_add(&h->readers, 1);
    pthread_mutex_unlock(&h->lists);
    // The job may have ended after the handler looked.
    glint_watch_wake(h->watch);
}

static void run(struct glint_task *task)
{
    struct glint_request *r = (struct glint_request *)task;
    r->park = false;
    r->route->handle(r);
    if (r->park && glint_http_draining(r->http)) {
        refuse_busy(r, "the server stops");
        r->park = false;
    }
    assert(r->status || r->park);
    if (r->park)
        park(r);
    else
        resume(r);
}

// A job and whether it has ended: those who wait for the same one mostly stand together.
struct verdict {
    const char *job;
    bool ended;
};

static bool due(struct glint_request *r, struct verdict *last)
{
    if (!last->job || strcmp(last->job, r->argument[0]))
        *last = (struct verdict){r->argument[0], glint_http_job_ended(r->http, r->argument[0])};
    return last->ended || atomic_load_explicit(&r->left, memory_order_relaxed) ||
           glint_http_draining(r->http);
}

// Unlinks the parked requests that are due and returns them as a list.
static struct glint_request *take_due(glint_http *http)
{
    struct glint_request *taken = NULL;
    struct verdict last = {0};
    pthread_mutex_lock(&http->lists);
    for (struct glint_request **at = &http->first_parked; *at;) {
        struct glint_request *r = *at;
        if (due(r, &last)) {
            *at = r->next_parked;
            atomic_fetch_sub(&http->readers, 1);
            r->next_parked = taken;
            taken = r;
        } else {
            at = &r->next_parked;
        }
    }
    pthread_mutex_unlock(&http->lists);
    return taken;
}

void glint_dispatch_parked(glint_http *http)
{
    struct glint_request *next;
    for (struct glint_request *r = take_due(http); r; r = next) {
        next = r->next_parked;
        glint_watch_attend(http->watch, r->client, NULL, NULL, NULL);
        if (atomic_load_explicit(&r->left, memory_order_relaxed))
            resume(r);
        else if (!glint_offload_push(http->lane[r->route->lane], &r->task))
            park(r);
    }
}

static enum MHD_Result start_handler(struct glint_request *r)
{
    const enum glint_lane lane = r->route->lane;
    if (lane == GLINT_LANE_NOW) {
        r->route->handle(r);
        assert(r->status);
        return queue(r);
    }
    if (glint_http_draining(r->http) || !glint_http_enter(r->http)) {
        refuse_busy(r, "the server stops");
        return queue(r);
    }
    r->task.run = run;
    MHD_suspend_connection(r->connection);
    if (!glint_offload_push(r->http->lane[lane], &r->task)) {
        refuse_busy(r, "too many requests wait");
        resume(r);
    }
    return MHD_YES;
}

static enum MHD_Result start(glint_http *h, struct MHD_Connection *connection, const char *url,
                             const char *method, const char *version, void **context)
{
    struct glint_request *r = glint_request_create(h, connection, url, method, version);
    if (!r)
        return MHD_NO;
    *context = r;
    pthread_mutex_lock(&h->mutex);
    h->requests++;
    pthread_mutex_unlock(&h->mutex);
    if (glint_watch_clients(h->watch) > glint_http_limits(h).connections) {
        refuse_busy(r, "too many connections");
        r->close = true;
    }
    const bool body =
        glint_request_header(r, "Content-Length") || glint_request_header(r, "Transfer-Encoding");
    glint_watch_deadline(h->watch, r->client, body ? GLINT_BODY_SECONDS : INFINITY);
    if (!r->status || !body)
        return MHD_YES;
    // Only now, before the body, can an answer come early; the rest of the connection is lost.
    r->close = true;
    return queue(r);
}

enum MHD_Result glint_dispatch_request(void *user, struct MHD_Connection *connection,
                                       const char *url, const char *method, const char *version,
                                       const char *data, size_t *size, void **context)
{
    struct glint_request *r = *context;
    if (!r)
        return start(user, connection, url, method, version, context);
    if (*size) {
        const size_t n = *size;
        *size = 0;
        glint_metric_add(r->http->received, (double)n);
        return glint_body_add(r, data, n) ? MHD_YES : MHD_NO;
    }
    if (r->left)
        return MHD_NO;
    if (r->status)
        return queue(r);
    if (r->begun) // suspended and woken without an answer
        return MHD_YES;
    r->begun = true;
    glint_watch_deadline(r->http->watch, r->client, INFINITY);
    return glint_body_finish(r) ? start_handler(r) : queue(r);
}

void glint_dispatch_completed(void *user, struct MHD_Connection *connection, void **context,
                              enum MHD_RequestTerminationCode code)
{
    (void)connection;
    glint_http *h = user;
    struct glint_request *r = *context;
    *context = NULL;
    if (!r)
        return;
    glint_record_request(r, code == MHD_REQUEST_TERMINATED_COMPLETED_OK || r->whole);
    glint_watch_deadline(h->watch, r->client, glint_http_limits(h).idle_seconds);
    glint_request_destroy(&r);
    pthread_mutex_lock(&h->mutex);
    h->requests--;
    pthread_cond_broadcast(&h->changed);
    pthread_mutex_unlock(&h->mutex);
}
