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

// Albedos at wo: of a white reflector, of the reflection, of reflection and refraction, of a white
// reflector's facets that do not reflect totally, of what these would pass on if they reflected
// nothing less the same, and of a white reflector and of the plain interface's transmission where
// gk_scatter.h takes it.
struct gk_pair {
    gk_f32 white, reflect, both, open, spared, scatter_white, scatter;
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
    p.white = gk_energy_albedo(&s->energy, GK_ENERGY_WHITE, cos_o, s->alpha);
    p.reflect = gk_energy_albedo(&s->energy, side, cos_o, s->alpha);
    p.both = gk_energy_albedo(&s->energy, both, cos_o, s->alpha);
    p.white = s->delta ? 1.0f : p.white;
    p.reflect = s->delta ? s->fresnel_o : p.reflect;
    p.both = s->thin ? p.white : p.both;
    p.open = p.white;
    p.spared = 0.0f;
#ifdef GK_SPECULAR
    const gk_i32 rest = known ? side + GK_ENERGY_SPARED : 0;
    const gk_i32 below = known && inside ? s->interface + GK_ENERGY_OPEN : GK_ENERGY_WHITE;
    p.open = gk_energy_albedo(&s->energy, below, cos_o, s->alpha);
    p.open = s->delta ? (s->fresnel_o < 1.0f ? 1.0f : 0.0f) : p.open;
    p.spared = s->thin ? 0.0f : gk_energy_albedo(&s->energy, rest, cos_o, s->alpha);
#endif
    p.scatter_white = 0.0f;
    p.scatter = 0.0f;
#ifdef GK_COLLIMATION
    const gk_i32 part = known ? s->interface + GK_ENERGY_SCATTER : 0;
    const gk_f32 z = gk_pair_cosine(s, cos_o);
    const gk_f32 white = gk_energy_albedo(&s->energy, GK_ENERGY_WHITE, z, s->alpha_t);
    const gk_f32 scatter = gk_energy_albedo(&s->energy, part, z, s->alpha_t);
    p.scatter_white = z > 0.0f ? white : 0.0f;
    p.scatter = z > 0.0f ? scatter : 0.0f;
#endif
    return p;
}

// What of one colour the pair reflects and passes on, under a white base; k: gk_specular_prepare's. Of
// the facets that do not reflect totally R is linear in F, so both follow from the albedos of the
// plain interface and of one that reflects nothing.
struct gk_pair_shares {
    gk_f32 reflect, passed;
};

GK_INLINE struct gk_pair_shares gk_pair_share(const struct gk_surface *s, const struct gk_pair *p,
                                              gk_f32 k)
{
#ifdef GK_SPECULAR
    const gk_f32 kept = s->specular * (1.0f - k), lifted = 1.0f - s->specular;
#else
    const gk_f32 kept = 1.0f, lifted = 0.0f;
    (void)k;
#endif
    struct gk_pair_shares c;
    c.reflect = gk_max(p->white - lifted * p->open - kept * (p->white - p->reflect), 0.0f);
    c.passed = lifted * (p->open + p->spared) + kept * (p->both - p->reflect);
#ifdef GK_COLLIMATION
    const gk_f32 scattered = lifted * p->scatter_white + kept * p->scatter;
    c.passed = s->scatters ? scattered : c.passed;
#endif
    return c;
}

GK_INLINE gk_f32 gk_pair_gain(struct gk_pair_shares c)
{
    return 1.0f / gk_clamp(c.reflect + c.passed, 0.05f, 1.0f);
}

#ifdef GK_COLLIMATION
// In proportion to what the surface reflects and what is scattered, facets of total reflection
// included.
GK_INLINE gk_f32 gk_pair_reflects(const struct gk_surface *s, const struct gk_pair_shares *x,
                                  const struct gk_pair_shares *y, const struct gk_pair_shares *z,
                                  gk_f32 cos_o)
{
    const gk_f32 mirror = s->metallic * gk_mean3(gk_fresnel_metal(s->base, cos_o));
    const gk_f32 gloss = gk_mean3(gk_vec(x->reflect, y->reflect, z->reflect));
    const gk_f32 passed = gk_mean3(gk_mul(s->base, gk_vec(x->passed, y->passed, z->passed)));
    const gk_f32 reflect = mirror + (1.0f - s->metallic) * gloss;
    const gk_f32 both = reflect + (1.0f - s->metallic) * s->transmission * passed;
    return both > 0.0f ? reflect / both : 1.0f;
}
#endif

GK_INLINE void gk_pair_prepare(struct gk_surface *s, struct gk_vec wo)
{
    gk_i32 lossy = !s->delta && !gk_surface_matched(s);
#ifdef GK_COLLIMATION
    lossy = lossy || s->scatters;
#endif
    const gk_f32 cos_o = gk_min(wo.z, 1.0f);
    const gk_i32 known = s->transmission > 0.0f && s->interface > 0;
    const struct gk_pair p = gk_pair_find(s, known, cos_o);
#ifdef GK_SPECULAR
    const struct gk_vec k = s->tint;
#else
    const struct gk_vec k = gk_splat(0.0f);
#endif
    const struct gk_pair_shares x = gk_pair_share(s, &p, k.x), y = gk_pair_share(s, &p, k.y),
                                z = gk_pair_share(s, &p, k.z);
    const struct gk_vec gain = gk_vec(gk_pair_gain(x), gk_pair_gain(y), gk_pair_gain(z));
    s->gain = gk_vec_select(gk_splat(1.0f), gain, lossy && known);
    const gk_f32 t = s->transmission;
    s->raise = gk_vec(1.0f + t * (s->gain.x - 1.0f), 1.0f + t * (s->gain.y - 1.0f),
                      1.0f + t * (s->gain.z - 1.0f));
#ifdef GK_COLLIMATION
    s->p_reflect = known ? gk_pair_reflects(s, &x, &y, &z, cos_o) : s->p_reflect;
#endif
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
