// gk_vertex.h - one vertex of a path: the surface that was hit, the medium before it, the solids
// around it, and how the path may go on from there.
#ifndef GK_VERTEX_H
#define GK_VERTEX_H

#include "kernels/gk_camera.h"
#include "kernels/gk_light.h"
#include "kernels/gk_medium.h"
#include "kernels/gk_solid.h"
#include "kernels/gk_surface.h"
#include "kernels/gk_wave.h"

struct gk_path {
    struct gk_vec o, d, beta;
    gk_f32 t, pdf;
    gk_f32 time; // 0..1 of the shutter, 0 where nothing moves
    gk_u32 lane, depth;
};

GK_INLINE struct gk_path gk_path_load(const GK_GLOBAL gk_f32 *wave, gk_u32 stride, gk_u32 i)
{
    struct gk_path p;
    p.o = gk_vec(GK_LOAD(GK_COL_OX, i), GK_LOAD(GK_COL_OY, i), GK_LOAD(GK_COL_OZ, i));
    p.d = gk_vec(GK_LOAD(GK_COL_DX, i), GK_LOAD(GK_COL_DY, i), GK_LOAD(GK_COL_DZ, i));
    p.beta =
        gk_vec(GK_LOAD(GK_COL_BETA_R, i), GK_LOAD(GK_COL_BETA_G, i), GK_LOAD(GK_COL_BETA_B, i));
    p.t = GK_LOAD(GK_COL_T, i);
    p.pdf = GK_LOAD(GK_COL_PDF, i);
#ifdef GK_MOTION
    p.time = GK_LOAD(GK_COL_TIME, i);
#else
    p.time = 0.0f;
#endif
    p.lane = GK_LOAD_U32(GK_COL_LANE, i);
    p.depth = GK_LOAD_U32(GK_COL_DEPTH, i);
    return p;
}

GK_INLINE struct gk_raw_hit gk_raw_hit_load(const GK_GLOBAL gk_f32 *wave, gk_u32 stride, gk_u32 i)
{
    struct gk_raw_hit h;
    h.primitive = GK_LOAD_U32(GK_COL_PRIMITIVE, i);
    h.geometry = GK_LOAD_U32(GK_COL_GEOMETRY, i);
    h.instance = GK_LOAD_U32(GK_COL_INSTANCE, i);
    h.u = GK_LOAD(GK_COL_U, i);
    h.v = GK_LOAD(GK_COL_V, i);
    h.ng = gk_vec(GK_LOAD(GK_COL_NX, i), GK_LOAD(GK_COL_NY, i), GK_LOAD(GK_COL_NZ, i));
    return h;
}

// What one item knows of its path vertex.
struct gk_vertex {
    struct gk_path path;
    struct gk_hit hit;
    struct gk_surface surface;
    struct gk_onb onb;         // around the shading normal
    struct gk_vec wo;          // on the shading normal's frame
    struct gk_vec front, back; // origins lifted off the surface, on the side of wo and beyond
    struct gk_vec p;           // where the path turns: on the surface, or in the medium
    struct gk_lane lane;
    gk_u32 order; // in which the numbers for light and direction are taken
    gk_i32 missed;
    gk_i32 in_medium;    // meets the medium before the surface
    gk_i32 passes;       // the surface is none to this path: it goes straight on
    gk_i32 scatters;     // meets something and has a bounce left
    gk_i32 fails;        // cannot be followed: a rejected sample
    gk_u32 here, there;  // 1 + material of the solid before the surface and beyond, 0: open space
    gk_u32 solid_beyond; // GK_COL_SOLID beyond the surface
    struct gk_nested nested, nested_beyond;
};

// Whether a solid without priority is entered or left where the path crosses the surface.
GK_INLINE gk_u32 gk_solid_beyond(const struct gk_resident *scene, const struct gk_hit *hit)
{
    const gk_u32 rank = GK_MATERIAL(scene, hit->material, interior);
    return hit->cos_g <= 0.0f && rank == 0u ? hit->material + 1u : 0u;
}

