// gk_fresnel.h - reflectance of smooth interfaces.
#ifndef GK_FRESNEL_H
#define GK_FRESNEL_H

#include "kernels/gk_vec.h"

// Unpolarised reflectance of a dielectric. cos_i: 0..1; eta: index beyond the interface over the
// index before it, > 0. 1 at and beyond total reflection, exactly 0 for eta = 1. Exact to 8u for a
// cos_i and eta within 4u of the given ones, u = 2^-24: at the edge of total reflection the slope
// has no bound. Source: Fresnel's equations, multiplied by eta; g is eta cos of the refracted ray.
GK_INLINE gk_f32 gk_fresnel_dielectric(gk_f32 cos_i, gk_f32 eta)
{
    const gk_f32 g2 = (eta - 1.0f) * (eta + 1.0f) + cos_i * cos_i;
    const gk_f32 g = gk_sqrt(gk_max(g2, 0.0f));
    const gk_f32 scaled = eta * eta * cos_i;
    const gk_f32 s = (cos_i - g) / gk_max(cos_i + g, 1e-20f);
    const gk_f32 p = (scaled - g) / gk_max(scaled + g, 1e-20f);
    return g2 < 0.0f ? 1.0f : 0.5f * (s * s + p * p);
}

// Schlick's interpolation towards white, as glTF 2.0 appendix B prescribes for metals.
GK_INLINE struct gk_vec gk_fresnel_metal(struct gk_vec base, gk_f32 cos_i)
{
    const gk_f32 x = gk_max(1.0f - cos_i, 0.0f);
    const gk_f32 x5 = x * x * x * x * x;
    return gk_vec(base.x + (1.0f - base.x) * x5, base.y + (1.0f - base.y) * x5,
                  base.z + (1.0f - base.z) * x5);
}

#endif
