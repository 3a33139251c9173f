// crew.h - the threads that work for the scheduler: one per device worker, one that prepares new
// jobs, one that finishes what began as a sketch and one that prepares the moves of live ones.
//
// They take an order from a bounded queue and answer into the scheduler's inbox; they decide
// nothing. The scheduler counts what it hands out, so an order never finds a queue full; an answer
// waits for room in the inbox, which the scheduler always empties.
//
// Threads: create and destroy by whoever owns the scheduler; the rest by the scheduler.
#ifndef GLINT_JOBS_CREW_H
#define GLINT_JOBS_CREW_H

#include "base/queue.h"
#include "jobs/table.h"

#define GLINT_CREW_DEPTH 2 // orders per worker: one that runs and one that waits

enum glint_message_kind {
    GLINT_MESSAGE_COMMAND,
    GLINT_MESSAGE_PREPARED,
    GLINT_MESSAGE_FINISHED, // as MOVED, of a job that began as a sketch
    GLINT_MESSAGE_MOVED,
    GLINT_MESSAGE_RETURNED
};

// What reaches the scheduler's inbox.
struct glint_message {
    enum glint_message_kind kind;
    struct glint_command *command; // COMMAND
    struct glint_entry *entry;     // others; all but RETURNED: with a reference
    glint_render *render;          // PREPARED: the receiver's, NULL if there is none
    glint_view *view;              // FINISHED, MOVED: the receiver's, NULL if there is none
    glint_revision *revision;      // of render or view, the receiver's
    uint32_t worker;               // RETURNED
    struct glint_slice slice;      // RETURNED
    double seconds, cpu_seconds;   // RETURNED: of the worker
    glint_status status;
    struct glint_error error; // the receiver's, when `status` is not GLINT_OK
};

typedef struct glint_crew glint_crew;

// Starts the threads. `inbox` takes struct glint_message and outlives the crew.
// Live jobs find their newest revision in `store`.
glint_status glint_crew_create(glint_crew **out, glint_devices *devices, glint_store *store,
                               glint_queue *inbox, struct glint_error *err);
// Lets orders out be finished, ends the threads. What they answer after the inbox was closed is
// freed here.
void glint_crew_destroy(glint_crew **crew);

uint32_t glint_crew_workers(const glint_crew *crew);

// Orders `worker` to run a slice. At most GLINT_CREW_DEPTH may be out for one.
void glint_crew_run(glint_crew *crew, uint32_t worker, struct glint_entry *entry,
                    const struct glint_slice *slice);
// Takes back an order that the worker has not begun; false: there is none.
bool glint_crew_recall(glint_crew *crew, uint32_t worker, struct glint_entry **entry,
                       struct glint_slice *slice);

// Orders the entry's render to be made. Takes a reference. At most one may be out.
// gone: a list by `next` of entries to be released before, to make room; takes their references.
void glint_crew_prepare(glint_crew *crew, struct glint_entry *entry, struct glint_entry *gone);

// Orders what a live job shows next to be made: the newest revision seen by its camera. Takes a
// reference. At most one may be out.
void glint_crew_move(glint_crew *crew, struct glint_entry *entry);

// Orders what a job shows that has begun as a sketch: the same with all that it is made of. Takes a
// reference. At most one may be out.
void glint_crew_finish(glint_crew *crew, struct glint_entry *entry);

// What an answer brings, when nobody takes it.
void glint_crew_drop(struct glint_message *answer);

// Has a render destroyed, which takes a while; stores NULL.
void glint_crew_discard(glint_crew *crew, glint_render **render);

// Has a view and a revision released, which takes a while; stores NULL. The crew may be NULL.
void glint_crew_dispose(glint_crew *crew, glint_view **view, glint_revision **revision);

#endif
