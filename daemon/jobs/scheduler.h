// scheduler.h - the thread that owns the table: it makes every state change and says who renders
// what next.
//
// Others send it commands through its bounded inbox and wait for the answer, which takes no longer
// than the messages before it: it never waits for a render, a compiler or a lock held long. When
// the inbox is full a command is refused with GLINT_E_BUSY.
//
// Threads: create/destroy by one; call by any other but the scheduler itself.
#ifndef GLINT_JOBS_SCHEDULER_H
#define GLINT_JOBS_SCHEDULER_H

#include "jobs/patch.h"
#include "jobs/table.h"

typedef struct glint_scheduler glint_scheduler;

enum glint_command_kind {
    GLINT_COMMAND_SUBMIT, // adds `entry`, or finds the one with its key
    GLINT_COMMAND_DELETE, // cancels, or forgets
    GLINT_COMMAND_PATCH,
    GLINT_COMMAND_SCENE,  // the scene `scene` has a new revision
    GLINT_COMMAND_WATCH,  // sets the callback
    GLINT_COMMAND_LIMITS, // sets `limits`
    GLINT_COMMAND_PING,   // nothing: that it is answered is the answer
    GLINT_COMMAND_RECALL, // adds `entry`, which was known before a restart, with what it has done
    GLINT_COMMAND_KEPT,   // a film is on the disk: its memory may be let go
    GLINT_COMMAND_STOP, // destroy's alone: cancels what lives and is not kept, ends the thread once nothing
                        // is out
};

struct glint_command {
    enum glint_command_kind kind;
    struct glint_entry
        *entry; // SUBMIT, RECALL: takes the reference on success; DELETE, PATCH: borrowed
    struct glint_job_patch patch; // the camera before is in it afterwards
    const char *scene;            // SCENE
    void (*changed)(void *user);  // WATCH
    void *user;
    struct glint_jobs_limits limits; // LIMITS

    // The answer.
    glint_status status;
    struct glint_error *err;      // the caller's, filled while it waits
    struct glint_entry *repeated; // SUBMIT: the job that had the key, retained
    struct glint_entry *gone;     // out of the table, by `next`: the caller releases them
    bool forgotten;               // DELETE
    bool answered;                // the scheduler's and call's
};

// `table` outlives the scheduler. limits: NULL: the defaults.
// In `store` live jobs find their newest revision.
glint_status glint_scheduler_create(glint_scheduler **out, glint_devices *devices,
                                    glint_store *store, struct glint_job_table *table,
                                    const struct glint_jobs_limits *limits,
                                    struct glint_error *err);
// Stops after the slices out now; what has not ended becomes cancelled, unless it is kept.
void glint_scheduler_destroy(glint_scheduler **scheduler);

glint_status glint_scheduler_call(glint_scheduler *scheduler, struct glint_command *command);

#endif
