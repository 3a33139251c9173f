// gk_surface.h - what a hit's material says there: the surface for the BSDF, and what it emits.
#ifndef GK_SURFACE_H
#define GK_SURFACE_H

#include "kernels/gk_bsdf.h"
#include "kernels/gk_hit.h"

#ifdef GK_VERTEX_COLOURS
// Linear colour and opacity at barycentrics (u, v) of a record, between those of its vertices.
GK_INLINE struct gk_texel gk_vertex_colour(const struct gk_resident *r, gk_u32 triangle, gk_f32 u,
                                           gk_f32 v)
{
    const gk_i32 has = (GK_TRIANGLE(r, triangle, flags) & GK_TRIANGLE_COLOURED) != 0u;
    const GK_GLOBAL gk_f32 *c = r->colour[has ? triangle : 0u].rgba;
    const gk_f32 w = 1.0f - u - v;
    const struct gk_vec rgb = gk_vec(w * c[0] + u * c[4] + v * c[8], w * c[1] + u * c[5] + v * c[9],
                                     w * c[2] + u * c[6] + v * c[10]);
    const gk_f32 a = w * c[3] + u * c[7] + v * c[11];
    struct gk_texel t;
    t.r = has ? rgb.x : 1.0f;
    t.g = has ? rgb.y : 1.0f;
    t.b = has ? rgb.z : 1.0f;
    t.a = has ? a : 1.0f;
    return t;
}
#endif

// Share of the surface that is there at barycentrics (u, v) of a record: what alpha modes mask and
// blend look at.
GK_INLINE gk_f32 gk_surface_opacity(const struct gk_resident *r, gk_u32 material, gk_u32 triangle,
                                    gk_f32 u, gk_f32 v)
{
    gk_f32 opacity = GK_MATERIAL(r, material, opacity);
#ifdef GK_TEXTURES
    opacity *= gk_texture_at(&r->textures, GK_MATERIAL(r, material, base_texture), GK_TEXELS_COLOUR,
                             gk_coordinates_at(r, triangle, u, v))
                   .a;
#endif
#ifdef GK_VERTEX_COLOURS
    opacity *= gk_vertex_colour(r, triangle, u, v).a;
#endif
    (void)triangle;
    (void)u;
    (void)v;
    return opacity;
}

// Radiance that the hit emits towards the ray's origin.
GK_INLINE struct gk_vec gk_hit_emission(const struct gk_resident *r, const struct gk_hit *hit)
{
    const gk_u32 m = hit->material;
    struct gk_vec L = GK_TRIPLE(GK_MATERIAL, r, m, emission, 0);
#if defined(GK_TEXTURES) && defined(GK_EMISSION_TEXTURES)
    const struct gk_texel e =
        gk_texture_at(&r->textures, GK_MATERIAL(r, m, emission_texture), GK_TEXELS_COLOUR, hit->at);
    L = gk_mul(L, gk_vec(e.r, e.g, e.b));
#endif
    const gk_i32 both = (GK_MATERIAL(r, m, flags) & GK_MATERIAL_TWO_SIDED_EMISSION) != 0u;
    const gk_i32 shows = (hit->cos_g <= 0.0f) | both;
    return gk_vec_select(gk_splat(0.0f), L, shows);
}

#ifdef GK_SPECULAR
GK_INLINE void gk_surface_specular(const struct gk_resident *r, const struct gk_hit *hit,
                                   struct gk_surface *s)
{
    const gk_u32 m = hit->material;
    s->specular = GK_MATERIAL(r, m, specular);
    s->specular_color = GK_TRIPLE(GK_MATERIAL, r, m, specular_color, 0);
#if defined(GK_TEXTURES) && defined(GK_LAYER_TEXTURES)
    s->specular *=
        gk_texture_at(&r->textures, GK_MATERIAL(r, m, specular_texture), GK_TEXELS_NUMBERS, hit->at)
            .a;
    const struct gk_texel t = gk_texture_at(&r->textures, GK_MATERIAL(r, m, specular_color_texture),
                                            GK_TEXELS_COLOUR, hit->at);
    s->specular_color = gk_mul(s->specular_color, gk_vec(t.r, t.g, t.b));
#endif
}
#endif

