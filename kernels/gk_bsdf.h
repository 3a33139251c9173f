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
//                   transmitting surface loses is made up for by gk_pair.h
//   coat            GK_CLEARCOAT: gk_coat.h, over all of these
// Below GK_ALPHA_DELTA reflection and refraction are delta lobes: never a value of f, only a
// weight of a sample.
// GK_SPECULAR: R = specular (F + k (1-F)), F Fresnel's exact curve and k such that it starts at
// min(F0 specular_color, 1), as KHR_materials_specular has it; all of what is totally reflected.
// GK_COLLIMATION: gk_scatter.h takes the place of the refraction where that has a roughness of its
// own, which is above that of the reflection.
//
// Sources: glTF 2.0 appendix B; Walter et al. 2007 (refraction); Heitz 2014 (masking); Dupuy and
// Benyoub 2023 (visible normals); Ashikhmin and Shirley 2000, after Shirley et al. 1997 (the diffuse
// coupling); Kulla and Conty 2017 (multiple scattering). gk_facet.h, gk_scatter.h and gk_coat.h have
// the lobes; gk_lobes.h what they share.
#ifndef GK_BSDF_H
#define GK_BSDF_H

#include "kernels/gk_facet.h"

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

#ifdef GK_MULTISCATTER
// Multiple scattering joins the diffuse lobe, whose density is already counted.
GK_INLINE struct gk_vec gk_multiple_eval(const struct gk_surface *s, gk_f32 cos_i)
{
    const gk_f32 loss_i =
        1.0f - gk_energy_albedo(&s->energy, GK_ENERGY_WHITE, gk_min(cos_i, 1.0f), s->alpha);
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
    const gk_f32 passed = gk_coat_passes(&s->coat, &s->energy, wi, gk_coat_faces(s, wi));
    value->f = gk_along(gk_splat(f), value->f, passed);
    value->pdf += s->coat.p * pdf;
}

GK_INLINE void gk_coat_take(const struct gk_surface *s, gk_i32 coat, gk_f32 u, gk_f32 v,
                            struct gk_bsdf_sample *out)
{
    gk_f32 weight;
    const struct gk_vec wi = gk_coat_sample(&s->coat, u, v, &weight);
    const gk_f32 passed = gk_coat_passes(&s->coat, &s->energy, out->wi, gk_coat_faces(s, out->wi));
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
