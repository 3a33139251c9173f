// jobs.h - the job table and the scheduler that owns it.
//
// One scheduler thread makes every state change and decides who renders what next; one thread per
// worker runs slices; one preparer compiles programs and allocates films. A higher priority
// is served first from the next slice; of equal priority clients share the workers alike, then the
// jobs of each client, in turns of one slice. A job goes on where it stopped when it is given more.
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

// What a queued job waits for.
enum glint_wait {
    GLINT_WAIT_NONE,
    GLINT_WAIT_TURN,        // others go first
    GLINT_WAIT_PREPARATION, // its program and film are being made
    GLINT_WAIT_MEMORY,      // others hold what it needs
    GLINT_WAITS
};
const char *glint_wait_name(enum glint_wait wait); // NULL for none

// What jobs may use. 0: the default of each. It may change at any time: what is there stays.
struct glint_jobs_limits {
    uint64_t memory_bytes; // of scenes, films and what jobs make of scenes; 3/4 of the machine's
    uint32_t live_jobs;    // queued, rendering or paused: 4096, and never more
    uint32_t ended_jobs;   // known after their end: 1000
    uint32_t side_by_side; // films of one priority or higher that get slices in turns: 8
};

// The oldest ended jobs are forgotten when a new one needs the memory of theirs; a job that does
// not fit beside those that render waits. limits: NULL: the defaults. keeper: where jobs and films
// are kept across restarts; NULL: nowhere.
glint_status glint_jobs_create(glint_jobs **out, glint_devices *devices, glint_store *store,
                               const struct glint_jobs_limits *limits, glint_keeper *keeper,
                               struct glint_error *err);
void glint_jobs_set_limits(glint_jobs *jobs, const struct glint_jobs_limits *limits);
// Seconds between two films of a job that are written to the disk, 0: the default; and all at once.
void glint_jobs_set_checkpoint(glint_jobs *jobs, double seconds);
void glint_jobs_checkpoint(glint_jobs *jobs);
// What films may take of the disk, 0: half of it. The oldest ended jobs are forgotten past that.
void glint_jobs_set_film_disk(glint_jobs *jobs, uint64_t bytes);
// Stops after the slices out now. Every job that has not ended is kept as it stands or, where
// nothing is kept, becomes cancelled.
void glint_jobs_destroy(glint_jobs **jobs);

// Called after every change of any job, from the scheduler thread: at once when a state changes, at
// most a hundred times a second for new pixels, never before they are there. It must not block,
// and of this header it may call describe, list, view, release and stats only. When this returns
// the one before is not running and will not be called again; NULL: none.
void glint_jobs_on_change(glint_jobs *jobs, void (*changed)(void *user), void *user);

// What comes with a job beside its body. All may be NULL.
struct glint_submission {
    const char *key;     // Idempotency-Key
    const char *client;  // who submits: clients share the workers alike; NULL: ""
    const char *request; // id of the request, for the resource and the log
};

// Takes `job` on success. The scene's current revision is pinned now. The same key with an equal
// body of the same client answers the same id and sets *repeated, with another body it is
// GLINT_E_RANGE. A key is good for a day and no longer than its job is known.
//   GLINT_E_RANGE     no such scene, no such camera (pointers into the job); the key
//   GLINT_E_CAPACITY  it would not fit if it were alone with its scene
//   GLINT_E_BUSY      too many jobs wait, or the daemon is shutting down
//   GLINT_E_PENDING   another submission of the client with this key is being answered
glint_status glint_jobs_submit(glint_jobs *jobs, struct glint_job *job,
                               const struct glint_submission *from, char id[GLINT_JOB_ID_BYTES],
                               bool *repeated, struct glint_error *err);

// Which jobs are listed.
struct glint_jobs_filter {
    uint32_t states;    // bit 1 << state for each; 0: all
    const char *client; // NULL: of all
    const char *after;  // id of the job that the list goes on behind, NULL: from the first on
    uint32_t limit;     // 0: none
};

