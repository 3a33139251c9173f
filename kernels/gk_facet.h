// gk_facet.h - GGX reflection and refraction: f, sample and pdf.
#ifndef GK_FACET_H
#define GK_FACET_H

#include "kernels/gk_scatter.h"

#ifdef GK_MICROFACET

// Reflectances of a microfacet seen under cos_m, and the probability of taking the reflection.
struct gk_facet {
    struct gk_vec reflect, refract;
    gk_f32 p_reflect;
};

GK_INLINE struct gk_facet gk_facet_make(const struct gk_surface *s, gk_f32 cos_m)
{
    const struct gk_vec fd = gk_dielectric(s, gk_fresnel_dielectric(cos_m, s->eta));
    const struct gk_vec fm = gk_fresnel_metal(s->base, cos_m);
    const gk_f32 share = (1.0f - s->metallic) * s->transmission;
    struct gk_facet m;
    m.reflect = gk_along(gk_scale(fm, s->metallic), fd, 1.0f - s->metallic);
    m.refract = gk_mul(s->base,
                       gk_vec(share * (1.0f - fd.x), share * (1.0f - fd.y), share * (1.0f - fd.z)));
    const gk_f32 r = gk_mean3(m.reflect), t = gk_mean3(m.refract);
    m.p_reflect = t > 0.0f ? r / (r + t) : 1.0f;
#ifdef GK_COLLIMATION
    m.p_reflect = s->scatters ? s->p_reflect : m.p_reflect;
#endif
#ifdef GK_PAIR
    m.reflect = gk_along(gk_scale(fm, s->metallic), gk_mul(fd, s->raise), 1.0f - s->metallic);
    m.refract = gk_mul(m.refract, s->gain);
#endif
    return m;
}

GK_INLINE void gk_facet_eval(const struct gk_surface *s, struct gk_vec wo, struct gk_vec wi,
                             struct gk_bsdf_value *value)
{
    const gk_f32 a2 = s->alpha * s->alpha;
    const gk_i32 same = wi.z > 0.0f;
    const gk_f32 zi = gk_abs(wi.z);
#ifdef GK_TRANSMISSION
    const gk_i32 bent = !same && !s->thin;
    const struct gk_vec mirrored = gk_vec(wi.x, wi.y, zi);
    const struct gk_vec sum =
        gk_vec_select(gk_add(wo, mirrored), gk_negate(gk_along(wo, wi, s->eta)), bent);
#else
    const struct gk_vec sum = gk_add(wo, wi);
#endif
    // Half the length of the sum of two unit vectors is its cosine with either: the same bits when
    // they change places.
    const gk_f32 length = gk_sqrt(gk_dot(sum, sum));
    struct gk_vec h = gk_scale(sum, 1.0f / gk_max(length, 1e-20f));
#ifdef GK_TRANSMISSION
    h = gk_vec_select(h, gk_negate(h), h.z < 0.0f);
    const gk_f32 hi = gk_dot(wi, h);
    const gk_f32 ho = bent ? gk_dot(wo, h) : 0.5f * length;
#else
    const gk_f32 ho = 0.5f * length;
#endif
    const gk_f32 so = gk_ggx_s(wo.z, a2), si = gk_ggx_s(zi, a2);
    const gk_f32 d = gk_ggx_d(h, a2);
    const gk_f32 masked = 2.0f * zi / (so * zi + si * wo.z); // G2/wo.z
    const gk_f32 visible = 2.0f / (wo.z + so);               // G1/wo.z
    const struct gk_facet m = gk_facet_make(s, gk_clamp(ho, 0.0f, 1.0f));

    gk_f32 f = 0.25f * d * masked, pdf = 0.25f * d * visible;
    gk_i32 valid = ho > 0.0f && !s->delta;
#ifdef GK_TRANSMISSION
    const gk_f32 base = hi + ho / s->eta;
    const gk_f32 jacobian = gk_abs(hi) / gk_max(base * base, 1e-30f);
    f = bent ? d * masked * ho * jacobian / (s->eta * s->eta) : f;
    pdf = bent ? d * visible * ho * jacobian : pdf;
    valid = valid && (!bent || (hi < 0.0f && !gk_surface_matched(s)));
#ifdef GK_COLLIMATION
    valid = valid && (same || !s->scatters);
#endif
    const struct gk_vec albedo = gk_vec_select(m.refract, m.reflect, same);
    const gk_f32 chosen = same ? m.p_reflect : 1.0f - m.p_reflect;
#else
    const struct gk_vec albedo = m.reflect;
    const gk_f32 chosen = m.p_reflect;
    valid = valid && same;
#endif
    f = valid ? f : 0.0f;
    value->f = gk_along(value->f, albedo, f);
    value->pdf += valid ? s->p_facet * chosen * pdf : 0.0f;
#ifdef GK_COLLIMATION
    gk_scatter_eval(s, wo, wi, value);
#endif
}

GK_INLINE void gk_facet_sample(const struct gk_surface *s, struct gk_vec wo, gk_f32 u_lobe,
                               gk_f32 u, gk_f32 v, struct gk_bsdf_sample *out)
{
    const struct gk_vec n = gk_vec(0.0f, 0.0f, 1.0f);
    const struct gk_vec h = gk_vec_select(gk_ggx_sample(wo, s->alpha, u, v), n, s->delta);
    const gk_f32 cos_m = gk_dot(wo, h);
    const gk_f32 p = s->p_facet;
    const struct gk_facet m = gk_facet_make(s, gk_clamp(cos_m, 0.0f, 1.0f));
    const struct gk_vec reflected = gk_sub(gk_scale(h, 2.0f * cos_m), wo);
#ifdef GK_TRANSMISSION
    const gk_i32 reflect = u_lobe < m.p_reflect;
    const struct gk_vec through = gk_vec(reflected.x, reflected.y, -reflected.z);
    const struct gk_vec bent = gk_refract(wo, h, cos_m, s->eta);
    const struct gk_vec wi =
        gk_vec_select(gk_vec_select(bent, through, s->thin), reflected, reflect);
    // One that left on the wrong side is lost: that side's density does not know of it.
    out->wi = gk_vec_select(wi, gk_splat(0.0f), (wi.z > 0.0f) != reflect);
    const gk_f32 scale = s->thin ? 1.0f : 1.0f / (s->eta * s->eta);
    const gk_f32 wr = 1.0f / gk_max(p * m.p_reflect, 1e-20f);
    const gk_f32 wt = scale / gk_max(p * (1.0f - m.p_reflect), 1e-20f);
    out->weight = gk_vec_select(gk_scale(m.refract, wt), gk_scale(m.reflect, wr), reflect);
    out->delta = s->delta || (!reflect && gk_surface_matched(s));
#ifdef GK_COLLIMATION
    const gk_i32 scattered = !reflect && s->scatters;
    out->wi = gk_vec_select(out->wi, gk_scatter_sample(s, wo, u, v), scattered);
    out->delta = out->delta && !scattered;
#endif
#else
    (void)u_lobe;
    out->wi = reflected;
    out->weight = gk_scale(m.reflect, 1.0f / gk_max(p * m.p_reflect, 1e-20f));
    out->delta = s->delta;
#endif
}

#endif

#endif
