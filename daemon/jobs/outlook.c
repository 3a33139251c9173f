#include "jobs/outlook.h"

#include "protocol/bias.h"

#include <math.h>

// JSON has no NAN: what is not known is null.
static cJSON *number(double value)
{
    return isfinite(value) ? cJSON_CreateNumber(value) : cJSON_CreateNull();
}

static void add_interval(cJSON *object, const char *name, double low, double high)
{
    cJSON *interval = cJSON_AddArrayToObject(object, name);
    cJSON_AddItemToArray(interval, number(low));
    cJSON_AddItemToArray(interval, number(high));
}

// Where rare events rule, nobody knows how long it takes at most.
static cJSON *describe_forecast(const struct glint_forecast *f, double parallel)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddItemToObject(o, "error", number(f->target));
    cJSON_AddItemToObject(o, "samples", number(f->samples[0]));
    add_interval(o, "interval", f->samples[1], f->lower_bound ? NAN : f->samples[2]);
    cJSON_AddItemToObject(o, "seconds", number(f->seconds[0] * parallel));
    add_interval(o, "seconds_interval", f->seconds[1] * parallel,
                 f->lower_bound ? NAN : f->seconds[2] * parallel);
    cJSON_AddBoolToObject(o, "reachable", f->reachable);
    cJSON_AddBoolToObject(o, "lower_bound", f->lower_bound);
    return o;
}

cJSON *glint_outlook_describe(const struct glint_render_state *s, const struct glint_job *job,
                              double parallel, bool ended)
{
    double interval[2];
    const struct glint_estimate *e = &s->estimate;
    cJSON *o = cJSON_CreateObject();
    glint_estimate_interval(e, interval);
    cJSON_AddItemToObject(o, "error", number(e->error));
    add_interval(o, "interval", interval[0], interval[1]);
    cJSON_AddItemToObject(o, "linear", number(e->linear));
    cJSON_AddItemToObject(o, "tone_mapped", number(e->tone_mapped));
    cJSON_AddItemToObject(o, "tail_index", number(e->tail));
    cJSON_AddItemToObject(o, "lift", number(e->lift));
    cJSON_AddBoolToObject(o, "rare_events", glint_estimate_rare(e));
    cJSON_AddItemToObject(o, "known_bias", number(job->known_bias > 0 ? job->known_bias : NAN));
    cJSON_AddItemToObject(o, "biases", glint_biases_describe(s->biases, job));
    cJSON_AddItemToObject(o, "forecast",
                          ended || isnan(s->forecast.target)
                              ? cJSON_CreateNull()
                              : describe_forecast(&s->forecast, parallel));
    return o;
}

// ---- kept

static const struct {
    const char *name;
    size_t offset;
} members[] = {
    {"error", offsetof(struct glint_estimate, error)},
    {"spread", offsetof(struct glint_estimate, spread)},
    {"linear", offsetof(struct glint_estimate, linear)},
    {"tone_mapped", offsetof(struct glint_estimate, tone_mapped)},
    {"tail", offsetof(struct glint_estimate, tail)},
    {"lift", offsetof(struct glint_estimate, lift)},
};

void glint_outlook_write(cJSON *object, const struct glint_render_state *s)
{
    for (size_t i = 0; i < sizeof members / sizeof *members; i++) {
        const double value = *(const double *)((const char *)&s->estimate + members[i].offset);
        if (isfinite(value))
            cJSON_AddNumberToObject(object, members[i].name, value);
    }
    cJSON_AddItemToObject(object, "biases", glint_biases_names(s->biases));
}

void glint_outlook_read(struct glint_render_state *s, const cJSON *object)
{
    for (size_t i = 0; i < sizeof members / sizeof *members; i++) {
        const cJSON *v = cJSON_GetObjectItemCaseSensitive(object, members[i].name);
        *(double *)((char *)&s->estimate + members[i].offset) =
            cJSON_IsNumber(v) ? v->valuedouble : NAN;
    }
    s->forecast = GLINT_NO_FORECAST;
    s->biases = glint_biases_named(cJSON_GetObjectItemCaseSensitive(object, "biases"));
}
