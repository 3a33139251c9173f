// gk_film.h - how a film tile of 16x16 pixels lies in memory, and exact running sums.
//
// Planes of 256 words follow one another; a sum has a word for the value and one for what rounding
// took from it (Neumaier 1974; renormalised as Dekker 1971), or is a double over the same two planes
// under GK_FILM_FP64.
#ifndef GK_FILM_H
#define GK_FILM_H

#include "kernels/gk_math.h"

#define GK_TILE_SIDE 16
#define GK_TILE_PIXELS 256

#define GK_PLANE_COLOUR 0    // [half A, B][r, g, b] sums of radiance
#define GK_PLANE_HITS 12     // samples that hit something
#define GK_PLANE_REJECTED 13 // samples whose radiance was not finite
#define GK_PLANES_BASE 14
// With AOVs, after the base planes:
#define GK_AOV_DEPTH 0  // least distance along the view axis
#define GK_AOV_NORMAL 1 // [x, y, z] sums
#define GK_AOV_ALBEDO 7 // [r, g, b] sums
#define GK_PLANES_AOV 13
// With motion vectors, after those: [forward u, v, backward u, v] sums.
#define GK_AOV_FLOW 13
#define GK_PLANES_FLOW 8

// sum += x, at word i of a two-plane sum: within 4 2^-24 of the exact sum of 2 10^7 positive
// addends, relative.
GK_INLINE void gk_film_add(GK_GLOBAL gk_f32 *sum, gk_u32 i, gk_f32 x)
{
#ifdef GK_FILM_FP64
    GK_GLOBAL double *wide = (GK_GLOBAL double *)sum;
    wide[i] += (double)x;
#else
    const gk_f32 s = sum[i];
    const gk_f32 t = s + x;
    const gk_f32 lost = gk_abs(s) >= gk_abs(x) ? (s - t) + x : (x - t) + s;
    // The second word stays below half an ulp of the first: left to grow, it would round as badly
    // as a plain sum once it holds the systematic part of millions of roundings.
    const gk_f32 c = sum[i + GK_TILE_PIXELS] + lost;
    const gk_f32 total = t + c;
    sum[i] = total;
    sum[i + GK_TILE_PIXELS] = c - (total - t);
#endif
}

#endif
