// gk_transport.h - ID coverage carried along a path: what each vertex gives to the matte under it
// and what it hands on.
//
// Source: Yoshimura, Tokuyoshi, Harada 2022, doi:10.2312/sr.20221162, Eq. 1 and 8. The weight of a
// vertex depends on where the path arrives next, so its deposit waits for one vertex. Under Eq. 1 a
// sample's deposits are units that sum to GK_MATTE_ONE: of `held` units round(held W b/q) go on and
// the rest is deposited; whatever ends the path deposits all. b: mean weight of the scattering; q:
// probability that the path lives on. No ray and no random number is added, so the picture is the
// same without.
#ifndef GK_TRANSPORT_H
#define GK_TRANSPORT_H

#include "kernels/gk_held.h"
#include "kernels/gk_vertex.h"

#ifdef GK_THROUGH

GK_INLINE gk_i32 gk_matte_flag(const GK_GLOBAL struct gk_frame *frame, gk_u32 flag)
{
    return (frame->matte_flags & flag) != 0u;
}

GK_INLINE struct gk_weight_rule gk_weight_rule_of(const GK_GLOBAL struct gk_frame *frame)
{
    struct gk_weight_rule rule;
    rule.alpha = frame->matte_alpha;
    rule.radius = frame->matte_radius;
    rule.slope = frame->matte_slope;
    rule.glossy = gk_matte_flag(frame, GK_MATTES_GLOSSY);
    rule.clamped = gk_matte_flag(frame, GK_MATTES_CLAMP);
    rule.eq3 = gk_matte_flag(frame, GK_MATTES_EQ3);
    rule.cut = gk_matte_flag(frame, GK_MATTES_CUT);
    return rule;
}

// W of the vertex that the path left last, on arrival.
GK_INLINE gk_f32 gk_transport_weight(const struct gk_transport *t,
                                     const struct gk_weight_rule *rule, gk_i32 missed)
{
    const gk_f32 delta = t->spread.last == 0.0f ? 1.0f : 0.0f;
#ifdef GK_GLOSSY_MATTES
    const gk_f32 weight = gk_path_weight(&t->spread, &t->cone, rule, missed);
    return rule->glossy ? weight : delta;
#else
    (void)rule;
    (void)missed;
    return delta;
#endif
}

// The class bits of a deposit: one of bounces, or one of depths, or the only one.
GK_INLINE gk_u32 gk_transport_class(const GK_GLOBAL struct gk_frame *frame,
                                    const struct gk_transport *t)
{
    const gk_f32 half_metres = gk_max(2.0f * t->cone.way, 1.0f);
    const gk_i32 octave = (gk_i32)(gk_as_u32(half_metres) >> 23) - 127; // floor of its log2
    const gk_i32 bin = gk_min_i32(octave, (gk_i32)frame->matte_bins - 1);
    const gk_u32 bounced =
        gk_matte_flag(frame, GK_MATTES_CLASSES) && (t->waits & GK_WAITS_CROSSED) != 0u ? 2u : 1u;
    return frame->matte_bins > 0u ? 1u + (gk_u32)bin : bounced;
}

// GK_COL_WAITS of the surface that was hit, or of the background.
GK_INLINE gk_u32 gk_transport_key(const GK_GLOBAL struct gk_frame *frame,
                                  const struct gk_resident *scene, const struct gk_vertex *x,
                                  const struct gk_transport *t)
{
    const gk_u32 matte = x->missed ? GK_MATTE_BACKGROUND : scene->instance[x->hit.instance].matte;
    const gk_i32 first = t->waits == 0u;
    const gk_i32 direct = first || ((t->waits & GK_WAITS_DIRECT) != 0u && t->spread.last == 0.0f);
    return gk_matte_of_class(matte, gk_transport_class(frame, t)) |
           (direct ? GK_WAITS_DIRECT : 0u) | (first ? GK_WAITS_FIRST : 0u) |
           (t->waits & GK_WAITS_CROSSED);
}

