// gk_bsdf.h - the metallic-roughness surface: f, sample and pdf, kept together.
//
// Local frame: z is the shading normal on the side of wo, so wo.z > 0. f is returned times
// |wi.z|. A mixture of four lobes, chosen by one random number:
//   diffuse       (1-m)(1-t) base/pi (1-F(o))(1-F(i))/(1-Fmean): what enters through a smooth
//                 interface and leaves through it; energy-conserving and reciprocal
//   GGX reflection  m Fmetal + (1-m) Fdielectric, height-correlated masking
//   GGX refraction  (1-m) t base (1-F), solid (bends, radiance scaled by 1/eta^2) or thin
//                 (the reflection mirrored through the wall, Khronos KHR_materials_transmission)
// Below GK_ALPHA_DELTA reflection and refraction are delta lobes: never a value of f, only a
// weight of a sample.
//
// Sources: glTF 2.0 appendix B; Walter et al. 2007 (refraction); Heitz 2014 (masking);
// Dupuy and Benyoub 2023 (visible normals by spherical caps); Ashikhmin and Shirley 2000, after
// Shirley et al. 1997 (the diffuse coupling).
#ifndef GK_BSDF_H
#define GK_BSDF_H

#include "kernels/gk_fresnel.h"

#define GK_ALPHA_DELTA 1e-3f

struct gk_surface {
    struct gk_vec base;
    gk_f32 metallic, transmission;
    gk_f32 alpha;        // roughness squared
    gk_f32 eta;          // index on the far side over index on the side of wo
    gk_f32 fresnel_mean; // of the dielectric, from outside
    gk_f32 fresnel_o;    // of the dielectric at wo.z
    gk_f32 p_diffuse;    // probability of choosing the diffuse lobe
    gk_i32 thin, delta;
};

struct gk_bsdf_value {
    struct gk_vec f; // times |wi.z|
    gk_f32 pdf;      // 1/sr
};

struct gk_bsdf_sample {
    struct gk_vec wi;
    struct gk_vec weight; // f |cos| / pdf, of a delta lobe only
    gk_i32 delta;
};

// Completes a surface for the direction wo: the share of the diffuse lobe is its mean albedo's.
GK_INLINE void gk_surface_prepare(struct gk_surface *s, gk_f32 cos_o)
{
#ifdef GK_MICROFACET
    const struct gk_vec fm = gk_fresnel_metal(s->base, cos_o);
    s->fresnel_o = gk_fresnel_dielectric(cos_o, s->eta);
    const gk_f32 below = (1.0f - s->metallic) * (1.0f - s->fresnel_o) * gk_mean3(s->base);
    const gk_f32 diffuse = below * (1.0f - s->transmission);
    const gk_f32 other =
        below * s->transmission + s->metallic * gk_mean3(fm) + (1.0f - s->metallic) * s->fresnel_o;
    const gk_f32 sum = diffuse + other;
    s->p_diffuse = sum > 0.0f ? diffuse / sum : 1.0f;
    s->delta = s->alpha < GK_ALPHA_DELTA;
#else
    (void)cos_o;
    s->fresnel_o = 0.0f;
    s->p_diffuse = 1.0f;
    s->delta = 0;
#endif
}

GK_INLINE gk_f32 gk_diffuse_coupling(const struct gk_surface *s, gk_f32 cos_i)
{
#ifdef GK_MICROFACET
    const gk_f32 fi = gk_fresnel_dielectric(cos_i, s->eta);
    return (1.0f - s->fresnel_o) * (1.0f - fi) / (1.0f - s->fresnel_mean);
#else
    (void)s;
    (void)cos_i;
    return 1.0f;
#endif
}

#ifdef GK_MICROFACET

// Reflectances of a microfacet seen under cos_m, and the probability of taking the reflection.
struct gk_facet {
    struct gk_vec reflect, refract;
    gk_f32 p_reflect;
};

GK_INLINE struct gk_facet gk_facet_make(const struct gk_surface *s, gk_f32 cos_m)
{
    const gk_f32 fd = gk_fresnel_dielectric(cos_m, s->eta);
    const struct gk_vec fm = gk_fresnel_metal(s->base, cos_m);
    struct gk_facet m;
    m.reflect = gk_along(gk_scale(fm, s->metallic), gk_splat(fd), 1.0f - s->metallic);
    m.refract = gk_scale(s->base, (1.0f - s->metallic) * s->transmission * (1.0f - fd));
    const gk_f32 r = gk_mean3(m.reflect), t = gk_mean3(m.refract);
    m.p_reflect = t > 0.0f ? r / (r + t) : 1.0f;
    return m;
}

// Trowbridge-Reitz density of normals; hx^2+hy^2 instead of 1-hz^2 keeps narrow lobes exact.
GK_INLINE gk_f32 gk_ggx_d(struct gk_vec h, gk_f32 a2)
{
    const gk_f32 d = h.x * h.x + h.y * h.y + a2 * h.z * h.z;
    return a2 / (GK_PI * d * d);
}

GK_INLINE gk_f32 gk_ggx_s(gk_f32 z, gk_f32 a2)
{
    return gk_sqrt(a2 + (1.0f - a2) * z * z);
}

