// pose_deform.c - morph targets and skins over the vertices of a mesh.
//
// In single precision, four lanes at a time: matrices come relative to the middle of the shape, so
// that what is far from the world's origin keeps its digits.
#include "scene/pose_work.h"

#include <math.h>
#include <string.h>

typedef float lanes __attribute__((vector_size(16)));

// No number becomes a bound.
static inline float bounded(float x)
{
    const float least = x > -GLINT_MAX_COORDINATE ? x : -GLINT_MAX_COORDINATE;
    return least < GLINT_MAX_COORDINATE ? least : GLINT_MAX_COORDINATE;
}

static inline lanes splat(float x)
{
    return (lanes){x, x, x, x};
}

static inline lanes cross(lanes a, lanes b)
{
    const lanes a1 = __builtin_shufflevector(a, a, 1, 2, 0, 3);
    const lanes b1 = __builtin_shufflevector(b, b, 1, 2, 0, 3);
    const lanes c = a * b1 - a1 * b;
    return __builtin_shufflevector(c, c, 1, 2, 0, 3);
}

// Squares of lengths outside of these may have lost digits.
#define LEAST_SQUARE 1e-24f
#define MOST_SQUARE 1e24f

static void store_unit_slowly(float out[3], const float v[3], const float otherwise[3])
{
    const double length = sqrt((double)v[0] * v[0] + (double)v[1] * v[1] + (double)v[2] * v[2]);
    const bool fine = length > 0 && isfinite(length);
    for (int k = 0; k < 3; k++)
        out[k] = fine ? (float)(v[k] / length) : otherwise[k];
}

static inline void store_unit(float out[3], float x, float y, float z, const float otherwise[3])
{
    const float square = x * x + y * y + z * z;
    if (square > LEAST_SQUARE && square < MOST_SQUARE) {
        const float scale = 1.0f / sqrtf(square);
        out[0] = x * scale;
        out[1] = y * scale;
        out[2] = z * scale;
        return;
    }
    const float v[3] = {x, y, z};
    store_unit_slowly(out, v, otherwise);
}

// out += weight * from; vectors of three that lie `stride` floats apart in `out`.
static void add(float *restrict out, size_t stride, const float *restrict from, float weight,
                size_t count)
{
    if (stride == 3) {
        for (size_t i = 0; i < 3 * count; i++)
            out[i] += weight * from[i];
        return;
    }
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++)
            out[stride * i + k] += weight * from[3 * i + k];
}

static void make_unit(float *out, size_t stride, const float *otherwise, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        float *v = out + stride * i;
        store_unit(v, v[0], v[1], v[2], otherwise + stride * i);
    }
}

static void morph(float *out, size_t stride, const float *base, const float *target,
                  const struct glint_mesh *mesh, const double *weight, bool unit)
{
    const size_t count = mesh->vertices;
    memcpy(out, base, count * stride * sizeof *out);
    for (uint32_t t = 0; target && t < mesh->targets; t++)
        if (weight[t] != 0)
            add(out, stride, target + 3 * count * t, (float)weight[t], count);
    if (unit && target)
        make_unit(out, stride, base, count);
}

void glint_pose_morph(const struct glint_mesh *mesh, const double *weight,
                      const struct glint_pose_deformed *out)
{
    morph(out->position, 3, mesh->position, mesh->target_position, mesh, weight, false);
    for (size_t i = 0; i < (size_t)3 * mesh->vertices; i++)
        out->position[i] = bounded(out->position[i]);
    if (out->normal)
        morph(out->normal, 3, mesh->normal, mesh->target_normal, mesh, weight, true);
    if (out->tangent)
        morph(out->tangent, 4, mesh->tangent, mesh->target_tangent, mesh, weight, true);
}

struct blend {
    lanes column[4];
};

static inline struct blend blend_at(const struct glint_mesh *mesh, const lanes *matrix, size_t v)
{
    const uint16_t *joint = mesh->joint + 4 * v;
    const float *weight = mesh->weight + 4 * v;
    struct blend b = {{splat(0), splat(0), splat(0), splat(0)}};
    for (int i = 0; i < 4; i++) {
        const lanes *m = matrix + 4 * (size_t)joint[i], w = splat(weight[i]);
        for (int c = 0; c < 4; c++)
            b.column[c] += w * m[c];
    }
    return b;
}

static inline lanes apply(const lanes *column, const float v[3])
{
    return column[0] * splat(v[0]) + column[1] * splat(v[1]) + column[2] * splat(v[2]);
}

// Normals go by the cofactors, which are the inverse transpose but for its length.
static inline lanes apply_cofactors(const lanes *column, const float v[3])
{
    const lanes cofactor[3] = {cross(column[1], column[2]), cross(column[2], column[0]),
                               cross(column[0], column[1])};
    return apply(cofactor, v);
}

void glint_pose_skin(const struct glint_mesh *mesh, const float *matrix,
                     const struct glint_pose_deformed *from, const struct glint_pose_deformed *out)
{
    const lanes *column = (const lanes *)matrix;
    for (size_t i = 0; i < mesh->vertices; i++) {
        const struct blend b = blend_at(mesh, column, i);
        const lanes p = apply(b.column, from->position + 3 * i) + b.column[3];
        for (int k = 0; k < 3; k++)
            out->position[3 * i + k] = bounded(p[k]);
        if (out->normal) {
            const lanes n = apply_cofactors(b.column, from->normal + 3 * i);
            store_unit(out->normal + 3 * i, n[0], n[1], n[2], from->normal + 3 * i);
        }
        if (out->tangent) {
            const lanes t = apply(b.column, from->tangent + 4 * i);
            store_unit(out->tangent + 4 * i, t[0], t[1], t[2], from->tangent + 4 * i);
            out->tangent[4 * i + 3] = from->tangent[4 * i + 3];
        }
    }
}
