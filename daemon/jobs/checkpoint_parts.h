// checkpoint_parts.h - the inside of the checkpoints, shared by the files that write, read and sweep.
//
// Everything in an entry's `kept` is read and written with the table's mutex.
#ifndef GLINT_JOBS_CHECKPOINT_PARTS_H
#define GLINT_JOBS_CHECKPOINT_PARTS_H

#include "base/metrics.h"
#include "jobs/checkpoint.h"
#include "jobs/checkpoint_file.h"

#include <pthread.h>
#include <stdatomic.h>

struct glint_checkpoints {
    glint_journal *journal;
    const char *folder;
    struct glint_job_table *table;
    void (*written)(void *user);
    void *user;
    glint_metric *total, *failures, *seconds_each, *written_bytes, *state_bytes;
    _Atomic uint64_t bytes; // of all films
    _Atomic uint64_t share,
        budget; // that they may have: at most half of the disk, or what was said
    pthread_t thread;
    bool started;
    bool unread; // rows that could not be: whose films there are besides, nobody knows

    pthread_mutex_t mutex; // guards what follows; a leaf
    pthread_cond_t changed;
    double seconds; // between films of a job
    bool ended;     // some entry has
    bool now;       // all are wanted
    bool stop;
};

// Exchanges a sentence that the entry's description shows, NULL: takes it back. Whether there was
// one before.
bool glint_checkpoints_say(struct glint_checkpoints *checkpoints, char **at, const char *format,
                           ...) __attribute__((format(printf, 3, 4)));

struct glint_checkpoint_file glint_checkpoints_file(const struct glint_checkpoints *checkpoints,
                                                    const struct glint_entry *entry,
                                                    uint64_t number);

// The entries of the table, each retained; free() the array. NULL: no memory, *count is 0.
struct glint_entry **glint_checkpoints_hold(struct glint_checkpoints *checkpoints, size_t *count);

#endif
