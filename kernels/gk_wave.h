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
// Coverage that the path still has to give away.
#define GK_COL_HELD 20    // units of GK_MATTE_ONE
#define GK_COL_WAITS 21   // slot key of the last vertex, GK_WAITS_*; 0: none yet
#define GK_COL_CARRIED 22 // held b/q: what goes on from there at a weight of 1
#define GK_COL_SPREAD0 23 // struct gk_spread
#define GK_COL_SPREAD1 24
#define GK_COL_SPREAD2 25
#define GK_COL_LAST 26
#define GK_COL_SINCE 27
#define GK_COL_RADIUS 28 // struct gk_cone
#define GK_COL_SLOPE 29
#define GK_COL_WAY 30
#define GK_COL_MOVED 31
// Hit, written by the tracer and read at once.
#define GK_COL_U 31
#define GK_COL_V 32
#define GK_COL_NX \
    33 // geometric normal, not normalised: of the mesh where it is placed, else of the world
#define GK_COL_NY 34
#define GK_COL_NZ 35
#define GK_COL_PRIMITIVE 36
#define GK_COL_GEOMETRY 37
#define GK_COL_INSTANCE 38
// Shadow ray and what it brings when it is not occluded.
#define GK_COL_SOX 39
#define GK_COL_SOY 40
#define GK_COL_SOZ 41
#define GK_COL_SDX 42
#define GK_COL_SDY 43
#define GK_COL_SDZ 44
#define GK_COL_ST 45 // distance; -inf: none, or occluded
#define GK_COL_SR 46
#define GK_COL_SG 47
#define GK_COL_SB 48
#define GK_COL_SLANE 49
// Constants that the tracer wants.
#define GK_COL_ZERO 50
#define GK_COL_MASK 51
// Of the lane.
#define GK_COL_LR 52 // radiance of the sample so far
#define GK_COL_LG 53
#define GK_COL_LB 54
#define GK_COL_KEY 55 // matte index of the first hit, 1: background
#define GK_COL_Z 56
#define GK_COL_FNX 57
#define GK_COL_FNY 58
#define GK_COL_FNZ 59
#define GK_COL_AR 60
#define GK_COL_AG 61
#define GK_COL_AB 62
#define GK_COL_FORWARD_U 63 // pixels to where the first hit is a frame later, y up
#define GK_COL_FORWARD_V 64
#define GK_COL_BACKWARD_U 65 // a frame earlier
#define GK_COL_BACKWARD_V 66
// Of the path again: how the vertex just shaded passes coverage on (gk_passing.h), if any is held. The
// pass that carries it leaves in their places what the one after takes.
#define GK_COL_PASSING 67  // matte that was hit, GK_PASSING_*
#define GK_COL_GAIN 68     // b/q
#define GK_COL_VARIANCE 69 // v^2
#define GK_COL_STEP 70     // way to the vertex
#define GK_COL_BEND_SLOPE \
    71 // the cone's slope beyond is this of its slope before and that of its radius
#define GK_COL_BEND_RADIUS 76
#define GK_COL_OPAQUE 75 // 1 - T of Eq. 8
// Deposits, of the vertex before and of a last one.
#define GK_COL_DEPOSIT0 67 // slot key, GK_WAITS_DIRECT; 0: none
#define GK_COL_AMOUNT0 68  // units
#define GK_COL_DEPOSIT1 69
#define GK_COL_AMOUNT1 70
#define GK_COL_EXCESS 71 // units that weights above one were cut by
// What rounding took from GK_COL_LR to GK_COL_LB, under GK_FILM_FP64.
#define GK_COL_LR_REST 72
#define GK_COL_LG_REST 73
#define GK_COL_LB_REST 74
#define GK_COL_MET 75 // matte of the vertex just shaded, 0: none
#define GK_COL_CUT 77 // nothing (gk_cut.h)
#define GK_COLUMNS 78

// The last place of a column: no pixel's. What goes there is read by nobody.
#define GK_LANE_OF_NOBODY(stride) ((stride)-1u)

// Bits of GK_COL_WAITS beside the slot key.
#define GK_WAITS_DIRECT 0x80000000u  // seen directly, or by deltas alone
#define GK_WAITS_CROSSED 0x40000000u // the path went on through x_1, else it was reflected there
#define GK_WAITS_FIRST 0x20000000u   // it is x_1
#define GK_WAITS_KEY 0x7fffffu

// Bits of GK_COL_PASSING beside the matte.
#define GK_PASSING_ALIVE 0x80000000u    // the path goes on
#define GK_PASSING_STRAIGHT 0x40000000u // through a surface that is none
#define GK_PASSING_MEDIUM 0x20000000u   // it turned before the surface
#define GK_PASSING_CROSSES 0x10000000u
#define GK_PASSING_MISSED 0x8000000u

#define GK_MATTE_BACKGROUND 1u

// Access by column inside a kernel with `wave` and `stride` in scope.
#define GK_AT(column, i) ((column)*stride + (i))
#define GK_LOAD(column, i) wave[GK_AT(column, i)]
#define GK_LOAD_U32(column, i) gk_as_u32(wave[GK_AT(column, i)])
// Of a lane, which differs from i: a signed offset of 32 bits, as GK_READ() has it.
#define GK_LANE(column, lane) (wave + (column)*stride)[(gk_i32)(lane)]
#define GK_STORE(column, i, value) (wave[GK_AT(column, i)] = (value))
#define GK_STORE_U32(column, i, value) (wave[GK_AT(column, i)] = gk_as_f32(value))

#endif
