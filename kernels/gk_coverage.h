// gk_coverage.h - how far ID coverage follows a path through glossy vertices.
//
// Source: Yoshimura, Tokuyoshi, Harada 2022, doi:10.2312/sr.20221162, Eq. 2 to 7, with one set of
// indices: x_1 is the first hit, t_m = |x_{m+1} - x_m|, v_m^2 the variance of the scattering at x_m,
// sigma_m^2 that of where paths arrive at x_m, r_m the radius of the camera sample's cone.
//
// Lengths are metres, variances and slopes are of tangents. A weight is in [0, 1]: the share of the
// coverage that x_m hands on to x_{m+1}.
#ifndef GK_COVERAGE_H
#define GK_COVERAGE_H

#include "kernels/gk_math.h"

#define GK_DIFFUSE_VARIANCE 1.5f // of a lobe of density 1/pi: what diffuse_cut compares with

// Eq. 2 without its double sum: over the vertices before the last, the sums of v^2 d^k, d the
// distance since each and k = 0, 1, 2. The last is apart, because the weight is about it.
struct gk_spread {
    gk_f32 s0, s1, s2;
    gk_f32 last;  // v^2 of the vertex that the path left last; inf: it leaves in any direction
    gk_f32 since; // distance from there
};

// The cone of one camera sample along the path: signed radius and slope, and the way so far.
struct gk_cone {
    gk_f32 r, g, way;
};

// How a job wants its weights.
struct gk_weight_rule {
    gk_f32 alpha;         // 0..16
    gk_f32 radius, slope; // of the cone where it starts; rh of Eq. 6 is radius + slope way
    gk_i32 glossy;        // else 1 of a delta and 0 of anything else
    gk_i32 clamped;       // Eq. 6, else Eq. 5
    gk_i32 eq3;           // in the place of Eq. 2
    gk_i32 cut;           // moved so that a lobe of density 1/pi hands on nothing
};

GK_INLINE struct gk_spread gk_spread_none(void)
{
    struct gk_spread s;
    s.s0 = s.s1 = s.s2 = s.last = s.since = 0.0f;
    return s;
}

// The path goes on by t. eq3: without the mixed terms.
GK_INLINE struct gk_spread gk_spread_advance(struct gk_spread s, gk_f32 t, gk_i32 eq3)
{
    struct gk_spread a = s;
    const gk_f32 square = t * t * s.s0;
    a.s2 = s.s2 + (eq3 ? square : 2.0f * t * s.s1 + square);
    a.s1 = s.s1 + t * s.s0;
    a.since = s.since + t;
    return a;
}

// The path scatters with variance v2 where it is; `last` was finite.
GK_INLINE struct gk_spread gk_spread_scatter(struct gk_spread s, gk_f32 v2)
{
    struct gk_spread a;
    a.s0 = s.s0 + s.last;
    a.s1 = s.s1 + s.since * s.last;
    a.s2 = s.s2 + s.since * s.since * s.last;
    a.last = v2;
    a.since = 0.0f;
    return a;
}

// Eq. 4 without cancellation. pdf: solid angle of the lobes of the side that was sampled that are not
// deltas; > 0, inf gives 0. side: probability of these lobes, over which pdf is that given the side.
// Up to side / (2 pi) the variance is infinite. With a = 2 pi pdf, e = side / a.
GK_INLINE gk_f32 gk_lobe_variance(gk_f32 pdf, gk_f32 side)
{
    const gk_f32 a = gk_min(GK_TWO_PI * pdf, 1e38f), rest = a - side;
    const gk_f32 v2 = side * (2.0f * a - side) / (2.0f * rest * rest);
    return rest > 0.0f ? v2 : GK_INFINITY;
}

GK_INLINE void gk_cone_advance(struct gk_cone *c, gk_f32 t)
{
    c->r += t * c->g;
    c->way += t;
}

