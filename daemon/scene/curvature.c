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

static double bend(const double p[2][3], const double n[2][3])
{
    double along = 0.0, square = 0.0;
    for (int i = 0; i < 3; i++) {
        const double d = p[1][i] - p[0][i];
        along += (n[1][i] - n[0][i]) * d;
        square += d * d;
    }
    return along / square;
}

float glint_curvature(const float *position, const float *normal, const uint32_t vertex[3])
{
    double sum = 0.0;
    for (int e = 0; e < 3; e++) {
        double p[2][3], n[2][3];
        for (int end = 0; end < 2; end++) {
            const size_t v = vertex[(e + end) % 3];
            widen(position + 3 * v, p[end]);
            widen(normal + 3 * v, n[end]);
            if (!glint_normalise3(n[end]))
                return 0.0f;
        }
        sum += bend(p, n) / 3.0;
    }
    return isfinite((float)sum) ? (float)sum : 0.0f;
}

uint32_t glint_curvature_bits(float curvature)
{
    uint32_t bits;
    memcpy(&bits, &curvature, 4);
    return (bits + 0x7fffu + (bits >> 16 & 1u)) & GK_TRIANGLE_CURVATURE;
}
