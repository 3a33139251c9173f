// gk_wave.h - the columns of a wave: structure of arrays, four bytes an element.
//
// Columns up to GK_COL_MOVED belong to a path and move when a wave is compacted, those from
// GK_COL_TIME on only where the plan carries them; the others belong to a lane, the place of its
// sample in the image, and stay.
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
// Path, where an effect wants it; zeros where none does.
#define GK_COL_TIME 13    // 0..1 of the shutter
#define GK_COL_PASSAGE 14 // key of the ray's chances to pass blended surfaces
#define GK_COL_SOLID 15   // 1 + material of the solid that it is in, 0: open space
#define GK_COL_NESTED0 16 // ranks of the prioritised solids that it is in, two a word
#define GK_COL_NESTED1 17
#define GK_COL_NESTED2 18
#define GK_COL_NESTED3 19
#define GK_COL_MOVED 20
// Hit, written by the tracer and read at once.
#define GK_COL_U 20
#define GK_COL_V 21
#define GK_COL_NX \
    22 // geometric normal, not normalised: of the mesh where it is placed, else of the world
#define GK_COL_NY 23
#define GK_COL_NZ 24
#define GK_COL_PRIMITIVE 25
#define GK_COL_GEOMETRY 26
#define GK_COL_INSTANCE 27
// Shadow ray and what it brings when it is not occluded.
#define GK_COL_SOX 28
#define GK_COL_SOY 29
#define GK_COL_SOZ 30
#define GK_COL_SDX 31
#define GK_COL_SDY 32
#define GK_COL_SDZ 33
#define GK_COL_ST 34 // distance; -inf: none, or occluded
#define GK_COL_SR 35
#define GK_COL_SG 36
#define GK_COL_SB 37
#define GK_COL_SLANE 38
// Constants that the tracer wants.
#define GK_COL_ZERO 39
#define GK_COL_MASK 40
// Of the lane.
#define GK_COL_LR 41 // radiance of the sample so far
#define GK_COL_LG 42
#define GK_COL_LB 43
#define GK_COL_KEY 44 // matte index of the first hit, 1: background
#define GK_COL_Z 45
#define GK_COL_FNX 46
#define GK_COL_FNY 47
#define GK_COL_FNZ 48
#define GK_COL_AR 49
#define GK_COL_AG 50
#define GK_COL_AB 51
#define GK_COL_FORWARD_U 52 // pixels to where the first hit is a frame later, y up
#define GK_COL_FORWARD_V 53
#define GK_COL_BACKWARD_U 54 // a frame earlier
#define GK_COL_BACKWARD_V 55
#define GK_COLUMNS 56

#define GK_MATTE_BACKGROUND 1u

// Access by column inside a kernel with `wave` and `stride` in scope.
#define GK_AT(column, i) ((column)*stride + (i))
#define GK_LOAD(column, i) wave[GK_AT(column, i)]
#define GK_LOAD_U32(column, i) gk_as_u32(wave[GK_AT(column, i)])
#define GK_STORE(column, i, value) (wave[GK_AT(column, i)] = (value))
#define GK_STORE_U32(column, i, value) (wave[GK_AT(column, i)] = gk_as_f32(value))

#endif
