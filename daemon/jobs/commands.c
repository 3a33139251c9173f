// commands.c - what others ask of the scheduler: submit, patch, delete, watch, stop.
#include "jobs/scheduler_parts.h"

#include "base/clock.h"
#include "base/memory.h"
#include "jobs/state.h"
#include "jobs/turn.h"

#include <string.h>

#define FIRST_SLICE 0.02 // seconds, the guess until a slice was measured
#define LONG_SLICE 0.1   // seconds: who pauses does not wait for the end of it

static void answer(glint_scheduler *s, struct glint_command *c)
{
    pthread_mutex_lock(&s->mutex);
    c->answered = true;
    pthread_cond_broadcast(&s->answer);
    pthread_mutex_unlock(&s->mutex);
}

static struct glint_entry *repeated(glint_scheduler *s, const struct glint_entry *e)
{
    return e->key ? glint_job_table_find_key(s->table, e->client, e->key) : NULL;
}

// What can never fit is refused: with nothing else there but its scene.
static glint_status fits_alone(const glint_scheduler *s, const struct glint_entry *e,
                               struct glint_error *err)
{
    const struct glint_need *need = &e->need;
    const uint64_t limit = s->table->limits.memory_bytes;
    if (need->film + need->scene + e->rest_bytes <= limit)
        return GLINT_OK;
    char all[16], film[16], rest[16], moment[16], most[16];
    return glint_fail(err, GLINT_E_CAPACITY, "/resolution",
                      "the job needs %s of memory: %s for its film, %s for its scene, "
                      "%s for the moment of it; all jobs and scenes may have %s",
                      glint_memory_text(need->film + need->scene + e->rest_bytes, all),
                      glint_memory_text(need->film, film), glint_memory_text(e->rest_bytes, rest),
                      glint_memory_text(need->scene, moment), glint_memory_text(limit, most));
}

static glint_status submit(glint_scheduler *s, struct glint_command *c)
{
    struct glint_entry *known = repeated(s, c->entry);
    if (known) {
        c->repeated = glint_entry_retain(known);
        return GLINT_OK;
    }
    if (s->stopping)
        return glint_fail(c->err, GLINT_E_BUSY, "", "the daemon is shutting down");
    if (s->lives >= s->table->limits.live_jobs)
        return glint_fail(c->err, GLINT_E_BUSY, "", "%zu jobs wait or render already", s->lives);
    const glint_status st = fits_alone(s, c->entry, c->err);
    if (st)
        return st;
    c->gone = glint_job_table_trim(s->table, s->table->limits.ended_jobs);
    const bool entered = glint_turn_enter(&s->accounts, c->entry, c->entry->priority);
    if (!entered || !glint_job_table_add(s->table, c->entry)) {
        glint_turn_leave(&s->accounts, c->entry);
        return glint_fail(c->err, GLINT_E_NOMEM, "", "no memory for one more job");
    }
    c->entry->slice_seconds = FIRST_SLICE;
    s->live[s->lives++] = c->entry;
    glint_revision_use(c->entry->revision, 1);
    s->news = true;
    return GLINT_OK;
}

// Takes up where the daemon before left it.
static glint_status recall(glint_scheduler *s, struct glint_command *c)
{
    struct glint_entry *e = c->entry;
    const bool lives = !glint_state_ended(e->state);
    if (lives && s->lives == GLINT_MAX_LIVE_JOBS)
        return glint_fail(c->err, GLINT_E_CAPACITY, "", "%zu jobs wait or render already",
                          s->lives);
    const bool entered = !lives || glint_turn_enter(&s->accounts, e, e->priority);
    if (!entered || !glint_job_table_add(s->table, e)) {
        glint_turn_leave(&s->accounts, e);
        return glint_fail(c->err, GLINT_E_NOMEM, "", "no memory for one more job");
    }
    e->slice_seconds = FIRST_SLICE;
    if (lives) {
        s->live[s->lives++] = e;
        glint_revision_use(e->revision, 1);
    }
    s->news = true;
    return GLINT_OK;
}

static glint_status delete (glint_scheduler *s, struct glint_command *c)
{
    if (!glint_state_ended(c->entry->state)) {
        glint_scheduler_end(s, c->entry, GLINT_JOB_CANCELLED);
        return GLINT_OK;
    }
    c->forgotten = true;
    if (!c->entry->listed) // another call was first
        return GLINT_OK;
    glint_job_table_remove(s->table, c->entry);
    c->gone = c->entry; // with the table's reference
    c->gone->next = NULL;
    glint_scheduler_unblock(s);
    s->news = true;
    return GLINT_OK;
}

static glint_status set_priority(glint_scheduler *s, struct glint_entry *e, int32_t priority,
                                 struct glint_error *err)
{
    if (priority == e->priority)
        return GLINT_OK;
    if (!glint_turn_enter(&s->accounts, e, priority))
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for another priority");
    glint_state_priority(s->table, e, priority);
    glint_turn_join(s->live, s->lives, e);
    glint_scheduler_recall(s);
    return GLINT_OK;
}

