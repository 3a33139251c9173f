// gk_light.h - next-event estimation: choosing a light, a point on it, and the pdf of both.
//
// One alias table holds all emitters but the environment image; a first random number splits
// between the two. Everything is straight-line: kinds are told apart by selects.
#ifndef GK_LIGHT_H
#define GK_LIGHT_H

#include "kernels/gk_environment.h"
#include "kernels/gk_frame.h"
#include "kernels/gk_sampler.h"
#include "kernels/gk_scene.h"
#include "kernels/gk_vec.h"

struct gk_light_sample {
    struct gk_vec wi; // unit, towards the light
    gk_f32 distance;  // to it, +inf for sun and environment; <= 0: nothing to be had
    struct gk_vec L;  // radiance; of a delta light: its L over the probability, pdf is then 1
    gk_f32 pdf;       // 1/sr, choice included
    gk_i32 delta;     // no BSDF sample can hit it
    gk_u32 triangle, material; // of a textured emitter, and where on it:
    gk_f32 u, v;               // barycentrics of its second and third vertex
};

// Power heuristic for a sample taken with pdf a where the other technique has pdf b (Veach 1997,
// Eq. 9.13 with beta = 2), formed from the ratio so that neither square overflows.
GK_INLINE gk_f32 gk_mis_weight(gk_f32 a, gk_f32 b)
{
    const gk_f32 r = b / a;
    return 1.0f / (1.0f + r * r);
}

// Bound on the error of a point computed as o + t d: 16 ulp of the coordinates and of t, in metres.
GK_INLINE gk_f32 gk_point_error(struct gk_vec p, gk_f32 t)
{
    return (gk_abs(p.x) + gk_abs(p.y) + gk_abs(p.z) + t) * 1.9073486e-6f;
}

#define GK_LIGHT(lights, index, member) GK_READ(lights, gk_light, index, member)

// Probability with which the table takes a light, one of `count`.
GK_INLINE gk_f32 gk_light_choice(const GK_GLOBAL struct gk_light *lights, gk_u32 index,
                                 gk_u32 count)
{
#ifdef GK_LIGHTS_UNIFORM
    (void)lights;
    (void)index;
    return 1.0f / (gk_f32)(gk_i32)count;
#else
    (void)count;
    return GK_READ_ALONE(lights, gk_light, index, choice);
#endif
}

// Between which motion keys of the light table a path's time lies.
struct gk_light_keys {
    gk_u32 from, to; // entries to add to a light's index
    gk_f32 w;        // of `to`
};

GK_INLINE struct gk_light_keys gk_light_keys_at(const GK_GLOBAL struct gk_frame *f, gk_f32 time)
{
    struct gk_light_keys k = {0u, 0u, 0.0f};
#ifdef GK_MOTION
    const gk_f32 at = time * (gk_f32)(gk_i32)f->motion_segments;
    const gk_i32 last = gk_max_i32((gk_i32)f->motion_segments - 1, 0);
    const gk_i32 segment = gk_min_i32((gk_i32)at, last);
    k.from = (gk_u32)segment * f->light_stride;
    k.to = k.from + f->light_stride;
    k.w = at - (gk_f32)segment;
#else
    (void)f;
    (void)time;
#endif
    return k;
}

struct gk_light_place {
    struct gk_vec p, a, b; // of gk_light
};

GK_INLINE struct gk_light_place gk_light_place_read(const GK_GLOBAL struct gk_light *lights,
                                                    gk_u32 i)
{
    struct gk_light_place l;
    l.p = GK_TRIPLE(GK_LIGHT, lights, i, p, 0);
    l.a = GK_TRIPLE(GK_LIGHT, lights, i, a, 0);
    l.b = GK_TRIPLE(GK_LIGHT, lights, i, b, 0);
    return l;
}

