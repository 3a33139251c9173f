// gk_bsdf.h - the metallic-roughness surface: f, sample and pdf, kept together.
//
// Local frame: z is the shading normal on the side of wo, so wo.z > 0. f is returned times
// |wi.z|. A mixture of lobes, chosen by one random number; R is the reflectance of the dielectric,
// m metallic, t transmission:
//   diffuse         (1-m)(1-t) base/pi (1-R(o))(1-R(i))/(1-Rmean): what enters through a smooth
//                   interface and leaves through it; energy-conserving and reciprocal
//   GGX reflection  m Fmetal + (1-m) R, height-correlated masking
//   GGX refraction  (1-m) t base (1-R), solid (bends, radiance scaled by 1/eta^2) or thin
//                   (the reflection mirrored through the wall, Khronos KHR_materials_transmission)
//   multiple        GK_MULTISCATTER: what met several facets of the reflection, of metal and of
//                   opaque dielectric; drawn with the diffuse lobe. The diffuse lobe then lies below
//                   a rough interface: the albedo of its reflection takes the place of R. What a
//                   rough refraction loses stays lost
//   coat            GK_CLEARCOAT: gk_coat.h, over all of these
// Below GK_ALPHA_DELTA reflection and refraction are delta lobes: never a value of f, only a
// weight of a sample.
// GK_SPECULAR: R = specular (F + k (1-F)), F Fresnel's exact curve and k such that it starts at
// min(F0 specular_color, 1), as KHR_materials_specular has it; all of what is totally reflected.
// GK_COLLIMATION: the refraction has a roughness of its own, at least that of the reflection. It
// then takes 1 - max(F) over o, i and the facet, since the smoother reflection has taken F(o); equal
// indices still pass everything straight on.
//
// Sources: glTF 2.0 appendix B; Walter et al. 2007 (refraction); Heitz 2014 (masking); Dupuy and
// Benyoub 2023 (visible normals); Ashikhmin and Shirley 2000, after Shirley et al. 1997 (the diffuse
// coupling); Kulla and Conty 2017 (multiple scattering).
#ifndef GK_BSDF_H
#define GK_BSDF_H

#include "kernels/gk_coat.h"
#include "kernels/gk_energy.h"
#include "kernels/gk_fresnel.h"
#include "kernels/gk_ggx.h"

struct gk_surface {
    struct gk_vec base;
    gk_f32 metallic, transmission;
    gk_f32 alpha;        // roughness squared
    gk_f32 eta;          // index on the far side over index on the side of wo
    gk_f32 fresnel_mean; // of the dielectric, from outside
    gk_i32 thin;
    gk_i32 inside;                  // wo is inside of a solid; under GK_CLEARCOAT
    gk_f32 specular;                // under GK_SPECULAR
    struct gk_vec specular_color;   // under GK_SPECULAR
    gk_f32 collimation;             // under GK_COLLIMATION
    struct gk_coat coat;            // under GK_CLEARCOAT
    const GK_GLOBAL gk_f32 *energy; // table of gk_energy.h, under GK_CLEARCOAT and GK_MULTISCATTER
    gk_i32 interface; // part of the table that is the dielectric's from outside, 0: none