// What a vertex takes; nothing where classes are told apart and the path has had no bounce yet, or
// beyond the scene where that is not asked for.
GK_INLINE struct gk_deposit gk_deposit_make(const GK_GLOBAL struct gk_frame *frame, gk_u32 waits,
                                            gk_u32 amount)
{
    const gk_i32 unclassed =
        gk_matte_flag(frame, GK_MATTES_CLASSES) && (waits & GK_WAITS_FIRST) != 0u;
    const gk_i32 beyond = (waits & GK_MATTE_BASE_KEY) == GK_MATTE_BACKGROUND &&
                          !gk_matte_flag(frame, GK_MATTES_ENVIRONMENT);
    struct gk_deposit d;
    d.key = unclassed || beyond ? 0u : waits & (GK_WAITS_DIRECT | GK_WAITS_KEY);
    d.amount = amount;
    return d;
}

// Share of light that the surface does not let through: 1 - T of Eq. 8.
GK_INLINE gk_f32 gk_opaque_share(const struct gk_vertex *x)
{
#ifdef GK_TRANSMISSION
    const struct gk_facet m = gk_facet_make(&x->surface, gk_min(x->wo.z, 1.0f));
    return x->missed ? 1.0f : gk_saturate(1.0f - gk_mean3(m.refract));
#else
    (void)x;
    return 1.0f;
#endif
}

// Eq. 8: what is held covers the vertex as far as it is opaque, unless that was the one before, and
// goes on undiminished.
GK_INLINE struct gk_deposit gk_opaque_deposit(const GK_GLOBAL struct gk_frame *frame,
                                              const struct gk_vertex *x, gk_u32 held, gk_u32 here,
                                              gk_u32 waited)
{
    const gk_i32 same = (here & GK_MATTE_BASE_KEY) == (waited & GK_MATTE_BASE_KEY);
    const gk_f32 units = (gk_f32)(gk_i32)held * gk_opaque_share(x);
    return gk_deposit_make(frame, same ? 0u : here, (gk_u32)(gk_i32)(units + 0.5f));
}

// The path has come to the vertex: the one before gets its deposit.
GK_INLINE void gk_transport_arrive(struct gk_transport *t, const GK_GLOBAL struct gk_frame *frame,
                                   const struct gk_resident *scene, const struct gk_vertex *x)
{
    const struct gk_weight_rule rule = gk_weight_rule_of(frame);
    const gk_f32 way = x->missed || x->in_medium ? 0.0f : x->path.t;
    t->spread = gk_spread_advance(t->spread, way, rule.eq3);
    gk_cone_advance(&t->cone, way);
    const gk_u32 waited = t->waits;
    const gk_i32 arrives = !x->passes && !x->in_medium && waited != 0u;
    // A medium hides nothing from mattes: before the first vertex the surface behind it counts.
    const gk_i32 begins = !x->passes && waited == 0u;
    gk_u32 excess;
    const gk_f32 weight = gk_transport_weight(t, &rule, x->missed);
    const gk_u32 on = gk_coverage_carry(t->held, t->carried, weight, &excess);
    const gk_u32 given = t->held - on;
    // A vertex that hands on more than it has should be given less than nothing: the next one is given
    // so much less, which is the same where both are of one thing, and those beyond get theirs.
    t->over = arrives && excess > 0u ? t->carried * weight / (gk_f32)(gk_i32)on : 1.0f;
    t->held = arrives ? on : t->held;
    t->waits = arrives || begins ? gk_transport_key(frame, scene, x, t) : waited;
    t->excess = arrives && ((waited ^ t->waits) & GK_WAITS_KEY) != 0u ? excess : 0u;
    t->before = gk_deposit_make(frame, arrives ? waited : 0u, given);
#ifdef GK_OPAQUE_FULL
    const gk_i32 full = gk_matte_flag(frame, GK_MATTES_OPAQUE);
    const struct gk_deposit opaque = gk_opaque_deposit(frame, x, t->held, t->waits, waited);
    t->before.key = full ? (arrives || begins ? opaque.key : 0u) : t->before.key;
    t->before.amount = full ? opaque.amount : t->before.amount;
#endif
#ifdef GK_PATH_LIST
    t->met = arrives || begins ? t->waits & GK_MATTE_BASE_KEY : 0u;
#endif
}

