// gk_matte.h - the slot table of one pixel: which matte keys cover it, and by how much.
//
// A slot packs key << 41 | direct << 40 | amount. Amounts are sums of sample weights in units of
// 2^-16, 40 bits: exact, and the same in any order while nothing is evicted. Key 0 is the empty
// slot. Every unit deposited is either in a slot or reported as lost, so kept + lost = total.
//
// Source: Yoshimura, Tokuyoshi, Harada 2022, doi:10.2312/sr.20221162, Algorithm 1, with its control
// flow repaired: the printed loop loses contributions and evicts the wrong slot. This is the
// owner's form: one work-item at a time touches a pixel, so plain loads and stores do.
#ifndef GK_MATTE_H
#define GK_MATTE_H

#include "kernels/gk_sampler.h"

#define GK_MATTE_MAX_KEY 0x7fffffu
#define GK_MATTE_MAX_AMOUNT ((gk_u64)0xffffffffff) // GLINT_MAX_SAMPLES whole samples, less one unit
#define GK_MATTE_ONE 65536u                        // a whole sample

// What a full table does with a key it does not hold.
#define GK_MATTE_DROP 0u         // the newcomer is lost
#define GK_MATTE_DIRECT_FIRST 1u // a directly visible one replaces the smallest that is not

GK_INLINE gk_u32 gk_matte_key(gk_u64 slot)
{
    return (gk_u32)(slot >> 41);
}

GK_INLINE gk_u32 gk_matte_direct(gk_u64 slot)
{
    return (gk_u32)(slot >> 40) & 1u;
}

GK_INLINE gk_u64 gk_matte_amount(gk_u64 slot)
{
    return slot & GK_MATTE_MAX_AMOUNT;
}

GK_INLINE gk_u64 gk_matte_pack(gk_u32 key, gk_u32 direct, gk_u64 amount)
{
    return (gk_u64)key << 41 | (gk_u64)direct << 40 | amount;
}

// Where the search for a key starts, 0..slots-1.
GK_INLINE gk_u32 gk_matte_start(gk_u32 key, gk_u32 slots)
{
    return (gk_u32)(((gk_u64)gk_mix32(key) * slots) >> 32);
}

// Adds `amount` to what `*slot` holds, saturating. Returns what does not fit.
GK_INLINE gk_u64 gk_matte_add(GK_GLOBAL gk_u64 *slot, gk_u32 key, gk_u32 direct, gk_u64 amount)
{
    const gk_u64 held = gk_matte_amount(*slot);
    const gk_u64 room = GK_MATTE_MAX_AMOUNT - held;
    const gk_u64 taken = gk_select(room, amount, amount < room);
    *slot = gk_matte_pack(key, gk_matte_direct(*slot) | direct, held + taken);
    return amount - taken;
}

// Deposits `amount` units of `key` (1..GK_MATTE_MAX_KEY; direct: 0 or 1) in the table of `slots`
// slots, 1..64. Returns the units lost: its own, or those of the slot it took.
GK_INLINE gk_u64 gk_matte_deposit(GK_GLOBAL gk_u64 *table, gk_u32 slots, gk_u32 key, gk_u32 direct,
                                  gk_u64 amount, gk_u32 policy)
{
    gk_u32 victim = slots;
    gk_u64 least = GK_MATTE_MAX_AMOUNT + 1u;
    gk_u32 at = gk_matte_start(key, slots);
    if (amount == 0)
        return 0;
    for (gk_u32 k = 0; k < slots; k++) {
        const gk_u64 slot = table[at];
        const gk_u32 held = gk_matte_key(slot);
        if (held == key || held == 0)
            return gk_matte_add(&table[at], key, direct, amount);
        if (!gk_matte_direct(slot) && gk_matte_amount(slot) < least) {
            victim = at;
            least = gk_matte_amount(slot);
        }
        at = at + 1 == slots ? 0 : at + 1;
    }
    if (!direct || policy != GK_MATTE_DIRECT_FIRST || victim == slots)
        return amount;
    table[victim] = 0;
    return least + gk_matte_add(&table[victim], key, direct, amount);
}

// Units of a sample weight in [0, 1], rounded to nearest; negative and NaN give 0, more than 1 a
// whole sample.
GK_INLINE gk_u32 gk_matte_units(gk_f32 weight)
{
    const gk_f32 clamped = gk_select(0.0f, gk_select(1.0f, weight, weight < 1.0f), weight > 0.0f);
    return (gk_u32)(gk_i32)(clamped * 65536.0f + 0.5f);
}

#endif