static void set_paused(glint_scheduler *s, struct glint_entry *e, bool paused)
{
    if (paused == (e->state == GLINT_JOB_PAUSED))
        return;
    glint_scheduler_enter(s, e,
                          paused     ? GLINT_JOB_PAUSED
                          : e->began ? GLINT_JOB_RENDERING
                                     : GLINT_JOB_QUEUED);
    if (e->idle)
        glint_state_idle(s->table, e, true);
    glint_scheduler_recall(s);
    if (e->render)
        glint_render_interrupt(e->render, paused && e->out && e->slice_seconds > LONG_SLICE);
    if (!paused)
        glint_turn_join(s->live, s->lives, e);
}

static bool same_stop(const struct glint_job_stop *a, const struct glint_job_stop *b)
{
    return a->samples == b->samples && a->seconds == b->seconds && a->error == b->error;
}

// Of its film, in memory or on the disk.
static uint32_t samples_of(glint_scheduler *s, const struct glint_entry *e)
{
    struct glint_render_state now;
    if (e->render) {
        glint_render_state(e->render, &now);
        return now.samples;
    }
    pthread_mutex_lock(&s->table->mutex);
    const uint32_t kept = e->kept.film ? e->kept.rendered.samples : 0;
    pthread_mutex_unlock(&s->table->mutex);
    return kept;
}

// Has the film stop at `stop`, or later at the error that it may reach. What is not in memory is
// told when it is.
static glint_status extend(glint_scheduler *s, struct glint_entry *e,
                           const struct glint_job_stop *stop, struct glint_error *err)
{
    if (stop->samples == e->stop.samples && stop->error == e->stop.error)
        return GLINT_OK;
    if (stop->error > 0 && e->job->estimate == GLINT_ESTIMATE_NONE)
        return glint_fail(err, GLINT_E_CONFLICT, "/stop/error",
                          "with estimate none the job does not know its noise");
    const uint32_t samples = samples_of(s, e);
    if (samples > stop->samples)
        return glint_fail(err, GLINT_E_CONFLICT, "/stop/samples",
                          "the job has %u samples already, %u would be fewer", samples,
                          stop->samples);
    if (!e->render || glint_render_extend(e->render, stop->samples, stop->error))
        return GLINT_OK;
    return e->job->sample_range[1]
               ? glint_fail(err, GLINT_E_CONFLICT, "/stop", "the job renders a range of samples")
               : glint_fail(err, GLINT_E_CONFLICT, "/stop/samples",
                            "parts of the frame have samples past %u already, or get them now",
                            stop->samples);
}

static bool has_time(const struct glint_entry *e, const struct glint_job_stop *stop)
{
    return stop->seconds <= 0 || stop->seconds > e->render_seconds;
}

static bool is_complete(glint_scheduler *s, const struct glint_entry *e,
                        const struct glint_job_stop *stop)
{
    return e->render ? glint_render_complete(e->render) : samples_of(s, e) >= stop->samples;
}

// An ended job goes on where it stopped.
static void resume(glint_scheduler *s, struct glint_entry *e)
{
    glint_revision_use(e->revision, 1);
    atomic_store_explicit(&e->abandoned, false, memory_order_relaxed);
    if (e->render)
        glint_render_interrupt(e->render, false);
    else
        e->began = false; // it is prepared again, with what it has rendered
    s->live[s->lives++] = e;
    glint_scheduler_enter(s, e, e->began ? GLINT_JOB_RENDERING : GLINT_JOB_QUEUED);
    glint_turn_join(s->live, s->lives, e);
}

static glint_status may_resume(glint_scheduler *s, struct glint_entry *e,
                               const struct glint_job_stop *stop, struct glint_error *err)
{
    if (s->stopping || s->lives >= s->table->limits.live_jobs)
        return glint_fail(err, GLINT_E_BUSY, "", "no more jobs can render now");
    const glint_status st = has_time(e, stop) ? extend(s, e, stop, err) : GLINT_OK;
    if (st)
        return st;
    if (has_time(e, stop) && !is_complete(s, e, stop))
        return GLINT_OK;
    return glint_fail(err, GLINT_E_CONFLICT, "", "the job is %s and has no more to render",
                      glint_job_state_name(e->state));
}

