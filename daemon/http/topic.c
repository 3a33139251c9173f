#include "http/topic.h"

#include "base/clock.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PROGRESS_SECONDS 0.25 // between events

struct glint_topic *glint_topic_create(const char *job)
{
    struct glint_topic *t = calloc(1, sizeof *t);
    if (!t)
        return NULL;
    strcpy(t->job, job);
    pthread_mutex_init(&t->mutex, NULL);
    t->progress_at = -INFINITY;
    return t;
}

void glint_topic_destroy(struct glint_topic *topic)
{
    for (int i = 0; i < GLINT_TOPIC_RING; i++)
        glint_blob_release(&topic->ring[i].text);
    pthread_mutex_destroy(&topic->mutex);
    free(topic);
}

// Takes `json`; NULL without memory.
static struct glint_blob *write_event(const char *before, uint64_t id, const char *name, char *json)
{
    char *text = NULL;
    const int length = json ? asprintf(&text, "%sid: %llu\nevent: %s\ndata: %s\n\n", before,
                                       (unsigned long long)id, name, json)
                            : -1;
    free(json);
    return length < 0 ? NULL : glint_blob_take((uint8_t *)text, (size_t)length);
}

// From here on: with the topic's mutex.

static struct glint_topic_event *event_at(struct glint_topic *t, uint64_t index)
{
    return &t->ring[index % GLINT_TOPIC_RING];
}

static uint64_t first_kept(const struct glint_topic *t)
{
    return t->count < GLINT_TOPIC_RING ? 0 : t->count - GLINT_TOPIC_RING;
}

// Takes `json`; without memory the event is lost.
static void publish(struct glint_topic *t, uint64_t cause_us, const char *name, char *json)
{
    const uint64_t id = cause_us > t->last ? cause_us : t->last + 1;
    struct glint_blob *text = write_event("", id, name, json);
    if (!text)
        return;
    struct glint_topic_event *e = event_at(t, t->count++);
    glint_blob_release(&e->text);
    *e = (struct glint_topic_event){id, text};
    t->last = id;
}

static double number(const cJSON *job, const char *name)
{
    return cJSON_GetNumberValue(cJSON_GetObjectItemCaseSensitive(job, name));
}

static char *write_progress(const cJSON *job)
{
    static const char *const members[] = {"state", "samples",  "target_samples", "progress",
                                          "error", "estimate", "seconds",        "eta_seconds"};
    cJSON *data = cJSON_CreateObject();
    for (size_t i = 0; i < sizeof members / sizeof *members; i++) {
        const cJSON *value = cJSON_GetObjectItemCaseSensitive(job, members[i]);
        if (value)
            cJSON_AddItemToObject(data, members[i], cJSON_Duplicate(value, true));
    }
    char *text = cJSON_PrintUnformatted(data);
    cJSON_Delete(data);
    return text;
}

static void publish_progress(struct glint_topic *t, const cJSON *job, uint64_t cause_us, double now)
{
    const double samples = number(job, "samples"), progress = number(job, "progress");
    if ((samples == t->samples && progress == t->progress) ||
        now < t->progress_at + PROGRESS_SECONDS)
        return;
    t->samples = samples;
    t->progress = progress;
    t->progress_at = now;
    publish(t, cause_us, "progress", write_progress(job));
}

static void publish_warnings(struct glint_topic *t, const cJSON *job, uint64_t cause_us)
{
    const cJSON *warnings = cJSON_GetObjectItemCaseSensitive(job, "warnings");
    const int count = cJSON_GetArraySize(warnings);
    for (; t->warnings < count; t->warnings++) {
        cJSON *data = cJSON_CreateObject();
        const cJSON *item = cJSON_GetArrayItem(warnings, t->warnings);
        cJSON_AddItemToObject(data, "detail", cJSON_Duplicate(item, true));
        publish(t, cause_us, "warning", cJSON_PrintUnformatted(data));
        cJSON_Delete(data);
    }
    t->warnings = count; // fewer: a live job has moved to what they do not hold for
}

static bool has_ended(const char *state)
{
    for (int s = GLINT_JOB_DONE; s <= GLINT_JOB_CANCELLED; s++)
        if (!strcmp(state, glint_job_state_name((enum glint_job_state)s)))
            return true;
    return false;
}

static void publish_state(struct glint_topic *t, const cJSON *job, uint64_t cause_us)
{
    const char *state = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(job, "state"));
    if (!state || !strcmp(state, t->state))
        return;
    snprintf(t->state, sizeof t->state, "%s", state);
    t->ended = has_ended(state);
    publish(t, cause_us, "state", cJSON_PrintUnformatted(job));
    if (t->ended)
        publish(t, cause_us, "done", cJSON_PrintUnformatted(job));
}