// A visible normal of the GGX surface (Dupuy and Benyoub 2023, listing 3).
GK_INLINE struct gk_vec gk_ggx_sample(struct gk_vec wo, gk_f32 alpha, gk_f32 u, gk_f32 v)
{
    const struct gk_vec o = gk_normalise(gk_vec(wo.x * alpha, wo.y * alpha, wo.z));
    gk_f32 sine, cosine;
    gk_sincos_2pi(u, &sine, &cosine);
    const gk_f32 z = (1.0f - v) * (1.0f + o.z) - o.z;
    const gk_f32 r = gk_sqrt(gk_max(1.0f - z * z, 0.0f));
    const struct gk_vec h =
        gk_vec((r * cosine + o.x) * alpha, (r * sine + o.y) * alpha, gk_max(z + o.z, 1e-7f));
    return gk_normalise(h);
}

// Direction refracted at the normal h, cos_m = wo.h > 0, eta as in gk_surface. g is eta cos of the
// refracted ray, in the form that does not cancel for eta near 1; g^2 < 0, total reflection, is
// clamped: the caller never takes it there (p_reflect is 1).
GK_INLINE struct gk_vec gk_refract(struct gk_vec wo, struct gk_vec h, gk_f32 cos_m, gk_f32 eta)
{
    const gk_f32 g2 = (eta - 1.0f) * (eta + 1.0f) + cos_m * cos_m;
    const gk_f32 along_h = cos_m - gk_sqrt(gk_max(g2, 0.0f));
    return gk_scale(gk_along(gk_negate(wo), h, along_h), 1.0f / eta);
}

// An interface between equal indices passes everything straight on, however rough: a delta lobe.
GK_INLINE gk_i32 gk_surface_matched(const struct gk_surface *s)
{
    return !s->thin && gk_abs(s->eta - 1.0f) < 1e-4f;
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
    const gk_f32 p = 1.0f - s->p_diffuse;

    gk_f32 f = 0.25f * d * masked, pdf = 0.25f * d * visible;
    gk_i32 valid = ho > 0.0f && !s->delta;
#ifdef GK_TRANSMISSION
    const gk_f32 base = hi + ho / s->eta;
    const gk_f32 jacobian = gk_abs(hi) / gk_max(base * base, 1e-30f);
    f = bent ? d * masked * ho * jacobian / (s->eta * s->eta) : f;
    pdf = bent ? d * visible * ho * jacobian : pdf;
    valid = valid && (!bent || (hi < 0.0f && !gk_surface_matched(s)));
    const struct gk_vec albedo = gk_vec_select(m.refract, m.reflect, same);
    const gk_f32 chosen = same ? m.p_reflect : 1.0f - m.p_reflect;
#else
    const struct gk_vec albedo = m.reflect;
    const gk_f32 chosen = m.p_reflect;
    valid = valid && same;
#endif
    f = valid ? f : 0.0f;
    value->f = gk_along(value->f, albedo, f);
    value->pdf += valid ? p * chosen * pdf : 0.0f;
}

GK_INLINE void gk_facet_sample(const struct gk_surface *s, struct gk_vec wo, gk_f32 u_lobe,
                               gk_f32 u, gk_f32 v, struct gk_bsdf_sample *out)
{
    const struct gk_vec n = gk_vec(0.0f, 0.0f, 1.0f);
    const struct gk_vec h = gk_vec_select(gk_ggx_sample(wo, s->alpha, u, v), n, s->delta);
    const gk_f32 cos_m = gk_dot(wo, h);
    const gk_f32 p = 1.0f - s->p_diffuse;
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
#else
    (void)u_lobe;
    out->wi = reflected;
    out->weight = gk_scale(m.reflect, 1.0f / gk_max(p * m.p_reflect, 1e-20f));
    out->delta = s->delta;
#endif
}

#endif // GK_MICROFACET

// f |wi.z| and the pdf with which gk_bsdf_sample would take wi. Delta lobes contribute nothing.
GK_INLINE struct gk_bsdf_value gk_bsdf_eval(const struct gk_surface *s, struct gk_vec wo,
                                            struct gk_vec wi)
{
    const gk_f32 z = gk_max(wi.z, 0.0f) * (1.0f / GK_PI);
    const gk_f32 share = (1.0f - s->metallic) * (1.0f - s->transmission);
    struct gk_bsdf_value value;
    value.f = gk_scale(s->base, share * z * gk_diffuse_coupling(s, gk_max(wi.z, 0.0f)));
    value.pdf = s->p_diffuse * z;
#ifdef GK_MICROFACET
    gk_facet_eval(s, wo, wi, &value);
#else
    (void)wo;
#endif
    return value;
}

// A direction by the mixture: u_lobe chooses, (u, v) place. For a delta lobe `weight` is f/pdf;
// otherwise ask gk_bsdf_eval at wi.
GK_INLINE struct gk_bsdf_sample gk_bsdf_sample(const struct gk_surface *s, struct gk_vec wo,
                                               gk_f32 u_lobe, gk_f32 u, gk_f32 v)
{
    gk_f32 sine, cosine;
    gk_sincos_2pi(u, &sine, &cosine);
    const gk_f32 r = gk_sqrt(v);
    const struct gk_vec cosine_wi = gk_vec(r * cosine, r * sine, gk_sqrt(gk_max(1.0f - v, 0.0f)));
    struct gk_bsdf_sample out;
#ifdef GK_MICROFACET
    const gk_i32 diffuse = u_lobe < s->p_diffuse;
    const gk_f32 rest = (u_lobe - s->p_diffuse) / gk_max(1.0f - s->p_diffuse, 1e-20f);
    gk_facet_sample(s, wo, rest, u, v, &out);
    out.wi = gk_vec_select(out.wi, cosine_wi, diffuse);
    out.delta = out.delta && !diffuse;
#else
    (void)wo;
    (void)u_lobe;
    out.wi = cosine_wi;
    out.weight = s->base;
    out.delta = 0;
#endif
    return out;
}

#endif
