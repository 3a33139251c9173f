// gk_coat.h - a clear coat over a surface (KHR_materials_clearcoat): f, sample and pdf.
//
// A dielectric of index 1.5 with a roughness and a normal of its own. What lies below shows through
// it with 1 - max(A(o), A(i)), A the coat's directional albedo: reciprocal, and together never more
// than 1, for the coat gives back A(o). The extension's own (1 - F(o)) is not reciprocal.
// Only outside: where wo is inside of a solid the coat is behind the interface.
#ifndef GK_COAT_H
#define GK_COAT_H

#include "kernels/gk_energy.h"
#include "kernels/gk_fresnel.h"
#include "kernels/gk_ggx.h"

#define GK_COAT_ETA 1.5f

struct gk_coat {
    gk_f32 weight; // 0: none
    gk_f32 alpha;
    struct gk_onb frame; // around its normal, on the side of wo, in the frame of the surface
    // Prepared for wo:
    struct gk_vec wo; // in its frame
    gk_f32 albedo_o;
    gk_f32 p; // probability of choosing it
};

// Share of the light at `cosine` that the coat sends back.
GK_INLINE gk_f32 gk_coat_albedo(const struct gk_coat *c, const struct gk_energy_table *energy,
                                gk_f32 cosine)
{
    const gk_f32 z = gk_saturate(cosine);
    const gk_f32 smooth = gk_fresnel_dielectric(z, GK_COAT_ETA);
    const gk_f32 rough = gk_energy_albedo(energy, GK_ENERGY_COAT, z, c->alpha);
    return c->weight * (c->alpha < GK_ALPHA_DELTA ? smooth : rough);
}

GK_INLINE void gk_coat_prepare(struct gk_coat *c, const struct gk_energy_table *energy,
                               struct gk_vec wo)
{
    c->wo = gk_to_local(c->frame, wo);
    c->wo.z = gk_max(c->wo.z, 1e-6f);
    c->albedo_o = gk_coat_albedo(c, energy, c->wo.z);
}

// Share of what lies below that is seen at wi. outside: whether wi is on the coat's side of a solid.
GK_INLINE gk_f32 gk_coat_passes(const struct gk_coat *c, const struct gk_energy_table *energy,
                                struct gk_vec wi, gk_i32 outside)
{
    const gk_f32 albedo_i = gk_coat_albedo(c, energy, gk_abs(gk_dot(wi, c->frame.n)));
    return 1.0f - gk_max(c->albedo_o, outside ? albedo_i : 0.0f);
}

// f times the cosine with the coat's normal, and the density of its lobe; wi in the surface's frame.
GK_INLINE gk_f32 gk_coat_eval(const struct gk_coat *c, struct gk_vec wi, gk_f32 *pdf)
{
    const struct gk_vec i = gk_to_local(c->frame, wi);
    const struct gk_vec sum = gk_add(c->wo, i);
    const gk_f32 length = gk_sqrt(gk_dot(sum, sum));
    const struct gk_vec h = gk_scale(sum, 1.0f / gk_max(length, 1e-20f));
    const gk_f32 a2 = c->alpha * c->alpha;
    const gk_f32 so = gk_ggx_s(c->wo.z, a2), si = gk_ggx_s(i.z, a2);
    const gk_f32 d = 0.25f * gk_ggx_d(h, a2);
    const gk_f32 fresnel = gk_fresnel_dielectric(gk_clamp(0.5f * length, 0.0f, 1.0f), GK_COAT_ETA);
    const gk_i32 valid =
        c->p > 0.0f && c->alpha >= GK_ALPHA_DELTA && wi.z > 0.0f && i.z > 0.0f && length > 0.0f;
    *pdf = valid ? d * 2.0f / (c->wo.z + so) : 0.0f;
    return valid ? c->weight * fresnel * d * 2.0f * i.z / (so * i.z + si * c->wo.z) : 0.0f;
}

// A direction in the surface's frame; *weight is f |cos| / pdf of the delta lobe that it is where
// alpha < GK_ALPHA_DELTA. Zero where it would leave on the wrong side.
GK_INLINE struct gk_vec gk_coat_sample(const struct gk_coat *c, gk_f32 u, gk_f32 v, gk_f32 *weight)
{
    const gk_i32 delta = c->alpha < GK_ALPHA_DELTA;
    const struct gk_vec h =
        gk_vec_select(gk_ggx_sample(c->wo, c->alpha, u, v), gk_vec(0.0f, 0.0f, 1.0f), delta);
    const struct gk_vec i = gk_sub(gk_scale(h, 2.0f * gk_dot(c->wo, h)), c->wo);
    const struct gk_vec wi = gk_to_world(c->frame, i);
    *weight =
        c->weight * gk_fresnel_dielectric(gk_saturate(c->wo.z), GK_COAT_ETA) / gk_max(c->p, 1e-20f);
    return gk_vec_select(gk_splat(0.0f), wi, i.z > 0.0f && wi.z > 0.0f);
}

#endif
