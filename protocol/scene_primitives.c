// scene_primitives.c - sphere, quad, box and disk as triangles, counter-clockwise from outside.
//
// Texture coordinates as in glTF: u to the right, v down. The sphere's poles are on y, its seam is
// at +x, and u runs towards -z.
#include "protocol/scene_parts.h"

#include <math.h>
#include <string.h>

struct builder {
    float *position, *normal, *uv;
    uint32_t *index;
    uint32_t vertices, indices;
};

static void vertex(struct builder *b, const float p[3], const float n[3], float u, float v)
{
    memcpy(b->position + 3 * (size_t)b->vertices, p, 3 * sizeof *p);
    memcpy(b->normal + 3 * (size_t)b->vertices, n, 3 * sizeof *n);
    b->uv[2 * (size_t)b->vertices] = u;
    b->uv[2 * (size_t)b->vertices + 1] = v;
    b->vertices++;
}

static void triangle(struct builder *b, uint32_t i, uint32_t j, uint32_t k)
{
    b->index[b->indices++] = i;
    b->index[b->indices++] = j;
    b->index[b->indices++] = k;
}

// Exact at the quarters, so that seams close and poles meet.
static void on_circle(uint32_t i, uint32_t n, double *c, double *s)
{
    static const double cosines[4] = {1, 0, -1, 0};
    const uint64_t quarters = 4ull * i;
    if (quarters % n == 0) {
        *c = cosines[quarters / n % 4];
        *s = cosines[(quarters / n + 3) % 4];
    } else {
        *c = cos(2 * M_PI * i / n);
        *s = sin(2 * M_PI * i / n);
    }
}

// ---- sphere

static uint32_t rings(uint32_t segments)
{
    return segments / 2 < 2 ? 2 : segments / 2;
}

static void sphere_row(struct builder *b, const struct glint_primitive *p, uint32_t row)
{
    double up, out, c, s;
    on_circle(row, 2 * rings(p->segments), &up, &out);
    const bool pole = row == 0 || row == rings(p->segments);
    for (uint32_t i = 0; i <= p->segments; i++) {
        on_circle(i % p->segments, p->segments, &c, &s);
        const float n[3] = {(float)(out * c), (float)up, (float)(-out * s)};
        const float at[3] = {p->radius * n[0], p->radius * n[1], p->radius * n[2]};
        const double u = (i + (pole ? 0.5 : 0)) / p->segments;
        vertex(b, at, n, (float)u, (float)row / (float)rings(p->segments));
    }
}

static void sphere(struct builder *b, const struct glint_primitive *p)
{
    const uint32_t width = p->segments + 1, last = rings(p->segments);
    for (uint32_t row = 0; row <= last; row++)
        sphere_row(b, p, row);
    for (uint32_t row = 0; row < last; row++)
        for (uint32_t i = 0; i < p->segments; i++) {
            const uint32_t a = row * width + i, d = a + width;
            if (row > 0)
                triangle(b, a, d, a + 1);
            if (row + 1 < last)
                triangle(b, row > 0 ? a + 1 : a, d, d + 1);
        }
}

// ---- flat ones

// A rectangle around `centre` with half axes x and y, seen from n = x cross y.
static void rectangle(struct builder *b, const float centre[3], const float x[3], const float y[3],
                      const float n[3])
{
    static const float corner[4][2] = {{-1, 1}, {-1, -1}, {1, -1}, {1, 1}};
    const uint32_t first = b->vertices;
    for (int i = 0; i < 4; i++) {
        float p[3];
        for (int k = 0; k < 3; k++)
            p[k] = centre[k] + corner[i][0] * x[k] + corner[i][1] * y[k];
        vertex(b, p, n, 0.5f + 0.5f * corner[i][0], 0.5f - 0.5f * corner[i][1]);
    }
    triangle(b, first, first + 1, first + 2);
    triangle(b, first, first + 2, first + 3);
}

static void quad(struct builder *b, const struct glint_primitive *p)
{
    const float x[3] = {0.5f * p->size[0], 0, 0}, y[3] = {0, 0.5f * p->size[1], 0};
    rectangle(b, (const float[]){0, 0, 0}, x, y, (const float[]){0, 0, 1});
}

static void box(struct builder *b, const struct glint_primitive *p)
{
    for (int side = 0; side < 6; side++) {
        const int axis = side / 2, first = (axis + 1) % 3, second = (axis + 2) % 3;
        const float sign = side % 2 ? -1 : 1;
        float n[3] = {0, 0, 0}, x[3] = {0, 0, 0}, y[3] = {0, 0, 0}, centre[3] = {0, 0, 0};
        n[axis] = sign;
        x[first] = 0.5f * sign * p->size[first];
        y[second] = 0.5f * p->size[second];
        centre[axis] = 0.5f * sign * p->size[axis];
        rectangle(b, centre, x, y, n);
    }
}

static void disk(struct builder *b, const struct glint_primitive *p)
{
    static const float n[3] = {0, 0, 1};
    vertex(b, (const float[]){0, 0, 0}, n, 0.5f, 0.5f);
    for (uint32_t i = 0; i < p->segments; i++) {
        double c, s;
        on_circle(i, p->segments, &c, &s);
        const float at[3] = {p->radius * (float)c, p->radius * (float)s, 0};
        vertex(b, at, n, (float)(0.5 + 0.5 * c), (float)(0.5 - 0.5 * s));
        triangle(b, 0, 1 + i, 1 + (i + 1) % p->segments);
    }
}

void glint_primitive_size(const struct glint_primitive *p, uint32_t *vertices, uint32_t *triangles)
{
    const uint32_t n = p->segments, m = rings(n);
    static const uint32_t flat_vertices[] = {[GLINT_QUAD] = 4, [GLINT_BOX] = 24};
    switch (p->kind) {
    case GLINT_SPHERE:
        *vertices = (n + 1) * (m + 1);
        *triangles = 2 * n * (m - 1);
        break;
    case GLINT_DISK:
        *vertices = n + 1;
        *triangles = n;
        break;
    default:
        *vertices = flat_vertices[p->kind];
        *triangles = *vertices / 2;
        break;
    }
}

bool glint_primitive_make(const struct glint_primitive *p, struct glint_arena *arena,
                          struct glint_mesh *out)
{
    static void (*const make[])(struct builder *, const struct glint_primitive *) = {
        [GLINT_SPHERE] = sphere, [GLINT_QUAD] = quad, [GLINT_BOX] = box, [GLINT_DISK] = disk};
    glint_primitive_size(p, &out->vertices, &out->triangles);
    struct builder b = {
        .position = glint_arena_array(arena, out->vertices, 3 * sizeof(float)),
        .normal = glint_arena_array(arena, out->vertices, 3 * sizeof(float)),
        .uv = glint_arena_array(arena, out->vertices, 2 * sizeof(float)),
        .index = glint_arena_array(arena, out->triangles, 3 * sizeof(uint32_t)),
    };
    if (!b.position || !b.normal || !b.uv || !b.index)
        return false;
    make[p->kind](&b, p);
    out->position = b.position;
    out->normal = b.normal;
    out->uv = b.uv;
    out->index = b.index;
    return true;
}
