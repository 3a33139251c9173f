#include "render/hold.h"

// Acquire and release: what was done to the tiles by the one who lets go is seen by the next.
static bool change(atomic_uint *hold, unsigned from, unsigned to)
{
    return atomic_compare_exchange_strong_explicit(hold, &from, to, memory_order_acq_rel,
                                                   memory_order_acquire);
}

bool glint_hold_take(atomic_uint *hold)
{
    return !hold || change(hold, GLINT_HOLD_WAITING, GLINT_HOLD_PREPARING);
}

void glint_hold_begin(atomic_uint *hold)
{
    if (hold)
        change(hold, GLINT_HOLD_PREPARING, GLINT_HOLD_TRACING);
}

bool glint_hold_keep(atomic_uint *hold)
{
    return !hold || change(hold, GLINT_HOLD_TRACING, GLINT_HOLD_WRITING);
}

bool glint_hold_revoke(atomic_uint *hold)
{
    return hold && (change(hold, GLINT_HOLD_WAITING, GLINT_HOLD_REVOKED) ||
                    change(hold, GLINT_HOLD_TRACING, GLINT_HOLD_REVOKED));
}

bool glint_hold_is_revoked(atomic_uint *hold)
{
    return hold && atomic_load_explicit(hold, memory_order_acquire) == GLINT_HOLD_REVOKED;
}
