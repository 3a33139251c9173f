// gk_ggx.h - the Trowbridge-Reitz distribution of normals, and refraction at one of them.
//
// Sources: Walter et al. 2007 (refraction); Heitz 2014 (masking); Dupuy and Benyoub 2023 (visible
// normals by spherical caps).
#ifndef GK_GGX_H
#define GK_GGX_H

#include "kernels/gk_vec.h"

// Below it reflection and refraction are delta lobes.
#define GK_ALPHA_DELTA 1e-3f

// Density of normals; hx^2+hy^2 instead of 1-hz^2 keeps narrow lobes exact.
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

// Direction refracted at the normal h, cos_m = wo.h > 0; eta: index beyond over that before. g is
// eta cos of the refracted ray, in the form that does not cancel for eta near 1; g^2 < 0, total
// reflection, is clamped: the caller never takes it there.
GK_INLINE struct gk_vec gk_refract(struct gk_vec wo, struct gk_vec h, gk_f32 cos_m, gk_f32 eta)
{
    const gk_f32 g2 = (eta - 1.0f) * (eta + 1.0f) + cos_m * cos_m;
    const gk_f32 along_h = cos_m - gk_sqrt(gk_max(g2, 0.0f));
    return gk_scale(gk_along(gk_negate(wo), h, along_h), 1.0f / eta);
}

#endif
