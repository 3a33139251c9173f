// hold.h - who may still say what becomes of a slice that a worker runs.
//
// Before a worker takes it up, and while its paths are traced, nothing of a slice is in the film, so
// that whoever waits for no worker takes it away: the worker finds out when it comes to prepare or to
// write, and does not. Meanwhile it is waited for. One of the two wins, whatever comes first.
//
//   WAITING -> PREPARING -> TRACING -> WRITING
//   WAITING, TRACING -> REVOKED
//
// Thread-safety: take, begin and keep by the worker, revoke by whoever gave the slice out.
#ifndef GLINT_RENDER_HOLD_H
#define GLINT_RENDER_HOLD_H

#include <stdatomic.h>
#include <stdbool.h>

enum {
    GLINT_HOLD_WAITING,
    GLINT_HOLD_PREPARING,
    GLINT_HOLD_TRACING,
    GLINT_HOLD_WRITING,
    GLINT_HOLD_REVOKED
};

// NULL, here and below: nobody takes the slice away.
// Before the worker touches the film; false: it must not.
bool glint_hold_take(atomic_uint *hold);
// From now on the worker neither reads nor writes it.
void glint_hold_begin(atomic_uint *hold);
// Before the worker writes; false: it must not.
bool glint_hold_keep(atomic_uint *hold);
// Takes the slice away; false: the worker is at the film, or has been.
bool glint_hold_revoke(atomic_uint *hold);
bool glint_hold_is_revoked(atomic_uint *hold);

#endif
