// gk_wave.h - the columns of a wave: structure of arrays, four bytes an element.
//
// Columns up to GK_COL_MOVED belong to a path and move when a wave is compacted; the others belong
// to a lane, the place of its sample in the image, and stay.
#ifndef GK_WAVE_H
#define GK_WAVE_H

#include "kernels/gk_types.h"

// Ray and hit, as Embree reads and writes them.
#define GK_COL_OX 0
#define GK_COL_OY 1
#define GK_COL_OZ 2
#define GK_COL_DX 3
#define GK_COL_DY 4
#define GK_COL_DZ 5
#define GK_COL_T 6 // +inf before tracing, distance after; -inf: no ray
// Path.
#define GK_COL_BETA_R 7
#define GK_COL_BETA_G 8
#define GK_COL_BETA_B 9
#define GK_COL_PDF 10 // solid-angle pdf of the last direction; -1: camera ray or delta lobe
#define GK_COL_LANE 11
#define GK_COL_DEPTH 12 // bounces so far
#define GK_COL_MOVED 13
// Hit, written by the tracer and read at once.
#define GK_COL_U 13
#define GK_COL_V 14
#define GK_COL_NX 15 // geometric normal, not normalised, in the space of the mesh
#define GK_COL_NY 16
#define GK_COL_NZ 17
#define GK_COL_PRIMITIVE 18
#define GK_COL_GEOMETRY 19
#define GK_COL_INSTANCE 20
// Shadow ray and what it brings when it is not occluded.
#define GK_COL_SOX 21
#define GK_COL_SOY 22
#define GK_COL_SOZ 23
#define GK_COL_SDX 24
#define GK_COL_SDY 25
#define GK_COL_SDZ 26
#define GK_COL_ST 27 // distance; -inf: none, or occluded
#define GK_COL_SR 28
#define GK_COL_SG 29
#define GK_COL_SB 30
#define GK_COL_SLANE 31
// Constants that the tracer wants.
#define GK_COL_ZERO 32
#define GK_COL_MASK 33
#define GK_COL_ID 34
// Of the lane.
#define GK_COL_LR 35 // radiance of the sample so far
#define GK_COL_LG 36
#define GK_COL_LB 37
#define GK_COL_KEY 38 // matte index of the first hit, 1: background
#define GK_COL_Z 39
#define GK_COL_FNX 40
#define GK_COL_FNY 41
#define GK_COL_FNZ 42
#define GK_COL_AR 43
#define GK_COL_AG 44
#define GK_COL_AB 45
#define GK_COLUMNS 46

#define GK_MATTE_BACKGROUND 1u

// Access by column inside a kernel with `wave` and `stride` in scope.
#define GK_AT(column, i) ((column)*stride + (i))
#define GK_LOAD(column, i) wave[GK_AT(column, i)]
#define GK_LOAD_U32(column, i) gk_as_u32(wave[GK_AT(column, i)])
#define GK_STORE(column, i, value) (wave[GK_AT(column, i)] = (value))
#define GK_STORE_U32(column, i, value) (wave[GK_AT(column, i)] = gk_as_f32(value))

#endif
