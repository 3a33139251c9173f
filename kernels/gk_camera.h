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
    gk_u32 base;  // gk_sampler_base of the pixel and part
    gk_u32 index; // of the sample in its part
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
    l.x = rect->x + (((column << 4) + (pixel & 15u)) << rect->spread_log2);
    l.y = rect->y + (((row << 4) + ((pixel >> 4) & 15u)) << rect->spread_log2);
    // Samples from 2^24 on are of a pilot: of parts that no others are of.
    const gk_u32 part = (sample & ((1u << rect->parts_log2) - 1u)) | sample >> 24 << 4;
    l.base = gk_sampler_base(l.x, l.y, seed, part);
    l.index = (sample & 0xffffffu) >> rect->parts_log2;
    return l;
}

#if defined(GK_MOTION) || defined(GK_CAMERA_MOTION)
#define GK_SHUTTER // paths have a time
#endif

struct gk_ray {
    struct gk_vec o, d;
    gk_f32 time; // 0..1 of the shutter
};

// One of the vectors of gk_frame.camera_key, `k` their place in it, at a time.
GK_INLINE struct gk_vec gk_camera_vector(const GK_GLOBAL struct gk_frame *f,
                                         const GK_GLOBAL gk_f32 *still, gk_u32 k, gk_f32 time)
{
#ifdef GK_CAMERA_MOTION
    const gk_f32 at = time * (gk_f32)(gk_i32)f->motion_segments;
    const gk_i32 last = gk_max_i32((gk_i32)f->motion_segments - 1, 0);
    const gk_i32 segment = gk_min_i32((gk_i32)at, last);
    const GK_GLOBAL gk_f32 *from = &f->camera_key[0][0] + segment * 15 + (gk_i32)k;
    const struct gk_vec a = gk_vec(from[0], from[1], from[2]);
    const struct gk_vec b = gk_vec(from[15], from[16], from[17]);
    (void)still;
    return gk_along(a, gk_sub(b, a), at - (gk_f32)segment);
#else
    (void)f;
    (void)k;
    (void)time;
    return gk_vec(still[0], still[1], still[2]);
#endif
}

// Position of the sample on the image, in pixels, y down.
GK_INLINE void gk_camera_raster(const GK_GLOBAL struct gk_frame *f, struct gk_lane lane, gk_f32 *px,
                                gk_f32 *py)
{
    gk_u32 a, b;
    const gk_u32 order = gk_sample_order(lane.base, lane.index, GK_PAIR_BOUNCE(0u, GK_PAIR_ORDER));
    gk_sample_crossed_bits(lane.base, order, GK_PAIR_FILTER, &a, &b);
    const gk_f32 u = gk_unit_float(a), v = gk_unit_float(b);
    gk_f32 dx = gk_filter_box(u, f->filter_width);
    gk_f32 dy = gk_filter_box(v, f->filter_width);
#ifdef GK_FILTER_BLACKMAN_HARRIS
    const gk_i32 bell = f->has_blackman_harris != 0u;
    dx = bell ? gk_filter_blackman_harris(u, f->filter_width) : dx;
    dy = bell ? gk_filter_blackman_harris(v, f->filter_width) : dy;
#endif
    *px = (gk_f32)(gk_i32)lane.x + 0.5f + dx;
    *py = (gk_f32)(gk_i32)lane.y + 0.5f + dy;
}

#ifdef GK_FLOW
// Pixels from (px, py) to where `to`, gk_frame.to_after or to_before, sees p; y up. w 0: p is a
// direction. Nothing where it would be behind the camera.
GK_INLINE void gk_camera_flow(const GK_GLOBAL gk_f32 *to, struct gk_vec p, gk_f32 w, gk_f32 px,
                              gk_f32 py, gk_f32 *u, gk_f32 *v)
{
    const gk_f32 x = to[0] * p.x + to[1] * p.y + to[2] * p.z + to[3] * w;
    const gk_f32 y = to[4] * p.x + to[5] * p.y + to[6] * p.z + to[7] * w;
    const gk_f32 z = to[8] * p.x + to[9] * p.y + to[10] * p.z + to[11] * w;
    const gk_i32 ahead = z > 0.0f;
    const gk_f32 right = x / z - px, up = py - y / z;
    *u = ahead ? right : 0.0f;
    *v = ahead ? up : 0.0f;
}
#endif

GK_INLINE gk_f32 gk_camera_time(struct gk_lane lane)
{
#ifdef GK_SHUTTER
    gk_f32 time, reserved;
    gk_sample_2d(lane.base, lane.index, GK_PAIR_TIME, &time, &reserved);
    return time;
#else
    (void)lane;
    return 0.0f;
#endif
}

GK_INLINE struct gk_ray gk_camera_ray(const GK_GLOBAL struct gk_frame *f, struct gk_lane lane)
{
    gk_f32 px, py;
    gk_camera_raster(f, lane, &px, &py);
    struct gk_ray ray;
    ray.time = gk_camera_time(lane);
    const struct gk_vec right = gk_camera_vector(f, f->right, 3u, ray.time);
    const struct gk_vec down = gk_camera_vector(f, f->down, 6u, ray.time);
    const struct gk_vec corner = gk_camera_vector(f, f->corner, 9u, ray.time);
    const struct gk_vec through = gk_along(gk_along(corner, right, px), down, py);
    ray.o = gk_camera_vector(f, f->origin, 0u, ray.time);
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
#ifdef GK_ORTHOGRAPHIC
    const struct gk_vec forward = gk_camera_vector(f, f->forward, 12u, ray.time);
    const struct gk_vec from = gk_add(gk_camera_vector(f, f->origin, 0u, ray.time), through);
    ray.o = gk_vec_select(ray.o, from, f->is_orthographic != 0u);
    ray.d = gk_vec_select(ray.d, gk_normalise(forward), f->is_orthographic != 0u);
#endif
    return ray;
}

#endif
