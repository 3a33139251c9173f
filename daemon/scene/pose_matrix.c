// pose_matrix.c - affine transforms of a pose, in double.
#include "scene/pose_work.h"

#include <math.h>
#include <string.h>

void glint_pose_multiply_float(double out[16], const double a[16], const float b[16])
{
    double wide[16];
    glint_matrix_widen(wide, b);
    glint_matrix_multiply(out, a, wide);
}

void glint_pose_point(double out[3], const double m[16], const double p[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i];
}

static bool bounded(const double m[16], double reach)
{
    for (int k = 0; k < 3; k++) {
        const double far =
            (fabs(m[k]) + fabs(m[4 + k]) + fabs(m[8 + k])) * fmax(reach, 1.0) + fabs(m[12 + k]);
        if (!(far <= GLINT_MAX_COORDINATE))
            return false;
    }
    return true;
}

bool glint_pose_drawable(const double m[16], double reach)
{
    return bounded(m, reach) && !glint_matrix_singular(m);
}

bool glint_pose_rigid(double out[16], const double m[16])
{
    return bounded(m, 0.0) && glint_matrix_rigid(out, m);
}

// What shrinks to nothing shrinks to this share of its neighbour; what cannot be there at all stays.
#define REMNANT 1e-4

static void mend(double m[16], const double near[16], double reach)
{
    double mended[16];
    memcpy(mended, m, sizeof mended);
    for (int i = 0; i < 12; i++)
        mended[i] += REMNANT * near[i];
    memcpy(m, glint_pose_drawable(mended, reach) ? mended : near, sizeof mended);
}

// Index of the drawable matrix nearest to i, or `count`.
static uint32_t nearest(const bool *good, uint32_t count, uint32_t i)
{
    for (uint32_t d = 1; d < count; d++) {
        if (i >= d && good[i - d])
            return i - d;
        if (i + d < count && good[i + d])
            return i + d;
    }
    return count;
}

uint32_t glint_pose_repair(glint_pose_matrix *m, uint32_t count, double reach)
{
    bool good[GLINT_POSE_ALL];
    uint32_t bad = 0;
    for (uint32_t i = 0; i < count; i++)
        bad += !(good[i] = glint_pose_drawable(m[i], reach));
    for (uint32_t i = 0; bad && bad < count && i < count; i++)
        if (!good[i])
            mend(m[i], m[nearest(good, count, i)], reach);
    return bad;
}