// The solids around the surface, and whether it is an interface at all.
GK_INLINE void gk_vertex_solids(const GK_GLOBAL gk_f32 *wave, gk_u32 stride, gk_u32 i,
                                const struct gk_resident *scene, struct gk_vertex *x)
{
    x->passes = 0;
    x->fails = 0;
    x->here = x->there = x->solid_beyond = 0u;
#ifdef GK_SOLIDS
    x->here = GK_LOAD_U32(GK_COL_SOLID, i);
    x->there = x->solid_beyond = gk_solid_beyond(scene, &x->hit);
#endif
#ifdef GK_NESTED
    const gk_u32 rank = GK_MATERIAL(scene, x->hit.material, interior);
    const gk_i32 known = rank > 0u && !x->missed;
    x->nested.a = GK_LOAD_U32(GK_COL_NESTED0, i);
    x->nested.b = GK_LOAD_U32(GK_COL_NESTED1, i);
    x->nested.c = GK_LOAD_U32(GK_COL_NESTED2, i);
    x->nested.d = GK_LOAD_U32(GK_COL_NESTED3, i);
    const struct gk_crossing crossing =
        gk_nested_cross(scene, x->nested, rank, x->hit.cos_g <= 0.0f);
    const gk_u32 top = gk_nested_top(x->nested), beyond = gk_nested_top(crossing.after);
    x->nested_beyond.a = known ? crossing.after.a : x->nested.a;
    x->nested_beyond.b = known ? crossing.after.b : x->nested.b;
    x->nested_beyond.c = known ? crossing.after.c : x->nested.c;
    x->nested_beyond.d = known ? crossing.after.d : x->nested.d;
    x->hit.eta = known ? crossing.eta : 0.0f;
    x->passes = known && crossing.nothing;
    x->fails = known && crossing.overflowing;
    const gk_u32 of_top = gk_rank_material(scene, top) + 1u;
    const gk_u32 of_beyond = gk_rank_material(scene, beyond) + 1u;
    x->here = top > 0u ? of_top : x->here;
    x->there = known && beyond > 0u ? of_beyond : x->there;
#else
    (void)wave;
    (void)stride;
    (void)i;
    (void)scene;
#endif
#ifdef GK_CULL
    const gk_u32 flags = GK_MATERIAL(scene, x->hit.material, flags);
    x->passes = x->passes || (x->path.depth == 0u && !x->missed && x->hit.cos_g > 0.0f &&
                              (flags & GK_MATERIAL_CULLED) != 0u);
#endif
}

// What is left of the path's light at its next turn, and where that is.
GK_INLINE void gk_vertex_reach(const GK_GLOBAL struct gk_frame *frame,
                               const struct gk_resident *scene, struct gk_vertex *x)
{
    x->in_medium = 0;
#ifdef GK_MEDIUM
    gk_f32 u, reserved;
    gk_sample_2d(x->lane.base, x->lane.index, GK_PAIR_BOUNCE(x->path.depth, GK_PAIR_MEDIUM), &u,
                 &reserved);
    const gk_f32 length = x->missed ? GK_INFINITY : x->path.t;
    const gk_f32 t =
        gk_medium_distance(frame, gk_medium_span(frame, x->path.o, x->path.d, length), u);
    x->in_medium = x->here == 0u && t < GK_INFINITY;
    x->passes = x->passes && !x->in_medium;
    x->p =
        gk_vec_select(x->p, gk_along(x->path.o, x->path.d, x->in_medium ? t : 0.0f), x->in_medium);
    const struct gk_vec albedo =
        gk_vec(frame->medium_albedo[0], frame->medium_albedo[1], frame->medium_albedo[2]);
    x->path.beta = gk_vec_select(x->path.beta, gk_mul(x->path.beta, albedo), x->in_medium);
#else
    (void)frame;
#endif
#ifdef GK_SOLIDS
    const struct gk_vec left =
        gk_solid_transmittance(scene, x->here, x->missed ? GK_INFINITY : x->path.t);
    x->path.beta = gk_mul(x->path.beta, left);
#else
    (void)scene;
#endif
}

// What is left of light over a way that begins at the vertex, on the far side of it or not.
GK_INLINE struct gk_vec gk_way_transmittance(const GK_GLOBAL struct gk_frame *frame,
                                             const struct gk_resident *scene,
                                             const struct gk_vertex *x, gk_i32 far_side,
                                             struct gk_vec o, struct gk_vec d, gk_f32 length)
{
    struct gk_vec left = gk_splat(1.0f);
#ifdef GK_SOLIDS
    const gk_u32 solid = far_side ? x->there : x->here;
    left = gk_solid_transmittance(scene, solid, length);
#else
    const gk_u32 solid = 0u;
    (void)scene;
    (void)x;
    (void)far_side;
#endif
#ifdef GK_MEDIUM
    const gk_f32 clear = gk_medium_transmittance(frame, o, d, length);
    left = gk_scale(left, solid == 0u ? clear : 1.0f);
#else
    (void)frame;
    (void)solid;
    (void)o;
    (void)d;
    (void)length;
#endif
    return left;
}

