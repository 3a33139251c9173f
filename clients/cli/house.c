#include "house.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

double glint_house_metric(const char *text, const char *name)
{
    const size_t length = strlen(name);
    for (const char *line = text; line; line = strchr(line, '\n')) {
        line += *line == '\n';
        if (strncmp(line, name, length) == 0 && line[length] == ' ')
            return strtod(line + length + 1, NULL);
    }
    return NAN;
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void read_metrics(struct glint_house *out, const char *text)
{
    out->workers = glint_house_metric(text, "glint_workers");
    out->busy_seconds = glint_house_metric(text, "glint_worker_busy_seconds_total");
    out->scene_bytes = glint_house_metric(text, "glint_scene_resident_bytes");
    out->film_bytes = glint_house_metric(text, "glint_film_bytes");
    out->resident_bytes = glint_house_metric(text, "process_resident_memory_bytes");
}

glint_status glint_house_look(struct glint_session *s, struct glint_house *out,
                              struct glint_error *err)
{
    cJSON *list;
    struct glint_answer metrics;
    *out = (struct glint_house){.seconds = now()};
    glint_status status = glint_client_get(s->client, "/v1/jobs", NULL, NULL, &list, err);
    if (status)
        return status;
    const struct glint_request request = {.method = "GET", .path = "/metrics"};
    status = glint_client_send(s->client, &request, &metrics, err);
    if (!status) {
        read_metrics(out, metrics.body);
        out->jobs = cJSON_DetachItemFromObjectCaseSensitive(list, "jobs");
        free(metrics.body);
    }
    cJSON_Delete(list);
    return status;
}

void glint_house_finish(struct glint_house *house)
{
    cJSON_Delete(house->jobs);
    *house = (struct glint_house){0};
}

double glint_house_busy(const struct glint_house *before, const struct glint_house *after)
{
    const double seconds = after->seconds - before->seconds;
    if (!before->jobs || seconds <= 0)
        return NAN;
    return fmax((after->busy_seconds - before->busy_seconds) / seconds, 0);
}

static double number_of(const cJSON *job, const char *name)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(job, name);
    return cJSON_IsNumber(item) ? item->valuedouble : NAN;
}

static const cJSON *find_job(const cJSON *jobs, const char *id)
{
    const cJSON *job;
    cJSON_ArrayForEach(job, jobs) {
        const char *other = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(job, "id"));
        if (id && other && strcmp(id, other) == 0)
            return job;
    }
    return NULL;
}

void glint_house_compare(const struct glint_house *before, struct glint_house *after)
{
    const double seconds = after->seconds - before->seconds;
    cJSON *job;
    cJSON_ArrayForEach(job, after->jobs) {
        const cJSON *old = find_job(
            before->jobs, cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(job, "id")));
        const double worked =
            number_of(job, "worker_seconds") - (old ? number_of(old, "worker_seconds") : 0);
        if (before->jobs && seconds > 0 && isfinite(worked))
            cJSON_AddNumberToObject(job, "workers", fmax(worked / seconds, 0));
    }
}
