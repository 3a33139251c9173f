// matrix.h - affine transforms in double, 4x4, column-major: what imports and poses reckon with until
// they store floats.
//
// Threads: any; nothing is kept.
#ifndef GLINT_SCENE_MATRIX_H
#define GLINT_SCENE_MATRIX_H

#include <stdbool.h>

void glint_matrix_multiply(double out[16], const double a[16], const double b[16]);
void glint_matrix_widen(double out[16], const float m[16]);
// Scale, then the rotation of the unit quaternion q (x y z w), then translation.
void glint_matrix_compose(double out[16], const double t[3], const double q[4], const double s[3]);
double glint_matrix_determinant(const double m[16]); // of the linear part
// Relative to its columns: a small scale is not singular, a collapsed axis is. The parser of native
// scenes draws the line at the same place.
bool glint_matrix_singular(const double m[16]);
// The rotation and translation of m: z is kept, y as far as it can be. False if z has no direction.
bool glint_matrix_rigid(double out[16], const double m[16]);

double glint_dot3(const double a[3], const double b[3]);
bool glint_normalise3(double v[3]); // false if it has no direction
void glint_cross3(double out[3], const double a[3], const double b[3]);

#endif