// {"id","name","client","request","scene","revision","state","waits_for","priority","samples",
//  "target_samples","progress","error","estimate":{...},"seconds","eta_seconds","worker_seconds",
//  "cpu_seconds","checkpoint","memory_bytes","rays":{...},"invariants":{...},"plan","problem",
//  "chosen","warnings","created","job":{...}} and
// {"jobs": [...], "next": id or null} in order of submission; filter: NULL: all; next: what to go on
// behind, when the limit has cut the list. Numbers not known yet are null; "problem" is there when
// the job has failed, "chosen" where its settings were picked by price, "request" where the
// submission had one.
//   GLINT_E_NOT_FOUND  no such job
cJSON *glint_jobs_describe(glint_jobs *jobs, const char *id, struct glint_error *err);
//   GLINT_E_RANGE      there is no job `after`
cJSON *glint_jobs_list(glint_jobs *jobs, const struct glint_jobs_filter *filter,
                       struct glint_error *err);

// What was measured of a scene's settings, from which those of jobs with a budget are picked: see
// protocol/accuracy_front.h. glint_jobs_front() answers with the scene's own or that of its class:
// {"scene", "from": "scene" or "class", "class", "current", "front": {...}}.
//   GLINT_E_NOT_FOUND  no such scene
glint_status glint_jobs_put_front(glint_jobs *jobs, const char *scene, const char *text,
                                  size_t length, bool *created, struct glint_error *err);
glint_status glint_jobs_drop_front(glint_jobs *jobs, const char *scene, struct glint_error *err);
cJSON *glint_jobs_front(glint_jobs *jobs, const char *scene, struct glint_error *err);

// First call on a live job cancels it and keeps its pixels (*forgotten false); on an ended one it
// forgets the job (*forgotten true).
glint_status glint_jobs_delete(glint_jobs *jobs, const char *id, bool *forgotten,
                               struct glint_error *err);

// PATCH: merge patch of `priority`, `paused`, `stop` and, of a live job, `camera`; unknown members
// are faults. A job that is done or cancelled goes on where it stopped when `stop` is moved past what
// it has; the same stop again is no fault.
//   GLINT_E_CONFLICT  it has ended otherwise, or has more samples already; its scene is gone
glint_status glint_jobs_patch(glint_jobs *jobs, const char *id, const char *text, size_t length,
                              struct glint_error *err);

// The job's render with a reference that keeps it alive until released, for pixels and plans; where
// it is not in memory it is opened from its film, which is read as pixels are asked for.
//   GLINT_E_BUSY  it is still being prepared
//   GLINT_E_IO    its film cannot be read
struct glint_job_view {
    glint_render *render; // NULL: the job ended before it had one
    enum glint_job_state state;
    const struct glint_job *job;
    struct glint_job_stop stop; // as it is now, the job's own or another since
    double parallel; // seconds of the job for a second of one worker; NAN before there is one
    char revision[65];
    uint64_t sequence; // grows with every change of this job
    void *hold;
    bool opened; // `render` is of a film on the disk, and the view's alone
};
glint_status glint_jobs_view(glint_jobs *jobs, const char *id, struct glint_job_view *out,
                             struct glint_error *err);
void glint_jobs_release(glint_jobs *jobs, struct glint_job_view *view);

// True for a job that there is and that this client has submitted.
bool glint_jobs_belongs(glint_jobs *jobs, const char *id, const char *client);

// Returns once the scheduler has come round; it takes long only where something is wrong.
void glint_jobs_ping(glint_jobs *jobs);

struct glint_jobs_stats {
    uint32_t by_state[6];
    uint32_t by_wait[GLINT_WAITS]; // of those that are queued
    uint64_t submitted, slices;
    uint64_t started;    // times that a queued job got its first slice
    double wait_seconds; // that they were queued before, together
    double worker_busy_seconds;
    uint64_t film_bytes, ended_film_bytes; // of jobs that have not ended and that have, with waves
    struct glint_jobs_limits limits;       // none is 0
};
void glint_jobs_stats(glint_jobs *jobs, struct glint_jobs_stats *out);

struct glint_worker_use {
    double busy_seconds;          // since the start
    double share;                 // busy in about the last second, 0..1
    char job[GLINT_JOB_ID_BYTES]; // whose slice it runs, "": none
};
// Of the first `capacity` workers; returns how many there are.
uint32_t glint_jobs_workers(glint_jobs *jobs, struct glint_worker_use *out, uint32_t capacity);

#endif
