#include "scene/matrix.h"

#include <math.h>
#include <string.h>

void glint_matrix_multiply(double out[16], const double a[16], const double b[16])
{
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++)
            out[4 * column + row] = a[row] * b[4 * column] + a[4 + row] * b[4 * column + 1] +
                                    a[8 + row] * b[4 * column + 2] +
                                    a[12 + row] * b[4 * column + 3];
}

void glint_matrix_widen(double out[16], const float m[16])
{
    for (int i = 0; i < 16; i++)
        out[i] = m[i];
}

void glint_matrix_compose(double out[16], const double t[3], const double q[4], const double s[3])
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

double glint_dot3(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void glint_cross3(double out[3], const double a[3], const double b[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

double glint_matrix_determinant(const double m[16])
{
    double n[3];
    glint_cross3(n, m, m + 4);
    return glint_dot3(n, m + 8);
}

bool glint_matrix_singular(const double m[16])
{
    double unit[3][3], n[3];
    for (int i = 0; i < 3; i++) {
        const double length = sqrt(glint_dot3(m + 4 * i, m + 4 * i));
        if (!(length > 1e-12))
            return true;
        for (int k = 0; k < 3; k++)
            unit[i][k] = m[4 * i + k] / length;
    }
    glint_cross3(n, unit[0], unit[1]);
    return !(fabs(glint_dot3(n, unit[2])) > 1e-6);
}

bool glint_normalise3(double v[3])
{
    const double length = sqrt(glint_dot3(v, v));
    if (!(length > 0 && isfinite(length)))
        return false;
    for (int i = 0; i < 3; i++)
        v[i] /= length;
    return true;
}

bool glint_matrix_rigid(double out[16], const double m[16])
{
    double z[3] = {m[8], m[9], m[10]}, y[3] = {m[4], m[5], m[6]}, x[3];
    if (!glint_normalise3(z))
        return false;
    glint_cross3(x, y, z);
    if (!glint_normalise3(x)) { // any up will do
        const double up[3] = {fabs(z[1]) < 0.9 ? 0 : 1, fabs(z[1]) < 0.9 ? 1 : 0, 0};
        glint_cross3(x, up, z);
        glint_normalise3(x);
    }
    glint_cross3(y, z, x);
    const double r[16] = {x[0], x[1], x[2], 0, y[0],  y[1],  y[2],  0,
                          z[0], z[1], z[2], 0, m[12], m[13], m[14], 1};
    memcpy(out, r, sizeof r);
    return true;
}
