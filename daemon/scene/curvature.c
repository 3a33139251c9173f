#include "scene/curvature.h"

#include "kernels/gk_scene.h"
#include "scene/matrix.h"

#include <math.h>
#include <string.h>

static void widen(const float *v, double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = v[i];
}

static double bend(const double p[3], const double q[3], const double n[3], const double m[3])
{
    double along = 0.0, square = 0.0;
    for (int i = 0; i < 3; i++) {
        const double d = q[i] - p[i];
        along += (m[i] - n[i]) * d;
        square += d * d;
    }
    return along / square;
}

float glint_curvature(const float *position, const float *normal, const uint32_t vertex[3])
{
    double p[3][3], n[3][3], sum = 0.0;
    for (int i = 0; i < 3; i++) {
        widen(position + 3 * (size_t)vertex[i], p[i]);
        widen(normal + 3 * (size_t)vertex[i], n[i]);
        if (!glint_normalise3(n[i]))
            return 0.0f;
    }
    for (int e = 0, next = 1; e < 3; e++, next = (next + 1) % 3)
        sum += bend(p[e], p[next], n[e], n[next]) / 3.0;
    return isfinite((float)sum) ? (float)sum : 0.0f;
}

uint32_t glint_curvature_bits(float curvature)
{
    uint32_t bits;
    memcpy(&bits, &curvature, 4);
    return (bits + 0x7fffu + (bits >> 16 & 1u)) & GK_TRIANGLE_CURVATURE;
}
