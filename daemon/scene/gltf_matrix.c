// gltf_matrix.c - 4x4 transforms, column-major, in double until they are stored.
#include "scene/gltf_file.h"

#include <math.h>

void glint_gltf_multiply(double out[16], const double a[16], const double b[16])
{
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++) {
            double sum = 0;
            for (int k = 0; k < 4; k++)
                sum += a[4 * k + row] * b[4 * column + k];
            out[4 * column + row] = sum;
        }
}

// q is a unit quaternion x y z w.
void glint_gltf_compose(double out[16], const double t[3], const double q[4], const double s[3])
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

bool glint_gltf_fit(float out[16], const double m[16])
{
    for (int i = 0; i < 16; i++) {
        out[i] = (float)m[i];
        if (!(fabsf(out[i]) <= GLINT_MAX_COORDINATE))
            return false;
    }
    return true;
}

static void cross(double out[3], const double a[3], const double b[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

// Relative to its columns: a small scale is not singular, a collapsed axis is. The parser of native
// scenes draws the line at the same place.
static bool singular(const float m[16])
{
    double unit[3][3];
    for (int i = 0; i < 3; i++) {
        double square = 0;
        for (int k = 0; k < 3; k++)
            square += (double)m[4 * i + k] * m[4 * i + k];
        if (!(sqrt(square) > 1e-12))
            return true;
        for (int k = 0; k < 3; k++)
            unit[i][k] = m[4 * i + k] / sqrt(square);
    }
    double n[3];
    cross(n, unit[0], unit[1]);
    return !(fabs(n[0] * unit[2][0] + n[1] * unit[2][1] + n[2] * unit[2][2]) > 1e-6);
}

bool glint_gltf_to_float(float out[16], const double m[16])
{
    return glint_gltf_fit(out, m) && !singular(out);
}

double glint_gltf_reach(const float m[16], float reach)
{
    double most = 0;
    for (int k = 0; k < 3; k++)
        most = fmax(most,
                    (fabs((double)m[k]) + fabs((double)m[4 + k]) + fabs((double)m[8 + k])) * reach +
                        fabs((double)m[12 + k]));
    return most;
}

static bool normalise(double v[3])
{
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (!(length > 0 && isfinite(length)))
        return false;
    for (int i = 0; i < 3; i++)
        v[i] /= length;
    return true;
}

bool glint_gltf_rigid(float out[16], const double m[16])
{
    double z[3] = {m[8], m[9], m[10]}, y[3] = {m[4], m[5], m[6]}, x[3];
    if (!normalise(z))
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
    return glint_gltf_fit(out, r);
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Of a rotation with the columns r. The largest of the four is found first, so that what is divided
// by is at least 1 (Shepperd 1978).
static void quaternion(const double r[3][3], double q[4])
{
    const double trace = r[0][0] + r[1][1] + r[2][2];
    int i = 0;
    if (r[1][1] > r[0][0])
        i = 1;
    if (r[2][2] > r[i][i])
        i = 2;
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    if (trace > r[i][i]) {
        q[3] = 1 + trace;
        for (int a = 0; a < 3; a++)
            q[a] = r[(a + 1) % 3][(a + 2) % 3] - r[(a + 2) % 3][(a + 1) % 3];
    } else {
        q[i] = 1 + r[i][i] - r[j][j] - r[k][k];
        q[j] = r[i][j] + r[j][i];
        q[k] = r[i][k] + r[k][i];
        q[3] = r[j][k] - r[k][j];
    }
    const double length = sqrt(dot(q, q) + q[3] * q[3]);
    for (int a = 0; a < 4; a++)
        q[a] /= length;
}

bool glint_gltf_decompose(const double m[16], double t[3], double q[4], double s[3])
{
    double axis[3][3], n[3];
    for (int i = 0; i < 3; i++) {
        t[i] = m[12 + i];
        s[i] = sqrt(dot(m + 4 * i, m + 4 * i));
        for (int k = 0; k < 3; k++)
            axis[i][k] = s[i] > 0 ? m[4 * i + k] / s[i] : (double)(i == k);
    }
    cross(n, axis[0], axis[1]);
    bool clean = fabs(fabs(dot(n, axis[2])) - 1) < 1e-6;
    if (dot(n, axis[2]) < 0) {
        s[0] = -s[0];
        for (int k = 0; k < 3; k++)
            axis[0][k] = -axis[0][k];
    }
    // square, where it was not: z stays, y as far as it can
    cross(axis[0], axis[1], axis[2]);
    clean = normalise(axis[0]) && clean;
    cross(axis[1], axis[2], axis[0]);
    quaternion(axis, q);
    return clean;
}
