// turn.h - whose turn it is: the policy, without threads.
//
// A higher priority goes first. Of one priority, clients share alike by worker seconds, however many
// jobs each has; then the jobs of a client share what it gets. The one that has had least goes
// next, slices that are out counted at what its slices cost of late.
//
// Who comes among its equals starts where the least served of them stands. Who comes back keeps at
// most two slices of debt or credit: turns that were taken alone were taken from nobody, and a time
// away earns nothing.
//
// Thread-safety: the scheduler's, as the fields that it reads and writes.
#ifndef GLINT_JOBS_TURN_H
#define GLINT_JOBS_TURN_H

#include "jobs/table.h"

#define GLINT_MAX_FILMS 8 // that render side by side, unless told otherwise

// The jobs of one client at one priority that have not ended.
struct glint_account {
    struct glint_account *next;
    char *client;
    int32_t priority;
    uint32_t entries;
    double turn;    // worker seconds on the scale on which the clients of a priority take turns
    double pending; // of slices out, and
    uint32_t films; // films: counted anew where they are needed
};

// Puts the entry into the account of its client at `priority`, and out of the one it was in. False
// without memory: nothing has changed.
bool glint_turn_enter(struct glint_account **accounts, struct glint_entry *entry, int32_t priority);
// Out of its account, if it is in one. The last to leave frees it.
void glint_turn_leave(struct glint_account **accounts, struct glint_entry *entry);

// Has a film and wants slices: does not idle, and is not about to move.
bool glint_turn_wants(const struct glint_entry *entry);

// Who gets the next slice: of those that want one and are not dry. NULL: nobody.
struct glint_entry *glint_turn_next(struct glint_entry *const *entry, size_t count);

// To be called when `entry` begins to want slices, and when its priority has changed.
void glint_turn_join(struct glint_entry *const *entry, size_t count, struct glint_entry *joining);

// Counts a slice that took `seconds` of a worker.
void glint_turn_charge(struct glint_entry *entry, double seconds);

// Whose film is made next, NULL: nobody's. The client with the fewest goes first. Films are memory,
// so that only `films` jobs that matter as much as the next have one, and one more for each client
// that has none; and nobody passes one that waits for memory, so that a large film gets its turn
// among small ones.
struct glint_entry *glint_turn_prepare(struct glint_entry *const *entry, size_t count,
                                       uint32_t films);

// Who moves next: the live job that should for longest, NULL: nobody.
struct glint_entry *glint_turn_move(struct glint_entry *const *entry, size_t count);

#endif
