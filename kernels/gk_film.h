// gk_film.h - how a film tile of 16x16 pixels lies in memory, and exact running sums.
//
// Planes of 256 words follow one another. Sums do not depend on the order of what is added, so that
// films of parts of a job's samples add up to the film of all, word for word:
//
// - A sum of radiance is three floats that together are exact: the largest is the sum rounded, the
//   second what that left out rounded, the third the rest (Knuth 1997, 4.2.2, theorem B; Priest
//   1991). They hold a window of 72 bits: exact while no addend has bits more than 2^-72 below the
//   sum; bits beyond are rounded off, which may then depend on the order. Addends are
//   |x| <= 2^100, larger ones count as that; below 2^-100 they count as 0, for what rounding takes
//   from them would not be a normal number. Under GK_FILM_FP64 it is a double over the first two of
//   the three planes, and not exact.
// - Sums of normals, albedo and motion are 64-bit integers over two planes, low words first.
#ifndef GK_FILM_H
#define GK_FILM_H

#include "kernels/gk_math.h"

#define GK_TILE_SIDE 16
#define GK_TILE_PIXELS 256

#define GK_SUM_PLANES 3      // of a sum of radiance
#define GK_PLANE_COLOUR 0    // [half A, B][r, g, b] sums of radiance
#define GK_PLANE_HITS 18     // samples that hit something
#define GK_PLANE_REJECTED 19 // samples whose radiance was negative or not finite
#define GK_PLANES_BASE 20
// With AOVs, after the base planes:
#define GK_AOV_DEPTH 0  // least distance along the view axis
#define GK_AOV_NORMAL 1 // [x, y, z] sums
#define GK_AOV_ALBEDO 7 // [r, g, b] sums
#define GK_PLANES_AOV 13
// With motion vectors, after those: [forward u, v, backward u, v] sums.
#define GK_AOV_FLOW 13
#define GK_PLANES_FLOW 8

// Red of a sample that could not be followed through nested solids; light itself is never that.
#define GK_RADIANCE_NESTED (-GK_INFINITY)

// With batches, after all those: [batch][r, g, b] sums of radiance.
#define GK_BATCHES 16
#define GK_PLANES_BATCHES 144

#define GK_SUM_LARGEST 0x1p100f
#define GK_SUM_LEAST 0x1p-100f

// Bits behind the point of the integers, and the largest magnitude of an addend: 2^24 of it fit.
#define GK_FIXED_UNIT 35 // normals and albedo
#define GK_FIXED_UNIT_LARGEST 8.0f
#define GK_FIXED_FLOW 21 // motion, pixels
#define GK_FIXED_FLOW_LARGEST 131072.0f

// Whether a sample may have this much light; NaN may not.
GK_INLINE gk_i32 gk_radiance_sound(gk_f32 x)
{
    return x >= 0.0f && x < GK_INFINITY;
}

// a + b rounded; *lost: what rounding took, exactly.
GK_INLINE gk_f32 gk_two_sum(gk_f32 a, gk_f32 b, gk_f32 *lost)
{
    const gk_f32 sum = a + b;
    const gk_f32 b_part = sum - a;
    *lost = (a - (sum - b_part)) + (b - b_part);
    return sum;
}

// sum += x, at word i of a three-plane sum of floats: x as it is.
GK_INLINE void gk_sum_add(GK_GLOBAL gk_f32 *sum, gk_u32 i, gk_f32 x)
{
    gk_f32 b, c, rest;
    gk_f32 a = gk_two_sum(sum[i], x, &b);
    b = gk_two_sum(sum[i + GK_TILE_PIXELS], b, &c);
    c = gk_two_sum(sum[i + 2 * GK_TILE_PIXELS], c, &rest);
    c = gk_two_sum(c, rest, &rest);
    b = gk_two_sum(b, c, &c);
    a = gk_two_sum(a, b, &b);
    // a is now the sum of two words rounded, ties to even. Where that was a tie which the third
    // word decides the other way, a is one unit off what the sum of all three rounds to.
    const gk_f32 next = a + 2.0f * b;
    const gk_i32 tie = b != 0.0f && next - a == 2.0f * b;
    const gk_i32 wrong = tie && c != 0.0f && (b > 0.0f) == (c > 0.0f);
    a = wrong ? next : a;
    b = wrong ? -b : b;
    b = gk_two_sum(b, c, &c);
    sum[i] = a;
    sum[i + GK_TILE_PIXELS] = b;
    sum[i + 2 * GK_TILE_PIXELS] = c + rest;
}

// The radiance x of a sample goes into a three-plane sum.
GK_INLINE void gk_film_add(GK_GLOBAL gk_f32 *sum, gk_u32 i, gk_f32 x)
{
    const gk_f32 clamped = gk_clamp(x, -GK_SUM_LARGEST, GK_SUM_LARGEST);
    const gk_f32 addend = gk_abs(x) < GK_SUM_LEAST ? 0.0f : clamped;
#ifdef GK_FILM_FP64
    GK_GLOBAL double *wide = (GK_GLOBAL double *)sum;
    wide[i] += (double)addend;
#else
    gk_sum_add(sum, i, addend);
#endif
}

// sum += x, at word i of a two-plane integer with `bits` behind the point; rounded towards 0.
GK_INLINE void gk_film_add_fixed(GK_GLOBAL gk_u32 *sum, gk_u32 i, gk_f32 x, gk_f32 largest,
                                 gk_u32 bits)
{
    const gk_f32 size = gk_abs(x) <= largest ? gk_abs(x) : gk_abs(x) > largest ? largest : 0.0f;
    // 2^(bits - 32): the whole part is the high word. All steps are exact.
    const gk_f32 scaled = size * gk_as_f32((127u + bits - 32u) << 23);
    const gk_i32 whole = (gk_i32)scaled;
    const gk_f32 upper = (scaled - (gk_f32)whole) * 65536.0f;
    const gk_i32 middle = (gk_i32)upper;
    const gk_i32 lower = (gk_i32)((upper - (gk_f32)middle) * 65536.0f);
    const gk_u32 low = (gk_u32)middle << 16 | (gk_u32)lower;
    const gk_i32 negative = x < 0.0f;
    const gk_u32 add_low = negative ? 0u - low : low;
    const gk_u32 add_high = negative ? ~(gk_u32)whole + (low == 0u ? 1u : 0u) : (gk_u32)whole;
    const gk_u32 total = sum[i] + add_low;
    sum[i + GK_TILE_PIXELS] += add_high + (total < add_low ? 1u : 0u);
    sum[i] = total;
}

#endif
