// gk_radiance.h - the radiance of a sample while its path goes on.
//
// Each addition rounds: a path of n terms is off by n u at most, u = 2^-24. Under GK_FILM_FP64 what
// rounding took is summed in columns of its own (Neumaier 1974), which the film adds as well: two
// floats are 48 bits, so that no sum between the light and the film has less.
#ifndef GK_RADIANCE_H
#define GK_RADIANCE_H

#include "kernels/gk_film.h"
#include "kernels/gk_wave.h"

// channel: 0, 1, 2 for red, green, blue.
GK_INLINE void gk_radiance_begin(GK_GLOBAL gk_f32 *wave, gk_u32 stride, gk_u32 lane, gk_u32 channel)
{
    GK_STORE(GK_COL_LR + channel, lane, 0.0f);
#ifdef GK_FILM_FP64
    GK_STORE(GK_COL_LR_REST + channel, lane, 0.0f);
#endif
}

GK_INLINE void gk_radiance_add(GK_GLOBAL gk_f32 *wave, gk_u32 stride, gk_u32 lane, gk_u32 channel,
                               gk_f32 x)
{
#ifdef GK_FILM_FP64
    gk_f32 lost;
    const gk_f32 sum = gk_two_sum(GK_LANE(GK_COL_LR + channel, lane), x, &lost);
    GK_LANE(GK_COL_LR_REST + channel, lane) += lost;
    GK_LANE(GK_COL_LR + channel, lane) = sum;
#else
    GK_LANE(GK_COL_LR + channel, lane) += x;
#endif
}

// One channel of a sample goes into pixel i of a sum of the film; nothing of one that is not `sound`.
GK_INLINE void gk_radiance_take(const GK_GLOBAL gk_f32 *wave, gk_u32 stride, gk_u32 lane,
                                gk_u32 channel, gk_i32 sound, GK_GLOBAL gk_f32 *sum, gk_u32 i)
{
    gk_film_add(sum, i, sound ? GK_LOAD(GK_COL_LR + channel, lane) : 0.0f);
#ifdef GK_FILM_FP64
    GK_GLOBAL double *wide = (GK_GLOBAL double *)sum;
    wide[i] += sound ? (double)GK_LOAD(GK_COL_LR_REST + channel, lane) : 0.0;
#endif
}

#endif
