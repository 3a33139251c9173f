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

static void column(const double m[16], int i, double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = m[4 * i + k];
}

static void widen(const float m[16], double out[16])
{
    for (int i = 0; i < 16; i++)
        out[i] = m[i];
}

bool glint_transform_invertible(const double m[16])
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

bool glint_transform_affine(float m[16])
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

struct parts {
    float translation[3], rotation[4], scale[3];
};

static double length4(const float q[4])
{
    return sqrt((double)q[0] * q[0] + (double)q[1] * q[1] + (double)q[2] * q[2] +
                (double)q[3] * q[3]);
}

static bool read_parts(const struct glint_json *at, struct parts *p)
{
    static const char *const known[] = {"translation", "rotation", "scale", NULL};
    const struct glint_json translation = glint_json_member(at, "translation");
    const struct glint_json rotation = glint_json_member(at, "rotation");
    const struct glint_json scale = glint_json_member(at, "scale");
    const float far = GLINT_MAX_COORDINATE;
    *p = (struct parts){{0, 0, 0}, {0, 0, 0, 1}, {1, 1, 1}};
    bool fine = glint_json_only(at, known);
    fine &= glint_json_floats(&translation, 3, -far, far, p->translation);
    fine &= glint_json_floats(&rotation, 4, -1e6f, 1e6f, p->rotation);
    fine &= glint_json_floats(&scale, 3, -far, far, p->scale);
    if (fine && length4(p->rotation) < 1e-6)
        return glint_json_fault(&rotation, "the quaternion is zero");
    return fine;
}

void glint_transform_compose(const float translation[3], const float rotation[4],
                             const float scale[3], float m[16])
{
    double q[4];
    const double length = length4(rotation);
    for (int k = 0; k < 4; k++)
        q[k] = rotation[k] / length;
    compose(m, translation, q, scale);
}

static bool check(const struct glint_json *at, float m[16])
{
    double wide[16];
    if (!glint_transform_affine(m))
        return glint_json_fault(at, "not affine: the last row is not 0 0 0 1");
    widen(m, wide);
    return glint_transform_invertible(wide) || glint_json_fault(at, "the matrix is singular");
}

// *whole: it was given as 16 numbers, which leaves the parts alone.
static bool read_either(const struct glint_json *at, float m[16], struct parts *p, bool *whole)
{
    const float far = GLINT_MAX_COORDINATE;
    *whole = !cJSON_IsObject(at->value);
    if (*whole ? !glint_json_floats(at, 16, -far, far, m) : !read_parts(at, p))
        return false;
    if (!*whole)
        glint_transform_compose(p->translation, p->rotation, p->scale, m);
    return check(at, m);
}

bool glint_transform_read(const struct glint_json *at, float out[16])
{
    float m[16];
    struct parts parts;
    bool whole;
    if (!at->value)
        return true;
    if (!read_either(at, m, &parts, &whole))
        return false;
    memcpy(out, m, sizeof m);
    return true;
}

// What is unit but for rounding stays as it is, so that reading what was written changes nothing.
static void make_unit(float q[4])
{
    const double length = length4(q);
    for (int k = 0; k < 4 && fabs(length - 1) > 1e-6; k++)
        q[k] = (float)(q[k] / length);
}

bool glint_transform_read_node(const struct glint_json *at, struct glint_node *node)
{
    float m[16];
    struct parts parts;
    if (!at->value)
        return true;
    if (!read_either(at, m, &parts, &node->matrix))
        return false;
    if (node->matrix) {
        memcpy(node->transform, m, sizeof m);
        return true;
    }
    make_unit(parts.rotation);
    memcpy(node->translation, parts.translation, sizeof parts.translation);
    memcpy(node->rotation, parts.rotation, sizeof parts.rotation);
    memcpy(node->scale, parts.scale, sizeof parts.scale);
    glint_transform_compose(parts.translation, parts.rotation, parts.scale, node->transform);
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
    double axis[3][3], wide[16];
    widen(m, wide);
    for (int i = 0; i < 3; i++)
        column(wide, i, axis[i]);
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

// The largest eigenvalue of the symmetric 3 x 3 matrix of the columns' products, by the cosine
// formula (Smith 1961, doi:10.1145/355578.366316).
double glint_transform_stretch(const float m[16])
{
    double c[3][3], g[3][3], wide[16];
    widen(m, wide);
    for (int i = 0; i < 3; i++)
        column(wide, i, c[i]);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            g[i][k] = dot(c[i], c[k]);
    const double q = (g[0][0] + g[1][1] + g[2][2]) / 3;
    double square = 0;
    for (int i = 0; i < 3; i++) {
        g[i][i] -= q;
        square += dot(g[i], g[i]);
    }
    const double p = sqrt(square / 6);
    if (!(p > 0))
        return sqrt(q);
    double n[3];
    cross(g[0], g[1], n);
    const double half = fmin(fmax(dot(n, g[2]) / (2 * p * p * p), -1), 1);
    return sqrt(q + 2 * p * cos(acos(half) / 3));
}

void glint_transform_chain(double out[16], const double a[16], const double b[16])
{
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 4; k++) {
            out[4 * i + k] = 0;
            for (int j = 0; j < 4; j++)
                out[4 * i + k] += a[4 * j + k] * b[4 * i + j];
        }
}

void glint_transform_product(double out[16], const double a[16], const float b[16])
{
    double wide[16];
    widen(b, wide);
    glint_transform_chain(out, a, wide);
}
