// coverage.cl - the matte keys of a wave's samples go into the slot tables of their pixels.
//
// One item per pixel of one tile, all its samples in order: a pixel has one owner, so no atomics.
// Runs of equal keys are merged before the table is touched.
#include "kernels/gk_matte_spill.h"
#include "kernels/gk_transport.h"
#include "kernels/gk_wave.h"
#ifdef GK_SHARED_TABLES
#include "kernels/gk_matte_shared.h"
#endif

// The table of one pixel while deposits come in.
struct gk_pixel_table {
    __global gk_u64 *tables; // of its tile
    gk_u32 pixel, slots, policy, salt;
    gk_u32 waits; // GK_COL_WAITS of the run under way
    gk_u64 amount;
    struct gk_matte_lost lost;
};

GK_INLINE struct gk_pixel_table gk_pixel_table_at(__global gk_u64 *tables, gk_u32 pixel,
                                                  gk_u32 slots, gk_u32 policy, gk_u32 salt)
{
    const struct gk_pixel_table t = {tables, pixel, slots, policy, salt, 0u, 0, {0, 0}};
    return t;
}

GK_INLINE void gk_pixel_flush(struct gk_pixel_table *t)
{
    t->salt = gk_mix32(t->salt + 1u);
    gk_matte_deposit_tile(t->tables, t->pixel, t->slots, t->waits & GK_WAITS_KEY, t->waits >> 31,
                          t->amount, t->policy, t->salt, &t->lost);
    t->amount = 0;
}

GK_INLINE void gk_pixel_deposit(struct gk_pixel_table *t, gk_u32 waits, gk_u32 amount)
{
    const gk_u32 taken = waits ? amount : 0u;
    if ((taken > 0u) & (waits != t->waits)) { // one branch: either alone is a toss-up
        gk_pixel_flush(t);
        t->waits = waits;
    }
    t->amount += taken;
}

GK_INLINE void gk_table_lose(__global gk_u64 *table, gk_u32 slots, const struct gk_matte_lost *lost)
{
    if ((lost->primary | lost->bounced) == 0u)
        return;
    table[slots + GK_MATTE_LOST_PRIMARY] += lost->primary;
    table[slots + GK_MATTE_LOST_BOUNCED] += lost->bounced;
}

GK_INLINE void gk_pixel_finish(struct gk_pixel_table *t)
{
    gk_pixel_flush(t);
    gk_table_lose(t->tables + t->pixel * gk_matte_words(t->slots, t->policy), t->slots, &t->lost);
}

// waits: GK_COL_WAITS, not 0; amount: > 0.
GK_INLINE void gk_path_deposit(__global gk_u64 *tables, gk_u32 pixel, gk_u32 slots, gk_u32 waits,
                               gk_u32 amount, gk_u32 policy, gk_u32 salt)
{
    struct gk_matte_lost lost = {0, 0};
    gk_matte_deposit_tile(tables, pixel, slots, waits & GK_WAITS_KEY, waits >> 31, amount, policy,
                          gk_mix32(salt), &lost);
    gk_table_lose(tables + pixel * gk_matte_words(slots, policy), slots, &lost);
}

// tables: [256][gk_matte_words()], from `offset` slots on. lane: of the tile's first pixel;
// step: lanes from one sample of a pixel to the next. salt: new for each launch on a tile.
__kernel void deposit_coverage(const __global float *restrict wave, const gk_u32 stride,
                               const gk_u32 n, const gk_u32 lane, const gk_u32 step,
                               const gk_u32 samples, __global gk_u64 *restrict tables,
                               const gk_u32 offset, const gk_u32 slots, const gk_u32 policy,
                               const gk_u32 salt)
{
    const gk_u32 i = (gk_u32)get_global_id(0);
    if (i >= n)
        return;
    struct gk_pixel_table t =
        gk_pixel_table_at(tables + offset, i, slots, policy, gk_mix32(salt ^ i));
    for (gk_u32 s = 0; s < samples; s++)
        gk_pixel_deposit(&t, GK_LOAD_U32(GK_COL_KEY, lane + i + s * step) | GK_WAITS_DIRECT,
                         GK_MATTE_ONE);
    gk_pixel_finish(&t);
}

