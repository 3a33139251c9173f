// film.cl - samples of every pixel of one tile go into the film.
//
// The kernels in fours take samples k = 0..3 of a pixel, of halves 0, 1, 0, 1, at lanes `step` apart,
// one after the other as four launches of the others would: a launch costs more than its work.
#include "kernels/gk_radiance.h"

// The sample at `lane` into pixel i. tile: its planes; `half_index` 0 or 1.
GK_INLINE void take_colour(const __global float *wave, gk_u32 stride, gk_u32 lane,
                           __global float *tile, gk_u32 half_index, gk_u32 i)
{
    const gk_f32 r = GK_LOAD(GK_COL_LR, lane), g = GK_LOAD(GK_COL_LG, lane),
                 b = GK_LOAD(GK_COL_LB, lane);
    const gk_i32 sound = gk_radiance_sound(r) && gk_radiance_sound(g) && gk_radiance_sound(b);
    __global float *colour =
        tile + (GK_PLANE_COLOUR + half_index * 3u * GK_SUM_PLANES) * GK_TILE_PIXELS;
    const gk_u32 sum = GK_SUM_PLANES * GK_TILE_PIXELS;
    gk_radiance_take(wave, stride, lane, 0u, sound, colour, i);
    gk_radiance_take(wave, stride, lane, 1u, sound, colour + sum, i);
    gk_radiance_take(wave, stride, lane, 2u, sound, colour + 2u * sum, i);
    __global gk_u32 *hits = (__global gk_u32 *)tile + GK_PLANE_HITS * GK_TILE_PIXELS;
    __global gk_u32 *rejected = (__global gk_u32 *)tile + GK_PLANE_REJECTED * GK_TILE_PIXELS;
    hits[i] += GK_LOAD_U32(GK_COL_KEY, lane) != GK_MATTE_BACKGROUND ? 1u : 0u;
    rejected[i] += sound ? 0u : 1u;
}

// One item per pixel. lane: that of the tile's first pixel; film: planes of the tile, from `offset`
// words on.
__kernel void accumulate_colour(const __global float *restrict wave, const gk_u32 stride,
                                const gk_u32 lane, __global float *restrict film,
                                const gk_u32 offset, const gk_u32 half_index)
{
    const gk_u32 i = (gk_u32)get_global_id(0);
    take_colour(wave, stride, lane + i, film + offset, half_index, i);
}

__kernel void accumulate_colour_4(const __global float *restrict wave, const gk_u32 stride,
                                  const gk_u32 lane, __global float *restrict film,
                                  const gk_u32 offset, const gk_u32 step)
{
    const gk_u32 i = (gk_u32)get_global_id(0);
    take_colour(wave, stride, lane + i, film + offset, 0u, i);
    take_colour(wave, stride, lane + step + i, film + offset, 1u, i);
    take_colour(wave, stride, lane + 2u * step + i, film + offset, 0u, i);
    take_colour(wave, stride, lane + 3u * step + i, film + offset, 1u, i);
}

// The same radiance into the sums of a batch, from `offset` words on.
__kernel void accumulate_batch(const __global float *restrict wave, const gk_u32 stride,
                               const gk_u32 lane, __global float *restrict film,
                               const gk_u32 offset)
{
    const gk_u32 i = (gk_u32)get_global_id(0);
    const gk_f32 r = GK_LOAD(GK_COL_LR, lane + i), g = GK_LOAD(GK_COL_LG, lane + i),
                 b = GK_LOAD(GK_COL_LB, lane + i);
    const gk_i32 finite = gk_isfinite(r) && gk_isfinite(g) && gk_isfinite(b);
    __global float *batch = film + offset;
    gk_film_add(batch, i, finite ? r : 0.0f);
    gk_film_add(batch + GK_SUM_PLANES * GK_TILE_PIXELS, i, finite ? g : 0.0f);
    gk_film_add(batch + 2 * GK_SUM_PLANES * GK_TILE_PIXELS, i, finite ? b : 0.0f);
}

#ifdef GK_AOVS
GK_INLINE void add_unit(__global gk_u32 *sum, const gk_u32 i, const gk_f32 x)
{
    gk_film_add_fixed(sum, i, x, GK_FIXED_UNIT_LARGEST, GK_FIXED_UNIT);
}

#ifdef GK_FLOW
GK_INLINE void add_flow(__global gk_u32 *sum, const gk_u32 i, const gk_f32 x)
{
    gk_film_add_fixed(sum, i, x, GK_FIXED_FLOW_LARGEST, GK_FIXED_FLOW);
}
#endif

GK_INLINE void take_aovs(const __global float *wave, gk_u32 stride, gk_u32 lane,
                         __global float *tile, gk_u32 i)
{
    tile[i] = gk_min(tile[i], GK_LOAD(GK_COL_Z, lane));
    __global gk_u32 *normal = (__global gk_u32 *)tile + GK_AOV_NORMAL * GK_TILE_PIXELS;
    add_unit(normal, i, GK_LOAD(GK_COL_FNX, lane));
    add_unit(normal + 2 * GK_TILE_PIXELS, i, GK_LOAD(GK_COL_FNY, lane));
    add_unit(normal + 4 * GK_TILE_PIXELS, i, GK_LOAD(GK_COL_FNZ, lane));
    __global gk_u32 *albedo = (__global gk_u32 *)tile + GK_AOV_ALBEDO * GK_TILE_PIXELS;
    add_unit(albedo, i, GK_LOAD(GK_COL_AR, lane));
    add_unit(albedo + 2 * GK_TILE_PIXELS, i, GK_LOAD(GK_COL_AG, lane));
    add_unit(albedo + 4 * GK_TILE_PIXELS, i, GK_LOAD(GK_COL_AB, lane));
#ifdef GK_FLOW
    __global gk_u32 *flow = (__global gk_u32 *)tile + GK_AOV_FLOW * GK_TILE_PIXELS;
    add_flow(flow, i, GK_LOAD(GK_COL_FORWARD_U, lane));
    add_flow(flow + 2 * GK_TILE_PIXELS, i, GK_LOAD(GK_COL_FORWARD_V, lane));
    add_flow(flow + 4 * GK_TILE_PIXELS, i, GK_LOAD(GK_COL_BACKWARD_U, lane));
    add_flow(flow + 6 * GK_TILE_PIXELS, i, GK_LOAD(GK_COL_BACKWARD_V, lane));
#endif
}

__kernel void accumulate_aovs(const __global float *restrict wave, const gk_u32 stride,
                              const gk_u32 lane, __global float *restrict film, const gk_u32 offset)
{
    const gk_u32 i = (gk_u32)get_global_id(0);
    take_aovs(wave, stride, lane + i, film + offset + GK_PLANES_BASE * GK_TILE_PIXELS, i);
}

__kernel void accumulate_aovs_4(const __global float *restrict wave, const gk_u32 stride,
                                const gk_u32 lane, __global float *restrict film,
                                const gk_u32 offset, const gk_u32 step)
{
    const gk_u32 i = (gk_u32)get_global_id(0);
    __global float *tile = film + offset + GK_PLANES_BASE * GK_TILE_PIXELS;
    take_aovs(wave, stride, lane + i, tile, i);
    take_aovs(wave, stride, lane + step + i, tile, i);
    take_aovs(wave, stride, lane + 2u * step + i, tile, i);
    take_aovs(wave, stride, lane + 3u * step + i, tile, i);
}
#endif
