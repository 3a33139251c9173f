// jobs.h - the job table and the scheduler that owns it.
//
// One scheduler thread makes every state change and decides who renders what next; one thread per
// worker runs slices; one preparer compiles programs and allocates films. Jobs of equal priority
// share the workers in turns of one slice; a higher priority is served first from the next slice.
//
// A live job is never done: when it has reached its stop it idles, and it starts again with the
// newest revision of its scene, or seen by another camera, as soon as its slices out are back. Of
// several changes that come meanwhile the last counts. Where it cannot follow it stays at what it
// shows, and a warning says why.
//
// Threads: create/destroy by main; every other call by any thread (they post to the scheduler or
// read under the table's mutex; none waits for a render).
#ifndef GLINT_JOBS_JOBS_H
#define GLINT_JOBS_JOBS_H

#include "protocol/job.h"
#include "render/render.h"
#include "scene/store.h"

#include <cjson/cJSON.h>

typedef struct glint_jobs glint_jobs;

enum glint_job_state {
    GLINT_JOB_QUEUED,
    GLINT_JOB_RENDERING,
    GLINT_JOB_PAUSED,
    GLINT_JOB_DONE,
    GLINT_JOB_FAILED,
    GLINT_JOB_CANCELLED
};
const char *glint_job_state_name(enum glint_job_state state);

#define GLINT_JOB_ID_BYTES 33

// film_bytes: memory for the films of all jobs. The oldest ended jobs are forgotten when a new one
// needs theirs; a job that does not fit beside those that render waits.
glint_status glint_jobs_create(glint_jobs **out, glint_devices *devices, glint_store *store,
                               uint64_t film_bytes, struct glint_error *err);
// Stops after the slices out now; every job that has not ended becomes cancelled.
void glint_jobs_destroy(glint_jobs **jobs);

// Called after every change of any job, from the scheduler thread: at once when a state changes, at
// most a hundred times a second for new pixels, never before they are there. It must not block,
// and of this header it may call describe, list, view, release and stats only. When this returns
// the one before is not running and will not be called again; NULL: none.
void glint_jobs_on_change(glint_jobs *jobs, void (*changed)(void *user), void *user);

// Takes `job` on success. The scene's current revision is pinned now. key: Idempotency-Key or
// NULL; the same key with an equal body answers the same id and sets *repeated, with another body
// it is GLINT_E_RANGE. A key is good for a day and no longer than its job is known.
//   GLINT_E_RANGE     no such scene, no such camera (pointers into the job); the key
//   GLINT_E_CAPACITY  its film is larger than all films may be together
//   GLINT_E_BUSY      too many jobs wait, or the daemon is shutting down
glint_status glint_jobs_submit(glint_jobs *jobs, struct glint_job *job, const char *key,
                               char id[GLINT_JOB_ID_BYTES], bool *repeated,
                               struct glint_error *err);

// {"id","name","scene","revision","state","priority","samples","target_samples","progress","error",
//  "seconds","eta_seconds","worker_seconds","rays":{...},"plan","problem","warnings","created",
//  "job":{...}} and {"jobs": [...]} in order of submission. Numbers not known yet are null;
// "problem" is there when the job has failed.
cJSON *glint_jobs_describe(glint_jobs *jobs, const char *id, struct glint_error *err);
cJSON *glint_jobs_list(glint_jobs *jobs);

// First call on a live job cancels it and keeps its pixels (*forgotten false); on an ended one it
// forgets the job (*forgotten true).
glint_status glint_jobs_delete(glint_jobs *jobs, const char *id, bool *forgotten,
                               struct glint_error *err);

// PATCH: merge patch of `priority`, `paused`, `stop` and, of a live job, `camera`; unknown members
// are faults. GLINT_E_CONFLICT when the job has ended, except that one that stopped by time goes on
// when it is given more.
glint_status glint_jobs_patch(glint_jobs *jobs, const char *id, const char *text, size_t length,
                              struct glint_error *err);

// The job's render with a reference that keeps it alive until released, for pixels and plans;
// GLINT_E_BUSY while it is still being prepared.
struct glint_job_view {
    glint_render *render; // NULL: the job ended before it had one
    enum glint_job_state state;
    const struct glint_job *job;
    char revision[65];
    uint64_t sequence; // grows with every change of this job
    void *hold;
};
glint_status glint_jobs_view(glint_jobs *jobs, const char *id, struct glint_job_view *out,
                             struct glint_error *err);
void glint_jobs_release(glint_jobs *jobs, struct glint_job_view *view);

struct glint_jobs_stats {
    uint32_t by_state[6];
    uint64_t submitted, slices;
    double worker_busy_seconds;
};
void glint_jobs_stats(glint_jobs *jobs, struct glint_jobs_stats *out);

#endif
