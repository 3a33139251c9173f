// events.c - GET /v1/jobs/{id}/events.
#include "http/events.h"

#include "base/clock.h"
#include "http/answer.h"
#include "http/resources.h"
#include "http/stream.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define RING 256
#define MAX_TOPICS 64 // that nobody reads just now
#define PROGRESS_SECONDS 0.25
#define PING_SECONDS 15.0

struct event {
    const char *name;
    char *data; // one line of JSON, owned
};

struct topic {
    struct topic *next;
    char job[GLINT_JOB_ID_BYTES];
    unsigned readers; // guarded by the topics' mutex

    pthread_mutex_t mutex;   // guards the rest
    struct event ring[RING]; // event `id` is ring[id % RING]
    uint64_t last;           // id of the newest
    uint64_t count;          // events so far
    char state[16];
    double samples, progress;
    int warnings;
    double progress_at;
    bool ended, gone;
};

struct glint_topics {
    pthread_mutex_t mutex; // taken before any topic's
    struct topic *first;   // least lately opened last
};

struct events {
    struct glint_stream stream;
    struct topic *topic;
    uint64_t cursor; // id of the last event that was sent
    bool greeted;
    bool resumes; // the client said where it stopped
};

glint_status glint_topics_create(glint_topics **out, struct glint_error *err)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for events");
    pthread_mutex_init(&(*out)->mutex, NULL);
    return GLINT_OK;
}

static void free_topic(struct topic *t)
{
    for (int i = 0; i < RING; i++)
        free(t->ring[i].data);
    pthread_mutex_destroy(&t->mutex);
    free(t);
}

void glint_topics_destroy(glint_topics **topics)
{
    glint_topics *all = *topics;
    *topics = NULL;
    if (!all)
        return;
    while (all->first) {
        struct topic *t = all->first;
        all->first = t->next;
        free_topic(t);
    }
    pthread_mutex_destroy(&all->mutex);
    free(all);
}

// With the mutex. Forgets those that nobody reads past MAX_TOPICS.
static void trim(glint_topics *all)
{
    unsigned idle = 0;
    for (struct topic **at = &all->first; *at;) {
        struct topic *t = *at;
        if (!t->readers && ++idle > MAX_TOPICS) {
            *at = t->next;
            free_topic(t);
        } else {
            at = &t->next;
        }
    }
}

static struct topic *new_topic(const char *job)
{
    struct topic *t = calloc(1, sizeof *t);
    if (!t)
        return NULL;
    strcpy(t->job, job);
    pthread_mutex_init(&t->mutex, NULL);
    // Milliseconds: over every id of an older topic of this job, which had fewer events than that.
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    t->last = (uint64_t)now.tv_sec * 1000 + (uint64_t)now.tv_nsec / 1000000;
    t->progress_at = -INFINITY;
    return t;
}

// The topic of a job, moved to the front, with one reader more.
static struct topic *open_topic(glint_topics *all, const char *job)
{
    pthread_mutex_lock(&all->mutex);
    struct topic **at = &all->first;
    while (*at && strcmp((*at)->job, job))
        at = &(*at)->next;
    struct topic *t = *at;
    if (t)
        *at = t->next;
    else
        t = new_topic(job);
    if (t) {
        t->next = all->first;
        all->first = t;
        t->readers++;
    }
    trim(all);
    pthread_mutex_unlock(&all->mutex);
    return t;
}

static void close_topic(glint_topics *all, struct topic *t)
{
    pthread_mutex_lock(&all->mutex);
    t->readers--;
    trim(all);
    pthread_mutex_unlock(&all->mutex);
}

// Takes `data`; without memory the event is lost.
static void publish(struct topic *t, const char *name, char *data)
{
    if (!data)
        return;
    struct event *e = &t->ring[++t->last % RING];
    free(e->data);
    *e = (struct event){name, data};
    t->count++;
}

static double number(const cJSON *job, const char *name)
{
    return cJSON_GetNumberValue(cJSON_GetObjectItemCaseSensitive(job, name));
}

static void publish_progress(struct topic *t, const cJSON *job)
{
    static const char *const members[] = {"state", "samples", "progress",
                                          "error", "seconds", "eta_seconds"};
    const double samples = number(job, "samples"), progress = number(job, "progress");
    const double now = glint_now();
    if ((samples == t->samples && progress == t->progress) ||
        now < t->progress_at + PROGRESS_SECONDS)
        return;
    t->samples = samples;
    t->progress = progress;
    t->progress_at = now;
    cJSON *data = cJSON_CreateObject();
    for (size_t i = 0; i < sizeof members / sizeof *members; i++) {
        const cJSON *value = cJSON_GetObjectItemCaseSensitive(job, members[i]);
        if (value)
            cJSON_AddItemToObject(data, members[i], cJSON_Duplicate(value, true));
    }
    publish(t, "progress", cJSON_PrintUnformatted(data));
    cJSON_Delete(data);
}

static void publish_warnings(struct topic *t, const cJSON *job)
{
    const cJSON *warnings = cJSON_GetObjectItemCaseSensitive(job, "warnings");
    const int count = cJSON_GetArraySize(warnings);
    for (; t->warnings < count; t->warnings++) {
        cJSON *data = cJSON_CreateObject();
        const cJSON *item = cJSON_GetArrayItem(warnings, t->warnings);
        cJSON_AddItemToObject(data, "detail", cJSON_Duplicate(item, true));
        publish(t, "warning", cJSON_PrintUnformatted(data));
        cJSON_Delete(data);
    }
}

