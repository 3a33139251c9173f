// curvature.h - how strongly a triangle's vertex normals bend over it.
//
// Source: Yoshimura, Tokuyoshi, Harada 2022 want it for the cone of a camera sample.
//
// Thread-safety: pure.
#ifndef GLINT_SCENE_CURVATURE_H
#define GLINT_SCENE_CURVATURE_H

#include <stdint.h>

// The mean over the edges of (n1 - n0).(p1 - p0) / |p1 - p0|^2, 1/m; > 0 where the side that the
// normals point to bulges. position, normal: [..][3]; vertex: the three. 0 where it has no meaning.
float glint_curvature(const float *position, const float *normal, const uint32_t vertex[3]);

// Rounded to the upper half of its bits: GK_TRIANGLE_CURVATURE of a record's flags.
uint32_t glint_curvature_bits(float curvature);

#endif
