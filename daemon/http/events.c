// events.c - GET /v1/jobs/{id}/events.
#include "http/events.h"

#include "base/clock.h"
#include "http/answer.h"
#include "http/resources.h"
#include "http/topic.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_IDLE_TOPICS 64 // that nobody reads just now
#define MAX_SECONDS 0.2    // between looks at all jobs that somebody watches
#define GREETING "retry: 2000\n\n"

struct glint_topics {
    pthread_mutex_t mutex;
    struct glint_topic *first; // most lately opened first
    size_t count;

    uint32_t
        by_state[GLINT_JOB_CANCELLED + 1]; // jobs at the last round, as are these: the watcher's
    uint64_t submitted;
    double looked_at; // when all topics were looked at
};

struct events {
    struct glint_stream stream;
    struct glint_topic *topic;
    uint64_t cursor; // id of the last event that was given
    bool resumes;    // the client said where it stopped
};

uint64_t glint_topics_clock(void)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    return (uint64_t)now.tv_sec * 1000000 + (uint64_t)now.tv_nsec / 1000;
}

glint_status glint_topics_create(glint_topics **out, struct glint_error *err)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for events");
    pthread_mutex_init(&(*out)->mutex, NULL);
    return GLINT_OK;
}

void glint_topics_destroy(glint_topics **topics)
{
    glint_topics *all = *topics;
    *topics = NULL;
    if (!all)
        return;
    while (all->first) {
        struct glint_topic *t = all->first;
        all->first = t->next;
        glint_topic_destroy(t);
    }
    pthread_mutex_destroy(&all->mutex);
    free(all);
}

// With the mutex. Forgets those that nobody reads past MAX_IDLE_TOPICS.
static void trim(glint_topics *all)
{
    unsigned idle = 0;
    for (struct glint_topic **at = &all->first; *at;) {
        struct glint_topic *t = *at;
        if (!t->users && ++idle > MAX_IDLE_TOPICS) {
            *at = t->next;
            all->count--;
            glint_topic_destroy(t);
        } else {
            at = &t->next;
        }
    }
}

// The topic of a job, moved to the front, with one user more; NULL without memory.
static struct glint_topic *open_topic(glint_topics *all, const char *job)
{
    pthread_mutex_lock(&all->mutex);
    struct glint_topic **at = &all->first;
    while (*at && strcmp((*at)->job, job))
        at = &(*at)->next;
    struct glint_topic *t = *at;
    if (t)
        *at = t->next;
    else
        all->count += (t = glint_topic_create(job)) != NULL;
    if (t) {
        t->next = all->first;
        all->first = t;
        t->users++;
    }
    trim(all);
    pthread_mutex_unlock(&all->mutex);
    return t;
}

static void close_topic(glint_topics *all, struct glint_topic *t)
{
    pthread_mutex_lock(&all->mutex);
    t->users--;
    trim(all);
    pthread_mutex_unlock(&all->mutex);
}

// Jobs that render change with every pixel, all others with some job's state. Two changes that make
// up for each other are seen a little later.
static bool all_may_have_changed(glint_topics *all, glint_jobs *jobs)
{
    struct glint_jobs_stats now;
    glint_jobs_stats(jobs, &now);
    const double time = glint_now();
    if (now.submitted == all->submitted && time < all->looked_at + MAX_SECONDS &&
        !memcmp(now.by_state, all->by_state, sizeof now.by_state))
        return false;
    memcpy(all->by_state, now.by_state, sizeof now.by_state);
    all->submitted = now.submitted;
    all->looked_at = time;
    return true;
}

// Those with readers that are worth a look, each with one user more, in a malloc'd array; NULL
// without memory.
static struct glint_topic **hold(glint_topics *all, bool quiet_too, size_t *count)
{
    *count = 0;
    pthread_mutex_lock(&all->mutex);
    struct glint_topic **held = malloc((all->count + 1) * sizeof(struct glint_topic *));
    for (struct glint_topic *t = all->first; held && t; t = t->next)
        // Relaxed: a round that comes too early for it is followed by another.
        if (t->users && (quiet_too || !atomic_load_explicit(&t->quiet, memory_order_relaxed))) {
            t->users++;
            held[(*count)++] = t;
        }
    pthread_mutex_unlock(&all->mutex);
    return held;
}

void glint_topics_round(glint_http *http, uint64_t cause_us)
{
    size_t count;
    struct glint_topic **held =
        hold(http->topics, all_may_have_changed(http->topics, http->jobs), &count);
    for (size_t i = 0; i < count; i++) {
        glint_topic_look(held[i], http->jobs, cause_us);
        close_topic(http->topics, held[i]);
    }
    free(held);
}

// Streams

static enum glint_stream_next read_events(struct glint_stream *stream, struct glint_blob **part)
{
    struct events *s = (struct events *)stream;
    switch (glint_topic_read(s->topic, &s->cursor, part)) {
    case GLINT_TOPIC_EVENT:
        return GLINT_STREAM_PART;
    case GLINT_TOPIC_LOST:
        *part = glint_topic_state(s->topic, stream->http->jobs, "reset", "", &s->cursor);
        return *part ? GLINT_STREAM_PART : GLINT_STREAM_END;
    case GLINT_TOPIC_OVER:
        return GLINT_STREAM_END;
    case GLINT_TOPIC_NOTHING:
        break;
    }
    return GLINT_STREAM_NOTHING;
}

static void destroy(struct glint_stream *stream)
{
    struct events *s = (struct events *)stream;
    close_topic(stream->http->topics, s->topic);
    free(s);
}

// What the client is told first: where it stopped, that this is not known, or how things stand.
static struct glint_blob *greet(struct events *s, glint_jobs *jobs)
{
    const bool known = s->resumes && glint_topic_knows(s->topic, s->cursor);
    if (!known)
        return glint_topic_state(s->topic, jobs, s->resumes ? "reset" : "state", GREETING,
                                 &s->cursor);
    uint8_t *text = (uint8_t *)strdup(GREETING);
    return text ? glint_blob_take(text, strlen(GREETING)) : NULL;
}

static void start(struct glint_request *r, struct events *s)
{
    const char *last = glint_request_header(r, "Last-Event-ID");
    s->resumes = last && *last;
    s->cursor = s->resumes ? strtoull(last, NULL, 10) : 0;
    s->stream = (struct glint_stream){.http = r->http,
                                      .kind = GLINT_STREAM_EVENTS,
                                      .news = &s->topic->news,
                                      .read = read_events,
                                      .destroy = destroy,
                                      .ping = ": ping\n\n"};
    glint_topic_look(s->topic, r->http->jobs, glint_topics_clock());
    // A client that comes back after the end has nothing to wait for: 204 stops its attempts.
    const bool over = s->resumes && glint_topic_ended_with(s->topic, s->cursor);
    s->stream.part = over ? NULL : greet(s, r->http->jobs);
    if (s->stream.part) {
        glint_stream_start(r, &s->stream, "text/event-stream");
        return;
    }
    if (over)
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
    if (s && (s->topic = open_topic(r->http->topics, r->argument[0]))) {
        start(r, s);
        return;
    }
    free(s);
    glint_answer_response(r, 0, NULL);
}