// Describing a job costs more than asking whether anything is worth it: a new state at once, all
// else with the next progress.
static bool worth_a_look(const struct glint_topic *t, glint_jobs *jobs, double now,
                         uint64_t *sequence)
{
    struct glint_job_view view;
    *sequence = 0;
    const glint_status st = glint_jobs_view(jobs, t->job, &view, NULL);
    if (st) // it is gone, or being prepared
        return true;
    const bool other_state = strcmp(glint_job_state_name(view.state), t->state);
    *sequence = view.sequence;
    glint_jobs_release(jobs, &view);
    return other_state ||
           (!t->ended && *sequence != t->looked_at && now >= t->progress_at + PROGRESS_SECONDS);
}

static void look(struct glint_topic *t, glint_jobs *jobs, uint64_t cause_us)
{
    const char *rendering = glint_job_state_name(GLINT_JOB_RENDERING);
    const double now = glint_now();
    uint64_t sequence;
    if (!worth_a_look(t, jobs, now, &sequence))
        return;
    cJSON *job = glint_jobs_describe(jobs, t->job, NULL);
    t->gone = !job;
    if (!job)
        return;
    publish_warnings(t, job, cause_us);
    publish_progress(t, job, cause_us, now);
    publish_state(t, job, cause_us);
    t->looked_at = sequence;
    atomic_store_explicit(&t->quiet, strcmp(t->state, rendering), memory_order_relaxed);
    cJSON_Delete(job);
}

// Events up to an id; false: it is not in the ring.
static bool find(struct glint_topic *t, uint64_t id, uint64_t *index)
{
    uint64_t low = first_kept(t), high = t->count;
    while (low < high) {
        const uint64_t middle = low + (high - low) / 2;
        if (event_at(t, middle)->id < id)
            low = middle + 1;
        else
            high = middle;
    }
    *index = low + 1;
    return low < t->count && event_at(t, low)->id == id;
}

static enum glint_topic_answer read_next(struct glint_topic *t, uint64_t *cursor,
                                         struct glint_blob **event)
{
    uint64_t next;
    if (!t->count)
        return t->gone ? GLINT_TOPIC_OVER : GLINT_TOPIC_NOTHING;
    if (!find(t, *cursor, &next))
        return t->gone ? GLINT_TOPIC_OVER : GLINT_TOPIC_LOST;
    if (next == t->count)
        return t->ended || t->gone ? GLINT_TOPIC_OVER : GLINT_TOPIC_NOTHING;
    *cursor = event_at(t, next)->id;
    *event = glint_blob_retain(event_at(t, next)->text);
    return GLINT_TOPIC_EVENT;
}

// The end itself is left for the ring to tell: its id is the last one.
static struct glint_blob *write_state(struct glint_topic *t, cJSON *job, const char *name,
                                      const char *before, uint64_t *cursor)
{
    uint64_t stands_for = t->count;
    if (t->ended && stands_for > first_kept(t) + 1)
        stands_for--;
    if (stands_for)
        *cursor = event_at(t, stands_for - 1)->id;
    return write_event(before, *cursor, name, cJSON_PrintUnformatted(job));
}

// Without the mutex.

void glint_topic_look(struct glint_topic *topic, glint_jobs *jobs, uint64_t cause_us)
{
    pthread_mutex_lock(&topic->mutex);
    look(topic, jobs, cause_us);
    atomic_store_explicit(&topic->news, 2 * topic->count + topic->gone, memory_order_release);
    pthread_mutex_unlock(&topic->mutex);
}

enum glint_topic_answer glint_topic_read(struct glint_topic *topic, uint64_t *cursor,
                                         struct glint_blob **event)
{
    pthread_mutex_lock(&topic->mutex);
    const enum glint_topic_answer news = read_next(topic, cursor, event);
    pthread_mutex_unlock(&topic->mutex);
    return news;
}

bool glint_topic_knows(struct glint_topic *topic, uint64_t id)
{
    uint64_t index;
    pthread_mutex_lock(&topic->mutex);
    const bool known = find(topic, id, &index);
    pthread_mutex_unlock(&topic->mutex);
    return known;
}

bool glint_topic_ended_with(struct glint_topic *topic, uint64_t id)
{
    pthread_mutex_lock(&topic->mutex);
    const bool over = topic->ended && topic->count && id == topic->last;
    pthread_mutex_unlock(&topic->mutex);
    return over;
}

struct glint_blob *glint_topic_state(struct glint_topic *topic, glint_jobs *jobs, const char *name,
                                     const char *before, uint64_t *cursor)
{
    pthread_mutex_lock(&topic->mutex);
    cJSON *job = glint_jobs_describe(jobs, topic->job, NULL);
    struct glint_blob *blob = job ? write_state(topic, job, name, before, cursor) : NULL;
    pthread_mutex_unlock(&topic->mutex);
    cJSON_Delete(job);
    return blob;
}