#ifdef GK_THROUGH
// Camera rays have met something, been shaded and go on: what they hold from here.
__kernel void carry_first(__global float *restrict wave, const gk_u32 stride,
                          const __global struct gk_frame *restrict frame)
{
    const gk_u32 i = (gk_u32)get_global_id(0);
    const struct gk_passing p = gk_passing_load(wave, stride, i);
    struct gk_transport t = gk_transport_begin(frame);
    gk_transport_arrive(&t, frame, &p);
    gk_transport_leave(&t, frame, &p);
    gk_transport_store(wave, stride, i, &t, 1);
}

// The same of later vertices, of the first n paths.
__kernel void carry_coverage(__global float *restrict wave, const gk_u32 stride,
                             const __global struct gk_frame *restrict frame)
{
    const gk_u32 i = (gk_u32)get_global_id(0);
    const struct gk_passing p = gk_passing_load(wave, stride, i);
    struct gk_transport t = gk_transport_load(wave, stride, i);
    gk_transport_arrive(&t, frame, &p);
    gk_transport_leave(&t, frame, &p);
    gk_transport_store(wave, stride, i, &t, 0);
}

// What the first vertices of a whole wave, just shaded, have left for the mattes: lanes are in their
// places, arguments as above.
__kernel void deposit_first(const __global float *restrict wave, const gk_u32 stride,
                            const gk_u32 n, const gk_u32 lane, const gk_u32 step,
                            const gk_u32 samples, __global gk_u64 *restrict tables,
                            const gk_u32 offset, const gk_u32 slots, const gk_u32 policy,
                            const gk_u32 salt)
{
    const gk_u32 i = (gk_u32)get_global_id(0);
    if (i >= n)
        return;
    struct gk_pixel_table t =
        gk_pixel_table_at(tables + offset, i, slots, policy, gk_mix32(salt ^ i));
    for (gk_u32 s = 0; s < samples; s++) {
        const gk_u32 at = lane + i + s * step;
#ifdef GK_OPAQUE_FULL
        gk_pixel_deposit(&t, GK_LOAD_U32(GK_COL_DEPOSIT0, at), GK_LOAD_U32(GK_COL_AMOUNT0, at));
#endif
        gk_pixel_deposit(&t, GK_LOAD_U32(GK_COL_DEPOSIT1, at), GK_LOAD_U32(GK_COL_AMOUNT1, at));
    }
    gk_pixel_finish(&t);
}

#ifdef GK_SHARED_TABLES
GK_INLINE void gk_path_share(__global gk_u64 *tables, gk_u32 pixel, gk_u32 slots, gk_u32 waits,
                             gk_u32 amount, gk_u32 policy, gk_u32 salt)
{
    struct gk_matte_lost lost = {0, 0};
    __global gk_u64 *table = tables + pixel * gk_matte_words(slots, policy);
    if (waits == 0u || amount == 0u)
        return;
    gk_matte_deposit_shared(tables, pixel, slots, waits & GK_WAITS_KEY, waits >> 31, amount, policy,
                            gk_mix32(salt), &lost);
    gk_matte_count(table + slots + GK_MATTE_LOST_PRIMARY, lost.primary);
    gk_matte_count(table + slots + GK_MATTE_LOST_BOUNCED, lost.bounced);
}

