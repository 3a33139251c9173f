// scheduler_parts.h - the inside of the scheduler, shared by the file that runs it and the one that
// obeys commands.
//
// Threads: the scheduler's, but for what says otherwise.
#ifndef GLINT_JOBS_SCHEDULER_PARTS_H
#define GLINT_JOBS_SCHEDULER_PARTS_H

#include "jobs/crew.h"
#include "jobs/scheduler.h"

// A slice at a worker.
struct glint_order {
    struct glint_entry *entry;
    struct glint_slice slice;
    bool revoked; // it is not the job's any more: the entry is retained, its render in use
};

// Orders at a worker; the first one runs.
struct glint_load {
    struct glint_order order[GLINT_CREW_DEPTH];
    uint32_t orders;
    atomic_uint hold[GLINT_CREW_DEPTH]; // of the orders, in no order
};

struct glint_scheduler {
    struct glint_job_table *table;
    glint_store *store;
    glint_crew *crew;
    glint_queue *inbox;
    pthread_t thread;
    bool started;

    // the thread's
    struct glint_entry *live[GLINT_MAX_LIVE_JOBS]; // not ended, in order of submission
    size_t lives;
    struct glint_account *accounts; // of those
    struct glint_load *load;        // [workers]
    uint32_t workers;
    bool preparing; // the preparer has an order
    double retry;   // glint_now() at which who is crowded tries again, INFINITY: none
    bool finishing; // the finisher has one
    bool moving;    // the mover has one
    bool news;      // a state or description is another: `changed` is called at once
    bool pixels;    // new pixels: `changed` is called PIXEL_SECONDS after it was the last time
    double told;    // glint_now() of that
    void (*changed)(void *user);
    void *user;
    bool stopping;

    pthread_mutex_t mutex; // of `answered` in every command under way; a leaf
    pthread_cond_t answer;
};

// Carries a command out and answers it.
void glint_scheduler_obey(glint_scheduler *s, struct glint_command *command);

void glint_scheduler_enter(glint_scheduler *s, struct glint_entry *entry,
                           enum glint_job_state state);

// Takes limits, with the default for each that is 0.
void glint_scheduler_limit(glint_scheduler *s, const struct glint_jobs_limits *limits);

// Memory may have come free: who waited for it may try again.
void glint_scheduler_unblock(glint_scheduler *s);

// Takes back what waits at the workers, so that the next slices go to whom they are due.
void glint_scheduler_recall(glint_scheduler *s);

// Notes an order, with a hold of its own; the worker then has one more.
void glint_load_add(struct glint_load *load, struct glint_entry *entry, struct glint_slice *slice);
// The first order is done; whose the next is, or NULL.
const struct glint_entry *glint_load_next(struct glint_load *load);
// The worker with the fewest orders, or GLINT_NONE when all have their fill.
uint32_t glint_scheduler_idlest(const glint_scheduler *s);

// Takes the job's slices away from workers that are not at its film: they count as given
// back, whenever the workers notice.
void glint_scheduler_revoke(glint_scheduler *s, struct glint_entry *entry);
// The worker is rid of it; if it was taken away, nothing keeps its job any more.
void glint_scheduler_forget(glint_scheduler *s, struct glint_order *order);

// The job ends in `state` as soon as none of its slices is out. A decision stands.
void glint_scheduler_end(glint_scheduler *s, struct glint_entry *entry, enum glint_job_state state);

#endif