GK_INLINE struct gk_light_place gk_light_place_at(const GK_GLOBAL struct gk_light *lights,
                                                  gk_u32 index, struct gk_light_keys k)
{
    struct gk_light_place l = gk_light_place_read(lights, index + k.from);
#ifdef GK_MOTION
    const struct gk_light_place to = gk_light_place_read(lights, index + k.to);
    const gk_i32 moves = k.to != k.from;
    const gk_u32 kind = GK_LIGHT(lights, index, kind) & GK_LIGHT_KIND;
    l.p = gk_along(l.p, gk_sub(to.p, l.p), k.w);
    l.a = gk_along(l.a, gk_sub(to.a, l.a), k.w);
    l.b = gk_along(l.b, gk_sub(to.b, l.b), k.w);
    // Directions stay unit: that of a sun, the axis of a spot.
    l.p = gk_vec_select(l.p, gk_normalise(l.p), moves && kind == GK_LIGHT_SUN);
    l.a = gk_vec_select(l.a, gk_normalise(l.a), moves && kind == GK_LIGHT_POINT);
#endif
    return l;
}

// Solid-angle pdf with which NEE would have taken the point on triangle light `index` that a ray
// of length t hit under the cosine `cosine` (absolute); choice: probability of choosing it at all.
GK_INLINE gk_f32 gk_triangle_light_pdf(const GK_GLOBAL struct gk_light *lights, gk_u32 index,
                                       struct gk_light_keys keys, gk_f32 t, gk_f32 cosine,
                                       gk_f32 choice)
{
    const struct gk_light_place place = gk_light_place_at(lights, index, keys);
    const struct gk_vec n = gk_cross(place.a, place.b);
    const gk_f32 area = 0.5f * gk_sqrt(gk_dot(n, n));
    return choice * t * t / (gk_max(cosine, 1e-7f) * area);
}

// A pair of uniform numbers that is used up choice by choice: what remains of it is uniform again,
// so that one well-stratified pair takes a light and a point on it.
struct gk_light_pair {
    gk_u32 u; // fraction of 2^32
    gk_f32 v;
    gk_f32 fine; // bits below the last of v and, after a choice, of u
};

// u, v: multiples of 2^-24 in [0, 1).
GK_INLINE void gk_light_pair_make(struct gk_light_pair *r, gk_f32 u, gk_f32 v)
{
    const gk_u32 more = gk_mix32(gk_as_u32(u) ^ gk_mix32(gk_as_u32(v)));
    r->u = ((gk_u32)(gk_i32)(u * 16777216.0f) << 8) | (more & 0xffu);
    r->v = v;
    r->fine = gk_unit_float(more);
}

// One of n slots by u; u: its place in that slot, from there on.
GK_INLINE gk_u32 gk_light_pair_slot(struct gk_light_pair *r, gk_u32 n)
{
    const gk_u32 low = r->u * n;
    const gk_u32 filled = low + (gk_u32)(gk_i32)(r->fine * (gk_f32)(gk_i32)n);
    const gk_u32 slot = gk_mul_high(r->u, n) + (filled < low ? 1u : 0u);
    r->u = filled;
    return slot;
}

// Whether v is below `keep`, a whole number of 2^-24; v: its place on that side, from there on.
GK_INLINE gk_i32 gk_light_pair_below(struct gk_light_pair *r, gk_f32 keep)
{
    const gk_i32 below = r->v < keep;
    const gk_f32 from = below ? 0.0f : keep, width = below ? keep : 1.0f - keep;
    const gk_f32 step = (r->v - from) * 16777216.0f + r->fine;
    r->v = gk_min(step / gk_max(width * 16777216.0f, 1.0f), 1.0f - GK_UNIT);
    return below;
}

