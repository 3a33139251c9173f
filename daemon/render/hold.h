// hold.h - who may still say what becomes of a slice that a worker runs.
//
// While its paths are traced nothing of a slice is in the film, so that whoever waits for no worker
// takes it away: the worker finds out when it comes to write, and writes nothing. Once it writes it
// is waited for. One of the two wins, whatever comes first.
//
//   WAITING -> TRACING -> WRITING
//                      -> REVOKED
//
// Thread-safety: begin and keep by the worker, revoke by whoever gave the slice out.
#ifndef GLINT_RENDER_HOLD_H
#define GLINT_RENDER_HOLD_H

#include <stdatomic.h>
#include <stdbool.h>

enum { GLINT_HOLD_WAITING, GLINT_HOLD_TRACING, GLINT_HOLD_WRITING, GLINT_HOLD_REVOKED };

// From now on the worker neither reads nor writes the film. NULL: nobody takes the slice away.
void glint_hold_begin(atomic_uint *hold);
// Before the worker writes; false: it must not.
bool glint_hold_keep(atomic_uint *hold);
// Takes the slice away; false: it has not begun to trace, or writes already.
bool glint_hold_revoke(atomic_uint *hold);
bool glint_hold_is_revoked(atomic_uint *hold);

#endif