    // Prepared for wo:
    struct gk_vec tint;        // k
    gk_f32 fresnel_o;          // of the dielectric at wo.z
    gk_f32 p_diffuse;          // probability of choosing the diffuse lobe
    gk_f32 p_facet;            // of reflection and refraction
    gk_f32 alpha_t;            // of the refraction
    gk_f32 p_reflect;          // of reflection among p_facet, where `scatters`
    struct gk_vec again;       // multiple scattering over (1-E(i)) cos/pi
    struct gk_vec again_below; // of the dielectric, the share of 1-E that it returns
    struct gk_vec below_o;     // (1-A(o)) / (1-Amean) of a rough interface, A its albedo
    gk_i32 rough;              // the diffuse lobe is below a rough interface
    gk_i32 delta, delta_t;     // reflection, refraction is a delta lobe
    gk_i32 scatters;           // alpha_t > alpha
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

#ifdef GK_MICROFACET

// R where Fresnel's curve is at f; of its mean for the mean of f.
GK_INLINE struct gk_vec gk_dielectric(const struct gk_surface *s, gk_f32 f)
{
#ifdef GK_SPECULAR
    const struct gk_vec raised = gk_along(gk_splat(f), s->tint, 1.0f - f);
    const struct gk_vec tinted =
        gk_vec(s->specular * gk_max(raised.x, 0.0f), s->specular * gk_max(raised.y, 0.0f),
               s->specular * gk_max(raised.z, 0.0f));
    return gk_vec_select(tinted, gk_splat(1.0f), f >= 1.0f && s->eta < 1.0f);
#else
    (void)s;
    return gk_splat(f);
#endif
}

GK_INLINE void gk_specular_prepare(struct gk_surface *s)
{
#ifdef GK_SPECULAR
    const gk_f32 root = (s->eta - 1.0f) / (s->eta + 1.0f);
    const gk_f32 f0 = root * root;
    const gk_f32 scale = 1.0f / (1.0f - f0);
    s->tint = gk_vec((gk_min(f0 * s->specular_color.x, 1.0f) - f0) * scale,
                     (gk_min(f0 * s->specular_color.y, 1.0f) - f0) * scale,
                     (gk_min(f0 * s->specular_color.z, 1.0f) - f0) * scale);
#else
    (void)s;
#endif
}

// What the refraction's own roughness makes of it; reflect, refract: mean albedos at wo.
GK_INLINE void gk_collimation_prepare(struct gk_surface *s, gk_f32 reflect, gk_f32 refract)
{
#ifdef GK_COLLIMATION
    s->alpha_t = gk_max(s->alpha, 1.0f - s->collimation);
    s->p_reflect = refract > 0.0f ? reflect / (reflect + refract) : 1.0f;
#else
    (void)reflect;
    (void)refract;
    s->alpha_t = s->alpha;
    s->p_reflect = 1.0f;
#endif
    s->scatters = s->alpha_t > s->alpha;
    s->delta_t = s->alpha_t < GK_ALPHA_DELTA;
}

#ifdef GK_MULTISCATTER
// Reflectance of a dielectric where `white` of a white one is reflected and `part` with the exact
// curve alone: R is linear in F.
GK_INLINE struct gk_vec gk_rough_dielectric(const struct gk_surface *s, gk_f32 white, gk_f32 part)
{
#ifdef GK_SPECULAR
    const struct gk_vec r = gk_along(gk_splat(part), s->tint, white - part);
    return gk_vec(s->specular * gk_max(r.x, 0.0f), s->specular * gk_max(r.y, 0.0f),
                  s->specular * gk_max(r.z, 0.0f));
#else
    (void)s;
    (void)white;
    return gk_splat(part);
#endif
}

// Share of what one reflection loses that further ones return: R^2 Emean / (1 - R (1-Emean)).
GK_INLINE struct gk_vec gk_multiple_tint(struct gk_vec r, gk_f32 mean)
{
    const gk_f32 loss = 1.0f - mean;
    return gk_vec(r.x * r.x * mean / (1.0f - r.x * loss), r.y * r.y * mean / (1.0f - r.y * loss),
                  r.z * r.z * mean / (1.0f - r.z * loss));
}

// Albedo of all that the rough interface reflects.
GK_INLINE struct gk_vec gk_interface_albedo(const struct gk_surface *s, gk_f32 cosine)
{
    const gk_f32 white = gk_energy_albedo(s->energy, GK_ENERGY_WHITE, cosine, s->alpha);
    const gk_f32 part = gk_energy_albedo(s->energy, s->interface, cosine, s->alpha);
    return gk_along(gk_rough_dielectric(s, white, part), s->again_below, 1.0f - white);
}

// Albedo of multiple scattering, of which `again` is the part that does not depend on wi: Kulla and
// Conty 2017, (1-E(o))(1-E(i)) / (pi (1-Emean)), for metal and for opaque dielectric.
GK_INLINE gk_f32 gk_multiple_prepare(struct gk_surface *s, gk_f32 cos_o)
{
    const gk_f32 mean = gk_energy_mean(s->energy, GK_ENERGY_WHITE, s->alpha);
    const gk_f32 part = gk_energy_mean(s->energy, s->interface, s->alpha);
    const gk_f32 white_o = gk_energy_albedo(s->energy, GK_ENERGY_WHITE, cos_o, s->alpha);
    const struct gk_vec fm =
        gk_along(gk_scale(s->base, 20.0f / 21.0f), gk_splat(1.0f / 21.0f), 1.0f);
    const gk_f32 opaque = (1.0f - s->metallic) * (1.0f - s->transmission);
    s->again_below = gk_multiple_tint(gk_dielectric(s, s->fresnel_mean), mean);
    const struct gk_vec tint =
        gk_along(gk_scale(gk_multiple_tint(fm, mean), s->metallic), s->again_below, opaque);
    const gk_f32 loss_o = s->delta ? 0.0f : 1.0f - white_o;
    s->again = gk_scale(tint, loss_o / gk_max(1.0f - mean, 1e-6f));
    s->rough = !s->delta && s->eta > 1.0f && s->interface > 0;
    const struct gk_vec o = gk_interface_albedo(s, cos_o);
    const struct gk_vec all =
        gk_along(gk_rough_dielectric(s, mean, part), s->again_below, 1.0f - mean);
    s->below_o = gk_vec((1.0f - o.x) / gk_max(1.0f - all.x, 1e-6f),
                        (1.0f - o.y) / gk_max(1.0f - all.y, 1e-6f),
                        (1.0f - o.z) / gk_max(1.0f - all.z, 1e-6f));
    return gk_mean3(tint) * loss_o;
}
#endif

// Probabilities in proportion to the albedos of the lobes, each at least where one of its colours
// has something.
GK_INLINE void gk_lobes_prepare(struct gk_surface *s, struct gk_vec wo)
{
    const gk_f32 cos_o = gk_min(wo.z, 1.0f);
    const struct gk_vec fm = gk_fresnel_metal(s->base, cos_o);
    s->fresnel_o = gk_fresnel_dielectric(cos_o, s->eta);
    gk_specular_prepare(s);
    s->delta = s->alpha < GK_ALPHA_DELTA;
    struct gk_vec r = gk_dielectric(s, s->fresnel_o);
#ifdef GK_MULTISCATTER
    const gk_f32 again = gk_multiple_prepare(s, cos_o);
    r = gk_vec_select(r, gk_interface_albedo(s, cos_o), s->rough);
#endif
    const gk_f32 least = gk_min(r.x, gk_min(r.y, r.z));
    const gk_f32 below = (1.0f - s->metallic) * (1.0f - least) * gk_mean3(s->base);
    const gk_f32 refract = below * s->transmission;
    const gk_f32 mirror = s->metallic * gk_mean3(fm);
    const gk_f32 gloss = (1.0f - s->metallic) * gk_max3(r);
    gk_collimation_prepare(s, mirror + gloss, refract);
    gk_f32 diffuse = below * (1.0f - s->transmission);
    const gk_f32 other = refract + mirror + gloss;
#ifdef GK_MULTISCATTER
    diffuse += again;
#endif
#ifdef GK_CLEARCOAT
    gk_coat_prepare(&s->coat, s->energy, wo);
    s->coat.albedo_o = s->inside ? 0.0f : s->coat.albedo_o;
    const gk_f32 coat = s->coat.albedo_o, passed = 1.0f - coat;
    const gk_f32 sum = (diffuse + other) * passed + coat;
    s->p_diffuse = sum > 0.0f ? diffuse * passed / sum : 1.0f;
    s->coat.p = sum > 0.0f ? coat / sum : 0.0f;
    s->p_facet = 1.0f - s->p_diffuse - s->coat.p;
#else
    const gk_f32 sum = diffuse + other;
    s->p_diffuse = sum > 0.0f ? diffuse / sum : 1.0f;
    s->p_facet = 1.0f - s->p_diffuse;
#endif
}

#endif

// Completes a surface for the direction wo.
GK_INLINE void gk_surface_prepare(struct gk_surface *s, struct gk_vec wo)
{
#ifdef GK_MICROFACET
    gk_lobes_prepare(s, wo);
#else
    (void)wo;
    s->fresnel_o = 0.0f;
    s->p_diffuse = 1.0f;
    s->p_facet = 0.0f;
    s->delta = s->delta_t = 0;
#endif
}

GK_INLINE struct gk_vec gk_diffuse_coupling(const struct gk_surface *s, gk_f32 cos_i)
{
#ifdef GK_MICROFACET
    const struct gk_vec o = gk_dielectric(s, s->fresnel_o);
    const struct gk_vec i = gk_dielectric(s, gk_fresnel_dielectric(cos_i, s->eta));
    const struct gk_vec mean = gk_dielectric(s, s->fresnel_mean);
    const struct gk_vec smooth = gk_vec((1.0f - o.x) * (1.0f - i.x) / gk_max(1.0f - mean.x, 1e-6f),
                                        (1.0f - o.y) * (1.0f - i.y) / gk_max(1.0f - mean.y, 1e-6f),
                                        (1.0f - o.z) * (1.0f - i.z) / gk_max(1.0f - mean.z, 1e-6f));
#ifdef GK_MULTISCATTER
    const struct gk_vec a = gk_interface_albedo(s, gk_min(cos_i, 1.0f));
    const struct gk_vec rough = gk_vec(s->below_o.x * (1.0f - a.x), s->below_o.y * (1.0f - a.y),
                                       s->below_o.z * (1.0f - a.z));
    return gk_vec_select(smooth, rough, s->rough);
#else
    return smooth;
#endif
#else
    (void)s;
    (void)cos_i;
    return gk_splat(1.0f);
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
    return m;
}

// What a facet under cos_m refracts towards wi, on the far side under |cos| cos_i.
GK_INLINE struct gk_vec gk_facet_through(const struct gk_surface *s, const struct gk_facet *m,
                                         gk_f32 cos_m, gk_f32 cos_i)
{
#ifdef GK_COLLIMATION
    const gk_f32 fm = gk_fresnel_dielectric(cos_m, s->eta);
    const gk_f32 fi = gk_fresnel_dielectric(cos_i, s->thin ? s->eta : 1.0f / s->eta);
    const struct gk_vec r = gk_dielectric(s, gk_max(fm, gk_max(fi, s->fresnel_o)));
    const gk_f32 share = (1.0f - s->metallic) * s->transmission;
    const struct gk_vec least =
        gk_mul(s->base, gk_vec(share * (1.0f - r.x), share * (1.0f - r.y), share * (1.0f - r.z)));
    return gk_vec_select(m->refract, least, s->scatters);
#else
    (void)s;
    (void)cos_m;
    (void)cos_i;
    return m->refract;
#endif
}

// An interface between equal indices passes everything straight on, however rough: a delta lobe.
GK_INLINE gk_i32 gk_surface_matched(const struct gk_surface *s)
{
    return !s->thin && gk_abs(s->eta - 1.0f) < 1e-4f;
}

GK_INLINE void gk_facet_eval(const struct gk_surface *s, struct gk_vec wo, struct gk_vec wi,
                             struct gk_bsdf_value *value)
{
    const gk_i32 same = wi.z > 0.0f;
    const gk_f32 alpha = same ? s->alpha : s->alpha_t;
    const gk_f32 a2 = alpha * alpha;
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
    const gk_f32 cos_m = gk_clamp(ho, 0.0f, 1.0f);
    const struct gk_facet m = gk_facet_make(s, cos_m);

