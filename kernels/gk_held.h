// gk_held.h - the coverage that a path still holds, in its columns of the wave.
//
// Through glossy lobes (GK_GLOSSY_MATTES) it takes the spread of the path and the cone of its camera
// sample; through deltas alone neither.
#ifndef GK_HELD_H
#define GK_HELD_H

#include "kernels/gk_coverage.h"
#include "kernels/gk_frame.h"
#include "kernels/gk_matte.h"
#include "kernels/gk_wave.h"

#ifdef GK_THROUGH

struct gk_deposit {
    gk_u32 key; // GK_COL_WAITS, 0: none
    gk_u32 amount;
};

struct gk_transport {
    gk_u32 held;  // units
    gk_u32 waits; // slot key of the last vertex and GK_WAITS_*; 0: there was none
    gk_f32 carried;
    struct gk_spread spread;
    struct gk_cone cone;
    struct gk_deposit before, last; // of this vertex
    gk_u32 excess;
    gk_u32 met;  // matte of this vertex, 0: none
    gk_f32 over; // at a vertex: what the one before hands on over what is held, 1 at least
};

// Before the first vertex a path has neither spread nor a deposit that waits: its columns are not read.
GK_INLINE struct gk_transport gk_transport_load(const GK_GLOBAL gk_f32 *wave, gk_u32 stride,
                                                gk_u32 i)
{
    struct gk_transport t;
    t.held = GK_LOAD_U32(GK_COL_HELD, i);
    t.waits = GK_LOAD_U32(GK_COL_WAITS, i);
    const gk_i32 begun = t.waits != 0u;
    t.carried = begun ? GK_LOAD(GK_COL_CARRIED, i) : 0.0f;
    t.spread = gk_spread_none();
    t.spread.last = begun ? GK_LOAD(GK_COL_LAST, i) : 0.0f;
    t.cone.r = t.cone.g = 0.0f;
    t.cone.way = GK_LOAD(GK_COL_WAY, i);
#ifdef GK_GLOSSY_MATTES
    t.spread.s0 = begun ? GK_LOAD(GK_COL_SPREAD0, i) : 0.0f;
    t.spread.s1 = begun ? GK_LOAD(GK_COL_SPREAD1, i) : 0.0f;
    t.spread.s2 = begun ? GK_LOAD(GK_COL_SPREAD2, i) : 0.0f;
    t.spread.since = begun ? GK_LOAD(GK_COL_SINCE, i) : 0.0f;
    t.cone.r = GK_LOAD(GK_COL_RADIUS, i);
    t.cone.g = GK_LOAD(GK_COL_SLOPE, i);
#endif
    t.before.key = t.before.amount = t.last.key = t.last.amount = t.excess = t.met = 0u;
    t.over = 1.0f;
    return t;
}

GK_INLINE void gk_transport_store(GK_GLOBAL gk_f32 *wave, gk_u32 stride, gk_u32 i,
                                  const struct gk_transport *t)
{
    GK_STORE_U32(GK_COL_HELD, i, t->held);
    GK_STORE_U32(GK_COL_WAITS, i, t->waits);
    GK_STORE(GK_COL_CARRIED, i, t->carried);
    GK_STORE(GK_COL_LAST, i, t->spread.last);
    GK_STORE(GK_COL_WAY, i, t->cone.way);
#ifdef GK_GLOSSY_MATTES
    GK_STORE(GK_COL_SPREAD0, i, t->spread.s0);
    GK_STORE(GK_COL_SPREAD1, i, t->spread.s1);
    GK_STORE(GK_COL_SPREAD2, i, t->spread.s2);
    GK_STORE(GK_COL_SINCE, i, t->spread.since);
    GK_STORE(GK_COL_RADIUS, i, t->cone.r);
    GK_STORE(GK_COL_SLOPE, i, t->cone.g);
#endif
    GK_STORE_U32(GK_COL_DEPOSIT0, i, t->before.key);
    GK_STORE_U32(GK_COL_AMOUNT0, i, t->before.amount);
    GK_STORE_U32(GK_COL_DEPOSIT1, i, t->last.key);
    GK_STORE_U32(GK_COL_AMOUNT1, i, t->last.amount);
    GK_STORE_U32(GK_COL_EXCESS, i, t->excess);
#ifdef GK_PATH_LIST
    GK_STORE_U32(GK_COL_MET, i, t->met);
#endif
}

// Of a camera ray.
GK_INLINE void gk_transport_begin(GK_GLOBAL gk_f32 *wave, gk_u32 stride, gk_u32 i,
                                  const GK_GLOBAL struct gk_frame *frame)
{
    GK_STORE_U32(GK_COL_HELD, i, GK_MATTE_ONE);
    GK_STORE_U32(GK_COL_WAITS, i, 0u);
    GK_STORE(GK_COL_WAY, i, 0.0f);
#ifdef GK_GLOSSY_MATTES
    GK_STORE(GK_COL_RADIUS, i, frame->matte_radius);
    GK_STORE(GK_COL_SLOPE, i, frame->matte_slope);
#else
    (void)frame;
#endif
}

#endif

#endif
