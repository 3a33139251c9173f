// gk_lobes.h - a surface, and what its lobes have in common for one direction wo.
#ifndef GK_LOBES_H
#define GK_LOBES_H

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
    gk_i32 inside;                 // wo is inside of a solid; under GK_CLEARCOAT
    gk_f32 specular;               // under GK_SPECULAR
    struct gk_vec specular_color;  // under GK_SPECULAR
    gk_f32 collimation;            // under GK_COLLIMATION
    struct gk_coat coat;           // under GK_CLEARCOAT
    struct gk_energy_table energy; // of gk_energy.h, under GK_CLEARCOAT and GK_MULTISCATTER
    gk_i32 interface; // part of the table that is the dielectric's from outside, 0: none

    // Prepared for wo:
    struct gk_vec tint;        // k
    gk_f32 fresnel_o;          // of the dielectric at wo.z
    gk_f32 p_diffuse;          // probability of choosing the diffuse lobe
    gk_f32 p_facet;            // of reflection and refraction
    gk_f32 alpha_t;            // of what passes, where `scatters`
    gk_f32 p_reflect;          // of reflection among p_facet, where `scatters`
    struct gk_vec again;       // multiple scattering over (1-E(i)) cos/pi
    struct gk_vec again_below; // of the dielectric, the share of 1-E that it returns
    struct gk_vec below_o;     // (1-A(o)) / (1-Amean) of a rough interface, A its albedo
    struct gk_vec gain;        // of the pair of a transmitting surface, gk_pair.h
    struct gk_vec raise;       // of the dielectric's reflection: as far as the surface transmits
    gk_i32 rough;              // the diffuse lobe is below a rough interface
    gk_i32 delta;              // reflection and refraction are delta lobes
    gk_i32 scatters;           // what passes is left to gk_scatter.h
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
        gk_vec(s->specular * gk_saturate(raised.x), s->specular * gk_saturate(raised.y),
               s->specular * gk_saturate(raised.z));
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

#ifdef GK_COLLIMATION
// Whether what is refracted is scattered by gk_scatter.h; reflect, refract: mean albedos at wo, which
// know nothing of facets that reflect totally: hence a least share. gk_pair.h knows better.
GK_INLINE void gk_collimation_prepare(struct gk_surface *s, gk_f32 reflect, gk_f32 refract)
{
    s->alpha_t = gk_max(s->alpha, 1.0f - s->collimation);
    const gk_f32 share = refract > 0.0f ? reflect / (reflect + refract) : 1.0f;
    s->p_reflect = s->delta ? share : gk_max(share, 0.1f);
    s->scatters = s->alpha_t > s->alpha && s->alpha_t >= GK_ALPHA_DELTA;
}
#endif

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
GK_INLINE gk_f32 gk_multiple_share(gk_f32 r, gk_f32 mean)
{
    return r * r * mean / gk_max(1.0f - r * (1.0f - mean), 1e-6f);
}

GK_INLINE struct gk_vec gk_multiple_tint(struct gk_vec r, gk_f32 mean)
{
    return gk_vec(gk_multiple_share(r.x, mean), gk_multiple_share(r.y, mean),
                  gk_multiple_share(r.z, mean));
}

// Albedo of all that the rough interface reflects.
GK_INLINE struct gk_vec gk_interface_albedo(const struct gk_surface *s, gk_f32 cosine)
{
    const gk_f32 white = gk_energy_albedo(&s->energy, GK_ENERGY_WHITE, cosine, s->alpha);
    const gk_f32 part = gk_energy_albedo(&s->energy, s->interface, cosine, s->alpha);
    const struct gk_vec all =
        gk_along(gk_rough_dielectric(s, white, part), s->again_below, 1.0f - white);
    return gk_vec(gk_min(all.x, 1.0f), gk_min(all.y, 1.0f), gk_min(all.z, 1.0f));
}

// Albedo of multiple scattering, of which `again` is the part that does not depend on wi: Kulla and
// Conty 2017, (1-E(o))(1-E(i)) / (pi (1-Emean)), for metal and for opaque dielectric.
GK_INLINE gk_f32 gk_multiple_prepare(struct gk_surface *s, gk_f32 cos_o)
{
    const gk_f32 mean = gk_energy_mean(&s->energy, GK_ENERGY_WHITE, s->alpha);
    const gk_f32 part = gk_energy_mean(&s->energy, s->interface, s->alpha);
    const gk_f32 white_o = gk_energy_albedo(&s->energy, GK_ENERGY_WHITE, cos_o, s->alpha);
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
#ifdef GK_COLLIMATION
    gk_collimation_prepare(s, mirror + gloss, refract);
#endif
    gk_f32 diffuse = below * (1.0f - s->transmission);
    const gk_f32 other = refract + mirror + gloss;
#ifdef GK_MULTISCATTER
    diffuse += again;
#endif
#ifdef GK_CLEARCOAT
    gk_coat_prepare(&s->coat, &s->energy, wo);
    s->coat.albedo_o = s->inside ? 0.0f : s->coat.albedo_o;
    const gk_f32 coat = s->coat.albedo_o, passed = 1.0f - coat;
    const gk_f32 sum = (diffuse + other) * passed + coat;
    s->p_diffuse = sum > 0.0f ? diffuse * passed / sum : 1.0f;
    s->coat.p = sum > 0.0f ? coat / sum : 0.0f;
    s->p_facet = gk_max(1.0f - s->p_diffuse - s->coat.p, 0.0f);
#else
    const gk_f32 sum = diffuse + other;
    s->p_diffuse = sum > 0.0f ? diffuse / sum : 1.0f;
    s->p_facet = 1.0f - s->p_diffuse;
#endif
}

#endif

#endif
