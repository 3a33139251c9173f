#include "jobs/describe.h"

#include "base/clock.h"
#include "jobs/invariants.h"
#include "jobs/outlook.h"
#include "protocol/problem.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// The shared fields of an entry at one moment.
struct moment {
    enum glint_job_state state;
    enum glint_wait wait;
    glint_render *render;
    int32_t priority;
    struct glint_job_stop stop;
    double seconds, worker_seconds, cpu_seconds;
    uint64_t sequence;
    bool idle;
    char revision[65];
    struct glint_look *look;        // retained, or NULL
    char *trouble[3];               // copies, or NULL
    struct glint_render_state kept; // of who has no render and was kept
    bool is_kept, has_film;
    char written[32]; // when its newest film was, or ""
};

static void look(struct glint_job_table *table, struct glint_entry *e, struct moment *out)
{
    const double now = glint_now();
    pthread_mutex_lock(&table->mutex);
    *out = (struct moment){e->state,
                           e->wait,
                           e->render,
                           e->priority,
                           e->stop,
                           glint_entry_seconds(e, now),
                           e->worker_seconds,
                           e->cpu_seconds,
                           e->sequence,
                           e->state == GLINT_JOB_RENDERING && isnan(e->since),
                           "",
                           glint_look_retain(e->look),
                           {e->trouble ? strdup(e->trouble) : NULL,
                            e->kept.trouble ? strdup(e->kept.trouble) : NULL,
                            e->kept.torn ? strdup(e->kept.torn) : NULL},
                           e->kept.rendered,
                           e->keeper != NULL,
                           e->kept.film != 0,
                           ""};
    memcpy(out->written, e->kept.written, sizeof out->written);
    e->views += e->render != NULL; // it stays until glint_entry_describe() is done with it
    strcpy(out->revision, glint_revision_id(e->revision));
    pthread_mutex_unlock(&table->mutex);
}

// JSON has no NAN: what is not known is null.
static void add_number(cJSON *object, const char *name, double value)
{
    if (isfinite(value))
        cJSON_AddNumberToObject(object, name, value);
    else
        cJSON_AddNullToObject(object, name);
}

static double progress(const struct moment *m, const struct glint_render_state *r)
{
    if (m->state == GLINT_JOB_DONE)
        return 1;
    const double by_time = m->stop.seconds > 0 ? m->seconds / m->stop.seconds : 0;
    return fmin(fmax(r->progress, by_time), 1);
}

// Seconds to the stop that comes first, each at the pace up to now; NAN: nobody knows.
static double eta(const struct moment *m, const struct glint_render_state *r)
{
    if (glint_state_ended(m->state) || m->idle)
        return 0;
    if (m->state != GLINT_JOB_RENDERING)
        return NAN;
    double left = NAN; // fmin takes the other one
    if (r->progress > 0)
        left = m->seconds * (1 - r->progress) / r->progress;
    if (m->stop.seconds > 0)
        left = fmin(left, m->stop.seconds - m->seconds);
    if (r->samples && isfinite(r->forecast.samples[0]))
        left = fmin(left, m->seconds * (r->forecast.samples[0] / r->samples - 1));
    return isnan(left) ? NAN : fmax(left, 0);
}

static void add_rays(cJSON *object, const struct glint_render_state *r)
{
    cJSON *rays = cJSON_AddObjectToObject(object, "rays");
    cJSON_AddNumberToObject(rays, "camera", (double)r->camera_rays);
    cJSON_AddNumberToObject(rays, "bounce", (double)r->bounce_rays);
    cJSON_AddNumberToObject(rays, "shadow", (double)r->shadow_rays);
}

// Who has no render is what was kept of it, on the way to the stop that it has by now.
static struct glint_render_state rendered(const struct moment *m)
{
    struct glint_render_state r = GLINT_NOTHING_RENDERED;
    if (m->render) {
        glint_render_state(m->render, &r);
        return r;
    }
    if (m->is_kept)
        r = m->kept;
    r.progress *= (double)r.target_samples / m->stop.samples;
    r.target_samples = m->stop.samples;
    return r;
}

static void add_render(cJSON *object, const struct glint_entry *e, const struct moment *m,
                       const struct glint_render_state *r)
{
    const bool bounded = r->target_samples && r->target_samples < GLINT_MAX_SAMPLES;
    cJSON_AddNumberToObject(object, "samples", r->samples);
    add_number(object, "target_samples", bounded ? r->target_samples : NAN);
    add_number(object, "progress", progress(m, r));
    add_number(object, "error", r->estimate.error);
    cJSON_AddItemToObject(object, "estimate",
                          glint_outlook_describe(r, e->job, m->seconds / m->worker_seconds,
                                                 glint_state_ended(m->state)));
    add_number(object, "seconds", m->seconds);
    add_number(object, "eta_seconds", eta(m, r));
    add_number(object, "worker_seconds", m->worker_seconds);
    add_number(object, "cpu_seconds", m->cpu_seconds);
    add_rays(object, r);
    glint_invariants_add(object, r);
    glint_invariants_ranks(object, &r->excess);
}

