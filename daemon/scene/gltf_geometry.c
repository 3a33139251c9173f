// gltf_geometry.c - batches of geometry for Assimp, and what is done to the arrays it gives back.
#include "scene/gltf_file.h"

#include <math.h>
#include <string.h>

#define BATCH_BYTES ((size_t)32 << 20) // Assimp needs several times as much while it works

static size_t bytes_of(const struct glint_gltf_geometry *g)
{
    size_t bytes = 0;
    for (int i = 0; i < GLTF_ASSEMBLED; i++)
        bytes += (size_t)g->part[i].count * g->part[i].components * 4;
    return bytes;
}

void glint_gltf_read_geometry(struct glint_gltf *g, const struct glint_gltf_geometry *geometry,
                              uint32_t count)
{
    for (uint32_t first = 0, end; first < count && !g->err->status; first = end) {
        size_t bytes = bytes_of(&geometry[first]);
        for (end = first + 1; end < count; end++) {
            bytes += bytes_of(&geometry[end]);
            if (bytes > BATCH_BYTES)
                break;
        }
        glint_gltf_assemble(g, geometry, first, end - first);
    }
    for (uint32_t i = 0; i < count && !g->err->status; i++)
        glint_gltf_read_attributes(g, i, &geometry[i]);
}

static bool normalise(float v[3])
{
    const double length = sqrt((double)v[0] * v[0] + (double)v[1] * v[1] + (double)v[2] * v[2]);
    if (!(length > 1e-30 && isfinite(length)))
        return false;
    for (int i = 0; i < 3; i++)
        v[i] = (float)(v[i] / length);
    return true;
}

static bool check_positions(struct glint_gltf *g, const struct glint_mesh *m, float *reach,
                            const struct glint_gltf_geometry *geometry)
{
    *reach = 0;
    for (size_t i = 0; i < (size_t)m->vertices * 3; i++) {
        const float size = fabsf(m->position[i]);
        if (!(size <= GLINT_MAX_COORDINATE))
            return glint_gltf_accessor_fault(g, &geometry->part[GLTF_POSITION],
                                             "vertex %zu of mesh \"%.200s\" has the coordinate %g",
                                             i / 3, geometry->name, (double)m->position[i]);
        *reach = size > *reach ? size : *reach;
    }
    return true;
}

// (b - a) x (c - a), unit, or +z for a triangle without area.
static void face_normal(const struct glint_mesh *m, const uint32_t *t, float out[3])
{
    const float *a = m->position + (size_t)t[0] * 3, *b = m->position + (size_t)t[1] * 3;
    const float *c = m->position + (size_t)t[2] * 3;
    double u[3], v[3];
    for (int i = 0; i < 3; i++) {
        u[i] = (double)b[i] - a[i];
        v[i] = (double)c[i] - a[i];
    }
    const double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                         u[0] * v[1] - u[1] * v[0]};
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int i = 0; i < 3; i++)
        out[i] = length > 0 ? (float)(n[i] / length) : (float)(i == 2);
}

// Normals without a length become that of a face they belong to.
static void clean_normals(struct glint_gltf *g, struct glint_mesh *m, const char *name)
{
    float *normal = (float *)m->normal;
    uint32_t bad = 0;
    for (uint32_t i = 0; i < m->vertices; i++)
        if (!normalise(normal + (size_t)i * 3)) {
            memset(normal + (size_t)i * 3, 0, 3 * sizeof *normal);
            bad++;
        }
    if (!bad)
        return;
    glint_gltf_note(g, "normals without a direction",
                    "%u normals of mesh \"%.200s\" have no direction; the faces' are used", bad,
                    name);
    static const float zero[3];
    for (size_t k = 0; k < (size_t)m->triangles * 3; k++) {
        float *n = normal + (size_t)m->index[k] * 3;
        if (memcmp(n, zero, sizeof zero) == 0)
            face_normal(m, m->index + k / 3 * 3, n);
    }
    for (uint32_t i = 0; i < m->vertices; i++) // in no triangle
        if (memcmp(normal + (size_t)i * 3, zero, sizeof zero) == 0)
            normal[(size_t)i * 3 + 2] = 1;
}

// Any unit vector across the normal.
static void across(const float n[3], float out[3])
{
    const int least = fabsf(n[0]) < fabsf(n[1]) ? (fabsf(n[0]) < fabsf(n[2]) ? 0 : 2)
                                                : (fabsf(n[1]) < fabsf(n[2]) ? 1 : 2);
    for (int i = 0; i < 3; i++)
        out[i] = (float)(i == least) - n[least] * n[i];
    normalise(out);
}

static void clean_tangents(struct glint_mesh *m)
{
    float *tangent = (float *)m->tangent;
    for (uint32_t i = 0; i < m->vertices; i++) {
        float *t = tangent + (size_t)i * 4;
        if (!normalise(t))
            across(m->normal + (size_t)i * 3, t);
        t[3] = t[3] < 0 ? -1 : 1;
    }
}

void glint_gltf_clean_mesh(struct glint_gltf *g, uint32_t mesh,
                           const struct glint_gltf_geometry *geometry)
{
    struct glint_mesh *m = &g->scene->mesh[mesh];
    const char *name = geometry->name;
    if (!check_positions(g, m, &g->reach[mesh], geometry))
        return;
    if (m->normal)
        clean_normals(g, m, name);
    if (m->tangent)
        clean_tangents(m);
}
