#include "jobs/choose.h"

#include "protocol/bias.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// A front and where it is from.
struct source {
    char *text;
    const char *of_class;
    bool own;
    struct glint_front *front;
};

static void close_source(struct source *s)
{
    free(s->text);
    free(s->front);
}

static glint_status open_source(struct source *out, glint_prices *prices, const char *scene,
                                const glint_revision *revision, struct glint_error *err)
{
    const glint_resident *resident = glint_revision_resident(revision);
    *out = (struct source){.of_class = glint_price_class(glint_resident_facts(resident))};
    out->text = glint_prices_find(prices, scene, out->of_class, &out->own);
    const glint_status st = out->text
                                ? glint_front_parse(&out->front, out->text, strlen(out->text), err)
                                : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a front");
    if (st)
        close_source(out);
    return st;
}

// Whether it was measured on the scene as it is.
static bool is_current(const struct source *s, const glint_revision *revision)
{
    return s->own && !strcmp(s->front->revision, glint_revision_id(revision));
}

static void add_origin(cJSON *object, const struct source *s, const glint_revision *revision)
{
    cJSON_AddStringToObject(object, "from", s->own ? "scene" : "class");
    cJSON_AddStringToObject(object, "class", s->of_class);
    cJSON_AddBoolToObject(object, "current", is_current(s, revision));
}

cJSON *glint_choose_describe(glint_prices *prices, const char *scene,
                             const glint_revision *revision, struct glint_error *err)
{
    struct source s;
    if (open_source(&s, prices, scene, revision, err))
        return NULL;
    cJSON *object = cJSON_CreateObject();
    cJSON_AddStringToObject(object, "scene", scene);
    add_origin(object, &s, revision);
    cJSON_AddItemToObject(object, "front", cJSON_Parse(s.text));
    close_source(&s);
    return object;
}

// ---- a job

// Dials of mattes stay the job's: they do not change the picture.
static void apply(struct glint_job *job, const struct glint_front_point *p, double samples)
{
    for (int d = 0; d < GLINT_DIAL_COUNT; d++)
        if (!strcmp(glint_dial_table[d].parent, "accuracy"))
            job->dial[d] = p->dial[d];
    job->max_bounces = p->max_bounces;
    job->known_bias = glint_biases_of_picture(glint_biases_asked(job)) ? p->bias : 0.0;
    if (job->budget.seconds > 0)
        job->stop.seconds = job->stop.seconds > 0 ? fmin(job->stop.seconds, job->budget.seconds)
                                                  : job->budget.seconds;
    // The job sees its own noise and not the bias, which has its part of what is asked.
    const double noise =
        sqrt(fmax(job->budget.error * job->budget.error - p->bias * p->bias, 1e-18));
    if (job->budget.error > 0)
        job->stop.least = (uint32_t)samples;
    if (job->budget.error > 0)
        job->stop.error = job->stop.error > 0 ? fmax(job->stop.error, noise) : noise;
}

static cJSON *describe_settings(const struct glint_job *job)
{
    cJSON *settings = cJSON_CreateObject();
    cJSON *dials = cJSON_AddObjectToObject(settings, "accuracy");
    for (int d = 0; d < GLINT_DIAL_COUNT; d++)
        if (!strcmp(glint_dial_table[d].parent, "accuracy"))
            cJSON_AddStringToObject(dials, glint_dial_table[d].name,
                                    glint_dial_table[d].setting[job->dial[d]]);
    cJSON_AddNumberToObject(settings, "max_bounces", job->max_bounces);
    return settings;
}

static cJSON *describe(const struct source *s, const glint_revision *revision,
                       const struct glint_front_choice *c, const struct glint_job *job)
{
    const struct glint_front_point *p = &s->front->point[c->point];
    cJSON *object = cJSON_CreateObject();
    add_origin(object, s, revision);
    cJSON_AddStringToObject(object, "row", p->row);
    cJSON_AddItemToObject(object, "settings", describe_settings(job));
    cJSON_AddNumberToObject(object, "expected_samples", c->samples);
    cJSON_AddNumberToObject(object, "expected_error", c->error);
    cJSON_AddNumberToObject(object, "expected_seconds", c->seconds);
    cJSON_AddNumberToObject(object, "known_bias", p->bias);
    return object;
}

// An error that no point reaches is named with the least that one does.
static glint_status unreachable(const struct glint_front *front, const struct glint_job *job,
                                struct glint_error *err)
{
    if (!(job->budget.error > 0))
        return glint_fail(err, GLINT_E_RANGE, "/accuracy",
                          "no settings measured for this scene are those that the job gives: leave "
                          "them to the choice, or give no time");
    double least = INFINITY;
    for (size_t i = 0; i < front->points; i++)
        least = fmin(least, front->point[i].bias);
    return glint_fail(err, GLINT_E_RANGE, "/accuracy/error",
                      "no settings measured for this scene reach that with those that the job "
                      "gives; the least bias known of any is %.3g",
                      least);
}

static struct glint_front_point settings_of(const struct glint_job *job)
{
    struct glint_front_point p = {.max_bounces = job->max_bounces};
    memcpy(p.dial, job->dial, sizeof p.dial);
    return p;
}

static glint_status pick(cJSON **chosen, const struct source *s, const glint_revision *revision,
                         uint32_t workers, struct glint_job *job, struct glint_error *err)
{
    const struct glint_front_point given = settings_of(job);
    uint32_t matters = GLINT_CHOICE_BOUNCES;
    for (int d = 0; d < GLINT_DIAL_COUNT; d++)
        matters |= !strcmp(glint_dial_table[d].parent, "accuracy") ? 1u << d : 0;
    const struct glint_front_wish wish = {
        .seconds = job->budget.seconds,
        .error = job->budget.error,
        .pixels = (double)job->region[2] * job->region[3],
        .workers = workers,
        .pinned = job->pinned & matters,
        .at = &given,
        .max_samples = job->stop.samples,
    };
    struct glint_front_choice c;
    if (!glint_front_choose(s->front, &wish, &c))
        return unreachable(s->front, job, err);
    apply(job, &s->front->point[c.point], c.samples);
    *chosen = describe(s, revision, &c, job);
    return *chosen ? GLINT_OK : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a job");
}

// What the settings that the job gives itself are off, where its scene's own front says so.
static void know(const struct source *s, struct glint_job *job)
{
    const struct glint_front_point given = settings_of(job);
    const struct glint_front_point *p = s->own ? glint_front_find(s->front, &given) : NULL;
    if (p && glint_biases_of_picture(glint_biases_asked(job)))
        job->known_bias = p->bias;
}

glint_status glint_choose(cJSON **chosen, glint_prices *prices, const glint_revision *revision,
                          uint32_t workers, struct glint_job *job, struct glint_error *err)
{
    struct source s;
    *chosen = NULL;
    glint_status st = open_source(&s, prices, job->scene, revision, err);
    if (st)
        return st;
    if (job->budget.seconds > 0 || job->budget.error > 0)
        st = pick(chosen, &s, revision, workers, job, err);
    else
        know(&s, job);
    close_source(&s);
    return st;
}