// Probability that the lobe which was chosen is no delta and leaves on that side.
GK_INLINE gk_f32 gk_side_probability(const struct gk_vertex *x, gk_i32 crosses)
{
#ifdef GK_MICROFACET
    const struct gk_surface *s = &x->surface;
    const struct gk_facet m = gk_facet_make(s, gk_min(x->wo.z, 1.0f));
    gk_f32 reflected = s->p_diffuse + (s->delta ? 0.0f : s->p_facet * m.p_reflect);
#ifdef GK_CLEARCOAT
    reflected += s->coat.alpha < GK_ALPHA_DELTA ? 0.0f : s->coat.p;
#endif
    return crosses ? s->p_facet * (1.0f - m.p_reflect) : reflected;
#else
    (void)x;
    (void)crosses;
    return 1.0f;
#endif
}

// v^2 of the vertex that the path leaves by `next`; through deltas alone, anything above 0 serves.
GK_INLINE gk_f32 gk_transport_variance(const struct gk_vertex *x, const struct gk_next *next)
{
#ifdef GK_GLOSSY_MATTES
    const gk_f32 side = gk_max(gk_side_probability(x, next->crosses), 1e-20f);
    const gk_f32 v2 = gk_lobe_variance(next->pdf, side);
#else
    (void)x;
    const gk_f32 v2 = GK_INFINITY;
#endif
    return next->pdf < 0.0f ? 0.0f : v2;
}

// Slope of the cone beyond the vertex.
GK_INLINE gk_f32 gk_transport_slope(const struct gk_transport *t, const struct gk_resident *scene,
                                    const struct gk_vertex *x, gk_i32 crosses)
{
#ifdef GK_TRANSMISSION
    const gk_f32 eta = x->surface.thin ? 1.0f : x->surface.eta;
#else
    const gk_f32 eta = 1.0f;
#endif
    return gk_cone_bent(t->cone.r, t->cone.g, gk_hit_curvature(scene, &x->hit), x->wo.z, eta,
                        crosses);
}

// The path leaves the vertex by `next`, or ends. scale: 1/q.
GK_INLINE void gk_transport_leave(struct gk_transport *t, const GK_GLOBAL struct gk_frame *frame,
                                  const struct gk_resident *scene, const struct gk_vertex *x,
                                  const struct gk_next *next, gk_f32 scale, gk_i32 alive)
{
    const gk_f32 v2 = gk_transport_variance(x, next);
    const gk_i32 turns = alive && !x->passes;
    const gk_i32 glossy = gk_matte_flag(frame, GK_MATTES_GLOSSY);
    const gk_i32 spread = glossy ? !(v2 < GK_INFINITY) && frame->matte_alpha > 0.0f : v2 > 0.0f;
    const gk_i32 blurred = turns && spread;
    const gk_i32 ends = !alive || x->in_medium || blurred;
    const gk_u32 taker = t->waits == 0u ? gk_matte_of_class(GK_MATTE_BACKGROUND, 1u) : t->waits;
    t->last = gk_deposit_make(frame, ends ? taker : 0u, t->held);
#ifdef GK_OPAQUE_FULL
    t->last.key = gk_matte_flag(frame, GK_MATTES_OPAQUE) ? 0u : t->last.key;
#endif
    const struct gk_spread scattered = gk_spread_scatter(t->spread, v2);
    const gk_f32 slope = gk_transport_slope(t, scene, x, next->crosses);
    t->held = ends ? 0u : t->held;
    const gk_f32 b = gk_mean3(next->weight) * gk_next_share(x, next);
    t->carried = turns ? (gk_f32)(gk_i32)t->held * t->over * (b * scale) : t->carried;
    t->spread.s0 = turns ? scattered.s0 : t->spread.s0;
    t->spread.s1 = turns ? scattered.s1 : t->spread.s1;
    t->spread.s2 = turns ? scattered.s2 : t->spread.s2;
    t->spread.last = turns ? scattered.last : t->spread.last;
    t->spread.since = turns ? scattered.since : t->spread.since;
    t->cone.g = turns ? slope : t->cone.g;
    const gk_i32 crossing = turns && next->crosses && (t->waits & GK_WAITS_FIRST) != 0u;
    t->waits |= crossing ? GK_WAITS_CROSSED : 0u;
}

#endif

#endif
