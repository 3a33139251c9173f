#include "scene/shape.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// A triangle whose height is below this share of its longest side is no surface.
#define SLIVER 1e-7

static void edge(const float *a, const float *b, double e[3])
{
    for (int k = 0; k < 3; k++)
        e[k] = (double)b[k] - a[k];
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static bool degenerate(const float *position, const uint32_t *t)
{
    double u[3], v[3], w[3], n[3];
    const float *a = position + 3 * (size_t)t[0], *b = position + 3 * (size_t)t[1],
                *c = position + 3 * (size_t)t[2];
    edge(a, b, u);
    edge(a, c, v);
    edge(b, c, w);
    for (int k = 0; k < 3; k++)
        n[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
    const double longest = fmax(dot(u, u), fmax(dot(v, v), dot(w, w)));
    return !(dot(n, n) > SLIVER * SLIVER * longest * longest);
}

static bool surface(const struct glint_mesh *m, const float *position, uint32_t keys,
                    const uint32_t *t)
{
    for (uint32_t k = 0; k < keys; k++)
        if (!degenerate(position + (size_t)k * m->vertices * 3, t))
            return true;
    return false;
}

static void measure(struct glint_shape *s, const float *position, size_t vertices)
{
    for (int k = 0; k < 3; k++)
        s->low[k] = s->high[k] = position[k];
    for (size_t i = 1; i < vertices; i++)
        for (int k = 0; k < 3; k++) {
            const float x = position[3 * i + k];
            s->low[k] = x < s->low[k] ? x : s->low[k];
            s->high[k] = x > s->high[k] ? x : s->high[k];
        }
}

// The list of those kept, from the first that is not.
static glint_status list_kept(struct glint_shape *s, const struct glint_mesh *m,
                              const float *position, uint32_t keys, uint32_t from,
                              struct glint_error *err)
{
    s->index = malloc((size_t)m->triangles * 12);
    if (!s->index)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u triangles", m->triangles);
    memcpy(s->index, m->index, (size_t)from * 12);
    s->triangles = from;
    for (uint32_t i = from; i < m->triangles; i++)
        if (surface(m, position, keys, m->index + 3 * (size_t)i))
            memcpy(s->index + 3 * (size_t)s->triangles++, m->index + 3 * (size_t)i, 12);
    s->dropped = m->triangles - s->triangles;
    return GLINT_OK;
}

glint_status glint_shape_create(struct glint_shape **out, const struct glint_mesh *mesh,
                                const float *position, uint32_t keys, struct glint_error *err)
{
    *out = NULL;
    struct glint_shape *s = calloc(1, sizeof *s);
    if (!s)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a mesh");
    atomic_init(&s->references, 1);
    pthread_mutex_init(&s->mutex, NULL);
    measure(s, position, (size_t)keys * mesh->vertices);
    while (s->triangles < mesh->triangles &&
           surface(mesh, position, keys, mesh->index + 3 * (size_t)s->triangles))
        s->triangles++;
    glint_status st = GLINT_OK;
    if (s->triangles < mesh->triangles)
        st = list_kept(s, mesh, position, keys, s->triangles, err);
    if (st)
        glint_shape_release(&s);
    *out = s;
    return st;
}

struct glint_shape *glint_shape_retain(struct glint_shape *shape)
{
    atomic_fetch_add_explicit(&shape->references, 1, memory_order_relaxed);
    return shape;
}

void glint_shape_release(struct glint_shape **shape)
{
    struct glint_shape *s = *shape;
    *shape = NULL;
    // Acquire-release: the last holder sees all that the others did before it frees.
    if (!s || atomic_fetch_sub_explicit(&s->references, 1, memory_order_acq_rel) != 1)
        return;
    for (int i = 0; i < 4; i++)
        glint_body_release(&s->body[i / 2][i % 2]);
    pthread_mutex_destroy(&s->mutex);
    free(s->index);
    free(s);
}

void glint_shape_origin(const struct glint_shape *shape, float origin[3])
{
    for (int k = 0; k < 3; k++)
        origin[k] = (float)(0.5 * ((double)shape->low[k] + shape->high[k]));
}

glint_status glint_shape_body(struct glint_shape *shape, glint_tracer *tracer,
                              const struct glint_geometry_mesh *mesh,
                              const struct glint_geometry_build *build, glint_body **out,
                              bool *built, struct glint_error *err)
{
    glint_status st = GLINT_OK;
    pthread_mutex_lock(&shape->mutex);
    glint_body **body = &shape->body[build->robust][mesh->holes];
    if (!*body) {
        struct glint_geometry_mesh centred = *mesh;
        glint_shape_origin(shape, centred.origin);
        st = glint_body_create(body, tracer, &centred, build, err);
        *built = true;
    }
    *out = *body;
    pthread_mutex_unlock(&shape->mutex);
    return st;
}

uint64_t glint_shape_bytes(struct glint_shape *shape)
{
    uint64_t bytes = 0;
    pthread_mutex_lock(&shape->mutex);
    for (int i = 0; i < 4; i++)
        bytes += shape->body[i / 2][i % 2] ? glint_body_bytes(shape->body[i / 2][i % 2]) : 0;
    pthread_mutex_unlock(&shape->mutex);
    return bytes;
}
