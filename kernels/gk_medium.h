// gk_medium.h - the scene's medium: free paths, transmittance and the Henyey-Greenstein phase
// function, f, sample and pdf kept together.
//
// Extinction is one number for all three colours, so a free path drawn from it has weight 1 and
// only the scattering albedo is left as a factor (Pharr et al. 2023, 11.2).
#ifndef GK_MEDIUM_H
#define GK_MEDIUM_H

#include "kernels/gk_frame.h"
#include "kernels/gk_vec.h"

// Part of a ray inside the medium, in metres along it; empty where begin >= end.
struct gk_span {
    gk_f32 begin, end;
};

GK_INLINE struct gk_span gk_span_clip(struct gk_span span, gk_f32 o, gk_f32 d, gk_f32 low,
                                      gk_f32 high)
{
    const gk_f32 inverse = 1.0f / d; // infinite along the slab: both ends on one side, or none
    const gk_f32 a = (low - o) * inverse, b = (high - o) * inverse;
    span.begin = gk_max(span.begin, gk_min(a, b));
    span.end = gk_min(span.end, gk_max(a, b));
    return span;
}

GK_INLINE struct gk_span gk_medium_span(const GK_GLOBAL struct gk_frame *f, struct gk_vec o,
                                        struct gk_vec d, gk_f32 length)
{
    struct gk_span span = {0.0f, length};
    span = gk_span_clip(span, o.x, d.x, f->medium_low[0], f->medium_high[0]);
    span = gk_span_clip(span, o.y, d.y, f->medium_low[1], f->medium_high[1]);
    return gk_span_clip(span, o.z, d.z, f->medium_low[2], f->medium_high[2]);
}

GK_INLINE gk_f32 gk_medium_transmittance(const GK_GLOBAL struct gk_frame *f, struct gk_vec o,
                                         struct gk_vec d, gk_f32 length)
{
    const struct gk_span span = gk_medium_span(f, o, d, length);
    const gk_f32 inside = span.begin < span.end ? span.end - span.begin : 0.0f;
    const gk_f32 left = gk_exp(-inside * f->medium_density);
    return f->medium_density > 0.0f ? left : 1.0f;
}

// Distance at which light that goes along the span meets the medium, +inf: it does not. u < 1.
GK_INLINE gk_f32 gk_medium_distance(const GK_GLOBAL struct gk_frame *f, struct gk_span span,
                                    gk_f32 u)
{
    const gk_f32 t = span.begin - gk_log(1.0f - u) / f->medium_density;
    return t < span.end ? t : GK_INFINITY;
}

#define GK_PHASE_DELTA 0.999755859375f // 1 - 2^-12: beyond it light goes straight on, or back

// pdf and value are the same: the function integrates to 1. d: direction of travel before. Backward
// scattering is forward scattering of the opposite direction, so both peaks keep their digits.
GK_INLINE gk_f32 gk_phase_eval(gk_f32 g, struct gk_vec d, struct gk_vec wi)
{
    const gk_f32 a = gk_abs(g);
    // 1 - cos without cancellation: half the square of the difference of two unit vectors.
    const struct gk_vec e = gk_along(wi, d, g < 0.0f ? 1.0f : -1.0f);
    const gk_f32 x = (1.0f - a) * (1.0f - a) + a * gk_dot(e, e);
    const gk_f32 value = (1.0f - a * a) / (4.0f * GK_PI * x * gk_sqrt(x));
    return a > GK_PHASE_DELTA ? 0.0f : value;
}

// 1 - cos of the angle to the peak, a = |g|, in the form that neither divides by a nor leaves [0, 2];
// exactly 0 for a delta.
GK_INLINE gk_f32 gk_phase_one_minus_cos(gk_f32 a, gk_f32 u)
{
    const gk_f32 s = 2.0f * u - 1.0f;
    const gk_f32 q = (1.0f - a) + 2.0f * a * u; // 1 + a s
    const gk_f32 r = (1.0f - a) / gk_max(q, 1e-20f);
    const gk_f32 x = 0.5f * r * r * (1.0f - s) * (2.0f + a * (1.0f + s));
    return a > GK_PHASE_DELTA ? 0.0f : gk_clamp(x, 0.0f, 2.0f);
}

GK_INLINE struct gk_vec gk_phase_sample(gk_f32 g, struct gk_vec d, gk_f32 u, gk_f32 v)
{
    const gk_f32 x = gk_phase_one_minus_cos(gk_abs(g), u);
    gk_f32 sine, cosine;
    gk_sincos_2pi(v, &sine, &cosine);
    const gk_f32 r = gk_sqrt(gk_max(x * (2.0f - x), 0.0f));
    const struct gk_onb onb = gk_onb_make(gk_vec_select(d, gk_negate(d), g < 0.0f));
    return gk_normalise(gk_to_world(onb, gk_vec(r * cosine, r * sine, 1.0f - x)));
}

#endif
