// checkpoint.h - films of jobs in the state folder, and the thread that writes them.
//
//   DIR/films/<job>.<number>       a film, whole: written beside, synced, renamed
//   DIR/films/<job>.<number>.new   one that is being written; removed at start
//   DIR/films/<job>.<number>.torn  one that could not be read back, for people to look at
//
// The number of the newest one is in the job's row, and that of the one before, which stays until
// the next is there: where the newest is torn the job goes on from it, or from nothing. A job that
// has ended gets a last film before its row says so; it is opened from there when its memory was
// needed. Nobody who renders waits for this thread.
//
// Threads: create to destroy by the table's owner; ended by the scheduler; the rest by any
// that may wait for a disk.
#ifndef GLINT_JOBS_CHECKPOINT_H
#define GLINT_JOBS_CHECKPOINT_H

#include "base/keeper.h"
#include "jobs/journal.h"

#define GLINT_CHECKPOINT_SECONDS 30.0

typedef struct glint_checkpoints glint_checkpoints;

// written: called by the thread after the last film of a job that has ended; must not wait.
glint_status glint_checkpoints_create(glint_checkpoints **out, glint_keeper *keeper,
                                      struct glint_job_table *table, void (*written)(void *user),
                                      void *user, struct glint_error *err);
glint_status glint_checkpoints_start(glint_checkpoints *checkpoints, struct glint_error *err);
// Ends the thread; while the scheduler runs, which it may wait for.
void glint_checkpoints_stop(glint_checkpoints *checkpoints);
// A last film of every job that has new samples. Once the scheduler has gone.
void glint_checkpoints_flush(glint_checkpoints *checkpoints);
void glint_checkpoints_destroy(glint_checkpoints **checkpoints);

glint_journal *glint_checkpoints_journal(glint_checkpoints *checkpoints);
void glint_checkpoints_set_seconds(glint_checkpoints *checkpoints, double seconds);
void glint_checkpoints_now(glint_checkpoints *checkpoints); // of every job

// The entry has just ended: never waits. Its `keeper` may be NULL.
void glint_checkpoint_ended(struct glint_entry *entry);

// The entry was changed by a PATCH: its row says so when this returns; where that fails its
// description does.
void glint_checkpoint_note(struct glint_entry *entry);

// Whether there is a film to go on from.
bool glint_checkpoint_exists(struct glint_entry *entry);

// Before the first slice of a new render: goes on from the newest film that can be read, if any. What
// cannot be is put aside, with a warning in the entry.
void glint_checkpoint_restore(struct glint_entry *entry, glint_render *render);

// The render of an entry, from its newest film; *out NULL: it has none.
glint_status glint_checkpoint_open(struct glint_entry *entry, glint_render **out,
                                   struct glint_error *err);

// Removes the films of a job whose row is gone.
void glint_checkpoint_remove(struct glint_entry *entry);

// Bytes of films over what they may take of the disk, 0: none. Until it is told otherwise that is
// half of what was free, or theirs, at the start.
uint64_t glint_checkpoints_excess(glint_checkpoints *checkpoints);
void glint_checkpoints_set_budget(glint_checkpoints *checkpoints, uint64_t bytes); // 0: that half

// Before the sweep: there are jobs that the table does not have, and their films are to stay.
void glint_checkpoints_spare(glint_checkpoints *checkpoints);
// Removes every file that no entry of the table has, but for those put aside.
void glint_checkpoints_sweep(glint_checkpoints *checkpoints);

// Whether the memory of an ended entry can be let go: it is on the disk. With the table's mutex.
bool glint_checkpoint_complete(const struct glint_entry *entry);

#endif