    gk_f32 f = 0.25f * d * masked, pdf = 0.25f * d * visible;
    gk_i32 valid = ho > 0.0f && !(same ? s->delta : s->delta_t);
#ifdef GK_TRANSMISSION
    const gk_f32 base = hi + ho / s->eta;
    const gk_f32 jacobian = gk_abs(hi) / gk_max(base * base, 1e-30f);
    f = bent ? d * masked * ho * jacobian / (s->eta * s->eta) : f;
    pdf = bent ? d * visible * ho * jacobian : pdf;
    valid = valid && (!bent || (hi < 0.0f && !gk_surface_matched(s)));
    const struct gk_vec albedo =
        gk_vec_select(gk_facet_through(s, &m, cos_m, gk_min(zi, 1.0f)), m.reflect, same);
    const gk_f32 chosen = same ? m.p_reflect : 1.0f - m.p_reflect;
#else
    const struct gk_vec albedo = m.reflect;
    const gk_f32 chosen = m.p_reflect;
    valid = valid && same;
#endif
    f = valid ? f : 0.0f;
    value->f = gk_along(value->f, albedo, f);
    value->pdf += valid ? s->p_facet * chosen * pdf : 0.0f;
}

GK_INLINE void gk_facet_sample(const struct gk_surface *s, struct gk_vec wo, gk_f32 u_lobe,
                               gk_f32 u, gk_f32 v, struct gk_bsdf_sample *out)
{
    const struct gk_vec n = gk_vec(0.0f, 0.0f, 1.0f);
#ifdef GK_COLLIMATION
    const gk_i32 scattered = s->scatters && u_lobe >= s->p_reflect;
    const gk_i32 smooth = scattered ? s->delta_t : s->delta;
    const struct gk_vec rough = gk_ggx_sample(wo, scattered ? s->alpha_t : s->alpha, u, v);
#else
    const gk_i32 smooth = s->delta;
    const struct gk_vec rough = gk_ggx_sample(wo, s->alpha, u, v);
#endif
    const struct gk_vec h = gk_vec_select(rough, n, smooth);
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
    out->delta = smooth || (!reflect && gk_surface_matched(s));
#else
    (void)u_lobe;
    out->wi = reflected;
    out->weight = gk_scale(m.reflect, 1.0f / gk_max(p * m.p_reflect, 1e-20f));
    out->delta = smooth;
#endif
}

#ifdef GK_MULTISCATTER
// Multiple scattering joins the diffuse lobe, whose density is already counted.
GK_INLINE struct gk_vec gk_multiple_eval(const struct gk_surface *s, gk_f32 cos_i)
{
    const gk_f32 loss_i =
        1.0f - gk_energy_albedo(s->energy, GK_ENERGY_WHITE, gk_min(cos_i, 1.0f), s->alpha);
    return gk_scale(s->again, loss_i * cos_i * (1.0f / GK_PI));
}
#endif

#ifdef GK_CLEARCOAT
// Whether wi leaves on the side of the coat: that of the open space where the surface bounds a solid.
GK_INLINE gk_i32 gk_coat_faces(const struct gk_surface *s, struct gk_vec wi)
{
    const gk_i32 solid = s->transmission > 0.0f && !s->thin;
    return wi.z > 0.0f ? !s->inside : (!solid || s->inside);
}

GK_INLINE void gk_coat_cover(const struct gk_surface *s, struct gk_vec wi,
                             struct gk_bsdf_value *value)
{
    gk_f32 pdf;
    const gk_f32 f = gk_coat_eval(&s->coat, wi, &pdf);
    const gk_f32 passed = gk_coat_passes(&s->coat, s->energy, wi, gk_coat_faces(s, wi));
    value->f = gk_along(gk_splat(f), value->f, passed);
    value->pdf += s->coat.p * pdf;
}

GK_INLINE void gk_coat_take(const struct gk_surface *s, gk_i32 coat, gk_f32 u, gk_f32 v,
                            struct gk_bsdf_sample *out)
{
    gk_f32 weight;
    const struct gk_vec wi = gk_coat_sample(&s->coat, u, v, &weight);
    const gk_f32 passed = gk_coat_passes(&s->coat, s->energy, out->wi, gk_coat_faces(s, out->wi));
    out->wi = gk_vec_select(out->wi, wi, coat);
    out->weight = gk_vec_select(gk_scale(out->weight, passed), gk_splat(weight), coat);
    out->delta = coat ? s->coat.alpha < GK_ALPHA_DELTA : out->delta;
}
#endif

#endif // GK_MICROFACET

// f |wi.z| and the pdf with which gk_bsdf_sample would take wi. Delta lobes contribute nothing.
GK_INLINE struct gk_bsdf_value gk_bsdf_eval(const struct gk_surface *s, struct gk_vec wo,
                                            struct gk_vec wi)
{
    const gk_f32 z = gk_max(wi.z, 0.0f) * (1.0f / GK_PI);
    const gk_f32 share = (1.0f - s->metallic) * (1.0f - s->transmission);
    struct gk_bsdf_value value;
    const struct gk_vec coupled = gk_diffuse_coupling(s, gk_max(wi.z, 0.0f));
    value.f = gk_mul(s->base, gk_scale(coupled, share * z));
    value.pdf = s->p_diffuse * z;
#ifdef GK_MICROFACET
#ifdef GK_MULTISCATTER
    value.f = gk_add(value.f, gk_multiple_eval(s, gk_max(wi.z, 0.0f)));
#endif
    gk_facet_eval(s, wo, wi, &value);
#ifdef GK_CLEARCOAT
    gk_coat_cover(s, wi, &value);
#endif
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
    const gk_f32 rest = (u_lobe - s->p_diffuse) / gk_max(s->p_facet, 1e-20f);
    gk_facet_sample(s, wo, rest, u, v, &out);
    out.wi = gk_vec_select(out.wi, cosine_wi, diffuse);
    out.delta = out.delta && !diffuse;
#ifdef GK_CLEARCOAT
    gk_coat_take(s, u_lobe >= 1.0f - s->coat.p && s->coat.p > 0.0f, u, v, &out);
#endif
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
