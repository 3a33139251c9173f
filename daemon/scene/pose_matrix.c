// pose_matrix.c - affine transforms of a pose, in double.
#include "scene/pose_work.h"

#include <math.h>
#include <string.h>

void glint_pose_multiply(double out[16], const double a[16], const double b[16])
{
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++)
            out[4 * column + row] = a[row] * b[4 * column] + a[4 + row] * b[4 * column + 1] +
                                    a[8 + row] * b[4 * column + 2] +
                                    a[12 + row] * b[4 * column + 3];
}

void glint_pose_widen(double out[16], const float m[16])
{
    for (int i = 0; i < 16; i++)
        out[i] = m[i];
}

void glint_pose_multiply_float(double out[16], const double a[16], const float b[16])
{
    double wide[16];
    glint_pose_widen(wide, b);
    glint_pose_multiply(out, a, wide);
}

// q is a unit quaternion x y z w.
void glint_pose_compose(double out[16], const double t[3], const double q[4], const double s[3])
{
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    const double r[9] = {
        1 - 2 * (y * y + z * z), 2 * (x * y + z * w),     2 * (x * z - y * w),
        2 * (x * y - z * w),     1 - 2 * (x * x + z * z), 2 * (y * z + x * w),
        2 * (x * z + y * w),     2 * (y * z - x * w),     1 - 2 * (x * x + y * y),
    };
    for (int column = 0; column < 3; column++) {
        for (int row = 0; row < 3; row++)
            out[4 * column + row] = r[3 * column + row] * s[column];
        out[4 * column + 3] = 0;
        out[12 + column] = t[column];
    }
    out[15] = 1;
}

void glint_pose_point(double out[3], const double m[16], const double p[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i];
}

static void cross(double out[3], const double a[3], const double b[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

double glint_pose_determinant(const double m[16])
{
    double n[3];
    cross(n, m, m + 4);
    return dot(n, m + 8);
}

static bool singular(const double m[16])
{
    double unit[3][3], n[3];
    for (int i = 0; i < 3; i++) {
        const double length = sqrt(dot(m + 4 * i, m + 4 * i));
        if (!(length > 1e-12))
            return true;
        for (int k = 0; k < 3; k++)
            unit[i][k] = m[4 * i + k] / length;
    }
    cross(n, unit[0], unit[1]);
    return !(fabs(dot(n, unit[2])) > 1e-6);
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
    return bounded(m, reach) && !singular(m);
}

static bool normalise(double v[3])
{
    const double length = sqrt(dot(v, v));
    if (!(length > 0 && isfinite(length)))
        return false;
    for (int i = 0; i < 3; i++)
        v[i] /= length;
    return true;
}

bool glint_pose_rigid(double out[16], const double m[16])
{
    double z[3] = {m[8], m[9], m[10]}, y[3] = {m[4], m[5], m[6]}, x[3];
    if (!bounded(m, 0.0) || !normalise(z))
        return false;
    cross(x, y, z);
    if (!normalise(x)) { // any up will do
        const double up[3] = {fabs(z[1]) < 0.9 ? 0 : 1, fabs(z[1]) < 0.9 ? 1 : 0, 0};
        cross(x, up, z);
        normalise(x);
    }
    cross(y, z, x);
    const double r[16] = {x[0], x[1], x[2], 0, y[0],  y[1],  y[2],  0,
                          z[0], z[1], z[2], 0, m[12], m[13], m[14], 1};
    memcpy(out, r, sizeof r);
    return true;
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
