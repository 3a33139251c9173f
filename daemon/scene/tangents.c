// tangents.c - tangent-space records, derived from the texture coordinates where a mesh has none.
#include "scene/records.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void edge(const float *a, const float *b, double e[3])
{
    for (int k = 0; k < 3; k++)
        e[k] = (double)b[k] - a[k];
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double c[3])
{
    for (int k = 0; k < 3; k++)
        c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static void store_unit(const double v[3], float out[3])
{
    const double length = sqrt(dot(v, v));
    for (int k = 0; k < 3; k++)
        out[k] = length > 0.0 ? (float)(v[k] / length) : 0.0f;
}

// Sum over a vertex's triangles of dP/du, the direction in which the texture runs, and the sign of
// the bitangent: v runs downwards in the image, the normal map's y upwards.
static void add_face_tangent(const struct glint_mesh *m, const float *position, const uint32_t *t,
                             double *sum)
{
    double e1[3], e2[3], n[3], tangent[3], bitangent[3], side[3];
    edge(position + 3 * (size_t)t[0], position + 3 * (size_t)t[1], e1);
    edge(position + 3 * (size_t)t[0], position + 3 * (size_t)t[2], e2);
    const float *a = m->uv + 2 * (size_t)t[0], *b = m->uv + 2 * (size_t)t[1],
                *c = m->uv + 2 * (size_t)t[2];
    const double u1 = b[0] - a[0], v1 = b[1] - a[1], u2 = c[0] - a[0], v2 = c[1] - a[1];
    const double det = u1 * v2 - u2 * v1;
    if (det == 0.0)
        return;
    for (int k = 0; k < 3; k++) {
        tangent[k] = (e1[k] * v2 - e2[k] * v1) / det;
        bitangent[k] = -(e2[k] * u1 - e1[k] * u2) / det;
    }
    cross(e1, e2, n);
    cross(n, tangent, side);
    const double sign = dot(side, bitangent) < 0.0 ? -1.0 : 1.0;
    const double area = sqrt(dot(n, n)), length = sqrt(dot(tangent, tangent));
    for (int v = 0; v < 3; v++) {
        for (int k = 0; k < 3; k++)
            sum[4 * (size_t)t[v] + k] += length > 0.0 ? tangent[k] / length * area : 0.0;
        sum[4 * (size_t)t[v] + 3] += sign * area;
    }
}

// [vertices][4] as in glTF, malloc'd; NULL without memory.
static float *derive_tangents(const struct glint_mesh *m, const float *position)
{
    double *sum = calloc(m->vertices, 4 * sizeof *sum);
    float *out = malloc((size_t)m->vertices * 16);
    if (sum && out) {
        for (uint32_t i = 0; m->uv && i < m->triangles; i++)
            add_face_tangent(m, position, m->index + 3 * (size_t)i, sum);
        for (size_t v = 0; v < m->vertices; v++) {
            store_unit(sum + 4 * v, out + 4 * v);
            out[4 * v + 3] = sum[4 * v + 3] < 0.0 ? -1.0f : 1.0f;
        }
    } else {
        free(out);
        out = NULL;
    }
    free(sum);
    return out;
}

glint_status glint_records_fill_tangents(struct gk_tangent *out, const struct glint_kept *k,
                                         uint32_t key, struct glint_error *err)
{
    const size_t start = (size_t)key * k->mesh->vertices;
    float *derived = k->tangent ? NULL : derive_tangents(k->mesh, k->position + 3 * start);
    const float *tangent = k->tangent ? k->tangent + 4 * start : derived;
    if (!tangent)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for tangents");
    for (uint32_t i = 0; i < k->triangles; i++)
        for (int c = 0; c < 3; c++)
            memcpy(out[i].tangent + 4 * c, tangent + 4 * (size_t)k->index[3 * (size_t)i + c], 16);
    free(derived);
    return GLINT_OK;
}
