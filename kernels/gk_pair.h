// gk_pair.h - what a rough transmitting surface's reflection and transmission lose to further facets.
//
// Both are scaled by 1/E(o), E the albedo of the pair under a white base: what would meet further
// facets goes where the first one sends the rest. Exact to the table in a white furnace; not
// reciprocal, so for paths from the camera. The densities of samples stay. A thin wall's pair loses
// what a white reflector does; what gk_scatter.h takes has an albedo of its own. A solid inside of
// another is left as it is, for it has no table.
//
// Sources: Turquin 2019.
#ifndef GK_PAIR_H
#define GK_PAIR_H

#include "kernels/gk_lobes.h"

#if defined(GK_MICROFACET) && defined(GK_MULTISCATTER) && defined(GK_TRANSMISSION)
#define GK_PAIR 1
#endif

#ifdef GK_MICROFACET

// An interface between equal indices passes everything straight on, however rough: a delta lobe.
GK_INLINE gk_i32 gk_surface_matched(const struct gk_surface *s)
{
    return !s->thin && gk_abs(s->eta - 1.0f) < 1e-4f;
}

#endif

#ifdef GK_PAIR

// Albedos at wo: of a white reflector, of the reflection, of reflection and refraction, and of a
// white reflector and of the plain interface's transmission where gk_scatter.h takes it.
struct gk_pair {
    gk_f32 white, reflect, both, scatter_white, scatter;
};

GK_INLINE gk_f32 gk_pair_cosine(const struct gk_surface *s, gk_f32 cos_o)
{
    const gk_f32 n = s->thin ? 1.0f : gk_max(1.0f / s->eta, 1.0f);
    return gk_sqrt(gk_max((1.0f - n) * (1.0f + n) + n * n * cos_o * cos_o, 0.0f));
}

// Where the interface is not `known` all is looked up in the white part.
GK_INLINE struct gk_pair gk_pair_find(const struct gk_surface *s, gk_i32 known, gk_f32 cos_o)
{
    const gk_i32 inside = !s->thin && s->eta < 1.0f;
    const gk_i32 side = known ? s->interface + (inside ? GK_ENERGY_INSIDE : 0) : 0;
    const gk_i32 both = known ? side + GK_ENERGY_BOTH : 0;
    struct gk_pair p;
    p.white = gk_energy_albedo(s->energy, GK_ENERGY_WHITE, cos_o, s->alpha);
    p.reflect = gk_energy_albedo(s->energy, side, cos_o, s->alpha);
    p.both = gk_energy_albedo(s->energy, both, cos_o, s->alpha);
    p.white = s->delta ? 1.0f : p.white;
    p.reflect = s->delta ? s->fresnel_o : p.reflect;
    p.both = s->thin ? p.white : p.both;
    p.scatter_white = 0.0f;
    p.scatter = 0.0f;
#ifdef GK_COLLIMATION
    const gk_i32 part = known ? s->interface + GK_ENERGY_SCATTER : 0;
    const gk_f32 z = gk_pair_cosine(s, cos_o);
    const gk_f32 white = gk_energy_albedo(s->energy, GK_ENERGY_WHITE, z, s->alpha_t);
    const gk_f32 scatter = gk_energy_albedo(s->energy, part, z, s->alpha_t);
    p.scatter_white = z > 0.0f ? white : 0.0f;
    p.scatter = z > 0.0f ? scatter : 0.0f;
#endif
    return p;
}

// 1/E of one colour; k: gk_specular_prepare's. R is linear in F, so E follows from the plain
// interface's albedos; from inside that takes a guess at what is not totally reflected.
GK_INLINE gk_f32 gk_pair_gain(const struct gk_surface *s, const struct gk_pair *p, gk_f32 k)
{
#ifdef GK_SPECULAR
    const gk_f32 root = (s->eta - 1.0f) / (s->eta + 1.0f);
    const gk_f32 least = s->eta < 1.0f ? 1.0f - root * root : 0.1f;
    const gk_f32 open = p->white / gk_max(p->white - p->reflect, least * p->white);
    const gk_f32 kept = s->specular * (1.0f - k), lifted = 1.0f - s->specular;
#else
    const gk_f32 open = 1.0f, kept = 1.0f, lifted = 0.0f;
    (void)k;
#endif
    const gk_f32 ratio = open * lifted + kept; // of 1-R to that of the plain interface
    gk_f32 e = p->white + ratio * (p->both - p->white);
#ifdef GK_COLLIMATION
    const gk_f32 reflect = p->white - ratio * (p->white - p->reflect);
    e = s->scatters ? reflect + p->scatter_white * lifted + p->scatter * kept : e;
#endif
    return 1.0f / gk_clamp(e, 0.05f, 1.0f);
}

GK_INLINE void gk_pair_prepare(struct gk_surface *s, struct gk_vec wo)
{
    gk_i32 lossy = !s->delta && !gk_surface_matched(s);
#ifdef GK_COLLIMATION
    lossy = lossy || s->scatters;
#endif
    const gk_i32 known = s->transmission > 0.0f && s->interface > 0;
    const struct gk_pair p = gk_pair_find(s, known, gk_min(wo.z, 1.0f));
#ifdef GK_SPECULAR
    const struct gk_vec k = s->tint;
#else
    const struct gk_vec k = gk_splat(0.0f);
#endif
    const struct gk_vec gain =
        gk_vec(gk_pair_gain(s, &p, k.x), gk_pair_gain(s, &p, k.y), gk_pair_gain(s, &p, k.z));
    s->gain = gk_vec_select(gk_splat(1.0f), gain, lossy && known);
    const gk_f32 t = s->transmission;
    s->raise = gk_vec(1.0f + t * (s->gain.x - 1.0f), 1.0f + t * (s->gain.y - 1.0f),
                      1.0f + t * (s->gain.z - 1.0f));
}

#endif

// Completes a surface for the direction wo.
GK_INLINE void gk_surface_prepare(struct gk_surface *s, struct gk_vec wo)
{
#ifdef GK_MICROFACET
    gk_lobes_prepare(s, wo);
#ifdef GK_PAIR
    gk_pair_prepare(s, wo);
#endif
#else
    (void)wo;
    s->fresnel_o = 0.0f;
    s->p_diffuse = 1.0f;
    s->p_facet = 0.0f;
    s->delta = 0;
#endif
}

#endif
