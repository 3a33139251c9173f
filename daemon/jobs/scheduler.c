#include "jobs/scheduler_parts.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/thread.h"
#include "jobs/checkpoint.h"
#include "jobs/state.h"
#include "jobs/turn.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define COMMAND_ROOM 256 // in the inbox, beside one answer for each order that can be out
#define FRESH_SLICES 8
#define RETRY_SECONDS 1.0
#define SHORT_SECONDS 0.006 // a slice that is not worth giving up: its tile counts as shown
#define PIXEL_SECONDS 0.01  // between calls of `changed` for new pixels: slices may be shorter

glint_status glint_scheduler_call(glint_scheduler *s, struct glint_command *c)
{
    const struct glint_message message = {.kind = GLINT_MESSAGE_COMMAND, .command = c};
    c->answered = false;
    if (!glint_queue_offer(s->inbox, &message))
        return c->status = glint_fail(c->err, GLINT_E_BUSY, "", "too many requests wait");
    pthread_mutex_lock(&s->mutex);
    while (!c->answered)
        pthread_cond_wait(&s->answer, &s->mutex);
    pthread_mutex_unlock(&s->mutex);
    return c->status;
}

void glint_scheduler_enter(glint_scheduler *s, struct glint_entry *e, enum glint_job_state state)
{
    glint_state_enter(s->table, e, state);
    s->news = true;
    glint_log(GLINT_LOG_DEBUG, "jobs", e->id, e->request, "%s", glint_job_state_name(state));
}

static void remove_live(glint_scheduler *s, const struct glint_entry *e)
{
    size_t at = 0;
    while (s->live[at] != e)
        at++;
    s->lives--;
    memmove(s->live + at, s->live + at + 1, (s->lives - at) * sizeof *s->live);
}

void glint_scheduler_unblock(glint_scheduler *s)
{
    for (size_t i = 0; i < s->lives; i++)
        s->live[i]->blocked = false;
}

static void settle(glint_scheduler *s, struct glint_entry *e)
{
    glint_revision_use(e->revision, -1); // first: who sees the job ended may delete its scene
    glint_scheduler_enter(s, e, e->end);
    e->end = GLINT_JOB_QUEUED;
    glint_checkpoint_ended(e);
    remove_live(s, e);
    glint_turn_leave(&s->accounts, e);
    glint_scheduler_unblock(s);
    glint_crew_dispose(s->crew, &e->next_view, &e->next_revision);
    glint_log(e->state == GLINT_JOB_FAILED ? GLINT_LOG_WARNING : GLINT_LOG_INFO, "jobs", e->id,
              e->request, "%s after %.3f s%s%s", glint_job_state_name(e->state), e->render_seconds,
              e->problem.status ? ": " : "",
              e->problem.status ? glint_error_text(&e->problem) : "");
}

void glint_scheduler_end(glint_scheduler *s, struct glint_entry *e, enum glint_job_state state)
{
    if (e->end == GLINT_JOB_QUEUED) {
        e->end = state;
        // Relaxed: a hint to the preparer.
        atomic_store_explicit(&e->abandoned, true, memory_order_relaxed);
        glint_scheduler_recall(s);
        if (e->out && state != GLINT_JOB_DONE) // nobody waits for what is out
            glint_render_interrupt(e->render, true);
    }
    if (!e->out) // or else what was out has been taken away since it began to end
        settle(s, e);
}

static void fail(glint_scheduler *s, struct glint_entry *e, struct glint_error *error)
{
    glint_state_blame(s->table, e, error);
    glint_scheduler_end(s, e, GLINT_JOB_FAILED);
}

// A live job that has reached its stop waits for something else to show.
static void idle(glint_scheduler *s, struct glint_entry *e)
{
    if (e->idle)
        return;
    glint_state_idle(s->table, e, true);
    glint_scheduler_recall(s);
    s->news = true;
}

// What it was asked for is there.
static void end_at_stop(glint_scheduler *s, struct glint_entry *e)
{
    if (e->job->live)
        idle(s, e);
    else
        glint_scheduler_end(s, e, GLINT_JOB_DONE);
}