// How the vertex scatters light that it sends to, or receives from, the world direction wi.
GK_INLINE struct gk_bsdf_value gk_vertex_eval(const GK_GLOBAL struct gk_frame *frame,
                                              const struct gk_vertex *x, struct gk_vec wi,
                                              struct gk_vec wi_local)
{
    struct gk_bsdf_value value = gk_bsdf_eval(&x->surface, x->wo, wi_local);
#ifdef GK_MEDIUM
    const gk_f32 phase = gk_phase_eval(frame->medium_g, x->path.d, wi);
    value.f = gk_vec_select(value.f, gk_splat(phase), x->in_medium);
    value.pdf = x->in_medium ? phase : value.pdf;
#else
    (void)frame;
    (void)wi;
#endif
    return value;
}

GK_INLINE struct gk_vertex gk_vertex_load(const GK_GLOBAL gk_f32 *wave, gk_u32 stride, gk_u32 i,
                                          const GK_GLOBAL struct gk_frame *frame,
                                          const GK_GLOBAL struct gk_wave_rect *rect,
                                          const struct gk_resident *scene)
{
    struct gk_vertex x;
    x.path = gk_path_load(wave, stride, i);
    struct gk_raw_hit raw = gk_raw_hit_load(wave, stride, i);
    x.missed = raw.geometry == GK_NONE;
#ifdef GK_MOTION
    const gk_f32 at = x.path.time * (gk_f32)(gk_i32)frame->motion_segments;
    const gk_i32 last = gk_max_i32((gk_i32)frame->motion_segments - 1, 0);
    raw.key = (gk_u32)gk_min_i32((gk_i32)at, last);
    raw.w = at - (gk_f32)(gk_i32)raw.key;
#else
    raw.key = 0u;
    raw.w = 0.0f;
#endif
    // A miss shades the first triangle of the scene and throws the result away: no divergence.
    raw.geometry = x.missed ? 0u : raw.geometry;
    raw.instance = x.missed ? GK_NONE : raw.instance;
    raw.primitive = x.missed ? 0u : raw.primitive;
#ifdef GK_MEDIUM
    // A way to nothing that ends in the medium has its light chosen as if by a surface: not by what
    // the row held before.
    raw.u = x.missed ? 0.0f : raw.u;
    raw.v = x.missed ? 0.0f : raw.v;
    raw.ng = gk_vec_select(raw.ng, gk_negate(x.path.d), x.missed);
#endif
    x.lane = gk_lane_at(rect, x.path.lane, frame->seed);
    x.order =
        gk_sample_order(x.lane.base, x.lane.index, GK_PAIR_BOUNCE(x.path.depth, GK_PAIR_ORDER));
    x.hit = gk_hit_decode(scene, raw, x.path.d);
    gk_vertex_solids(wave, stride, i, scene, &x);
    x.onb = gk_onb_make(x.hit.ns);
    x.wo = gk_to_local(x.onb, gk_negate(x.path.d));
    x.wo.z = gk_max(x.wo.z, 1e-6f);
    x.surface = gk_hit_surface(scene, &x.hit, x.onb, x.wo);
    x.p = gk_along(x.path.o, x.path.d, x.path.t);
    const gk_f32 lift = gk_point_error(x.p, x.path.t);
    x.front = gk_along(x.p, x.hit.ng, lift);
    x.back = gk_along(x.p, x.hit.ng, -lift);
    gk_vertex_reach(frame, scene, &x);
    const gk_i32 turns = !x.missed || x.in_medium;
    x.scatters = turns & (x.path.depth < frame->max_bounces);
    return x;
}

// How a path goes on.
struct gk_next {
    struct gk_vec o, d;
    struct gk_vec weight; // of the scattering, before roulette
    gk_f32 pdf;           // -1: no light sample could have found what it finds
    gk_i32 crosses;       // goes on beyond the surface
    gk_i32 possible;
};

