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
#define GK_MATTE_CLASS_SHIFT 19u // a key is an index of the scene's mattes and, above it, a class:
#define GK_MATTE_BASE_KEY 0x7ffffu // 0 what is seen directly, 1.. what bounces have brought
#define GK_MATTE_MAX_AMOUNT ((gk_u64)0xffffffffff) // GLINT_MAX_SAMPLES whole samples, less one unit
#define GK_MATTE_ONE 65536u                        // a whole sample
// Behind the slots of a table: units that found none, of what is seen directly and of the others.
#define GK_MATTE_LOST_PRIMARY 0u
#define GK_MATTE_LOST_BOUNCED 1u
#define GK_MATTE_LOST_WORDS 2u

// What a full table does with a key it does not hold. Class 0 is never called after another nor given
// what is another's: it takes the least slot of the classes above, and where there is none it is
// lost. Of the others:
#define GK_MATTE_EXACT 0u        // none comes: there is a slot for every key of the scene
#define GK_MATTE_DROP 1u         // the newcomer is lost
#define GK_MATTE_DIRECT_FIRST 2u // a direct one replaces the least that is not
// The newcomer joins the least slot, which is called after him by the odds of his part: unbiased
// space saving, Ting 2018. Nothing is lost and every matte is right on average.
#define GK_MATTE_USS 3u
// A direct one takes the least that is not, whose amount joins the next such. Without such, and where
// they are not direct, newcomers join the least of their like; with none of these they are lost.
#define GK_MATTE_USS_DIRECT_FIRST 4u
// The pixels of a tile share places beside their slots, gk_matte_spill.h; when these are taken, as
// before.
#define GK_MATTE_SPILL 5u
#define GK_MATTE_SPILL_WORDS 10u // that a pixel brings

// Words of a pixel's table.
GK_INLINE gk_u32 gk_matte_words(gk_u32 slots, gk_u32 policy)
{
    return slots + GK_MATTE_LOST_WORDS + (policy == GK_MATTE_SPILL ? GK_MATTE_SPILL_WORDS : 0u);
}

GK_INLINE gk_u32 gk_matte_key(gk_u64 slot)
{
    return (gk_u32)(slot >> 41);
}

GK_INLINE gk_u32 gk_matte_of_class(gk_u32 matte, gk_u32 class_of_it)
{
    return matte | class_of_it << GK_MATTE_CLASS_SHIFT;
}