static void end_if_complete(glint_scheduler *s, struct glint_entry *e)
{
    if (glint_state_ended(e->state) || e->end != GLINT_JOB_QUEUED || e->out ||
        !glint_render_complete(e->render))
        return;
    end_at_stop(s, e);
}

// The job shows what was made for it. Nothing of it is out.
static void change_view(glint_scheduler *s, struct glint_entry *e)
{
    e->sketch = false;
    glint_render_restart(e->render, &e->next_view);
    glint_revision_use(e->next_revision, 1);
    glint_revision_use(e->revision, -1);
    glint_state_moved(s->table, e, &e->next_revision);
    glint_crew_dispose(s->crew, &e->next_view, &e->next_revision);
    glint_turn_join(s->live, s->lives, e);
    e->fresh = FRESH_SLICES;
    s->news = true;
}

// Answers of the crew.

// Whether somebody else's film may go and make room.
static bool others_hold_films(const glint_scheduler *s, const struct glint_entry *e)
{
    for (size_t i = 0; i < s->lives; i++)
        if (s->live[i] != e && s->live[i]->render)
            return true;
    return false;
}

static void not_prepared(glint_scheduler *s, struct glint_entry *e, struct glint_message *m)
{
    const bool memory = m->status == GLINT_E_CAPACITY || m->status == GLINT_E_NOMEM;
    if (!memory || !others_hold_films(s, e)) {
        fail(s, e, &m->error);
        return;
    }
    glint_log(GLINT_LOG_INFO, "jobs", e->id, e->request, "waits for another job to end: %s",
              glint_error_text(&m->error));
    glint_error_finish(&m->error);
    e->blocked = true;
}

// The stop may have changed while the film was made, and a film may come with samples.
static void follow_stop(glint_scheduler *s, struct glint_entry *e)
{
    const struct glint_job_stop *asked = &e->job->stop;
    const bool as_made = e->stop.samples == asked->samples && e->stop.error == asked->error;
    if (!as_made && !glint_render_extend(e->render, e->stop.samples, e->stop.error))
        end_at_stop(s, e);
}

static void prepared(glint_scheduler *s, struct glint_message *m)
{
    struct glint_entry *e = m->entry;
    s->preparing = e->preparing = false;
    if (glint_state_ended(e->state)) { // a film without a sample is of no use to anybody
        glint_render_destroy(&m->render);
        glint_error_finish(&m->error);
    } else if (m->status) {
        not_prepared(s, e, m);
    } else if (m->render) { // none: it was cancelled meanwhile, and goes on; it is prepared again
        if (m->revision != e->revision) {
            glint_revision_use(m->revision, 1);
            glint_revision_use(e->revision, -1);
            glint_state_moved(s->table, e, &m->revision);
        }
        e->sketch = glint_render_is_sketch(m->render);
        e->fresh = e->sketch ? FRESH_SLICES : e->fresh;
        glint_state_prepared(s->table, e, &m->render);
        follow_stop(s, e);
        glint_turn_join(s->live, s->lives, e);
        glint_scheduler_recall(s);
        s->news = true;
        end_if_complete(s, e);
    }
    glint_crew_dispose(s->crew, &m->view, &m->revision);
    glint_entry_release(&m->entry);
}

static void stay(glint_scheduler *s, struct glint_entry *e, struct glint_error *error)
{
    const char *why = glint_error_text(error);
    glint_log(GLINT_LOG_WARNING, "jobs", e->id, e->request, "cannot move: %s", why);
    glint_state_trouble(s->table, e, strdup(why));
    glint_error_finish(error);
    s->news = true;
}