static cJSON *stop_of(const struct glint_job_stop *stop)
{
    cJSON *object = cJSON_CreateObject();
    if (stop->samples < GLINT_MAX_SAMPLES)
        cJSON_AddNumberToObject(object, "samples", stop->samples);
    if (stop->seconds > 0)
        cJSON_AddNumberToObject(object, "seconds", stop->seconds);
    if (stop->error > 0)
        cJSON_AddNumberToObject(object, "error", stop->error);
    if (stop->least > 0)
        cJSON_AddNumberToObject(object, "least", stop->least);
    return object;
}

// The job as submitted, with what a PATCH has changed since.
static void add_job(cJSON *object, const struct glint_entry *e, const struct moment *m)
{
    cJSON *job = cJSON_Parse(e->text);
    cJSON_DeleteItemFromObjectCaseSensitive(job, "priority");
    cJSON_AddNumberToObject(job, "priority", m->priority);
    cJSON_DeleteItemFromObjectCaseSensitive(job, "stop");
    cJSON_AddItemToObject(job, "stop", stop_of(&m->stop));
    if (m->look)
        cJSON_DeleteItemFromObjectCaseSensitive(job, "camera");
    if (m->look && !cJSON_IsNull(m->look->camera))
        cJSON_AddItemToObject(job, "camera", cJSON_Duplicate(m->look->camera, true));
    cJSON_AddItemToObject(object, "job", job);
}

static void add_warnings(cJSON *object, const struct glint_entry *e, const struct moment *m,
                         const struct glint_render_state *r)
{
    cJSON *warnings = cJSON_Duplicate(e->warnings, true);
    for (size_t i = 0; i < sizeof m->trouble / sizeof *m->trouble; i++)
        if (m->trouble[i])
            cJSON_AddItemToArray(warnings, cJSON_CreateString(m->trouble[i]));
    glint_invariants_warn(warnings, r);
    if (glint_state_ended(m->state))
        glint_invariants_warn_of_ranks(warnings, &r->excess, e->job);
    cJSON_AddItemToObject(object, "warnings", warnings);
}

// Null: nothing of it is on the disk.
static void add_checkpoint(cJSON *object, const struct moment *m)
{
    if (!m->has_film) {
        cJSON_AddNullToObject(object, "checkpoint");
        return;
    }
    cJSON *o = cJSON_AddObjectToObject(object, "checkpoint");
    cJSON_AddNumberToObject(o, "samples", m->kept.samples);
    if (*m->written)
        cJSON_AddStringToObject(o, "written", m->written);
    else
        cJSON_AddNullToObject(o, "written");
}

// What was made of its scene is not an ended job's any more.
static uint64_t memory_of(const struct glint_entry *e, const struct moment *m)
{
    return e->need.film + (glint_state_ended(m->state) ? 0 : e->need.scene);
}

static void add_wait(cJSON *object, const struct moment *m)
{
    const char *name = m->state == GLINT_JOB_QUEUED ? glint_wait_name(m->wait) : NULL;
    if (name)
        cJSON_AddStringToObject(object, "waits_for", name);
    else
        cJSON_AddNullToObject(object, "waits_for");
}

static cJSON *describe(const struct glint_entry *e, const struct moment *m)
{
    cJSON *object = cJSON_CreateObject();
    if (!object)
        return NULL;
    const struct glint_render_state r = rendered(m);
    char plan[64];
    snprintf(plan, sizeof plan, "/v1/jobs/%s/plan", e->id);
    cJSON_AddStringToObject(object, "id", e->id);
    cJSON_AddStringToObject(object, "name", e->job->name ? e->job->name : "");
    cJSON_AddStringToObject(object, "client", e->client);
    if (e->request)
        cJSON_AddStringToObject(object, "request", e->request);
    cJSON_AddStringToObject(object, "scene", e->job->scene);
    cJSON_AddStringToObject(object, "revision", m->revision);
    cJSON_AddStringToObject(object, "state", glint_job_state_name(m->state));
    add_wait(object, m);
    cJSON_AddNumberToObject(object, "priority", m->priority);
    add_render(object, e, m, &r);
    add_checkpoint(object, m);
    cJSON_AddNumberToObject(object, "memory_bytes", (double)memory_of(e, m));
    cJSON_AddStringToObject(object, "plan", plan);
    if (m->state == GLINT_JOB_FAILED) // from then on nobody changes the problem
        cJSON_AddItemToObject(object, "problem", glint_problem_object(&e->problem, NULL, NULL));
    if (e->chosen)
        cJSON_AddItemToObject(object, "chosen", cJSON_Duplicate(e->chosen, true));
    add_warnings(object, e, m, &r);
    cJSON_AddStringToObject(object, "created", e->created);
    add_job(object, e, m);
    return object;
}

cJSON *glint_entry_describe(struct glint_job_table *table, struct glint_entry *e)
{
    struct moment m;
    look(table, e, &m);
    cJSON *object = describe(e, &m);
    glint_look_release(&m.look);
    for (size_t i = 0; i < sizeof m.trouble / sizeof *m.trouble; i++)
        free(m.trouble[i]);
    pthread_mutex_lock(&table->mutex);
    e->views -= m.render != NULL;
    pthread_mutex_unlock(&table->mutex);
    return object;
}
