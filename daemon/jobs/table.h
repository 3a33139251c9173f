// table.h - the jobs and what is known of each.
//
// An entry's fields fall into groups, by who may touch them:
//   fixed      written before the entry is in the table, never again: any thread
//   shared     written by the scheduler under the table's mutex; read by others under it, and by
//              the scheduler without
//   scheduler  its alone
//   counted    atomic
//
// Locks: the table's mutex is a leaf. Nothing that locks, waits or calls another module runs under
// it, so it has no order to keep with the locks of queues, renders and stores.
#ifndef GLINT_JOBS_TABLE_H
#define GLINT_JOBS_TABLE_H

#include "jobs/jobs.h"
#include "jobs/look.h"
#include "jobs/need.h"
#include "jobs/use.h"

#include <pthread.h>
#include <stdatomic.h>

#define GLINT_MAX_LIVE_JOBS 4096u  // queued, rendering or paused
#define GLINT_MAX_ENDED_JOBS 1000u // kept, unless told otherwise; the oldest are forgotten first
#define GLINT_KEY_SECONDS \
    86400.0 // an Idempotency-Key is good for a day, and while its job is known

struct glint_account;
struct glint_checkpoints;

// What is on the disk of a job. Written by the thread of the checkpoints and, before the job renders,
// by the preparer; where the others look at it, with the table's mutex.
struct glint_job_kept {
    uint64_t film, film_before;         // numbers of films, 0: none
    char written[32];                   // when the newest film was, UTC, "": not known
    struct glint_render_state rendered; // as the last row says
    uint64_t complete;                  // the entry's sequence when all of an ended job was kept
    bool removed;                       // the job is forgotten: its films go
    char *trouble;                      // why nothing is being kept, NULL: it is
    char *torn;                         // which film could not be read back, NULL: none
    double worker_seconds, at, retry;   // at the last film, when that was, not before
};

struct glint_entry {
    // fixed
    char id[GLINT_JOB_ID_BYTES];
    struct glint_job *job;
    char *text;      // canonical JSON of `job`
    char *asked;     // the same as submitted, where the settings were picked, or NULL
    cJSON *chosen;   // what was picked, and what is expected of it, or NULL
    char *key;       // Idempotency-Key or NULL
    char *client;    // who submitted, "": nobody says
    char *request;   // id of the request that did, or NULL
    cJSON *warnings; // array of strings
    char created[32];
    double submitted; // glint_now()
    struct glint_need need;
    uint64_t rest_bytes;              // of the scene at rest
    struct glint_checkpoints *keeper; // NULL: it is not kept

    // shared
    enum glint_job_state state;
    double queued; // glint_now() since which it is queued once more, 0: since it was submitted
    glint_revision *revision; // retained; a live job's is exchanged
    struct glint_look *look;  // a live job's camera, NULL: as submitted
    char *trouble;            // why a live job stays where it is, NULL: it does not
    glint_render *render;     // NULL until prepared
    struct glint_error problem;
    int32_t priority;
    enum glint_wait wait;
    struct glint_job_stop stop; // as it is now; that of `job` is as submitted
    double render_seconds;      // of rendering, up to `since`
    double since;               // glint_now() from which it is rendering, NAN: not now, or it idles
    double worker_seconds;
    double cpu_seconds; // of the workers' threads: less where they wait for a device or a core
    uint64_t sequence;
    uint32_t views; // by whom `render` is used beside the scheduler and its workers
    struct glint_job_kept kept;

    // scheduler
    bool listed;           // in the table
    bool preparing;        // at the preparer
    bool blocked;          // found no memory; waits for another job to end
    bool crowded;          // or for a scene to go, of which nobody is told
    bool began;            // has had a slice
    bool dry;              // had no slice to give in this round of turns
    bool idle;             // live, and has reached its stop
    bool sketch;           // has a render that is one
    uint32_t fresh;        // slices after a move that are told of at once
    double stale;          // live: glint_now() since which it should show something else, 0: not
    glint_view *next_view; // waits until no slice is out, NULL: none
    glint_revision *next_revision; // of it, retained
    uint32_t out;                  // slices at workers
    struct glint_account *account; // of its client at its priority, NULL: it has ended
    double turn;              // worker seconds on the scale on which a client's jobs take turns
    double slice_seconds;     // of late, per slice
    enum glint_job_state end; // state to end in once `out` is 0; QUEUED: not ending
    struct glint_entry *next; // of entries on their way out of the table

    // counted
    atomic_uint references;
    atomic_bool abandoned; // set by the scheduler: not worth preparing any more
};

struct glint_job_table {
    pthread_mutex_t mutex;
    struct glint_entry **entry; // [count] in order of submission, one reference each
    size_t count, capacity;
    uint64_t submitted, slices, started;
    double busy_seconds, wait_seconds; // of workers; of jobs until they were started
    struct glint_jobs_limits limits;   // none is 0
    struct glint_use *worker;          // [workers]
    uint32_t workers;
};

// False without memory.
bool glint_job_table_init(struct glint_job_table *table, uint32_t workers);
void glint_job_table_finish(struct glint_job_table *table); // drops every reference

// Retained, or NULL with GLINT_E_NOT_FOUND in *err.
struct glint_entry *glint_job_table_hold(struct glint_job_table *table, const char *id,
                                         struct glint_error *err);

// The entry that the client submitted with this key in the last day, not retained, or NULL. With
// the mutex, or by the scheduler.
struct glint_entry *glint_job_table_find_key(const struct glint_job_table *table,
                                             const char *client, const char *key);

// Scheduler only. add takes the reference; false without memory. remove hands the table's reference
// to the caller.
bool glint_job_table_add(struct glint_job_table *table, struct glint_entry *entry);
void glint_job_table_remove(struct glint_job_table *table, struct glint_entry *entry);

// Scheduler only: takes the oldest ended jobs past `most` out; a list by `next`.
struct glint_entry *glint_job_table_trim(struct glint_job_table *table, size_t most);

// Scheduler only: lets go of the films of ended jobs that are on the disk, the oldest first, or,
// where jobs are not kept, takes as many of the oldest ended jobs out as hold the film that is too much for
// `wanted` bytes more within `limit` for all films. False, and nothing done, where that cannot be enough. No film may
// be in preparation: it is not counted.
bool glint_job_table_make_room(struct glint_job_table *table, uint64_t wanted, uint64_t limit,
                               struct glint_entry **gone,
                               void (*let_go)(void *user, glint_render **render), void *user);

// As glint_jobs_stats() and glint_jobs_workers().
void glint_job_table_stats(struct glint_job_table *table, struct glint_jobs_stats *out);
uint32_t glint_job_table_workers(struct glint_job_table *table, struct glint_worker_use *out,
                                 uint32_t capacity);

static inline bool glint_state_ended(enum glint_job_state state)
{
    return state >= GLINT_JOB_DONE;
}

struct glint_entry *glint_entry_retain(struct glint_entry *entry);
// The last reference frees the film, which takes a while: not under a lock.
void glint_entry_release(struct glint_entry **entry);
void glint_entry_release_all(struct glint_entry *gone); // a list by `next`

// Seconds of rendering up to now. With the mutex, or by the scheduler.
double glint_entry_seconds(const struct glint_entry *entry, double now);

#endif