// Of what has ended or ends meanwhile a new view is of no use. None has come where it seemed to end
// and goes on: it is ordered again.
static void moved(glint_scheduler *s, struct glint_message *m)
{
    struct glint_entry *e = m->entry;
    const bool waits = e->end == GLINT_JOB_QUEUED && !glint_state_ended(e->state);
    *(m->kind == GLINT_MESSAGE_FINISHED ? &s->finishing : &s->moving) = false;
    if (m->status && !e->sketch) {
        stay(s, e, &m->error);
    } else if (m->status && waits) {
        fail(s, e, &m->error);
    } else if (m->view && waits) {
        glint_crew_dispose(s->crew, &e->next_view, &e->next_revision); // superseded
        e->next_view = m->view;
        e->next_revision = m->revision;
        m->view = NULL;
        m->revision = NULL;
        glint_scheduler_recall(s);
        if (!e->out)
            change_view(s, e);
        else if (e->slice_seconds > SHORT_SECONDS)
            glint_render_interrupt(e->render, true);
    }
    glint_crew_dispose(s->crew, &m->view, &m->revision);
    glint_error_finish(&m->error);
    glint_entry_release(&m->entry);
}

// The job has done without it: of what it was nothing counts but the worker's time.
static void returned_late(glint_scheduler *s, struct glint_message *m)
{
    struct glint_order order = s->load[m->worker].order[0];
    glint_error_finish(&m->error);
    glint_state_worked(s->table, m->seconds, m->worker, glint_load_next(&s->load[m->worker]));
    glint_scheduler_forget(s, &order);
}

static void returned(glint_scheduler *s, struct glint_message *m)
{
    struct glint_entry *e = m->entry;
    e->out--;
    glint_render_give_back(e->render, &m->slice, !m->status);
    glint_state_slice(s->table, e, m->seconds, m->cpu_seconds, m->worker,
                      glint_load_next(&s->load[m->worker]));
    glint_turn_charge(e, m->seconds);
    s->pixels = true;
    s->news |= e->fresh > 0; // somebody waits for it
    e->fresh -= e->fresh > 0;
    if (m->status && m->status != GLINT_E_BUSY)
        fail(s, e, &m->error);
    if (e->end != GLINT_JOB_QUEUED && !e->out && !glint_state_ended(e->state))
        settle(s, e);
    else if (e->next_view && !e->out)
        change_view(s, e);
    else
        end_if_complete(s, e);
}

static void handle(glint_scheduler *s, struct glint_message *m)
{
    switch (m->kind) {
    case GLINT_MESSAGE_COMMAND:
        glint_scheduler_obey(s, m->command);
        break;
    case GLINT_MESSAGE_PREPARED:
        prepared(s, m);
        break;
    case GLINT_MESSAGE_FINISHED:
    case GLINT_MESSAGE_MOVED:
        moved(s, m);
        break;
    case GLINT_MESSAGE_RETURNED:
        if (s->load[m->worker].order[0].revoked)
            returned_late(s, m);
        else
            returned(s, m);
        break;
    }
}

// What the scheduler does of itself.

// The time that a job was given begins with its first sample.
static double deadline_of(const struct glint_entry *e)
{
    return e->sketch ? INFINITY : glint_state_deadline(e);
}

static double next_deadline(const glint_scheduler *s)
{
    double next = INFINITY;
    for (size_t i = 0; i < s->lives; i++)
        if (s->live[i]->end == GLINT_JOB_QUEUED)
            next = fmin(next, deadline_of(s->live[i]));
    return next;
}

// Whoever said when it must be over waits, once every pixel has a sample, for no slice that others
// keep from the processor: it does not get into the film, unless it is being written.
static void give_up_slices(glint_scheduler *s, struct glint_entry *e)
{
    struct glint_render_state now;
    if (!e->out || e->job->live)
        return;
    glint_render_state(e->render, &now);
    if (!now.samples)
        return;
    glint_render_interrupt(e->render, true);
    glint_scheduler_recall(s);
    glint_scheduler_revoke(s, e);
}

static void end_late(glint_scheduler *s)
{
    const double now = glint_now();
    for (size_t i = s->lives; i--;) {
        struct glint_entry *e = s->live[i];
        if (deadline_of(e) > now)
            continue;
        give_up_slices(s, e);
        end_at_stop(s, e);
    }
}

// What scenes leave of the memory.
static uint64_t memory_for_films(const glint_scheduler *s)
{
    struct glint_store_stats scenes;
    glint_store_stats(s->store, &scenes);
    const uint64_t limit = s->table->limits.memory_bytes;
    return limit > scenes.resident_bytes ? limit - scenes.resident_bytes : 0;
}