static bool has_ended(const char *state)
{
    for (int s = GLINT_JOB_DONE; s <= GLINT_JOB_CANCELLED; s++)
        if (!strcmp(state, glint_job_state_name((enum glint_job_state)s)))
            return true;
    return false;
}

static void publish_state(struct topic *t, const cJSON *job)
{
    const char *state = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(job, "state"));
    if (!state || !strcmp(state, t->state))
        return;
    snprintf(t->state, sizeof t->state, "%s", state);
    t->ended = has_ended(state);
    publish(t, "state", cJSON_PrintUnformatted(job));
    if (t->ended)
        publish(t, "done", cJSON_PrintUnformatted(job));
}

// Looks at the job and publishes what is new; returns its description, NULL if it is gone. With
// the topic's mutex.
static cJSON *look(glint_http *h, struct topic *t)
{
    cJSON *job = glint_jobs_describe(h->jobs, t->job, NULL);
    t->gone = !job;
    if (!job || t->ended) // nothing follows `done`
        return job;
    publish_warnings(t, job);
    publish_progress(t, job);
    publish_state(t, job);
    return job;
}

static void send_event(struct events *s, uint64_t id, const char *name, const char *data)
{
    char head[96];
    const int n =
        snprintf(head, sizeof head, "id: %llu\nevent: %s\ndata: ", (unsigned long long)id, name);
    glint_stream_add(&s->stream, head, (size_t)n);
    glint_stream_add(&s->stream, data, strlen(data));
    glint_stream_add(&s->stream, "\n\n", 2);
}

// Sends the whole state, which stands for every event up to now, but for the end: that has an event
// of its own, so that who is cut off before it still gets it.
static void send_state(struct events *s, const char *name, const cJSON *job)
{
    char *data = cJSON_PrintUnformatted(job);
    s->cursor = s->topic->last;
    if (!data)
        return;
    const bool ended = s->topic->ended;
    send_event(s, s->cursor - ended, name, data);
    if (ended)
        send_event(s, s->cursor, "done", data);
    free(data);
}

static bool in_ring(const struct topic *t, uint64_t after)
{
    const uint64_t kept = t->count < RING ? t->count : RING;
    return after <= t->last && t->last - after <= kept;
}

static void send_news(struct events *s, const cJSON *job)
{
    struct topic *t = s->topic;
    const bool lost = !in_ring(t, s->cursor);
    if (!s->greeted)
        glint_stream_add(&s->stream, "retry: 2000\n\n", 13);
    if (!s->greeted && !s->resumes)
        send_state(s, "state", job);
    else if (lost)
        send_state(s, "reset", job);
    s->greeted = true;
    for (; s->cursor < t->last; s->cursor++) {
        const struct event *e = &t->ring[(s->cursor + 1) % RING];
        send_event(s, s->cursor + 1, e->name, e->data);
    }
}

static bool fill(struct glint_stream *stream)
{
    struct events *s = (struct events *)stream;
    struct topic *t = s->topic;
    pthread_mutex_lock(&t->mutex);
    cJSON *job = look(stream->http, t);
    if (job)
        send_news(s, job);
    const bool more = job && !t->ended;
    pthread_mutex_unlock(&t->mutex);
    cJSON_Delete(job);
    if (more && !stream->length && glint_now() > stream->filled_at + PING_SECONDS)
        glint_stream_add(stream, ": ping\n\n", 8);
    return more;
}

static void destroy(struct glint_stream *stream)
{
    struct events *s = (struct events *)stream;
    if (s->topic)
        close_topic(stream->http->topics, s->topic);
    free(s);
}

// A client that comes back after the end has nothing to wait for: 204 stops its attempts.
static bool nothing_follows(glint_http *h, struct events *s)
{
    pthread_mutex_lock(&s->topic->mutex);
    cJSON_Delete(look(h, s->topic));
    const bool over = s->topic->ended && s->resumes && s->cursor == s->topic->last;
    pthread_mutex_unlock(&s->topic->mutex);
    return over;
}

static void start(struct glint_request *r, struct events *s)
{
    const char *last = glint_request_header(r, "Last-Event-ID");
    s->resumes = last && *last;
    s->cursor = s->resumes ? strtoull(last, NULL, 10) : 0;
    s->stream.fill = fill;
    s->stream.destroy = destroy;
    s->stream.http = r->http;
    s->topic = open_topic(r->http->topics, r->argument[0]);
    if (s->topic && !nothing_follows(r->http, s)) {
        glint_stream_start(r, &s->stream, "text/event-stream");
        return;
    }
    if (s->topic)
        glint_answer_empty(r, MHD_HTTP_NO_CONTENT);
    else
        glint_answer_response(r, 0, NULL);
    destroy(&s->stream);
}

void glint_http_events_stream(struct glint_request *r)
{
    struct glint_error err = {0};
    cJSON *job = glint_jobs_describe(r->http->jobs, r->argument[0], &err);
    if (!job) {
        glint_answer_error(r, &err);
        return;
    }
    cJSON_Delete(job);
    struct events *s = calloc(1, sizeof *s);
    if (s)
        start(r, s);
    else
        glint_answer_response(r, 0, NULL);
}
