// gk_matte_shared.h - the slot table of a pixel under many work-items at a time.
//
// Source: Yoshimura, Tokuyoshi, Harada 2022, doi:10.2312/sr.20221162, Algorithm 1, repaired: after a
// lost race the same slot is looked at again, and a lost eviction begins the search anew. Every slot
// changes as one word, so that kept + lost = total at any moment; what a newcomer evicts is in
// nobody's slot until it is in another. Two that bring one key to a full table at the same time may
// each evict for it: readers add up the slots of a key.
#ifndef GK_MATTE_SHARED_H
#define GK_MATTE_SHARED_H

#include "kernels/gk_matte_spill.h"

// Adds to a word that others add to.
GK_INLINE void gk_matte_count(GK_SHARED gk_u64 *at, gk_u64 units)
{
    gk_u64 was = GK_MATTE_READ(at), found;
    while (units > 0u && (found = GK_MATTE_CAS(at, was, was + units)) != was)
        was = found;
}

// Who looks for a place.
struct gk_matte_guest {
    gk_u32 key, direct;
    gk_u64 amount;
};

// The slot with the guest in it as well. *over: what does not fit.
GK_INLINE gk_u64 gk_matte_with(gk_u64 slot, const struct gk_matte_guest *g, gk_u32 key,
                               gk_u32 direct, gk_u64 *over)
{
    const gk_u64 room = GK_MATTE_MAX_AMOUNT - gk_matte_amount(slot);
    const gk_u64 taken = g->amount < room ? g->amount : room;
    *over = g->amount - taken;
    return gk_matte_pack(key, direct, gk_matte_amount(slot) + taken);
}

// What a search saw: slots and their contents at that moment.
struct gk_matte_seen {
    gk_u32 indirect, direct;
    gk_u64 indirect_slot, direct_slot;
};

// Puts the guest into his slot or an empty one. False: there is none; then *seen is filled.
GK_INLINE gk_i32 gk_matte_settle(GK_SHARED gk_u64 *table, gk_u32 slots,
                                 const struct gk_matte_guest *g, struct gk_matte_seen *seen,
                                 struct gk_matte_lost *lost)
{
    gk_u64 over;
    gk_u32 at = gk_matte_start(g->key, slots);
    seen->indirect = seen->direct = GK_MATTE_NOWHERE;
    seen->indirect_slot = seen->direct_slot = 0;
    for (gk_u32 k = 0; k < slots; k++) {
        gk_u64 slot = GK_MATTE_READ(&table[at]);
        while (gk_matte_key(slot) == g->key || slot == 0) {
            const gk_u64 full =
                gk_matte_with(slot, g, g->key, gk_matte_direct(slot) | g->direct, &over);
            const gk_u64 found = GK_MATTE_CAS(&table[at], slot, full);
            if (found == slot) {
                gk_matte_lose(lost, g->key, over);
                return 1;
            }
            slot = found;
        }
        const gk_i32 seen_first = gk_matte_direct(slot) != 0u;
        const gk_i32 primary = gk_matte_primary(gk_matte_key(slot));
        const gk_u64 amount = gk_matte_amount(slot);
        if (!primary && !seen_first &&
            (seen->indirect == GK_MATTE_NOWHERE || amount < gk_matte_amount(seen->indirect_slot))) {
            seen->indirect = at;
            seen->indirect_slot = slot;
        }
        if (!primary && seen_first &&
            (seen->direct == GK_MATTE_NOWHERE || amount < gk_matte_amount(seen->direct_slot))) {
            seen->direct = at;
            seen->direct_slot = slot;
        }
        at = at + 1u == slots ? 0u : at + 1u;
    }
    return 0;
}

// As gk_matte_victim() and gk_matte_like(), of what was seen.
GK_INLINE gk_u32 gk_matte_seen_victim(const struct gk_matte_seen *s, const struct gk_matte_guest *g,
                                      gk_u32 policy)
{
    const struct gk_matte_search search = {GK_MATTE_NOWHERE, s->indirect, s->direct};
    return gk_matte_victim(&search, g->key, g->direct, policy);
}

GK_INLINE gk_u32 gk_matte_seen_like(const struct gk_matte_seen *s, const struct gk_matte_guest *g,
                                    gk_u32 policy)
{
    if (gk_matte_primary(g->key) || policy <= GK_MATTE_DIRECT_FIRST)
        return GK_MATTE_NOWHERE;
    const gk_i32 both = s->indirect != GK_MATTE_NOWHERE && s->direct != GK_MATTE_NOWHERE;
    const gk_i32 less = gk_matte_amount(s->direct_slot) < gk_matte_amount(s->indirect_slot);
    const gk_u32 lesser = both ? (less ? s->direct : s->indirect)
                               : (s->direct != GK_MATTE_NOWHERE ? s->direct : s->indirect);
    return policy == GK_MATTE_USS ? lesser : (g->direct ? s->direct : s->indirect);
}

// As gk_matte_deposit_tile(), for many at a time on one table.
GK_INLINE void gk_matte_deposit_shared(GK_SHARED gk_u64 *tables, gk_u32 pixel, gk_u32 slots,
                                       gk_u32 key, gk_u32 direct, gk_u64 amount, gk_u32 policy,
                                       gk_u32 random, struct gk_matte_lost *lost)
{
    const gk_u32 words = gk_matte_words(slots, policy);
    GK_SHARED gk_u64 *table = tables + pixel * words;
    struct gk_matte_guest g = {key, direct, amount};
    gk_i32 may_evict = 1; // who was evicted does not evict
    gk_u64 over = 0;
    while (g.amount > 0) {
        struct gk_matte_seen s;
        if (gk_matte_settle(table, slots, &g, &s, lost))
            return;
        if (policy == GK_MATTE_SPILL && may_evict)
            g.amount = gk_matte_spill(tables, words, pixel, g.key, g.direct, g.amount);
        if (g.amount == 0)
            return;
        const gk_u32 victim = may_evict ? gk_matte_seen_victim(&s, &g, policy) : GK_MATTE_NOWHERE;
        const gk_u32 like = gk_matte_seen_like(&s, &g, policy);
        const gk_u32 at = victim != GK_MATTE_NOWHERE ? victim : like;
        if (at == GK_MATTE_NOWHERE) {
            gk_matte_lose(lost, g.key, g.amount);
            return;
        }
        const gk_u64 slot = at == s.indirect ? s.indirect_slot : s.direct_slot;
        if (victim != GK_MATTE_NOWHERE) {
            if (GK_MATTE_CAS(&table[at], slot, gk_matte_with(0, &g, g.key, g.direct, &over)) !=
                slot)
                continue;
            gk_matte_lose(lost, g.key, over);
            g.key = gk_matte_key(slot);
            g.direct = gk_matte_direct(slot);
            g.amount = gk_matte_amount(slot);
            may_evict = 0;
            continue;
        }
        const gk_i32 wins = gk_matte_scaled(random, gk_matte_amount(slot) + g.amount) < g.amount;
        const gk_u64 joined = gk_matte_with(slot, &g, wins ? g.key : gk_matte_key(slot),
                                            wins ? g.direct : gk_matte_direct(slot), &over);
        if (GK_MATTE_CAS(&table[at], slot, joined) == slot) {
            gk_matte_lose(lost, g.key, over);
            return;
        }
    }
}

#endif
