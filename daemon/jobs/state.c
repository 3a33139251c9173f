#include "jobs/state.h"

#include "base/clock.h"

#include <math.h>
#include <stdlib.h>

const char *glint_job_state_name(enum glint_job_state state)
{
    static const char *const name[] = {
        [GLINT_JOB_QUEUED] = "queued", [GLINT_JOB_RENDERING] = "rendering",
        [GLINT_JOB_PAUSED] = "paused", [GLINT_JOB_DONE] = "done",
        [GLINT_JOB_FAILED] = "failed", [GLINT_JOB_CANCELLED] = "cancelled",
    };
    return name[state];
}

const char *glint_wait_name(enum glint_wait wait)
{
    static const char *const name[GLINT_WAITS] = {[GLINT_WAIT_TURN] = "turn",
                                                  [GLINT_WAIT_PREPARATION] = "preparation",
                                                  [GLINT_WAIT_MEMORY] = "memory"};
    return name[wait];
}

// With the mutex: how long it was queued counts once it is.
static void count_wait(struct glint_job_table *table, struct glint_entry *entry,
                       enum glint_job_state state, double now)
{
    if (state == GLINT_JOB_QUEUED)
        entry->queued = now;
    if (state != GLINT_JOB_RENDERING || entry->state != GLINT_JOB_QUEUED)
        return;
    table->started++;
    table->wait_seconds += now - (entry->queued > 0 ? entry->queued : entry->submitted);
}

void glint_state_enter(struct glint_job_table *table, struct glint_entry *entry,
                       enum glint_job_state state)
{
    const double now = glint_now();
    pthread_mutex_lock(&table->mutex);
    count_wait(table, entry, state, now);
    entry->render_seconds = glint_entry_seconds(entry, now);
    entry->since = state == GLINT_JOB_RENDERING ? now : NAN;
    entry->state = state;
    entry->sequence++;
    pthread_mutex_unlock(&table->mutex);
}

void glint_state_blame(struct glint_job_table *table, struct glint_entry *entry,
                       struct glint_error *error)
{
    if (entry->problem.status) {
        glint_error_finish(error);
        return;
    }
    pthread_mutex_lock(&table->mutex);
    entry->problem = *error;
    pthread_mutex_unlock(&table->mutex);
    *error = (struct glint_error){0};
}

void glint_state_prepared(struct glint_job_table *table, struct glint_entry *entry,
                          glint_render **render)
{
    pthread_mutex_lock(&table->mutex);
    entry->render = *render;
    entry->sequence++;
    pthread_mutex_unlock(&table->mutex);
    *render = NULL;
}

void glint_state_idle(struct glint_job_table *table, struct glint_entry *entry, bool idle)
{
    const double now = glint_now();
    entry->idle = idle;
    pthread_mutex_lock(&table->mutex);
    entry->render_seconds = glint_entry_seconds(entry, now);
    entry->since = !idle && entry->state == GLINT_JOB_RENDERING ? now : NAN;
    entry->sequence++;
    pthread_mutex_unlock(&table->mutex);
}

void glint_state_moved(struct glint_job_table *table, struct glint_entry *entry,
                       glint_revision **revision)
{
    glint_revision *old = entry->revision;
    char *trouble = entry->trouble;
    entry->idle = false;
    pthread_mutex_lock(&table->mutex);
    entry->revision = *revision;
    entry->trouble = NULL;
    entry->render_seconds = 0;
    entry->since = entry->state == GLINT_JOB_RENDERING ? glint_now() : NAN;
    entry->sequence++;
    pthread_mutex_unlock(&table->mutex);
    *revision = old;
    free(trouble);
}

void glint_state_trouble(struct glint_job_table *table, struct glint_entry *entry, char *why)
{
    char *old = entry->trouble;
    pthread_mutex_lock(&table->mutex);
    entry->trouble = why;
    entry->sequence++;
    pthread_mutex_unlock(&table->mutex);
    free(old);
}

void glint_state_look(struct glint_job_table *table, struct glint_entry *entry,
                      struct glint_look **look)
{
    struct glint_look *old = entry->look;
    pthread_mutex_lock(&table->mutex);
    entry->look = *look;
    entry->sequence++;
    pthread_mutex_unlock(&table->mutex);
    *look = old;
}

// With the mutex.
static void count_work(struct glint_job_table *table, double seconds, uint32_t worker,
                       const struct glint_entry *next, double now)
{
    table->slices++;
    table->busy_seconds += seconds;
    glint_use_add(&table->worker[worker], seconds);
    glint_use_set(&table->worker[worker], next ? next->id : NULL, now);
}

void glint_state_slice(struct glint_job_table *table, struct glint_entry *entry, double seconds,
                       double cpu_seconds, uint32_t worker, const struct glint_entry *next)
{
    const double now = glint_now();
    pthread_mutex_lock(&table->mutex);
    entry->worker_seconds += seconds;
    entry->cpu_seconds += cpu_seconds;
    entry->sequence++;
    count_work(table, seconds, worker, next, now);
    pthread_mutex_unlock(&table->mutex);
}

void glint_state_worked(struct glint_job_table *table, double seconds, uint32_t worker,
                        const struct glint_entry *next)
{
    const double now = glint_now();
    pthread_mutex_lock(&table->mutex);
    count_work(table, seconds, worker, next, now);
    pthread_mutex_unlock(&table->mutex);
}

void glint_state_lend(struct glint_job_table *table, struct glint_entry *entry, int users)
{
    pthread_mutex_lock(&table->mutex);
    entry->views += (uint32_t)users;
    pthread_mutex_unlock(&table->mutex);
}

void glint_state_work(struct glint_job_table *table, const struct glint_entry *entry,
                      uint32_t worker)
{
    const double now = glint_now();
    pthread_mutex_lock(&table->mutex);
    glint_use_set(&table->worker[worker], entry->id, now);
    pthread_mutex_unlock(&table->mutex);
}

void glint_state_wait(struct glint_job_table *table, struct glint_entry *entry,
                      enum glint_wait wait)
{
    pthread_mutex_lock(&table->mutex);
    entry->wait = wait;
    entry->sequence++;
    pthread_mutex_unlock(&table->mutex);
}

void glint_state_priority(struct glint_job_table *table, struct glint_entry *entry,
                          int32_t priority)
{
    pthread_mutex_lock(&table->mutex);
    entry->priority = priority;
    entry->sequence++;
    pthread_mutex_unlock(&table->mutex);
}

void glint_state_stop(struct glint_job_table *table, struct glint_entry *entry,
                      const struct glint_job_stop *stop)
{
    pthread_mutex_lock(&table->mutex);
    entry->stop = *stop;
    entry->sequence++;
    pthread_mutex_unlock(&table->mutex);
}

double glint_state_deadline(const struct glint_entry *entry)
{
    if (entry->stop.seconds <= 0 || isnan(entry->since))
        return INFINITY;
    return entry->since + (entry->stop.seconds - entry->render_seconds);
}