// As below, an item for each path: several of them share a pixel.
__kernel void deposit_carried(const __global float *restrict wave, const gk_u32 stride,
                              const gk_u32 n, const gk_u32 pixels, __global gk_u64 *tables,
                              const gk_u32 slots, const gk_u32 policy, const gk_u32 salt)
{
    const gk_u32 i = (gk_u32)get_global_id(0);
    if (i >= n)
        return;
    const gk_u32 lane = GK_LOAD_U32(GK_COL_LANE, i);
    const gk_u32 pixel = lane & 255u, tile = (lane & (pixels - 1u)) - pixel;
    __global gk_u64 *of_tile = tables + tile * gk_matte_words(slots, policy);
    gk_path_share(of_tile, pixel, slots, GK_LOAD_U32(GK_COL_DEPOSIT0, i),
                  GK_LOAD_U32(GK_COL_AMOUNT0, i), policy, salt ^ 2u * lane);
    gk_path_share(of_tile, pixel, slots, GK_LOAD_U32(GK_COL_DEPOSIT1, i),
                  GK_LOAD_U32(GK_COL_AMOUNT1, i), policy, salt ^ (2u * lane + 1u));
}
#else
// Deposits of some paths, without those of nothing: whether there is one is a toss-up, which is not
// left to the processor to guess.
#define GK_BATCH 32u
struct gk_batch {
    gk_u32 count, lane[2u * GK_BATCH], waits[2u * GK_BATCH], amount[2u * GK_BATCH];
};

GK_INLINE void gk_batch_put(struct gk_batch *b, gk_u32 lane, gk_u32 waits, gk_u32 amount)
{
    b->lane[b->count] = lane;
    b->waits[b->count] = waits;
    b->amount[b->count] = amount;
    b->count += (waits != 0u) & (amount != 0u);
}

// Of later vertices: those of the first n paths, one item in all, because any of them may share a
// pixel. tables: [pixels][gk_matte_words()]; pixels: of the block, a power of two. salt:
// new for each launch on a block.
__kernel void deposit_carried(const __global float *restrict wave, const gk_u32 stride,
                              const gk_u32 n, const gk_u32 pixels, __global gk_u64 *restrict tables,
                              const gk_u32 slots, const gk_u32 policy, const gk_u32 salt)
{
    struct gk_batch b;
    if (get_global_id(0) > 0)
        return;
    for (gk_u32 first = 0; first < n; first += GK_BATCH) {
        const gk_u32 end = first + GK_BATCH < n ? first + GK_BATCH : n;
        b.count = 0u;
        for (gk_u32 i = first; i < end; i++) {
            const gk_u32 lane = 2u * GK_LOAD_U32(GK_COL_LANE, i);
            gk_batch_put(&b, lane, GK_LOAD_U32(GK_COL_DEPOSIT0, i), GK_LOAD_U32(GK_COL_AMOUNT0, i));
            gk_batch_put(&b, lane + 1u, GK_LOAD_U32(GK_COL_DEPOSIT1, i),
                         GK_LOAD_U32(GK_COL_AMOUNT1, i));
        }
        for (gk_u32 k = 0; k < b.count; k++) {
            const gk_u32 lane = b.lane[k] >> 1;
            const gk_u32 pixel = lane & 255u, tile = (lane & (pixels - 1u)) - pixel;
            gk_path_deposit(tables + tile * gk_matte_words(slots, policy), pixel, slots, b.waits[k],
                            b.amount[k], policy, salt ^ b.lane[k]);
        }
    }
}
#endif
#endif

#ifdef GK_PATH_LIST
// Eq. 8 with a list of all that a path has met: what it meets again takes nothing more. Of the first n
// paths; list: by lane, [rows][stride], what follows the last entry is 0; rows: more than a path has
// vertices, by 1.
__kernel void forget_repeated(__global float *restrict wave, const gk_u32 stride, const gk_u32 n,
                              __global gk_u32 *restrict list, const gk_u32 rows)
{
    const gk_u32 i = (gk_u32)get_global_id(0);
    const gk_u32 met = i < n ? GK_LOAD_U32(GK_COL_MET, i) : 0u;
    if (met == 0u)
        return;
    __global gk_u32 *entry = list + GK_LOAD_U32(GK_COL_LANE, i);
    for (gk_u32 k = 2u; k < rows && *entry != 0u && *entry != met; k++)
        entry += stride;
    if (*entry == met) {
        GK_STORE_U32(GK_COL_DEPOSIT0, i, 0u);
    } else {
        *entry = met;
        entry[stride] = 0u;
    }
}
#endif
