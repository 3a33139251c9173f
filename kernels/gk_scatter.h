// gk_scatter.h - what a surface of low collimation transmits: f, sample and pdf.
//
// The wall is a rough reflection of alpha_t mirrored to the far side, in the optically thinner
// medium; where the surface bounds a solid, Snell's law leads from there to the direction inside. So
// all that enters is inside the cone that can leave again, and eta near 1 needs no other treatment
// than a thin wall. It takes 1 - max(R) over o, i and the facet, since the reflection, which keeps
// its own roughness, has taken R(o). Reciprocal up to eta^2, never more than 1.
#ifndef GK_SCATTER_H
#define GK_SCATTER_H

#include "kernels/gk_pair.h"

#if defined(GK_COLLIMATION) && defined(GK_MICROFACET)

// A unit direction whose part along the surface is n times as long, on the same side; z is 0 where
// there is none. From z, for at grazing angles 1 - x^2 - y^2 has few digits.
GK_INLINE struct gk_vec gk_bend(struct gk_vec w, gk_f32 n)
{
    const gk_f32 z2 = (1.0f - n) * (1.0f + n) + n * n * w.z * w.z;
    return gk_vec(w.x * n, w.y * n, gk_copysign(gk_sqrt(gk_max(z2, 0.0f)), w.z));
}

// Index of wi's and of wo's side over that of the thinner one.
GK_INLINE gk_f32 gk_dense_far(const struct gk_surface *s)
{
    return s->thin ? 1.0f : gk_max(s->eta, 1.0f);
}

GK_INLINE gk_f32 gk_dense_near(const struct gk_surface *s)
{
    return s->thin ? 1.0f : gk_max(1.0f / s->eta, 1.0f);
}

// Share that passes a facet under cos_m between directions under cos_o and cos_i.
GK_INLINE struct gk_vec gk_scatter_tint(const struct gk_surface *s, gk_f32 cos_m, gk_f32 cos_o,
                                        gk_f32 cos_i)
{
    const gk_f32 eta = s->thin ? s->eta : gk_max(s->eta, 1.0f / s->eta);
    const gk_f32 fm = gk_fresnel_dielectric(cos_m, eta);
    const gk_f32 fo = gk_fresnel_dielectric(cos_o, eta);
    const gk_f32 fi = gk_fresnel_dielectric(cos_i, eta);
    const struct gk_vec r = gk_dielectric(s, gk_max(fm, gk_max(fo, fi)));
    const gk_f32 share = (1.0f - s->metallic) * s->transmission;
    const struct gk_vec tint =
        gk_mul(s->base, gk_vec(share * (1.0f - r.x), share * (1.0f - r.y), share * (1.0f - r.z)));
#ifdef GK_PAIR
    return gk_mul(tint, s->gain);
#else
    return tint;
#endif
}

// Adds to *value; nothing where wi is on the side of wo.
GK_INLINE void gk_scatter_eval(const struct gk_surface *s, struct gk_vec wo, struct gk_vec wi,
                               struct gk_bsdf_value *value)
{
    const gk_f32 dense = gk_dense_far(s);
    const struct gk_vec o = gk_bend(wo, gk_dense_near(s)), i = gk_bend(wi, dense);
    const gk_f32 zo = gk_saturate(o.z), zi = gk_saturate(-i.z);
    const struct gk_vec sum = gk_add(o, gk_vec(i.x, i.y, -i.z));
    const gk_f32 length = gk_sqrt(gk_dot(sum, sum));
    const struct gk_vec h = gk_scale(sum, 1.0f / gk_max(length, 1e-20f));
    const gk_f32 a2 = s->alpha_t * s->alpha_t;
    const gk_f32 so = gk_ggx_s(zo, a2), si = gk_ggx_s(zi, a2), d = 0.25f * gk_ggx_d(h, a2);
    const gk_i32 valid = s->scatters && zo > 0.0f && zi > 0.0f && wi.z < 0.0f;
    // Solid angle in the thin medium over that in the dense one.
    const gk_f32 spread = dense > 1.0f ? dense * dense * gk_abs(wi.z) / gk_max(zi, 1e-20f) : 1.0f;
    const gk_f32 squeezed = s->thin ? 1.0f : 1.0f / (s->eta * s->eta);
    const gk_f32 f = d * 2.0f * zi / (so * zi + si * zo) * spread * squeezed;
    const gk_f32 pdf = d * 2.0f / (zo + so) * spread;
    const struct gk_vec tint = gk_scatter_tint(s, gk_min(0.5f * length, 1.0f), zo, zi);
    value->f = gk_along(value->f, tint, valid ? f : 0.0f);
    value->pdf += valid ? s->p_facet * (1.0f - s->p_reflect) * pdf : 0.0f;
}

GK_INLINE struct gk_vec gk_scatter_sample(const struct gk_surface *s, struct gk_vec wo, gk_f32 u,
                                          gk_f32 v)
{
    const struct gk_vec o = gk_bend(wo, gk_dense_near(s));
    const struct gk_vec h = gk_ggx_sample(o, s->alpha_t, u, v);
    const struct gk_vec r = gk_sub(gk_scale(h, 2.0f * gk_dot(o, h)), o);
    const struct gk_vec wi = gk_bend(gk_vec(r.x, r.y, -r.z), 1.0f / gk_dense_far(s));
    return gk_vec_select(gk_splat(0.0f), wi, r.z > 0.0f);
}

#endif

#endif
