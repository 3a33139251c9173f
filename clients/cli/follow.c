#include "follow.h"
#include "interrupt.h"
#include "outlook.h"
#include "problem.h"
#include "protocol/job.h"
#include "sse.h"
#include "tev_stream.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_RETRIES 5
#define RETRY_MS 500

struct follower {
    struct glint_session *session;
    struct glint_sse sse;
    struct glint_progress_state shown;
    char state[24];
    unsigned events; // since the stream was opened
};

bool glint_follow_ended(const char *state)
{
    return strcmp(state, "done") == 0 || strcmp(state, "failed") == 0 ||
           strcmp(state, "cancelled") == 0;
}

static const cJSON *member(const cJSON *object, const char *name)
{
    return cJSON_GetObjectItemCaseSensitive(object, name);
}

// What an event or the job's resource says of its progress; null means not known.
static void take_number(const cJSON *data, const char *name, double *value)
{
    const cJSON *item = member(data, name);
    if (cJSON_IsNumber(item))
        *value = item->valuedouble;
    else if (cJSON_IsNull(item))
        *value = NAN;
}

static void take_count(const cJSON *data, const char *name, uint32_t *value)
{
    double number = NAN;
    take_number(data, name, &number);
    if (number >= 0 && number <= UINT32_MAX)
        *value = (uint32_t)number;
}

static void update(struct follower *f, const cJSON *data)
{
    const char *state = cJSON_GetStringValue(member(data, "state"));
    if (state)
        snprintf(f->state, sizeof f->state, "%s", state);
    take_number(data, "progress", &f->shown.fraction);
    take_number(data, "error", &f->shown.error);
    take_number(data, "eta_seconds", &f->shown.eta_seconds);
    const cJSON *estimate = member(data, "estimate");
    if (estimate)
        glint_outlook_short(estimate, f->shown.outlook, sizeof f->shown.outlook);
    take_count(data, "samples", &f->shown.samples);
    take_count(data, "target_samples", &f->shown.target_samples);
    if (f->shown.target_samples >= GLINT_MAX_SAMPLES)
        f->shown.target_samples = 0; // it stops for another reason
    glint_progress_show(&f->session->progress, &f->shown);
}

static void warn(struct follower *f, const cJSON *data)
{
    const char *text = cJSON_GetStringValue(member(data, "detail"));
    if (text)
        glint_progress_note(&f->session->progress, "warning: %s", text);
}

static bool on_event(void *user, const char *name, const char *text)
{
    struct follower *f = user;
    f->events++;
    cJSON *data = cJSON_Parse(text);
    if (strcmp(name, "warning") == 0)
        warn(f, data);
    else if (strcmp(name, "tile") != 0)
        update(f, data);
    cJSON_Delete(data);
    return !glint_follow_ended(f->state);
}

static bool on_bytes(void *user, const void *bytes, size_t size)
{
    struct follower *f = user;
    return glint_sse_feed(&f->sse, bytes, size);
}

// Reads the stream until the job ends or the stream does.
static glint_status stream(struct follower *f, const char *path, struct glint_error *err)
{
    glint_sse_restart(&f->sse);
    f->events = 0;
    const struct glint_request request = {.method = "GET",
                                          .path = path,
                                          .stream = true,
                                          .last_event_id = f->sse.id[0] ? f->sse.id : NULL,
                                          .receive = on_bytes,
                                          .user = f};
    return glint_client_send(f->session->client, &request, NULL, err);
}

static glint_status fetch(struct follower *f, const char *id, cJSON **job, struct glint_error *err)
{
    cJSON_Delete(*job);
    const glint_status status = glint_client_get(f->session->client, "/v1/jobs/", id, "", job, err);
    if (!status)
        update(f, *job);
    return status;
}

// The resource decides; the stream only tells when to look.
static glint_status follow(struct follower *f, const char *id, const char *events_path, cJSON **job,
                           struct glint_error *err)
{
    for (int silent = 0;;) {
        struct glint_error broken = {0};
        glint_tev_stream_tend(f->session->tev);
        stream(f, events_path, &broken);
        silent = f->events ? 0 : silent + 1;
        if (glint_interrupt_pending())
            return glint_error_finish(&broken), glint_fail(err, GLINT_E_BUSY, "", "interrupted");
        const glint_status status = fetch(f, id, job, err);
        glint_error_finish(&broken);
        if (status || glint_follow_ended(f->state))
            return status;
        if (silent > MAX_RETRIES)
            return glint_fail(err, GLINT_E_UNAVAILABLE, "", "the job's events do not come");
        if (silent)
            glint_interrupt_wait(-1, RETRY_MS);
    }
}

// Ends the pictures as well.
static void finish(struct follower *f)
{
    glint_tev_stream_destroy(&f->session->tev);
    glint_progress_finish(&f->session->progress);
    glint_sse_finish(&f->sse);
}

glint_status glint_follow_job(struct glint_session *s, const char *id, cJSON **job,
                              struct glint_error *err)
{
    struct follower f = {.session = s, .shown = {.error = NAN, .eta_seconds = NAN}};
    f.sse.event = on_event;
    f.sse.user = &f;
    *job = NULL;
    char *events_path = glint_client_path("/v1/jobs/", id, "/events");
    glint_status status = GLINT_E_NOMEM;
    if (events_path)
        status = follow(&f, id, events_path, job, err);
    else
        glint_fail(err, status, "", "no memory");
    finish(&f);
    free(events_path);
    return status;
}

glint_status glint_follow_verdict(struct glint_session *s, const cJSON *job,
                                  struct glint_error *err)
{
    const char *state = cJSON_GetStringValue(member(job, "state"));
    if (state && strcmp(state, "done") == 0)
        return GLINT_OK;
    if (state && strcmp(state, "failed") == 0) {
        glint_problem_faults(member(job, "problem"), GLINT_E_INTERNAL, err);
        return GLINT_E_INTERNAL;
    }
    s->cancelled = true;
    return glint_fail(err, GLINT_E_CONFLICT, "", "the job was cancelled");
}
