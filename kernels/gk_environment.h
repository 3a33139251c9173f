// gk_environment.h - light from infinitely far: an equirectangular image, importance sampled.
//
// Coordinates: u = 0.5 looks along -z turned by the rotation about +y, u grows towards +x; v = 0 is
// +y. The sampling density is constant over the cells of a grid no finer than the image and
// bounds the bilinear look-up from below nowhere by zero, so MIS stays unbiased.
#ifndef GK_ENVIRONMENT_H
#define GK_ENVIRONMENT_H

#include "kernels/gk_cut.h"
#include "kernels/gk_frame.h"
#include "kernels/gk_scene.h"
#include "kernels/gk_vec.h"

struct gk_environment {
    const GK_GLOBAL struct gk_env_texel *texel; // [height][width]
    const GK_GLOBAL struct gk_env_cell *cell;   // [cell_height][cell_width]
    gk_i32 width, height, cell_width, cell_height;
    gk_f32 cosine, sine; // of the rotation
    struct gk_vec factor;
    struct gk_cut cut;
};

struct gk_direction_uv {
    gk_f32 u, v;
    gk_f32 sine; // of the polar angle: uv density over solid-angle density is 2 pi^2 sine
};

GK_INLINE struct gk_direction_uv gk_environment_uv(const struct gk_environment *e, struct gk_vec d)
{
    const gk_f32 x = e->cosine * d.x - e->sine * d.z;
    const gk_f32 z = e->sine * d.x + e->cosine * d.z;
    struct gk_direction_uv r;
    const gk_f32 u = 0.5f + gk_atan2(x, -z) * (0.5f / GK_PI);
    r.u = u < 0.0f ? u + 1.0f : u >= 1.0f ? u - 1.0f : u;
    r.v = gk_acos(gk_clamp(d.y, -1.0f, 1.0f)) * (1.0f / GK_PI);
    r.sine = gk_sqrt(gk_max(x * x + z * z, 1e-14f));
    return r;
}

#define GK_ENV_TEXEL(e, index, member) GK_READ((e)->texel, gk_env_texel, index, member)
#define GK_ENV_CELL(e, index, member) GK_READ((e)->cell, gk_env_cell, index, member)

GK_INLINE struct gk_vec gk_environment_radiance(const struct gk_environment *e,
                                                struct gk_direction_uv at)
{
    const gk_f32 x = at.u * (gk_f32)e->width - 0.5f, y = at.v * (gk_f32)e->height - 0.5f;
    const gk_f32 fx = gk_floor(x), fy = gk_floor(y);
    gk_i32 x0 = (gk_i32)fx, y0 = (gk_i32)fy;
    gk_i32 x1 = x0 + 1, y1 = y0 + 1;
    x0 = x0 < 0 ? e->width - 1 : x0;
    x1 = x1 >= e->width ? 0 : x1;
    x0 = gk_min_i32(x0, e->width - 1);
    y0 = gk_max_i32(y0, 0);
    y1 = gk_min_i32(y1, e->height - 1);
    y0 = gk_min_i32(y0, e->height - 1);
    const gk_i32 i00 = y0 * e->width + x0, i10 = y0 * e->width + x1;
    const gk_i32 i01 = y1 * e->width + x0, i11 = y1 * e->width + x1;
    GK_CUT(e->cut, (gk_u32)(i00 ^ i10 ^ i01 ^ i11));
    const struct gk_vec t00 = GK_TRIPLE(GK_ENV_TEXEL, e, i00, L, 0);
    const struct gk_vec t10 = GK_TRIPLE(GK_ENV_TEXEL, e, i10, L, 0);
    const struct gk_vec t01 = GK_TRIPLE(GK_ENV_TEXEL, e, i01, L, 0);
    const struct gk_vec t11 = GK_TRIPLE(GK_ENV_TEXEL, e, i11, L, 0);
    const gk_f32 wx = x - fx, wy = y - fy;
    const struct gk_vec top = gk_along(gk_scale(t00, 1.0f - wx), t10, wx);
    const struct gk_vec bottom = gk_along(gk_scale(t01, 1.0f - wx), t11, wx);
    return gk_mul(e->factor, gk_along(gk_scale(top, 1.0f - wy), bottom, wy));
}

// Solid-angle pdf of gk_environment_sample() at a direction.
GK_INLINE gk_f32 gk_environment_pdf(const struct gk_environment *e, struct gk_direction_uv at)
{
    const gk_i32 x = gk_min_i32((gk_i32)(at.u * (gk_f32)e->cell_width), e->cell_width - 1);
    const gk_i32 y = gk_min_i32((gk_i32)(at.v * (gk_f32)e->cell_height), e->cell_height - 1);
    const gk_i32 cell = y * e->cell_width + x;
    GK_CUT(e->cut, (gk_u32)cell);
    return GK_ENV_CELL(e, cell, pdf) / (2.0f * GK_PI * GK_PI * at.sine);
}

// A direction with that pdf: (choice, keep) takes the cell, (u, v) the place in it.
GK_INLINE struct gk_vec gk_environment_sample(const struct gk_environment *e, gk_f32 choice,
                                              gk_f32 keep, gk_f32 u, gk_f32 v)
{
    const gk_i32 cells = e->cell_width * e->cell_height;
    const gk_i32 slot = gk_min_i32((gk_i32)(choice * (gk_f32)cells), cells - 1);
    GK_CUT(e->cut, (gk_u32)slot);
    const gk_i32 other = (gk_i32)GK_ENV_CELL(e, slot, other);
    const gk_i32 taken = keep < GK_ENV_CELL(e, slot, keep) ? slot : other;
    // Exact for fewer than 2^22 cells: the half keeps the quotient away from integers.
    const gk_i32 y = (gk_i32)(((gk_f32)taken + 0.5f) / (gk_f32)e->cell_width);
    const gk_i32 x = taken - y * e->cell_width;
    const gk_f32 su = ((gk_f32)x + u) / (gk_f32)e->cell_width;
    const gk_f32 sv = ((gk_f32)y + v) / (gk_f32)e->cell_height;
    gk_f32 sin_phi, cos_phi, sin_theta, cos_theta;
    gk_sincos_2pi(su, &sin_phi, &cos_phi); // phi = 2 pi (su - 1/2): both change sign
    gk_sincos_2pi(sv * 0.5f, &sin_theta, &cos_theta);
    const gk_f32 dx = -sin_phi * sin_theta, dz = cos_phi * sin_theta;
    return gk_vec(e->cosine * dx + e->sine * dz, cos_theta, -e->sine * dx + e->cosine * dz);
}

#endif
