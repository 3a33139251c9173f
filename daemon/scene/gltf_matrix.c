// gltf_matrix.c - transforms as they are stored, and taken apart.
#include "scene/gltf_file.h"

#include <math.h>

bool glint_gltf_fit(float out[16], const double m[16])
{
    for (int i = 0; i < 16; i++) {
        out[i] = (float)m[i];
        if (!(fabsf(out[i]) <= GLINT_MAX_COORDINATE))
            return false;
    }
    return true;
}

bool glint_gltf_to_float(float out[16], const double m[16])
{
    double stored[16];
    if (!glint_gltf_fit(out, m))
        return false;
    glint_matrix_widen(stored, out);
    return !glint_matrix_singular(stored);
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

bool glint_gltf_rigid(float out[16], const double m[16])
{
    double r[16];
    return glint_matrix_rigid(r, m) && glint_gltf_fit(out, r);
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
    const double length = sqrt(glint_dot3(q, q) + q[3] * q[3]);
    for (int a = 0; a < 4; a++)
        q[a] /= length;
}

bool glint_gltf_decompose(const double m[16], double t[3], double q[4], double s[3])
{
    double axis[3][3], n[3];
    for (int i = 0; i < 3; i++) {
        t[i] = m[12 + i];
        s[i] = sqrt(glint_dot3(m + 4 * i, m + 4 * i));
        for (int k = 0; k < 3; k++)
            axis[i][k] = s[i] > 0 ? m[4 * i + k] / s[i] : (double)(i == k);
    }
    glint_cross3(n, axis[0], axis[1]);
    bool clean = fabs(fabs(glint_dot3(n, axis[2])) - 1) < 1e-6;
    if (glint_dot3(n, axis[2]) < 0) {
        s[0] = -s[0];
        for (int k = 0; k < 3; k++)
            axis[0][k] = -axis[0][k];
    }
    // square, where it was not: z stays, y as far as it can
    glint_cross3(axis[0], axis[1], axis[2]);
    clean = glint_normalise3(axis[0]) && clean;
    glint_cross3(axis[1], axis[2], axis[0]);
    quaternion(axis, q);
    return clean;
}