GK_INLINE gk_u32 gk_alias_choose(const GK_GLOBAL struct gk_alias *table, gk_u32 n,
                                 struct gk_light_pair *r, struct gk_cut cut)
{
    const gk_u32 i = gk_light_pair_slot(r, n);
    GK_CUT(cut, i);
#ifdef GK_LIGHTS_UNIFORM
    (void)table;
    return i;
#else
    const gk_f32 keep = GK_READ(table, gk_alias, i, keep);
    const gk_u32 other = GK_READ(table, gk_alias, i, other);
    const gk_u32 chosen = gk_light_pair_below(r, keep) ? i : other;
    GK_CUT(cut, chosen);
    return chosen;
#endif
}

// Where the unit square's (u, v) lies on a triangle, uniformly, by folding it (Heitz 2019).
GK_INLINE void gk_light_point(gk_f32 u, gk_f32 v, gk_f32 *s, gk_f32 *t)
{
    const gk_i32 upper = v > u;
    *s = upper ? u * 0.5f : u - v * 0.5f;
    *t = upper ? v - u * 0.5f : v * 0.5f;
}

// Light `index` of the table as seen from p, chosen with probability `choice`.
GK_INLINE struct gk_light_sample gk_light_from_table(const GK_GLOBAL struct gk_light *lights,
                                                     gk_u32 index, struct gk_light_keys keys,
                                                     struct gk_vec p, gk_f32 choice, gk_f32 u,
                                                     gk_f32 v)
{
    struct gk_light_sample s;
    const struct gk_light_place place = gk_light_place_at(lights, index, keys);
    const struct gk_vec position = place.p, a = place.a, b = place.b;
    const gk_u32 flags = GK_LIGHT(lights, index, kind), kind = flags & GK_LIGHT_KIND;
    s.L = GK_TRIPLE(GK_LIGHT, lights, index, L, 0);
    s.triangle = GK_LIGHT(lights, index, triangle);
    s.material = GK_LIGHT(lights, index, material);
    s.delta = kind != GK_LIGHT_TRIANGLE;

    gk_f32 s1, s2;
    gk_light_point(u, v, &s1, &s2);
    const gk_i32 turned = (flags & GK_LIGHT_TURNED) != 0u;
    s.u = turned ? s2 : s1;
    s.v = turned ? s1 : s2;
    const struct gk_vec normal = gk_cross(a, b);
    const gk_f32 twice_area = gk_sqrt(gk_dot(normal, normal));
    const struct gk_vec n = gk_scale(normal, 1.0f / gk_max(twice_area, 1e-37f));
    const struct gk_vec point = gk_along(gk_along(position, a, s1), b, s2);
    const gk_f32 side = gk_dot(gk_sub(p, point), n);
    // Off the emitter by its own error bound, towards p, so that it does not shadow itself.
    const gk_f32 lift = gk_point_error(point, 0.0f);
    const struct gk_vec target =
        gk_vec_select(gk_along(point, n, side < 0.0f ? -lift : lift), position, s.delta);

    const struct gk_vec to = gk_sub(target, p);
    const gk_f32 d2 = gk_max(gk_dot(to, to), 1e-37f);
    const gk_f32 d = gk_sqrt(d2);
    const gk_i32 sun = kind == GK_LIGHT_SUN;
    s.wi = gk_vec_select(gk_scale(to, 1.0f / d), position, sun);
    s.distance = sun ? GK_INFINITY : d;

    const gk_f32 cosine = -gk_dot(s.wi, n);
    const gk_i32 facing = (cosine > 0.0f) | ((flags >> 4) != 0u);
    const gk_f32 pdf = 2.0f * d2 / (gk_max(gk_abs(cosine), 1e-7f) * twice_area) * choice;
    const gk_f32 cone = gk_clamp((-gk_dot(s.wi, a) - b.x) * b.y, 0.0f, 1.0f);
    const gk_f32 falloff = sun ? 1.0f : cone * cone / d2;
    s.pdf = s.delta ? 1.0f : pdf;
    s.L = gk_scale(s.L, s.delta ? falloff / choice : facing ? 1.0f : 0.0f);
    return s;
}

#endif