// Slope of a cone beyond a vertex: of_slope times that before and of_radius times its radius. After a
// mirror, or, where it crosses, paraxial refraction. curvature: 1/m, > 0 where the surface bulges
// towards the path. cosine > 0, of the path; eta: index behind over index before. One division for both.
GK_INLINE void gk_cone_bend(gk_f32 curvature, gk_f32 cosine, gk_f32 eta, gk_i32 crosses,
                            gk_f32 *of_slope, gk_f32 *of_radius)
{
    const gk_f32 inverse = 1.0f / (crosses ? eta : cosine);
    const gk_f32 across = (inverse - 1.0f) * curvature;
    *of_slope = crosses ? inverse : 1.0f;
    *of_radius = crosses ? across : 2.0f * curvature * inverse;
}

// Square of the radius at a hit.
GK_INLINE gk_f32 gk_cone_area(const struct gk_cone *c, const struct gk_weight_rule *rule)
{
    const gk_f32 own = c->r * c->r, straight = rule->radius + rule->slope * c->way;
    return rule->clamped ? gk_max(own, straight * straight) : own;
}

// That per squared metre, as the distance grows without bound.
GK_INLINE gk_f32 gk_cone_area_far(const struct gk_cone *c, const struct gk_weight_rule *rule)
{
    const gk_f32 own = c->g * c->g;
    return rule->clamped ? gk_max(own, rule->slope * rule->slope) : own;
}

// s^alpha - 1 where s^2 = rest / (part + rest), 1 of nothing; alpha > 0.
GK_INLINE gk_f32 gk_weight_loss(gk_f32 part, gk_f32 rest, gk_f32 alpha)
{
    const gk_f32 ratio = part > 0.0f ? part / rest : 0.0f;
    return gk_expm1(-0.5f * alpha * gk_log1p(ratio));
}

// Eq. 7, where the last vertex adds `part` to the variance `rest`. alpha in [0, 16]; 0: 1 always.
// flat: what a lobe of density 1/pi would have added in its place: the weight is moved so that such
// a lobe hands on nothing; < 0: it is not.
GK_INLINE gk_f32 gk_coverage_weight(gk_f32 part, gk_f32 rest, gk_f32 flat, gk_f32 alpha)
{
    const gk_i32 bounded = part < GK_INFINITY;
    const gk_f32 loss = gk_weight_loss(bounded ? part : 0.0f, rest, alpha);
    const gk_f32 most = gk_weight_loss(flat, rest, alpha);
    const gk_f32 cut = most < 0.0f ? gk_max(1.0f - loss / most, 0.0f) : 1.0f;
    const gk_f32 weight = flat < 0.0f ? 1.0f + loss : cut;
    return alpha > 0.0f ? (bounded ? weight : 0.0f) : 1.0f;
}

// What the last vertex adds to the variance of the rest, and a lobe of density 1/pi in its place.
struct gk_weighing {
    gk_f32 part, rest, flat;
};

// Of the path that arrives so at a hit, or that leaves the scene: the limit as the way grows.
GK_INLINE struct gk_weighing gk_weighing_of(const struct gk_spread *s, const struct gk_cone *c,
                                            const struct gk_weight_rule *rule, gk_i32 missed)
{
    const gk_f32 square = missed ? 1.0f : s->since * s->since;
    struct gk_weighing w;
    w.part = s->last > 0.0f ? square * s->last : 0.0f;
    w.rest = missed ? gk_cone_area_far(c, rule) + s->s0 : gk_cone_area(c, rule) + s->s2;
    w.flat = rule->cut ? square * GK_DIFFUSE_VARIANCE : -1.0f;
    return w;
}

GK_INLINE gk_f32 gk_path_weight(const struct gk_spread *s, const struct gk_cone *c,
                                const struct gk_weight_rule *rule, gk_i32 missed)
{
    const struct gk_weighing w = gk_weighing_of(s, c, rule, missed);
    return gk_coverage_weight(w.part, w.rest, w.flat, rule->alpha);
}

// Units of `held` that go on: `carried` times the weight, to nearest, at most all. carried: held b/q,
// >= 0 and not NaN. *excess: by how much it was more.
GK_INLINE gk_u32 gk_coverage_carry(gk_u32 held, gk_f32 carried, gk_f32 weight, gk_u32 *excess)
{
    const gk_u32 wanted = (gk_u32)(gk_i32)(gk_min(carried * weight, 1e9f) + 0.5f);
    *excess = wanted > held ? wanted - held : 0u;
    return wanted > held ? held : wanted;
}

#endif
