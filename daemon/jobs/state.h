// state.h - the changes of an entry's state, each under the table's mutex.
//
//   queued -> rendering -> done, failed, cancelled
//   queued, rendering <-> paused
//   done, cancelled -> queued, rendering, when it is granted more
//
// The clock of a job runs while it is `rendering`: seconds of a pause do not count. That of a live
// job stands while it idles, and begins again when it moves.
//
// Threads: the scheduler.
#ifndef GLINT_JOBS_STATE_H
#define GLINT_JOBS_STATE_H

#include "jobs/table.h"

// Enters a state that is not failed; the clock runs from now on if it is `rendering`.
void glint_state_enter(struct glint_job_table *table, struct glint_entry *entry,
                       enum glint_job_state state);

// Notes why the job will fail: moves *error. The first reason stays.
void glint_state_blame(struct glint_job_table *table, struct glint_entry *entry,
                       struct glint_error *error);

// Moves *render into the entry.
void glint_state_prepared(struct glint_job_table *table, struct glint_entry *entry,
                          glint_render **render);

// A live job has nothing to do, or something again.
void glint_state_idle(struct glint_job_table *table, struct glint_entry *entry, bool idle);

// A live job shows *revision from now on, without trouble; *revision is then the one before.
void glint_state_moved(struct glint_job_table *table, struct glint_entry *entry,
                       glint_revision **revision);

// Why a live job could not move. Takes `why`, which may be NULL.
void glint_state_trouble(struct glint_job_table *table, struct glint_entry *entry, char *why);

// Exchanges the camera of a live job; *look is then the one before.
void glint_state_look(struct glint_job_table *table, struct glint_entry *entry,
                      struct glint_look **look);

// Counts a slice that the worker has run; it runs one of `next` now, NULL: none.
void glint_state_slice(struct glint_job_table *table, struct glint_entry *entry, double seconds,
                       double cpu_seconds, uint32_t worker, const struct glint_entry *next);
// Counts what a worker has done for nobody; it runs a slice of `next` now, NULL: none.
void glint_state_worked(struct glint_job_table *table, double seconds, uint32_t worker,
                        const struct glint_entry *next);
// So many more use the entry's render beside the scheduler and its workers.
void glint_state_lend(struct glint_job_table *table, struct glint_entry *entry, int users);
// The worker runs a slice of the entry.
void glint_state_work(struct glint_job_table *table, const struct glint_entry *entry,
                      uint32_t worker);

void glint_state_wait(struct glint_job_table *table, struct glint_entry *entry,
                      enum glint_wait wait);
void glint_state_priority(struct glint_job_table *table, struct glint_entry *entry,
                          int32_t priority);
void glint_state_stop(struct glint_job_table *table, struct glint_entry *entry,
                      const struct glint_job_stop *stop);

// glint_now() at which stop.seconds is reached, INFINITY while its clock stands or without a limit.
double glint_state_deadline(const struct glint_entry *entry);

#endif