GK_INLINE gk_u32 gk_matte_class(gk_u32 key)
{
    return key >> GK_MATTE_CLASS_SHIFT;
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

// floor(random (amount) / 2^32) without overflow, for amounts up to 2^41.
GK_INLINE gk_u64 gk_matte_scaled(gk_u32 random, gk_u64 amount)
{
    return (gk_u64)random * (amount >> 32) + (((gk_u64)random * (amount & 0xffffffffu)) >> 32);
}

// The newcomer joins the slot, and it is called after him with the probability of his part.
GK_INLINE gk_u64 gk_matte_join(GK_GLOBAL gk_u64 *slot, gk_u32 key, gk_u32 direct, gk_u64 amount,
                               gk_u32 random)
{
    const gk_i32 wins = gk_matte_scaled(random, gk_matte_amount(*slot) + amount) < amount;
    *slot = wins ? gk_matte_pack(key, direct, gk_matte_amount(*slot)) : *slot;
    return gk_matte_add(slot, gk_matte_key(*slot), 0u, amount);
}

#define GK_MATTE_NOWHERE 0xffffffffu

// What a search of the whole table has found.
struct gk_matte_search {
    gk_u32 found; // slot of the key, or an empty one; GK_MATTE_NOWHERE: the table is full
    gk_u32 indirect, direct; // least slots of classes above 0, GK_MATTE_NOWHERE: none
};

GK_INLINE gk_i32 gk_matte_primary(gk_u32 key)
{
    return key <= GK_MATTE_BASE_KEY;
}

GK_INLINE struct gk_matte_search gk_matte_find(const GK_GLOBAL gk_u64 *table, gk_u32 slots,
                                               gk_u32 key)
{
    struct gk_matte_search s = {GK_MATTE_NOWHERE, GK_MATTE_NOWHERE, GK_MATTE_NOWHERE};
    gk_u64 indirect = GK_MATTE_MAX_AMOUNT + 1u, direct = GK_MATTE_MAX_AMOUNT + 1u;
    gk_u32 at = gk_matte_start(key, slots);
    for (gk_u32 k = 0; k < slots && s.found == GK_MATTE_NOWHERE; k++) {
        const gk_u32 held = gk_matte_key(table[at]);
        const gk_u64 amount = gk_matte_amount(table[at]);
        const gk_i32 seen = gk_matte_direct(table[at]) != 0u;
        const gk_i32 less_indirect = !gk_matte_primary(held) && !seen && amount < indirect;
        const gk_i32 less_direct = !gk_matte_primary(held) && seen && amount < direct;
        s.found = held == key || held == 0u ? at : s.found;
        s.indirect = less_indirect ? at : s.indirect;
        indirect = less_indirect ? amount : indirect;
        s.direct = less_direct ? at : s.direct;
        direct = less_direct ? amount : direct;
        at = at + 1u == slots ? 0u : at + 1u;
    }
    return s;
}

// The slot of a key, or an empty one for it; GK_MATTE_NOWHERE: the table is full.
GK_INLINE gk_u32 gk_matte_place(const GK_GLOBAL gk_u64 *table, gk_u32 slots, gk_u32 key)
{
    gk_u32 at = gk_matte_start(key, slots);
    for (gk_u32 k = 0; k < slots; k++) {
        const gk_u32 held = gk_matte_key(table[at]);
        if (held == key || held == 0u)
            return at;
        at = at + 1u == slots ? 0u : at + 1u;
    }
    return GK_MATTE_NOWHERE;
}

// The smaller of two slots, of which either may be GK_MATTE_NOWHERE.
GK_INLINE gk_u32 gk_matte_lesser(const GK_GLOBAL gk_u64 *table, gk_u32 a, gk_u32 b)
{
    if (a == GK_MATTE_NOWHERE || b == GK_MATTE_NOWHERE)
        return a == GK_MATTE_NOWHERE ? b : a;
    return gk_matte_amount(table[b]) < gk_matte_amount(table[a]) ? b : a;
}

// The slot that a newcomer takes from its key, GK_MATTE_NOWHERE: none.
GK_INLINE gk_u32 gk_matte_victim(const struct gk_matte_search *s, gk_u32 key, gk_u32 direct,
                                 gk_u32 policy)
{
    const gk_i32 first = policy == GK_MATTE_DIRECT_FIRST || policy >= GK_MATTE_USS_DIRECT_FIRST;
    if (gk_matte_primary(key))
        return s->indirect != GK_MATTE_NOWHERE ? s->indirect : s->direct;
    return direct && first ? s->indirect : GK_MATTE_NOWHERE;
}

// The slot that a key without one joins, GK_MATTE_NOWHERE: none.
GK_INLINE gk_u32 gk_matte_like(const GK_GLOBAL gk_u64 *table, const struct gk_matte_search *s,
                               gk_u32 key, gk_u32 direct, gk_u32 policy)
{
    if (gk_matte_primary(key) || policy <= GK_MATTE_DIRECT_FIRST)
        return GK_MATTE_NOWHERE;
    if (policy == GK_MATTE_USS)
        return gk_matte_lesser(table, s->indirect, s->direct);
    return direct ? s->direct : s->indirect;
}

// Units that found no slot, of class 0 and of those above.
struct gk_matte_lost {
    gk_u64 primary, bounced;
};

GK_INLINE void gk_matte_lose(struct gk_matte_lost *lost, gk_u32 key, gk_u64 amount)
{
    const gk_i32 primary = gk_matte_primary(key);
    lost->primary += primary ? amount : 0u;
    lost->bounced += primary ? 0u : amount;
}

// A full table takes a key that it does not hold.
GK_INLINE void gk_matte_crowd(GK_GLOBAL gk_u64 *table, gk_u32 slots, gk_u32 key, gk_u32 direct,
                              gk_u64 amount, gk_u32 policy, gk_u32 random,
                              struct gk_matte_lost *lost)
{
    struct gk_matte_search s = gk_matte_find(table, slots, key);
    const gk_u32 victim = gk_matte_victim(&s, key, direct, policy);
    if (victim != GK_MATTE_NOWHERE) { // then it is the one without a place
        const gk_u64 before = table[victim];
        table[victim] = 0;
        gk_matte_lose(lost, key, gk_matte_add(&table[victim], key, direct, amount));
        key = gk_matte_key(before);
        direct = gk_matte_direct(before);
        amount = gk_matte_amount(before);
        s = gk_matte_find(table, slots, key);
    }
    const gk_u32 like = gk_matte_like(table, &s, key, direct, policy);
    if (like != GK_MATTE_NOWHERE)
        amount = gk_matte_join(&table[like], key, direct, amount, random);
    gk_matte_lose(lost, key, amount);
}

// Deposits `amount` units of `key` (1..GK_MATTE_MAX_KEY; direct: 0 or 1) in the table of `slots`
// slots, at least 1. random: any 32 bits, new for each deposit. Adds to *lost what finds no slot.
GK_INLINE void gk_matte_deposit(GK_GLOBAL gk_u64 *table, gk_u32 slots, gk_u32 key, gk_u32 direct,
                                gk_u64 amount, gk_u32 policy, gk_u32 random,
                                struct gk_matte_lost *lost)
{
    if (amount == 0)
        return;
    const gk_u32 at = gk_matte_place(table, slots, key);
    if (at != GK_MATTE_NOWHERE)
        gk_matte_lose(lost, key, gk_matte_add(&table[at], key, direct, amount));
    else
        gk_matte_crowd(table, slots, key, direct, amount, policy, random, lost);
}

// Units of a sample weight in [0, 1], rounded to nearest; negative and NaN give 0, more than 1 a
// whole sample.
GK_INLINE gk_u32 gk_matte_units(gk_f32 weight)
{
    const gk_f32 clamped = gk_select(0.0f, gk_select(1.0f, weight, weight < 1.0f), weight > 0.0f);
    return (gk_u32)(gk_i32)(clamped * 65536.0f + 0.5f);
}

#endif