static void let_go(void *user, glint_render **render)
{
    const glint_scheduler *s = user;
    glint_crew_discard(s->crew, render);
}

static void retry_crowded(glint_scheduler *s)
{
    if (glint_now() < s->retry)
        return;
    s->retry = INFINITY;
    for (size_t i = 0; i < s->lives; i++)
        if (s->live[i]->crowded)
            s->live[i]->blocked = s->live[i]->crowded = false;
}

static void prepare_next(glint_scheduler *s)
{
    struct glint_entry *e =
        s->preparing ? NULL : glint_turn_prepare(s->live, s->lives, s->table->limits.side_by_side);
    if (!e)
        return;
    struct glint_entry *gone = NULL;
    e->blocked = !glint_job_table_make_room(s->table, e->need.film + e->need.scene,
                                            memory_for_films(s), &gone, let_go, s);
    e->crowded = e->blocked;
    if (e->blocked) {
        s->retry = glint_now() + RETRY_SECONDS;
        return;
    }
    s->preparing = e->preparing = true;
    glint_crew_prepare(s->crew, e, gone);
}

// What it needs all cores for begins once a part of the sketch has been traced: somebody waits for
// that.
static void finish_next(glint_scheduler *s)
{
    for (size_t i = 0; i < s->lives && !s->finishing; i++) {
        struct glint_entry *e = s->live[i];
        if (!e->render || !e->sketch || e->next_view || e->end != GLINT_JOB_QUEUED ||
            e->fresh == FRESH_SLICES)
            continue;
        s->finishing = true;
        glint_crew_finish(s->crew, e);
    }
}

static void move_next(glint_scheduler *s)
{
    struct glint_entry *e = s->moving ? NULL : glint_turn_move(s->live, s->lives);
    if (!e)
        return;
    e->stale = 0; // what changes from now on asks again
    s->moving = true;
    glint_crew_move(s->crew, e);
}

static void hand_out(glint_scheduler *s, uint32_t worker, struct glint_entry *e,
                     struct glint_slice *slice)
{
    if (!e->began)
        glint_scheduler_enter(s, e, GLINT_JOB_RENDERING);
    e->began = true;
    e->out++;
    struct glint_load *load = &s->load[worker];
    glint_load_add(load, e, slice);
    if (load->orders == 1)
        glint_state_work(s->table, e, worker);
    glint_crew_run(s->crew, worker, e, slice);
}

static void dispatch(glint_scheduler *s)
{
    for (size_t i = 0; i < s->lives; i++)
        s->live[i]->dry = false;
    for (uint32_t worker; (worker = glint_scheduler_idlest(s)) != GLINT_NONE;) {
        struct glint_entry *e = glint_turn_next(s->live, s->lives);
        struct glint_slice slice;
        if (!e)
            return;
        e->dry = !glint_render_take(e->render, &slice);
        if (!e->dry)
            hand_out(s, worker, e, &slice);
    }
}

// A job with nothing out, nothing to take and samples missing would wait for ever.
static void fail_stuck(glint_scheduler *s)
{
    for (size_t i = s->lives; i--;) {
        struct glint_entry *e = s->live[i];
        if (!e->dry || e->out || e->sketch || !glint_turn_wants(e))
            continue;
        struct glint_error error = {0};
        glint_fail(&error, GLINT_E_INTERNAL, "", "samples are missing and no slice is left");
        fail(s, e, &error);
    }
}

static enum glint_wait wait_of(const struct glint_entry *e)
{
    if (e->state != GLINT_JOB_QUEUED)
        return GLINT_WAIT_NONE;
    if (e->preparing)
        return GLINT_WAIT_PREPARATION;
    return e->blocked ? GLINT_WAIT_MEMORY : GLINT_WAIT_TURN;
}

static void note_waits(glint_scheduler *s)
{
    for (size_t i = 0; i < s->lives; i++) {
        const enum glint_wait wait = wait_of(s->live[i]);
        if (wait == s->live[i]->wait)
            continue;
        glint_state_wait(s->table, s->live[i], wait);
        s->news = true;
    }
}

