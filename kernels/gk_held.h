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
    gk_u32 met;   // matte of this vertex, 0: none
    gk_f32 going; // at a vertex: units that the one before hands on, `held` or more
};

// Of a camera ray, on its way to what it meets first.
GK_INLINE struct gk_transport gk_transport_begin(const GK_GLOBAL struct gk_frame *frame)
{
    struct gk_transport t;
    t.held = GK_MATTE_ONE;
    t.waits = 0u;
    t.carried = t.going = 0.0f;
    t.spread = gk_spread_none();
    t.cone.r = frame->matte_radius;
    t.cone.g = frame->matte_slope;
    t.cone.way = 0.0f;
    t.before.key = t.before.amount = t.last.key = t.last.amount = t.excess = t.met = 0u;
    return t;
}

// Before the second vertex a path has no spread, and before the first no deposit that waits: these
// columns are not read.
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
    const gk_i32 bounced = begun && (t.waits & GK_WAITS_FIRST) == 0u;
    t.spread.s0 = bounced ? GK_LOAD(GK_COL_SPREAD0, i) : 0.0f;
    t.spread.s1 = bounced ? GK_LOAD(GK_COL_SPREAD1, i) : 0.0f;
    t.spread.s2 = bounced ? GK_LOAD(GK_COL_SPREAD2, i) : 0.0f;
    t.spread.since = begun ? GK_LOAD(GK_COL_SINCE, i) : 0.0f;
    t.cone.r = GK_LOAD(GK_COL_RADIUS, i);
    t.cone.g = GK_LOAD(GK_COL_SLOPE, i);
#endif
    t.before.key = t.before.amount = t.last.key = t.last.amount = t.excess = t.met = 0u;
    t.going = 0.0f;
    return t;
}

// first: of the vertex that a camera ray has met: what it has none of is not written.
GK_INLINE void gk_transport_store(GK_GLOBAL gk_f32 *wave, gk_u32 stride, gk_u32 i,
                                  const struct gk_transport *t, gk_i32 first)
{
    GK_STORE_U32(GK_COL_HELD, i, t->held);
    GK_STORE_U32(GK_COL_WAITS, i, t->waits);
    GK_STORE(GK_COL_CARRIED, i, t->carried);
    GK_STORE(GK_COL_LAST, i, t->spread.last);
    GK_STORE(GK_COL_WAY, i, t->cone.way);
#ifdef GK_GLOSSY_MATTES
    GK_STORE(GK_COL_SINCE, i, t->spread.since);
    GK_STORE(GK_COL_RADIUS, i, t->cone.r);
    GK_STORE(GK_COL_SLOPE, i, t->cone.g);
    if (!first) {
        GK_STORE(GK_COL_SPREAD0, i, t->spread.s0);
        GK_STORE(GK_COL_SPREAD1, i, t->spread.s1);
        GK_STORE(GK_COL_SPREAD2, i, t->spread.s2);
    }
#endif
    GK_STORE_U32(GK_COL_DEPOSIT0, i, t->before.key);
    GK_STORE_U32(GK_COL_AMOUNT0, i, t->before.amount);
    GK_STORE_U32(GK_COL_DEPOSIT1, i, t->last.key);
    GK_STORE_U32(GK_COL_AMOUNT1, i, t->last.amount);
    if (!first)
        GK_STORE_U32(GK_COL_EXCESS, i, t->excess);
#ifdef GK_PATH_LIST
    GK_STORE_U32(GK_COL_MET, i, t->met);
#endif
}

#endif

#endif