GK_INLINE struct gk_next gk_next_make(const GK_GLOBAL struct gk_frame *frame,
                                      const struct gk_vertex *x, gk_f32 u_lobe)
{
    gk_f32 u, v;
    gk_sample_ordered(x->lane.base, x->order, GK_PAIR_BOUNCE(x->path.depth, GK_PAIR_BSDF), &u, &v);
    const struct gk_bsdf_sample s = gk_bsdf_sample(&x->surface, x->wo, u_lobe, u, v);
    const struct gk_bsdf_value value = gk_bsdf_eval(&x->surface, x->wo, s.wi);
    const gk_f32 inverse = value.pdf > 1e-30f ? 1.0f / value.pdf : 0.0f;
    struct gk_next next;
    next.weight = gk_vec_select(gk_scale(value.f, inverse), s.weight, s.delta);
    next.d = gk_normalise(gk_to_world(x->onb, s.wi));
    const gk_f32 side = gk_dot(next.d, x->hit.ng);
    next.o = gk_vec_select(x->back, x->front, side > 0.0f);
    next.pdf = s.delta ? -1.0f : value.pdf;
    next.crosses = side <= 0.0f;
    next.possible = side * s.wi.z > 0.0f;
#ifdef GK_MEDIUM
    const struct gk_vec d = gk_phase_sample(frame->medium_g, x->path.d, u, v);
    const gk_f32 phase = gk_phase_eval(frame->medium_g, x->path.d, d);
    next.weight = gk_vec_select(next.weight, gk_splat(1.0f), x->in_medium);
    next.d = gk_vec_select(next.d, d, x->in_medium);
    next.o = gk_vec_select(next.o, x->p, x->in_medium);
    next.pdf = x->in_medium ? (phase > 0.0f ? phase : -1.0f) : next.pdf;
    next.crosses = next.crosses && !x->in_medium;
    next.possible = next.possible || x->in_medium;
#else
    (void)frame;
#endif
    return next;
}

// Radiance grows by the square of the index where light enters a solid, and shrinks where it leaves:
// undone, what is left of a path is the share of the light that takes it, in a solid and beyond it.
GK_INLINE gk_f32 gk_next_share(const struct gk_vertex *x, const struct gk_next *next)
{
#ifdef GK_TRANSMISSION
    const gk_i32 scaled = next->crosses && !x->passes && !x->surface.thin;
    return scaled ? x->surface.eta * x->surface.eta : 1.0f;
#else
    (void)x;
    (void)next;
    return 1.0f;
#endif
}

// A surface that is none: the ray starts again behind it. No light sample reached beyond it.
GK_INLINE struct gk_next gk_next_straight(const struct gk_vertex *x, struct gk_next next)
{
    next.weight = gk_vec_select(next.weight, gk_splat(1.0f), x->passes);
    next.d = gk_vec_select(next.d, x->path.d, x->passes);
    next.o = gk_vec_select(next.o, x->back, x->passes);
    next.pdf = x->passes ? -1.0f : next.pdf;
    next.crosses = next.crosses || x->passes;
    next.possible = next.possible || x->passes;
    return next;
}

// What the path carries on beyond its ray.
GK_INLINE void gk_store_carried(GK_GLOBAL gk_f32 *wave, gk_u32 stride, gk_u32 i,
                                const struct gk_vertex *x, const struct gk_next *next)
{
#ifdef GK_SOLIDS
    const gk_u32 solid = GK_LOAD_U32(GK_COL_SOLID, i);
    GK_STORE_U32(GK_COL_SOLID, i, next->crosses && !x->passes ? x->solid_beyond : solid);
#endif
#ifdef GK_NESTED
    GK_STORE_U32(GK_COL_NESTED0, i, next->crosses ? x->nested_beyond.a : x->nested.a);
    GK_STORE_U32(GK_COL_NESTED1, i, next->crosses ? x->nested_beyond.b : x->nested.b);
    GK_STORE_U32(GK_COL_NESTED2, i, next->crosses ? x->nested_beyond.c : x->nested.c);
    GK_STORE_U32(GK_COL_NESTED3, i, next->crosses ? x->nested_beyond.d : x->nested.d);
#endif
#ifdef GK_BLEND
    gk_u32 key, reserved;
    gk_sample_2d_bits(x->lane.base, x->lane.index,
                      GK_PAIR_BOUNCE(x->path.depth + 1u, GK_PAIR_ALPHA), &key, &reserved);
    GK_STORE_U32(GK_COL_PASSAGE, i, x->passes ? GK_LOAD_U32(GK_COL_PASSAGE, i) : key);
#endif
    (void)wave;
    (void)stride;
    (void)i;
    (void)x;
    (void)next;
}

#endif
