// gk_transport.h - ID coverage carried along a path: what each vertex gives to the matte under it
// and what it hands on.
//
// Source: Yoshimura, Tokuyoshi, Harada 2022, doi:10.2312/sr.20221162, Eq. 1 and 8. The weight of a
// vertex depends on where the path arrives next, so its deposit waits for one vertex. Under Eq. 1 a
// sample's deposits are units that sum to GK_MATTE_ONE: of `held` units round(held W b/q) go on and
// the rest is deposited; whatever ends the path deposits all. b: mean weight of the scattering; q:
// probability that the path lives on. No ray and no random number is added, so the picture is the
// same without. What is known of a vertex is in the columns that gk_passing.h left.
#ifndef GK_TRANSPORT_H
#define GK_TRANSPORT_H

#include "kernels/gk_held.h"

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
    (void)missed;
    return rule->glossy ? 1.0f : delta; // at alpha 0
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
GK_INLINE gk_u32 gk_transport_key(const GK_GLOBAL struct gk_frame *frame, gk_u32 matte,
                                  const struct gk_transport *t)
{
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

// A vertex, of the columns that it left.
struct gk_passing {
    gk_u32 word; // GK_COL_PASSING
    gk_f32 gain, variance, step, of_slope, of_radius, opaque;
};

GK_INLINE struct gk_passing gk_passing_load(const GK_GLOBAL gk_f32 *wave, gk_u32 stride, gk_u32 i)
{
    struct gk_passing p;
    p.word = GK_LOAD_U32(GK_COL_PASSING, i);
    p.gain = GK_LOAD(GK_COL_GAIN, i);
    p.variance = GK_LOAD(GK_COL_VARIANCE, i);
    p.step = GK_LOAD(GK_COL_STEP, i);
    p.of_slope = p.opaque = 1.0f;
    p.of_radius = 0.0f;
#ifdef GK_GLOSSY_MATTES
    p.of_slope = GK_LOAD(GK_COL_BEND_SLOPE, i);
    p.of_radius = GK_LOAD(GK_COL_BEND_RADIUS, i);
#endif
#ifdef GK_OPAQUE_FULL
    p.opaque = GK_LOAD(GK_COL_OPAQUE, i);
#endif
    return p;
}

GK_INLINE gk_i32 gk_passing_is(const struct gk_passing *p, gk_u32 flag)
{
    return (p->word & flag) != 0u;
}

// Eq. 8: what is held covers the vertex as far as it is opaque, unless that was the one before, and
// goes on undiminished.
GK_INLINE struct gk_deposit gk_opaque_deposit(const GK_GLOBAL struct gk_frame *frame, gk_f32 opaque,
                                              gk_u32 held, gk_u32 here, gk_u32 waited)
{
    const gk_i32 same = (here & GK_MATTE_BASE_KEY) == (waited & GK_MATTE_BASE_KEY);
    const gk_f32 units = (gk_f32)(gk_i32)held * opaque;
    return gk_deposit_make(frame, same ? 0u : here, (gk_u32)(gk_i32)(units + 0.5f));
}

// The path has come to the vertex: the one before gets its deposit.
GK_INLINE void gk_transport_arrive(struct gk_transport *t, const GK_GLOBAL struct gk_frame *frame,
                                   const struct gk_passing *p)
{
    const struct gk_weight_rule rule = gk_weight_rule_of(frame);
    t->spread = gk_spread_advance(t->spread, p->step, rule.eq3);
    gk_cone_advance(&t->cone, p->step);
    const gk_u32 waited = t->waits;
    // A medium hides nothing from mattes: before the first vertex the surface behind it counts.
    const gk_i32 counts = !gk_passing_is(p, GK_PASSING_STRAIGHT);
    const gk_i32 arrives = counts && !gk_passing_is(p, GK_PASSING_MEDIUM) && waited != 0u;
    const gk_i32 begins = counts && waited == 0u;
    gk_u32 excess;
    const gk_f32 weight = gk_transport_weight(t, &rule, gk_passing_is(p, GK_PASSING_MISSED));
    const gk_u32 on = gk_coverage_carry(t->held, t->carried, weight, &excess);
    const gk_u32 given = t->held - on;
    t->held = arrives ? on : t->held;
    // A vertex that hands on more than it has should be given less than nothing: the next one is given
    // so much less, which is the same where both are of one thing, and those beyond get theirs.
    t->going = arrives && excess > 0u ? t->carried * weight : (gk_f32)(gk_i32)t->held;
    const gk_u32 key = gk_transport_key(frame, p->word & GK_MATTE_BASE_KEY, t);
    t->waits = arrives || begins ? key : waited;
    t->excess = arrives && ((waited ^ t->waits) & GK_WAITS_KEY) != 0u ? excess : 0u;
    t->before = gk_deposit_make(frame, arrives ? waited : 0u, given);
#ifdef GK_OPAQUE_FULL
    const gk_i32 full = gk_matte_flag(frame, GK_MATTES_OPAQUE);
    const struct gk_deposit opaque = gk_opaque_deposit(frame, p->opaque, t->held, t->waits, waited);
    t->before.key = full ? (arrives || begins ? opaque.key : 0u) : t->before.key;
    t->before.amount = full ? opaque.amount : t->before.amount;
#endif
#ifdef GK_PATH_LIST
    t->met = arrives || begins ? t->waits & GK_MATTE_BASE_KEY : 0u;
#endif
}

// The path leaves the vertex, or ends.
GK_INLINE void gk_transport_leave(struct gk_transport *t, const GK_GLOBAL struct gk_frame *frame,
                                  const struct gk_passing *p)
{
    const gk_f32 v2 = p->variance;
    const gk_i32 alive = gk_passing_is(p, GK_PASSING_ALIVE);
    const gk_i32 turns = alive && !gk_passing_is(p, GK_PASSING_STRAIGHT);
    const gk_i32 glossy = gk_matte_flag(frame, GK_MATTES_GLOSSY);
    const gk_i32 spread = glossy ? !(v2 < GK_INFINITY) && frame->matte_alpha > 0.0f : v2 > 0.0f;
    const gk_i32 blurred = turns && spread;
    const gk_i32 ends = !alive || gk_passing_is(p, GK_PASSING_MEDIUM) || blurred;
    const gk_u32 taker = t->waits == 0u ? gk_matte_of_class(GK_MATTE_BACKGROUND, 1u) : t->waits;
    t->last = gk_deposit_make(frame, ends ? taker : 0u, t->held);
#ifdef GK_OPAQUE_FULL
    t->last.key = gk_matte_flag(frame, GK_MATTES_OPAQUE) ? 0u : t->last.key;
#endif
    const struct gk_spread scattered = gk_spread_scatter(t->spread, v2);
    const gk_f32 slope = p->of_slope * t->cone.g + p->of_radius * t->cone.r;
    t->held = ends ? 0u : t->held;
    t->carried = turns ? (ends ? 0.0f : t->going) * p->gain : t->carried;
    t->spread.s0 = turns ? scattered.s0 : t->spread.s0;
    t->spread.s1 = turns ? scattered.s1 : t->spread.s1;
    t->spread.s2 = turns ? scattered.s2 : t->spread.s2;
    t->spread.last = turns ? scattered.last : t->spread.last;
    t->spread.since = turns ? scattered.since : t->spread.since;
    t->cone.g = turns ? slope : t->cone.g;
    const gk_i32 crossing =
        turns && gk_passing_is(p, GK_PASSING_CROSSES) && (t->waits & GK_WAITS_FIRST) != 0u;
    t->waits |= crossing ? GK_WAITS_CROSSED : 0u;
}

#endif

#endif