// Only another stop has one that ended go on; a failed job has nothing that could.
static glint_status patch_ended(glint_scheduler *s, struct glint_command *c)
{
    struct glint_entry *e = c->entry;
    const struct glint_job_stop stop = glint_job_patch_stop(&c->patch, &e->stop);
    if (!glint_job_patch_stops(&c->patch) || e->state == GLINT_JOB_FAILED)
        return glint_fail(c->err, GLINT_E_CONFLICT, "",
                          "the job is %s; where it is not failed, another stop has it go on",
                          glint_job_state_name(e->state));
    if (e->state == GLINT_JOB_DONE && same_stop(&stop, &e->stop))
        return GLINT_OK; // said twice
    const glint_status st = may_resume(s, e, &stop, c->err);
    if (st)
        return st;
    const int32_t priority = c->patch.has_priority ? c->patch.priority : e->priority;
    if (!glint_turn_enter(&s->accounts, e, priority))
        return glint_fail(c->err, GLINT_E_NOMEM, "", "no memory for one more job that renders");
    glint_state_priority(s->table, e, priority);
    glint_state_stop(s->table, e, &stop);
    resume(s, e);
    if (c->patch.has_paused)
        set_paused(s, e, c->patch.paused);
    s->news = true;
    return GLINT_OK;
}

static void set_stop(glint_scheduler *s, struct glint_entry *e, const struct glint_job_stop *stop)
{
    glint_state_stop(s->table, e, stop);
    if (e->idle && has_time(e, stop) && !is_complete(s, e, stop))
        glint_state_idle(s->table, e, false);
}

static glint_status patch(glint_scheduler *s, struct glint_command *c)
{
    struct glint_entry *e = c->entry;
    if (!e->listed)
        return glint_fail(c->err, GLINT_E_NOT_FOUND, "", "the job was forgotten just now");
    if (glint_state_ended(e->state))
        return patch_ended(s, c);
    if (e->end != GLINT_JOB_QUEUED)
        return glint_fail(c->err, GLINT_E_CONFLICT, "", "the job is about to be %s",
                          glint_job_state_name(e->end));
    const struct glint_job_stop stop = glint_job_patch_stop(&c->patch, &e->stop);
    glint_status st = extend(s, e, &stop, c->err);
    if (!st && c->patch.has_priority)
        st = set_priority(s, e, c->patch.priority, c->err);
    if (st)
        return st;
    if (!same_stop(&stop, &e->stop))
        set_stop(s, e, &stop);
    if (c->patch.look) {
        glint_state_look(s->table, e, &c->patch.look);
        e->stale = glint_now();
    }
    if (c->patch.has_paused)
        set_paused(s, e, c->patch.paused);
    s->news = true;
    return GLINT_OK;
}

static void scene_changed(glint_scheduler *s, const char *scene)
{
    for (size_t i = 0; i < s->lives; i++)
        if (s->live[i]->job->live && !strcmp(s->live[i]->job->scene, scene))
            s->live[i]->stale = glint_now();
}

void glint_scheduler_limit(glint_scheduler *s, const struct glint_jobs_limits *limits)
{
    static const struct glint_jobs_limits defaults;
    const struct glint_jobs_limits *l = limits ? limits : &defaults;
    const uint32_t lives =
        l->live_jobs && l->live_jobs < GLINT_MAX_LIVE_JOBS ? l->live_jobs : GLINT_MAX_LIVE_JOBS;
    pthread_mutex_lock(&s->table->mutex);
    s->table->limits = (struct glint_jobs_limits){
        .memory_bytes = l->memory_bytes ? l->memory_bytes : glint_memory_total() / 4 * 3,
        .live_jobs = lives,
        .ended_jobs = l->ended_jobs ? l->ended_jobs : GLINT_MAX_ENDED_JOBS,
        .side_by_side = l->side_by_side ? l->side_by_side : GLINT_MAX_FILMS};
    pthread_mutex_unlock(&s->table->mutex);
    glint_scheduler_unblock(s);
}

static void begin_stop(glint_scheduler *s)
{
    s->stopping = true;
    for (size_t i = s->lives; i--;) // backwards: glint_scheduler_end() may take the entry out
        if (!s->live[i]->keeper)
            glint_scheduler_end(s, s->live[i], GLINT_JOB_CANCELLED);
        else // relaxed: a hint to the preparer
            atomic_store_explicit(&s->live[i]->abandoned, true, memory_order_relaxed);
    glint_scheduler_recall(s);
}

void glint_scheduler_obey(glint_scheduler *s, struct glint_command *c)
{
    c->status = GLINT_OK;
    switch (c->kind) {
    case GLINT_COMMAND_SUBMIT:
        c->status = submit(s, c);
        break;
    case GLINT_COMMAND_DELETE:
        c->status = delete (s, c);
        break;
    case GLINT_COMMAND_PATCH:
        c->status = patch(s, c);
        break;
    case GLINT_COMMAND_SCENE:
        scene_changed(s, c->scene);
        break;
    case GLINT_COMMAND_WATCH:
        s->changed = c->changed;
        s->user = c->user;
        break;
    case GLINT_COMMAND_LIMITS:
        glint_scheduler_limit(s, &c->limits);
        break;
    case GLINT_COMMAND_RECALL:
        c->status = recall(s, c);
        break;
    case GLINT_COMMAND_KEPT:
        glint_scheduler_unblock(s);
        break;
    case GLINT_COMMAND_PING:
        break;
    case GLINT_COMMAND_STOP:
        begin_stop(s);
        return;
    }
    answer(s, c);
}
