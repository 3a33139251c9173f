#include "house.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

glint_status glint_house_look(struct glint_session *s, struct glint_house *out,
                              struct glint_error *err)
{
    *out = (struct glint_house){.seconds = now()};
    glint_status status = glint_client_get(s->client, "/v1/jobs", NULL, NULL, &out->jobs, err);
    if (!status)
        status = glint_client_get(s->client, "/v1/stats", NULL, NULL, &out->stats, err);
    if (status)
        glint_house_finish(out);
    return status;
}

void glint_house_finish(struct glint_house *house)
{
    cJSON_Delete(house->jobs);
    cJSON_Delete(house->stats);
    *house = (struct glint_house){0};
}

static double number_of(const cJSON *job, const char *name)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(job, name);
    return cJSON_IsNumber(item) ? item->valuedouble : NAN;
}

static const cJSON *member(const cJSON *object, const char *name)
{
    return cJSON_GetObjectItemCaseSensitive(object, name);
}

double glint_house_busy(const struct glint_house *house)
{
    double busy = 0;
    const cJSON *worker;
    cJSON_ArrayForEach(worker, member(house->stats, "workers")) {
        const double share = number_of(worker, "busy");
        busy += isfinite(share) ? share : 0;
    }
    return busy;
}

static const cJSON *find_job(const struct glint_house *house, const char *id)
{
    const cJSON *job;
    cJSON_ArrayForEach(job, member(house->jobs, "jobs")) {
        const char *other = cJSON_GetStringValue(member(job, "id"));
        if (id && other && strcmp(id, other) == 0)
            return job;
    }
    return NULL;
}

void glint_house_compare(const struct glint_house *before, struct glint_house *after)
{
    const double seconds = after->seconds - before->seconds;
    cJSON *job;
    cJSON_ArrayForEach(job, member(after->jobs, "jobs")) {
        const cJSON *old = find_job(before, cJSON_GetStringValue(member(job, "id")));
        const double worked =
            number_of(job, "worker_seconds") - (old ? number_of(old, "worker_seconds") : 0);
        if (before->jobs && seconds > 0 && isfinite(worked))
            cJSON_AddNumberToObject(job, "workers", fmax(worked / seconds, 0));
    }
}
