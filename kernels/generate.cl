// generate.cl - camera rays of a wave.
#include "kernels/gk_camera.h"
#include "kernels/gk_radiance.h"
#include "kernels/gk_scene.h"

// One item per lane. Lanes outside the region, or whose pixel has had the sample, get no ray.
__kernel void generate_camera_rays(__global float *restrict wave, const gk_u32 stride,
                                   const __global struct gk_frame *restrict frame,
                                   const __global struct gk_wave_rect *restrict rect)
{
    const gk_u32 i = (gk_u32)get_global_id(0);
    const struct gk_lane lane = gk_lane_at(rect, i, frame->seed);
    const struct gk_ray ray = gk_camera_ray(frame, lane);
    const gk_i32 inside = lane.x < rect->x_end && lane.y < rect->y_end;
    const gk_i32 had = rect->coarser && !((i | i >> 4) & 1u);

    GK_STORE(GK_COL_OX, i, ray.o.x);
    GK_STORE(GK_COL_OY, i, ray.o.y);
    GK_STORE(GK_COL_OZ, i, ray.o.z);
    GK_STORE(GK_COL_DX, i, ray.d.x);
    GK_STORE(GK_COL_DY, i, ray.d.y);
    GK_STORE(GK_COL_DZ, i, ray.d.z);
    GK_STORE(GK_COL_T, i, inside && !had ? GK_INFINITY : -GK_INFINITY);
    GK_STORE(GK_COL_BETA_R, i, frame->weight);
    GK_STORE(GK_COL_BETA_G, i, frame->weight);
    GK_STORE(GK_COL_BETA_B, i, frame->weight);
    GK_STORE(GK_COL_PDF, i, -1.0f);
#ifdef GK_SHUTTER
    GK_STORE(GK_COL_TIME, i, ray.time);
#endif
#ifdef GK_BLEND
    gk_u32 key, reserved;
    gk_sample_2d_bits(lane.base, lane.index, GK_PAIR_BOUNCE(0u, GK_PAIR_ALPHA), &key, &reserved);
    GK_STORE_U32(GK_COL_PASSAGE, i, key);
#endif
#ifdef GK_SOLIDS
    GK_STORE_U32(GK_COL_SOLID, i, frame->solid);
#endif
#ifdef GK_NESTED
    GK_STORE_U32(GK_COL_NESTED0, i, frame->nested[0]);
    GK_STORE_U32(GK_COL_NESTED1, i, frame->nested[1]);
    GK_STORE_U32(GK_COL_NESTED2, i, frame->nested[2]);
    GK_STORE_U32(GK_COL_NESTED3, i, frame->nested[3]);
#endif
    GK_STORE_U32(GK_COL_LANE, i, i);
    GK_STORE_U32(GK_COL_DEPTH, i, 0u);
    GK_STORE_U32(GK_COL_GEOMETRY, i, GK_NONE);
    GK_STORE_U32(GK_COL_INSTANCE, i, GK_NONE);
    gk_radiance_begin(wave, stride, i, 0u);
    gk_radiance_begin(wave, stride, i, 1u);
    gk_radiance_begin(wave, stride, i, 2u);
    GK_STORE_U32(GK_COL_KEY, i, GK_MATTE_BACKGROUND);
    // Films keep pixels outside the region too: as empty ones, whatever the lanes held before.
#ifdef GK_AOVS
    GK_STORE(GK_COL_Z, i, 1e30f);
    GK_STORE(GK_COL_FNX, i, 0.0f);
    GK_STORE(GK_COL_FNY, i, 0.0f);
    GK_STORE(GK_COL_FNZ, i, 0.0f);
    GK_STORE(GK_COL_AR, i, 0.0f);
    GK_STORE(GK_COL_AG, i, 0.0f);
    GK_STORE(GK_COL_AB, i, 0.0f);
#endif
#ifdef GK_FLOW
    GK_STORE(GK_COL_FORWARD_U, i, 0.0f);
    GK_STORE(GK_COL_FORWARD_V, i, 0.0f);
    GK_STORE(GK_COL_BACKWARD_U, i, 0.0f);
    GK_STORE(GK_COL_BACKWARD_V, i, 0.0f);
#endif
}
