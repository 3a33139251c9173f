// gk_passing.h - what a vertex says of the coverage that passes it: how the path came, how it scatters
// and how it goes on. The pass that carries coverage (gk_transport.h) needs nothing else of it.
//
// Source: Yoshimura, Tokuyoshi, Harada 2022, doi:10.2312/sr.20221162, Eq. 1, 4 and 8.
#ifndef GK_PASSING_H
#define GK_PASSING_H

#include "kernels/gk_held.h"
#include "kernels/gk_vertex.h"

#ifdef GK_THROUGH

// Share of light that the surface does not let through: 1 - T of Eq. 8.
GK_INLINE gk_f32 gk_opaque_share(const struct gk_vertex *x)
{
#ifdef GK_TRANSMISSION
    const struct gk_facet m = gk_facet_make(&x->surface, gk_min(x->wo.z, 1.0f));
    return x->missed ? 1.0f : gk_saturate(1.0f - gk_mean3(m.refract));
#else
    (void)x;
    return 1.0f;
#endif
}

// Probability that the lobe which was chosen is no delta and leaves on that side.
GK_INLINE gk_f32 gk_side_probability(const struct gk_vertex *x, gk_i32 crosses)
{
#ifdef GK_MICROFACET
    const struct gk_surface *s = &x->surface;
    const struct gk_facet m = gk_facet_make(s, gk_min(x->wo.z, 1.0f));
    gk_f32 reflected = s->p_diffuse + (s->delta ? 0.0f : s->p_facet * m.p_reflect);
#ifdef GK_CLEARCOAT
    reflected += s->coat.alpha < GK_ALPHA_DELTA ? 0.0f : s->coat.p;
#endif
    return crosses ? s->p_facet * (1.0f - m.p_reflect) : reflected;
#else
    (void)x;
    (void)crosses;
    return 1.0f;
#endif
}

// v^2 of the vertex that the path leaves by `next`; through deltas alone, anything above 0 serves.
GK_INLINE gk_f32 gk_passing_variance(const struct gk_vertex *x, const struct gk_next *next)
{
#ifdef GK_GLOSSY_MATTES
    const gk_f32 side = gk_max(gk_side_probability(x, next->crosses), 1e-20f);
    const gk_f32 v2 = gk_lobe_variance(next->pdf, side);
#else
    (void)x;
    const gk_f32 v2 = GK_INFINITY;
#endif
    return next->pdf < 0.0f ? 0.0f : v2;
}

GK_INLINE gk_u32 gk_passing_key(const struct gk_resident *scene, const struct gk_vertex *x,
                                const struct gk_next *next, gk_i32 alive)
{
    const gk_u32 of_instance = GK_READ_ALONE(scene->instance, gk_instance, x->hit.instance, matte);
    const gk_u32 matte = x->missed ? GK_MATTE_BACKGROUND : of_instance;
    return matte | (x->missed ? GK_PASSING_MISSED : 0u) | (x->passes ? GK_PASSING_STRAIGHT : 0u) |
           (x->in_medium ? GK_PASSING_MEDIUM : 0u) | (next->crosses ? GK_PASSING_CROSSES : 0u) |
           (alive ? GK_PASSING_ALIVE : 0u);
}

// How a vertex passes coverage on by `next`. scale: 1/q.
GK_INLINE void gk_passing_store(GK_GLOBAL gk_f32 *wave, gk_u32 stride, gk_u32 i,
                                const struct gk_resident *scene, const struct gk_vertex *x,
                                const struct gk_next *next, gk_f32 scale, gk_i32 alive)
{
    const gk_f32 b = gk_mean3(next->weight) * gk_next_share(x, next);
    GK_STORE_U32(GK_COL_PASSING, i, gk_passing_key(scene, x, next, alive));
    GK_STORE(GK_COL_GAIN, i, b * scale);
    GK_STORE(GK_COL_VARIANCE, i, gk_passing_variance(x, next));
    GK_STORE(GK_COL_STEP, i, x->missed || x->in_medium ? 0.0f : x->path.t);
#ifdef GK_GLOSSY_MATTES
#ifdef GK_TRANSMISSION
    const gk_f32 eta = x->surface.thin ? 1.0f : x->surface.eta;
#else
    const gk_f32 eta = 1.0f;
#endif
    gk_f32 of_slope, of_radius;
    gk_cone_bend(gk_hit_curvature(scene, &x->hit), x->wo.z, eta, next->crosses, &of_slope,
                 &of_radius);
    GK_STORE(GK_COL_BEND_SLOPE, i, of_slope);
    GK_STORE(GK_COL_BEND_RADIUS, i, of_radius);
#endif
#ifdef GK_OPAQUE_FULL
    GK_STORE(GK_COL_OPAQUE, i, gk_opaque_share(x));
#endif
}

#endif

#endif