#ifdef GK_CLEARCOAT
GK_INLINE void gk_surface_coat(const struct gk_resident *r, const struct gk_hit *hit,
                               struct gk_onb onb, struct gk_surface *s)
{
    const gk_u32 m = hit->material;
    gk_f32 roughness = GK_MATERIAL(r, m, coat_roughness);
    s->coat.weight = GK_MATERIAL(r, m, coat);
#if defined(GK_TEXTURES) && defined(GK_LAYER_TEXTURES)
    s->coat.weight *=
        gk_texture_at(&r->textures, GK_MATERIAL(r, m, coat_texture), GK_TEXELS_NUMBERS, hit->at).r;
    roughness *= gk_texture_at(&r->textures, GK_MATERIAL(r, m, coat_rough_texture),
                               GK_TEXELS_NUMBERS, hit->at)
                     .g;
#endif
    s->coat.alpha = roughness * roughness;
    s->coat.frame = gk_onb_make(gk_normalise(gk_to_local(onb, hit->nc)));
    s->inside = hit->cos_g > 0.0f && s->transmission > 0.0f && !s->thin;
}
#endif

// The surface at a hit, prepared for the direction back along the ray: wo in the frame `onb` around
// the shading normal.
GK_INLINE struct gk_surface gk_hit_surface(const struct gk_resident *r, const struct gk_hit *hit,
                                           struct gk_onb onb, struct gk_vec wo)
{
    const gk_u32 m = hit->material;
    struct gk_surface s;
    s.base = GK_TRIPLE(GK_MATERIAL, r, m, base, 0);
    s.metallic = GK_MATERIAL(r, m, metallic);
    gk_f32 roughness = GK_MATERIAL(r, m, roughness);
#ifdef GK_TEXTURES
    const struct gk_texel base =
        gk_texture_at(&r->textures, GK_MATERIAL(r, m, base_texture), GK_TEXELS_COLOUR, hit->at);
    s.base = gk_mul(s.base, gk_vec(base.r, base.g, base.b));
#endif
#if defined(GK_TEXTURES) && defined(GK_ROUGHNESS_TEXTURES)
    const struct gk_texel rough =
        gk_texture_at(&r->textures, GK_MATERIAL(r, m, rough_texture), GK_TEXELS_NUMBERS, hit->at);
    s.metallic *= rough.b;
    roughness *= rough.g;
#endif
#ifdef GK_VERTEX_COLOURS
    const struct gk_texel colour = gk_vertex_colour(r, hit->triangle, hit->u, hit->v);
    s.base = gk_mul(s.base, gk_vec(colour.r, colour.g, colour.b));
#endif
    s.alpha = roughness * roughness;
    s.fresnel_mean = GK_MATERIAL(r, m, fresnel_mean);
#ifdef GK_TRANSMISSION
    s.transmission = GK_MATERIAL(r, m, transmission);
#if defined(GK_TEXTURES) && defined(GK_LAYER_TEXTURES)
    s.transmission *= gk_texture_at(&r->textures, GK_MATERIAL(r, m, transmission_texture),
                                    GK_TEXELS_NUMBERS, hit->at)
                          .r;
#endif
#ifdef GK_COLLIMATION
    s.collimation = GK_MATERIAL(r, m, collimation);
#endif
    s.thin = (GK_MATERIAL(r, m, flags) & GK_MATERIAL_THIN) != 0u;
    const gk_i32 leaving = hit->cos_g > 0.0f && s.transmission > 0.0f && !s.thin;
    const gk_f32 ior = GK_MATERIAL(r, m, ior);
    s.eta = leaving ? 1.0f / ior : ior;
#ifdef GK_NESTED
    s.eta = hit->eta > 0.0f ? hit->eta : s.eta;
#endif
#else
    s.transmission = 0.0f;
    s.thin = 0;
    s.eta = GK_MATERIAL(r, m, ior);
#endif
    s.energy.entry = r->energy;
    s.energy.cut = r->textures.cut;
    s.interface = (gk_i32)GK_MATERIAL(r, m, energy);
#ifdef GK_NESTED
    s.interface = hit->eta > 0.0f ? 0 : s.interface; // another index than in the open
#endif
#ifdef GK_SPECULAR
    gk_surface_specular(r, hit, &s);
#endif
#ifdef GK_CLEARCOAT
    gk_surface_coat(r, hit, onb, &s);
#else
    (void)onb;
#endif
    gk_surface_prepare(&s, wo);
    return s;
}

#endif
