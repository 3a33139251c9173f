// gk_matte_spill.h - what the pixels of a tile have beside their slots, together: a key that finds its
// pixel's slots full gets a place of the tile's, and keeps it. While there are places nothing is
// evicted and nothing is lost, so that mattes are exact; after that it is as under uss_direct_first.
//
// Each pixel's table ends with GK_MATTE_SPILL_WORDS words of the common places. A pixel searches its
// own and those of the GK_MATTE_SPILL_PIXELS - 1 pixels behind it, the first pixels being behind the
// last; up to the first that is empty, because none is ever emptied. A place packs
// key << 41 | direct << 40 | pixel << 32 | amount, of 32 bits: what is above goes to another place.
//
// GK_MATTE_CAS(address, expected, desired) returns what was there: atom_cmpxchg of 64 bits. Pixels
// that deposit at the same time share places.
#ifndef GK_MATTE_SPILL_H
#define GK_MATTE_SPILL_H

#include "kernels/gk_matte.h"

#ifdef GK_DEVICE
#pragma OPENCL EXTENSION cl_khr_int64_base_atomics : enable
#define GK_SHARED volatile __global
#define GK_MATTE_CAS(at, expected, desired) \
    atom_cmpxchg((volatile __global ulong *)(at), expected, desired)
#define GK_MATTE_READ(at) (*(at))
#else
#define GK_SHARED volatile
// Relaxed: what is found is tried by compare and swap.
#ifndef GK_MATTE_READ
#define GK_MATTE_READ(at) __atomic_load_n(at, __ATOMIC_RELAXED)
#endif
GK_INLINE gk_u64 gk_matte_cas(volatile gk_u64 *at, gk_u64 expected, gk_u64 desired)
{
    // Sequentially consistent: nothing else is read or written by what is found.
    __atomic_compare_exchange_n(at, &expected, desired, 0, __ATOMIC_SEQ_CST, __ATOMIC_SEQ_CST);
    return expected;
}
#ifndef GK_MATTE_CAS
#define GK_MATTE_CAS gk_matte_cas
#endif
#endif

#define GK_MATTE_SPILL_PIXELS 32u
#define GK_MATTE_SPILL_PLACES \
    (GK_MATTE_SPILL_PIXELS * GK_MATTE_SPILL_WORDS) // that a pixel can have
#define GK_MATTE_SPILL_TILE 256u                   // pixels; the index of one has 8 bits
#define GK_MATTE_SPILL_MOST ((gk_u64)0xffffffff)

// Index in the tables of a tile of place n that a pixel searches. words: of a pixel's table.
GK_INLINE gk_u32 gk_matte_spill_at(gk_u32 words, gk_u32 pixel, gk_u32 n)
{
    const gk_u32 of = (pixel + n / GK_MATTE_SPILL_WORDS) % GK_MATTE_SPILL_TILE;
    return (of + 1u) * words - GK_MATTE_SPILL_WORDS + n % GK_MATTE_SPILL_WORDS;
}

// Whether the place is that of the key in the pixel.
GK_INLINE gk_i32 gk_matte_spilled(gk_u64 place, gk_u32 pixel, gk_u32 key)
{
    return gk_matte_key(place) == key && ((gk_u32)(place >> 32) & 0xffu) == pixel;
}

// The slot that a place stands for.
GK_INLINE gk_u64 gk_matte_spill_slot(gk_u64 place)
{
    return (place & ~GK_MATTE_MAX_AMOUNT) | (place & GK_MATTE_SPILL_MOST);
}

// Puts what fits into a place, empty or of the key. Returns what does not.
GK_INLINE gk_u64 gk_matte_spill_add(GK_SHARED gk_u64 *at, gk_u32 pixel, gk_u32 key, gk_u32 direct,
                                    gk_u64 amount)
{
    gk_u64 was = GK_MATTE_READ(at);
    while (was == 0 || gk_matte_spilled(was, pixel, key)) {
        const gk_u64 held = was & GK_MATTE_SPILL_MOST, room = GK_MATTE_SPILL_MOST - held;
        const gk_u64 taken = amount < room ? amount : room;
        const gk_u64 now =
            gk_matte_pack(key, gk_matte_direct(was) | direct, (gk_u64)pixel << 32 | (held + taken));
        const gk_u64 found = GK_MATTE_CAS(at, was, now);
        if (found == was)
            return amount - taken;
        was = found;
    }
    return amount;
}

// Deposits in the places of a tile. tables: of its first pixel. Returns what finds none.
GK_INLINE gk_u64 gk_matte_spill(GK_SHARED gk_u64 *tables, gk_u32 words, gk_u32 pixel, gk_u32 key,
                                gk_u32 direct, gk_u64 amount)
{
    for (gk_u32 n = 0; n < GK_MATTE_SPILL_PLACES && amount > 0; n++)
        amount = gk_matte_spill_add(tables + gk_matte_spill_at(words, pixel, n), pixel, key, direct,
                                    amount);
    return amount;
}

// As gk_matte_deposit(), in the table of a pixel of a tile whose tables begin at `tables`.
GK_INLINE void gk_matte_deposit_tile(GK_GLOBAL gk_u64 *tables, gk_u32 pixel, gk_u32 slots,
                                     gk_u32 key, gk_u32 direct, gk_u64 amount, gk_u32 policy,
                                     gk_u32 random, struct gk_matte_lost *lost)
{
    const gk_u32 words = gk_matte_words(slots, policy);
    GK_GLOBAL gk_u64 *table = tables + pixel * words;
    if (amount == 0)
        return;
    const gk_u32 at = gk_matte_place(table, slots, key);
    if (at != GK_MATTE_NOWHERE) {
        gk_matte_lose(lost, key, gk_matte_add(&table[at], key, direct, amount));
        return;
    }
    if (policy == GK_MATTE_SPILL)
        amount = gk_matte_spill(tables, words, pixel, key, direct, amount);
    if (amount > 0)
        gk_matte_crowd(table, slots, key, direct, amount, policy, random, lost);
}

#endif