static void tell(glint_scheduler *s)
{
    const double now = glint_now();
    if (!s->news && (!s->pixels || now < s->told + PIXEL_SECONDS))
        return;
    s->news = s->pixels = false;
    s->told = now;
    if (s->changed)
        s->changed(s->user);
}

// When it must act though no message comes.
static double wake_up(const glint_scheduler *s)
{
    const double deadline = fmin(next_deadline(s), s->retry);
    return s->pixels ? fmin(deadline, s->told + PIXEL_SECONDS) : deadline;
}

// What is kept need not end, but what is out of it comes back.
static bool is_over(const glint_scheduler *s)
{
    bool over = s->stopping;
    for (size_t i = 0; i < s->lives && over; i++)
        over = s->live[i]->keeper && !s->live[i]->out;
    return over;
}

static void *run(void *arg)
{
    glint_scheduler *s = arg;
    struct glint_message message;
    while (!is_over(s)) {
        if (glint_queue_pop_until(s->inbox, &message, wake_up(s)))
            do
                handle(s, &message);
            while (glint_queue_poll(s->inbox, &message));
        end_late(s);
        retry_crowded(s);
        if (!s->stopping) {
            prepare_next(s);
            finish_next(s);
            move_next(s);
            dispatch(s);
            fail_stuck(s);
        }
        note_waits(s);
        tell(s);
    }
    return NULL;
}

glint_status glint_scheduler_create(glint_scheduler **out, glint_devices *devices,
                                    glint_store *store, struct glint_job_table *table,
                                    const struct glint_jobs_limits *limits, struct glint_error *err)
{
    *out = NULL;
    glint_scheduler *s = calloc(1, sizeof *s);
    const uint32_t workers = glint_devices_workers(devices);
    struct glint_load *load = calloc(workers, sizeof *load);
    if (!s || !load) {
        free(s);
        free(load);
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the scheduler");
    }
    s->table = table;
    s->store = store;
    s->retry = INFINITY;
    glint_scheduler_limit(s, limits);
    s->load = load;
    s->workers = workers;
    pthread_mutex_init(&s->mutex, NULL);
    pthread_cond_init(&s->answer, NULL);
    glint_status st = glint_queue_create(&s->inbox, GLINT_CREW_DEPTH * workers + 3 + COMMAND_ROOM,
                                         sizeof(struct glint_message), err);
    if (!st)
        st = glint_crew_create(&s->crew, devices, store, s->inbox, err);
    if (!st)
        st = glint_thread_start(&s->thread, "scheduler", run, s, err);
    s->started = !st;
    if (st)
        glint_scheduler_destroy(&s);
    *out = s;
    return st;
}

static void stop(glint_scheduler *s)
{
    // Nobody waits for an answer: the thread's end is one.
    struct glint_command command = {.kind = GLINT_COMMAND_STOP};
    const struct glint_message message = {.kind = GLINT_MESSAGE_COMMAND, .command = &command};
    glint_queue_push(s->inbox, &message); // waits for room: this one must not be refused
    pthread_join(s->thread, NULL);
}

void glint_scheduler_destroy(glint_scheduler **scheduler)
{
    glint_scheduler *s = *scheduler;
    if (!s)
        return;
    if (s->started)
        stop(s);
    if (s->inbox)
        glint_queue_close(s->inbox);
    glint_crew_destroy(&s->crew);
    for (struct glint_message m; s->inbox && glint_queue_poll(s->inbox, &m);)
        if (m.kind == GLINT_MESSAGE_RETURNED) // what was taken away: nothing else is out
            glint_error_finish(&m.error);
        else
            glint_crew_drop(&m); // what was being prepared: nobody renders any more
    for (uint32_t w = 0; w < s->workers; w++)
        for (uint32_t i = 0; i < s->load[w].orders; i++)
            glint_scheduler_forget(s, &s->load[w].order[i]);
    glint_queue_destroy(&s->inbox);
    for (size_t i = 0; i < s->lives; i++) // those that are kept
        glint_turn_leave(&s->accounts, s->live[i]);
    pthread_cond_destroy(&s->answer);
    pthread_mutex_destroy(&s->mutex);
    free(s->load);
    free(s);
    *scheduler = NULL;
}
