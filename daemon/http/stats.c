// stats.c - GET /v1/stats: who works on what, what waits, what holds the memory.
#include "http/answer.h"
#include "http/auth.h"
#include "http/resources.h"

#include "base/clock.h"
#include "base/memory.h"

#include <stdlib.h>

static void add_text_or_null(cJSON *object, const char *name, const char *text)
{
    if (text && *text)
        cJSON_AddStringToObject(object, name, text);
    else
        cJSON_AddNullToObject(object, name);
}

// A worker's job is shown to who may see it.
static void add_workers(cJSON *object, const struct glint_request *r)
{
    glint_jobs *jobs = r->http->jobs;
    const char *tenant = glint_auth_tenant(r);
    cJSON *list = cJSON_AddArrayToObject(object, "workers");
    const uint32_t count = glint_jobs_workers(jobs, NULL, 0);
    struct glint_worker_use *use = calloc(count, sizeof *use);
    if (use)
        glint_jobs_workers(jobs, use, count);
    for (uint32_t w = 0; use && w < count; w++) {
        cJSON *o = cJSON_CreateObject();
        const bool seen = !tenant || glint_jobs_belongs(jobs, use[w].job, tenant);
        add_text_or_null(o, "job", seen ? use[w].job : NULL);
        cJSON_AddNumberToObject(o, "busy", use[w].share);
        cJSON_AddNumberToObject(o, "busy_seconds", use[w].busy_seconds);
        cJSON_AddItemToArray(list, o);
    }
    free(use);
}

static void add_jobs(cJSON *object, const struct glint_jobs_stats *s)
{
    cJSON *jobs = cJSON_AddObjectToObject(object, "jobs");
    for (int state = GLINT_JOB_QUEUED; state <= GLINT_JOB_CANCELLED; state++)
        cJSON_AddNumberToObject(jobs, glint_job_state_name((enum glint_job_state)state),
                                s->by_state[state]);
    cJSON *waits = cJSON_AddObjectToObject(object, "queued_for");
    for (int wait = GLINT_WAIT_NONE + 1; wait < GLINT_WAITS; wait++)
        cJSON_AddNumberToObject(waits, glint_wait_name((enum glint_wait)wait), s->by_wait[wait]);
    cJSON_AddNumberToObject(object, "submitted", (double)s->submitted);
    cJSON_AddNumberToObject(object, "slices", (double)s->slices);
}

static void add_memory(cJSON *object, const struct glint_jobs_stats *s, glint_store *store)
{
    struct glint_store_stats scenes;
    glint_store_stats(store, &scenes);
    cJSON *memory = cJSON_AddObjectToObject(object, "memory");
    cJSON_AddNumberToObject(memory, "scene_bytes", (double)scenes.resident_bytes);
    cJSON_AddNumberToObject(memory, "film_bytes", (double)s->film_bytes);
    cJSON_AddNumberToObject(memory, "ended_film_bytes", (double)s->ended_film_bytes);
    cJSON_AddNumberToObject(memory, "limit_bytes", (double)s->limits.memory_bytes);
    cJSON_AddNumberToObject(memory, "resident_bytes", (double)glint_memory_resident());
    cJSON_AddNumberToObject(memory, "machine_bytes", (double)glint_memory_total());
}

static void add_limits(cJSON *object, const struct glint_jobs_limits *limits)
{
    cJSON *o = cJSON_AddObjectToObject(object, "limits");
    cJSON_AddNumberToObject(o, "live_jobs", limits->live_jobs);
    cJSON_AddNumberToObject(o, "ended_jobs", limits->ended_jobs);
    cJSON_AddNumberToObject(o, "side_by_side", limits->side_by_side);
}

void glint_http_service_stats(struct glint_request *r)
{
    struct glint_jobs_stats stats;
    char now[32];
    glint_jobs_stats(r->http->jobs, &stats);
    glint_utc(now);
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "time", now);
    add_workers(o, r);
    add_jobs(o, &stats);
    add_memory(o, &stats, r->http->store);
    add_limits(o, &stats.limits);
    glint_answer_json(r, MHD_HTTP_OK, o);
}
