// scene_transform.c - affine matrices: read, checked, made rigid.
#include "protocol/scene_parts.h"

#include <float.h>
#include <math.h>
#include <string.h>

// Rounding 16 floats of a singular matrix can leave a determinant of some 1e-7 of the product of
// its columns' lengths; a shear that comes closer to it has no usable inverse either.
#define MIN_VOLUME 1e-6
#define MIN_SCALE 1e-12

const float glint_identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void column(const float m[16], int i, double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = m[4 * i + k];
}

static bool invertible(const float m[16])
{
    double x[3], y[3], z[3], n[3];
    column(m, 0, x);
    column(m, 1, y);
    column(m, 2, z);
    cross(x, y, n);
    const double lx = sqrt(dot(x, x)), ly = sqrt(dot(y, y)), lz = sqrt(dot(z, z));
    return lx > MIN_SCALE && ly > MIN_SCALE && lz > MIN_SCALE &&
           fabs(dot(n, z)) > MIN_VOLUME * lx * ly * lz;
}

static bool affine(float m[16])
{
    static const float last[4] = {0, 0, 0, 1};
    for (int i = 0; i < 4; i++) {
        if (fabsf(m[4 * i + 3] - last[i]) > 1e-6f)
            return false;
        m[4 * i + 3] = last[i];
    }
    return true;
}

static void compose(float m[16], const float t[3], const double q[4], const float s[3])
{
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    const double rotation[3][3] = {
        {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
        {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
        {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)},
    };
    memcpy(m, glint_identity, sizeof glint_identity);
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++)
            m[4 * i + k] = (float)(rotation[i][k] * s[i]);
        m[12 + i] = t[i];
    }
}

static bool read_parts(const struct glint_json *at, float m[16])
{
    static const char *const known[] = {"translation", "rotation", "scale", NULL};
    float t[3] = {0, 0, 0}, r[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1};
    const struct glint_json translation = glint_json_member(at, "translation");
    const struct glint_json rotation = glint_json_member(at, "rotation");
    const struct glint_json scale = glint_json_member(at, "scale");
    const float far = GLINT_MAX_COORDINATE;
    bool fine = glint_json_only(at, known);
    fine &= glint_json_floats(&translation, 3, -far, far, t);
    fine &= glint_json_floats(&rotation, 4, -1e6f, 1e6f, r);
    fine &= glint_json_floats(&scale, 3, -far, far, s);
    if (!fine)
        return false;
    const double length =
        sqrt((double)r[0] * r[0] + (double)r[1] * r[1] + (double)r[2] * r[2] + (double)r[3] * r[3]);
    if (length < 1e-6)
        return glint_json_fault(&rotation, "the quaternion is zero");
    compose(m, t, (const double[4]){r[0] / length, r[1] / length, r[2] / length, r[3] / length}, s);
    return true;
}

bool glint_transform_read(const struct glint_json *at, float out[16])
{
    float m[16];
    if (!at->value)
        return true;
    const float far = GLINT_MAX_COORDINATE;
    if (cJSON_IsObject(at->value) ? !read_parts(at, m) : !glint_json_floats(at, 16, -far, far, m))
        return false;
    if (!affine(m))
        return glint_json_fault(at, "not affine: the last row is not 0 0 0 1");
    if (!invertible(m))
        return glint_json_fault(at, "the matrix is singular");
    memcpy(out, m, sizeof m);
    return true;
}

static bool orthonormal(const double axis[3][3])
{
    for (int i = 0; i < 3; i++)
        for (int k = i; k < 3; k++)
            if (fabs(dot(axis[i], axis[k]) - (i == k)) > 1e-5)
                return false;
    return true;
}

// Takes the part along `unit` out of v.
static void reject(double v[3], const double unit[3])
{
    const double along = dot(v, unit);
    for (int k = 0; k < 3; k++)
        v[k] -= along * unit[k];
}

static void normalise(double v[3])
{
    const double length = sqrt(dot(v, v));
    for (int k = 0; k < 3; k++)
        v[k] /= length;
}

void glint_transform_rigid(float m[16])
{
    double axis[3][3];
    for (int i = 0; i < 3; i++)
        column(m, i, axis[i]);
    if (orthonormal((const double(*)[3])axis))
        return;
    normalise(axis[2]);
    reject(axis[1], axis[2]);
    normalise(axis[1]);
    reject(axis[0], axis[2]);
    reject(axis[0], axis[1]);
    normalise(axis[0]);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            m[4 * i + k] = (float)axis[i][k];
}

double glint_transform_reach(const float m[16], float reach)
{
    double most = 0;
    for (int k = 0; k < 3; k++) {
        const double sum = fabs((double)m[k]) + fabs((double)m[4 + k]) + fabs((double)m[8 + k]);
        most = fmax(most, sum * reach + fabs((double)m[12 + k]));
    }
    return most;
}
