// gk_solid.h - which solids a path is in, and what they take from its light.
//
// Solids without a priority are told apart by one word: the last that the path was refracted into.
// Prioritised ones may overlap and touch: the path keeps all that it is in, and where several are
// the one of the highest rank is there; surfaces inside a higher one are no interfaces (Schmidt and
// Budge 2002, "Simple Nested Dielectrics in Ray Traced Images").
#ifndef GK_SOLID_H
#define GK_SOLID_H

#include "kernels/gk_hit.h"

// Up to 8 ranks, two a word, 0 for an empty place, in no order.
struct gk_nested {
    gk_u32 a, b, c, d;
};

GK_INLINE gk_u32 gk_rank_max(gk_u32 word, gk_u32 top)
{
    const gk_u32 low = word & 0xffffu, high = word >> 16;
    const gk_u32 most = low > high ? low : high;
    return most > top ? most : top;
}

// The highest rank, 0: open space.
GK_INLINE gk_u32 gk_nested_top(struct gk_nested s)
{
    return gk_rank_max(s.a, gk_rank_max(s.b, gk_rank_max(s.c, gk_rank_max(s.d, 0u))));
}

// Writes `to` into the first place that holds `from`, unless that is done already.
GK_INLINE gk_u32 gk_nested_word(gk_u32 word, gk_u32 from, gk_u32 to, gk_i32 *done)
{
    const gk_i32 low = !*done && (word & 0xffffu) == from;
    const gk_i32 high = !*done && !low && (word >> 16) == from;
    const gk_u32 with_low = (word & 0xffff0000u) | to;
    const gk_u32 with_high = (word & 0xffffu) | (to << 16);
    *done = *done || low || high;
    return low ? with_low : high ? with_high : word;
}

GK_INLINE struct gk_nested gk_nested_replace(struct gk_nested s, gk_u32 from, gk_u32 to,
                                             gk_i32 *found)
{
    *found = 0;
    s.a = gk_nested_word(s.a, from, to, found);
    s.b = gk_nested_word(s.b, from, to, found);
    s.c = gk_nested_word(s.c, from, to, found);
    s.d = gk_nested_word(s.d, from, to, found);
    return s;
}

// What crossing the surface of a solid of `rank` does to a stack.
struct gk_crossing {
    struct gk_nested after;
    gk_f32 eta;         // index beyond over index before
    gk_i32 nothing;     // no interface is there: straight on
    gk_i32 overflowing; // entered a ninth
};

// The material of a rank > 0.
GK_INLINE gk_u32 gk_rank_material(const struct gk_resident *r, gk_u32 rank)
{
    return GK_MATERIAL(r, rank > 0u ? rank - 1u : 0u, ranked);
}

GK_INLINE gk_f32 gk_rank_index(const struct gk_resident *r, gk_u32 rank)
{
    const gk_f32 ior = GK_MATERIAL(r, gk_rank_material(r, rank), ior);
    return rank > 0u ? ior : 1.0f;
}

GK_INLINE struct gk_crossing gk_nested_cross(const struct gk_resident *r, struct gk_nested s,
                                             gk_u32 rank, gk_i32 entering)
{
    struct gk_crossing c;
    gk_i32 found;
    c.after = gk_nested_replace(s, entering ? 0u : rank, entering ? rank : 0u, &found);
    c.overflowing = entering && !found;
    const gk_u32 here = gk_nested_top(s), there = gk_nested_top(c.after);
    c.nothing = here == there;
    c.eta = gk_rank_index(r, there) / gk_rank_index(r, here);
    return c;
}

// Beer's law over `t` metres in the material `solid` - 1; 1 in open space and over an infinite way,
// which only a surface that is no solid's leaves open.
GK_INLINE struct gk_vec gk_solid_transmittance(const struct gk_resident *r, gk_u32 solid, gk_f32 t)
{
    const gk_u32 m = solid > 0u ? solid - 1u : 0u;
    const struct gk_vec left = gk_vec(gk_exp(-GK_MATERIAL(r, m, attenuation[0]) * t),
                                      gk_exp(-GK_MATERIAL(r, m, attenuation[1]) * t),
                                      gk_exp(-GK_MATERIAL(r, m, attenuation[2]) * t));
    return gk_vec_select(gk_splat(1.0f), left, solid > 0u && t < GK_INFINITY);
}

#endif
