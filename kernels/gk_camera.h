// gk_camera.h - from a lane to its pixel, and from a pixel to a ray.
#ifndef GK_CAMERA_H
#define GK_CAMERA_H

#include "kernels/gk_filter.h"
#include "kernels/gk_frame.h"
#include "kernels/gk_sampler.h"
#include "kernels/gk_vec.h"

// Which sample of which pixel a lane is.
struct gk_lane {
    gk_u32 x, y;  // pixel in the display window
    gk_u32 base;  // gk_sampler_base of the pixel and half
    gk_u32 index; // of the sample in its half
};

GK_INLINE struct gk_lane gk_lane_at(const GK_GLOBAL struct gk_wave_rect *rect, gk_u32 lane,
                                    gk_u32 seed)
{
    const gk_u32 pixel = lane & ((1u << rect->pixels_log2) - 1u);
    const gk_u32 sample = rect->sample + (lane >> rect->pixels_log2);
    const gk_u32 tile = pixel >> 8;
    const gk_u32 row = tile >> rect->tiles_log2;
    const gk_u32 column = tile - (row << rect->tiles_log2);
    struct gk_lane l;
    l.x = rect->x + (column << 4) + (pixel & 15u);
    l.y = rect->y + (row << 4) + ((pixel >> 4) & 15u);
    l.base = gk_sampler_base(l.x, l.y, seed, sample & 1u);
    l.index = sample >> 1;
    return l;
}

struct gk_ray {
    struct gk_vec o, d;
};

GK_INLINE struct gk_ray gk_camera_ray(const GK_GLOBAL struct gk_frame *f, struct gk_lane lane)
{
    gk_f32 u, v;
    gk_sample_2d(lane.base, lane.index, GK_PAIR_FILTER, &u, &v);
    gk_f32 dx = gk_filter_box(u, f->filter_width);
    gk_f32 dy = gk_filter_box(v, f->filter_width);
#ifdef GK_FILTER_BLACKMAN_HARRIS
    const gk_i32 bell = f->has_blackman_harris != 0u;
    dx = bell ? gk_filter_blackman_harris(u, f->filter_width) : dx;
    dy = bell ? gk_filter_blackman_harris(v, f->filter_width) : dy;
#endif
    const gk_f32 px = (gk_f32)(gk_i32)lane.x + 0.5f + dx;
    const gk_f32 py = (gk_f32)(gk_i32)lane.y + 0.5f + dy;
    const struct gk_vec right = gk_vec(f->right[0], f->right[1], f->right[2]);
    const struct gk_vec down = gk_vec(f->down[0], f->down[1], f->down[2]);
    const struct gk_vec corner = gk_vec(f->corner[0], f->corner[1], f->corner[2]);
    const struct gk_vec through = gk_along(gk_along(corner, right, px), down, py);
    struct gk_ray ray;
    ray.o = gk_vec(f->origin[0], f->origin[1], f->origin[2]);
    ray.d = gk_normalise(through);
#ifdef GK_LENS
    gk_f32 lu, lv, sine, cosine;
    gk_sample_2d(lane.base, lane.index, GK_PAIR_LENS, &lu, &lv);
    gk_sincos_2pi(lv, &sine, &cosine);
    const gk_f32 r = gk_sqrt(lu);
    const struct gk_vec lens_right = gk_vec(f->lens_right[0], f->lens_right[1], f->lens_right[2]);
    const struct gk_vec lens_up = gk_vec(f->lens_up[0], f->lens_up[1], f->lens_up[2]);
    const struct gk_vec shift = gk_along(gk_scale(lens_right, r * cosine), lens_up, r * sine);
    // `through` lies on the plane at distance 1, so focus x through lies in the plane of focus.
    const struct gk_vec bent = gk_normalise(gk_sub(gk_scale(through, f->focus), shift));
    ray.o = gk_vec_select(ray.o, gk_add(ray.o, shift), f->has_lens != 0u);
    ray.d = gk_vec_select(ray.d, bent, f->has_lens != 0u);
#endif
    return ray;
}

#endif
