// turn.h - whose turn it is: the policy, without threads.
//
// A higher priority goes first. Equals share by worker seconds: the one that has had least goes
// next, slices that are out counted at what its slices cost of late. A job that comes (back) among
// its equals starts where the least served of them stands, neither in debt nor in credit.
//
// Thread-safety: the scheduler's, as the fields that it reads and writes.
#ifndef GLINT_JOBS_TURN_H
#define GLINT_JOBS_TURN_H

#include "jobs/table.h"

#define GLINT_MAX_FILMS 8 // jobs of one priority or higher that render side by side

// Has a film and wants slices: does not idle, and is not about to move.
bool glint_turn_wants(const struct glint_entry *entry);

// Who gets the next slice: of those that want one and are not dry. NULL: nobody.
struct glint_entry *glint_turn_next(struct glint_entry *const *entry, size_t count);

// To be called when `entry` begins to want slices, and when its priority has changed.
void glint_turn_join(struct glint_entry *const *entry, size_t count, struct glint_entry *joining);

// Counts a slice that took `seconds` of a worker.
void glint_turn_charge(struct glint_entry *entry, double seconds);

// Whose film is made next, NULL: nobody's. Films are memory, so that only GLINT_MAX_FILMS jobs that
// matter as much as the next have one; and nobody passes one that waits
// for memory, so that a large film gets its turn among small ones.
struct glint_entry *glint_turn_prepare(struct glint_entry *const *entry, size_t count);

// Who moves next: the live job that should for longest, NULL: nobody.
struct glint_entry *glint_turn_move(struct glint_entry *const *entry, size_t count);

#endif
