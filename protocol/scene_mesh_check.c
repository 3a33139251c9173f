// scene_mesh_check.c - what must hold for the arrays of a mesh before anybody indexes with them.
#include "protocol/scene_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define UNIT_TOLERANCE 1e-5f // of a squared length; rounding a unit vector leaves 4e-7
#define MIN_WEIGHT 1e-6      // of four together

// Largest magnitude as bits: without their sign they order as the floats do, infinities and NaN
// last, so one maximum finds what is too large and what is no number.
static int32_t largest(const float *value, size_t count)
{
    int32_t most = 0;
#pragma omp simd reduction(max : most)
    for (size_t i = 0; i < count; i++) {
        int32_t bits;
        memcpy(&bits, &value[i], sizeof bits);
        bits &= 0x7fffffff;
        most = bits > most ? bits : most;
    }
    return most;
}

static float as_float(int32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static bool bounded(const struct glint_json *at, const char *what, const float *value, size_t width,
                    size_t count, float *most)
{
    if (!value)
        return true;
    const float found = as_float(largest(value, width * count));
    if (found <= GLINT_MAX_COORDINATE) {
        *most = found;
        return true;
    }
    size_t i = 0;
    while (fabsf(value[i]) <= GLINT_MAX_COORDINATE)
        i++;
    return glint_json_fault(at, "%s %zu is %g: not finite or larger than %g", what, i / width,
                            value[i], GLINT_MAX_COORDINATE);
}

static bool indices_fit(const struct glint_json *at, const struct glint_mesh *m)
{
    const size_t count = (size_t)m->triangles * 3;
    uint32_t most = 0;
    for (size_t i = 0; i < count; i++)
        most = m->index[i] > most ? m->index[i] : most;
    if (most < m->vertices)
        return true;
    size_t i = 0;
    while (m->index[i] < m->vertices)
        i++;
    return glint_json_fault(at, "triangle %zu names vertex %u; there are %u", i / 3, m->index[i],
                            m->vertices);
}

static bool handed(const struct glint_json *at, const struct glint_mesh *m)
{
    for (size_t i = 0; m->tangent && i < m->vertices; i++)
        if (fabsf(m->tangent[4 * i + 3]) != 1)
            return glint_json_fault(at, "tangent %zu: its fourth number must be 1 or -1, not %g", i,
                                    m->tangent[4 * i + 3]);
    return true;
}

// ---- colours

// Nothing reflects more than it receives: what is above 1 is cut, in a copy.
static bool colors_fit(struct glint_scene_reader *r, const struct glint_json *at,
                       struct glint_mesh *m)
{
    const size_t count = m->color ? (size_t)m->vertices * 4 : 0;
    float least = 0, most = 0;
    for (size_t i = 0; i < count; i++) {
        least = m->color[i] < least ? m->color[i] : least;
        most = m->color[i] > most ? m->color[i] : most;
    }
    if (least < 0) {
        size_t i = 0;
        while (m->color[i] >= 0)
            i++;
        return glint_json_fault(at, "color %zu has %g in it: negative", i / 4, m->color[i]);
    }
    if (most <= 1)
        return true;
    float *copy = glint_arena_array(&r->scene->arena, count, sizeof *copy);
    if (!copy)
        return glint_scene_no_memory(r);
    for (size_t i = 0; i < count; i++)
        copy[i] = fminf(m->color[i], 1);
    m->color = copy;
    return true;
}

// ---- joints

static double weight_sum(const float w[4])
{
    return (double)w[0] + w[1] + w[2] + w[3];
}

static bool scale_weights(struct glint_scene_reader *r, struct glint_mesh *m)
{
    float *copy = glint_arena_array(&r->scene->arena, m->vertices, 4 * sizeof *copy);
    if (!copy)
        return glint_scene_no_memory(r);
    for (size_t i = 0; i < (size_t)m->vertices * 4; i++)
        copy[i] = (float)(m->weight[i] / weight_sum(m->weight + i / 4 * 4));
    m->weight = copy;
    return true;
}

static bool weights_fit(struct glint_scene_reader *r, const struct glint_json *at,
                        struct glint_mesh *m)
{
    bool unit = true;
    for (size_t i = 0; i < m->vertices; i++) {
        const float *w = m->weight + 4 * i;
        const double sum = weight_sum(w);
        if (!(w[0] >= 0 && w[1] >= 0 && w[2] >= 0 && w[3] >= 0))
            return glint_json_fault(at, "the weights of vertex %zu are %g %g %g %g: negative", i,
                                    w[0], w[1], w[2], w[3]);
        if (sum < MIN_WEIGHT)
            return glint_json_fault(at, "the weights of vertex %zu are zero", i);
        unit &= fabs(sum - 1) <= UNIT_TOLERANCE;
    }
    return unit || scale_weights(r, m);
}

static bool joints_fit(struct glint_scene_reader *r, const struct glint_json *at,
                       struct glint_mesh *m)
{
    if (!m->joint && !m->weight)
        return true;
    if (!m->joint || !m->weight)
        return glint_json_fault(at, "joints and weights go together; there are %s only",
                                m->joint ? "joints" : "weights");
    uint16_t most = 0;
    for (size_t i = 0; i < (size_t)m->vertices * 4; i++)
        most = m->joint[i] > most ? m->joint[i] : most;
    m->joint_end = most + 1u;
    return weights_fit(r, at, m);
}

// ---- normals

static bool all_unit(const float *n, size_t count)
{
    float worst = 0;
    for (size_t i = 0; i < count; i++) {
        const float d = fabsf(n[3 * i] * n[3 * i] + n[3 * i + 1] * n[3 * i + 1] +
                              n[3 * i + 2] * n[3 * i + 2] - 1);
        worst = d > worst ? d : worst;
    }
    return worst <= UNIT_TOLERANCE;
}

// False for what has no direction.
static bool make_unit(float n[3])
{
    const double x = n[0], y = n[1], z = n[2], length = sqrt(x * x + y * y + z * z);
    if (!(length > 1e-30))
        return false;
    n[0] = (float)(x / length);
    n[1] = (float)(y / length);
    n[2] = (float)(z / length);
    return true;
}

static void add_face(const struct glint_mesh *m, const uint32_t *corner, float *sum)
{
    double a[3], b[3];
    const float *p = m->position;
    for (int k = 0; k < 3; k++) {
        a[k] = (double)p[3 * corner[1] + k] - p[3 * corner[0] + k];
        b[k] = (double)p[3 * corner[2] + k] - p[3 * corner[0] + k];
    }
    sum[0] += (float)(a[1] * b[2] - a[2] * b[1]);
    sum[1] += (float)(a[2] * b[0] - a[0] * b[2]);
    sum[2] += (float)(a[0] * b[1] - a[1] * b[0]);
}

// Vertices without a direction take that of their faces, or +z where those have none either.
static void fill_from_faces(const struct glint_mesh *m, float *normal, const unsigned char *empty)
{
    for (size_t t = 0; t < m->triangles; t++) {
        const uint32_t *corner = m->index + 3 * t;
        for (int k = 0; k < 3; k++)
            if (empty[corner[k]])
                add_face(m, corner, normal + 3 * (size_t)corner[k]);
    }
    for (size_t i = 0; i < m->vertices; i++)
        if (empty[i] && !make_unit(normal + 3 * i))
            memcpy(normal + 3 * i, (const float[]){0, 0, 1}, 3 * sizeof *normal);
}

static bool normalise(struct glint_scene_reader *r, struct glint_mesh *m)
{
    float *copy = glint_arena_array(&r->scene->arena, m->vertices, 3 * sizeof *copy);
    unsigned char *empty = calloc(m->vertices, 1);
    if (copy && empty) {
        bool any = false;
        memcpy(copy, m->normal, (size_t)m->vertices * 3 * sizeof *copy);
        for (size_t i = 0; i < m->vertices; i++) {
            empty[i] = !make_unit(copy + 3 * i);
            any |= empty[i];
        }
        if (any)
            fill_from_faces(m, copy, empty);
        m->normal = copy;
    }
    free(empty);
    return (copy && empty) || glint_scene_no_memory(r);
}

static bool targets_fit(const struct glint_json *at, struct glint_mesh *m)
{
    const size_t count = (size_t)m->targets * m->vertices;
    float unused;
    bool fine = bounded(at, "target position", m->target_position, 3, count, &m->target_reach);
    fine &= bounded(at, "target normal", m->target_normal, 3, count, &unused);
    fine &= bounded(at, "target tangent", m->target_tangent, 3, count, &unused);
    return fine;
}

void glint_mesh_box(const struct glint_mesh *m, float low[3], float high[3])
{
    const float *p = m->position;
    memcpy(low, p, 3 * sizeof *low);
    memcpy(high, p, 3 * sizeof *high);
    for (size_t i = 0; i < (size_t)m->vertices * 3; i += 3)
        for (int k = 0; k < 3; k++) {
            low[k] = p[i + k] < low[k] ? p[i + k] : low[k];
            high[k] = p[i + k] > high[k] ? p[i + k] : high[k];
        }
}

bool glint_mesh_check(struct glint_scene_reader *r, const struct glint_json *at,
                      struct glint_mesh *mesh)
{
    struct glint_mesh *m = mesh;
    float unused;
    bool fine = bounded(at, "position", m->position, 3, m->vertices, &m->reach);
    fine &= bounded(at, "normal", m->normal, 3, m->vertices, &unused);
    fine &= bounded(at, "uv", m->uv, 2, m->vertices, &unused);
    fine &= bounded(at, "tangent", m->tangent, 4, m->vertices, &unused) && handed(at, m);
    fine &= bounded(at, "second uv", m->uv1, 2, m->vertices, &unused);
    fine &= bounded(at, "color", m->color, 4, m->vertices, &unused) && colors_fit(r, at, m);
    fine &= bounded(at, "weight", m->weight, 4, m->vertices, &unused) && joints_fit(r, at, m);
    fine &= targets_fit(at, m);
    fine &= indices_fit(at, m);
    if (fine)
        glint_mesh_box(m, m->low, m->high);
    m->checked = true;
    if (!fine || !m->normal || all_unit(m->normal, m->vertices))
        return fine;
    return normalise(r, m);
}
