#include "shapes.h"
#include "dice.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void glint_shape_finish(struct glint_shape *shape)
{
    free(shape->position);
    free(shape->normal);
    free(shape->index);
    *shape = (struct glint_shape){0};
}

static void *grow(void *array, size_t size)
{
    void *grown = realloc(array, size);
    if (!grown) {
        perror("glint-demo-scene");
        exit(EXIT_FAILURE);
    }
    return grown;
}

static uint32_t add_vertex(struct glint_shape *s, const double p[3], const double n[3])
{
    if (s->vertices == s->vertex_capacity) {
        s->vertex_capacity = 2 * s->vertex_capacity + 256;
        s->position = grow(s->position, s->vertex_capacity * 3 * sizeof *s->position);
        s->normal = grow(s->normal, s->vertex_capacity * 3 * sizeof *s->normal);
    }
    memcpy(s->position + 3 * s->vertices, p, 3 * sizeof *p);
    memcpy(s->normal + 3 * s->vertices, n, 3 * sizeof *n);
    return (uint32_t)s->vertices++;
}

static int same_place(const struct glint_shape *s, uint32_t a, uint32_t b)
{
    const double *p = s->position + 3 * a, *q = s->position + 3 * b;
    return fabs(p[0] - q[0]) + fabs(p[1] - q[1]) + fabs(p[2] - q[2]) < 1e-9;
}

// Leaves out what has no area, at the poles.
static void add_triangle(struct glint_shape *s, uint32_t a, uint32_t b, uint32_t c)
{
    if (same_place(s, a, b) || same_place(s, b, c) || same_place(s, c, a))
        return;
    if (s->triangles == s->triangle_capacity) {
        s->triangle_capacity = 2 * s->triangle_capacity + 256;
        s->index = grow(s->index, s->triangle_capacity * 3 * sizeof *s->index);
    }
    uint32_t *t = s->index + 3 * s->triangles++;
    t[0] = a;
    t[1] = b;
    t[2] = c;
}

// A grid of (rows + 1) x (columns + 1) vertices that begin at `first`, row by row.
static void add_grid(struct glint_shape *s, uint32_t first, int rows, int columns)
{
    const uint32_t stride = (uint32_t)columns + 1;
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < columns; c++) {
            const uint32_t a = first + (uint32_t)r * stride + (uint32_t)c;
            add_triangle(s, a, a + 1, a + stride + 1);
            add_triangle(s, a, a + stride + 1, a + stride);
        }
}

void glint_profile_add(struct glint_profile *profile, double radius, double height)
{
    assert(profile->points < sizeof profile->point / sizeof *profile->point);
    double *p = profile->point[profile->points++];
    p[0] = radius;
    p[1] = height;
}

void glint_profile_arc(struct glint_profile *profile, double radius, double height, double size,
                       double from, double to, int steps)
{
    for (int i = 0; i <= steps; i++) {
        const double a = from + (to - from) * i / steps;
        glint_profile_add(profile, radius + size * cos(a), height + size * sin(a));
    }
}

// Outward normal of the piece of outline from a to b.
static void piece_normal(const double a[2], const double b[2], double out[2])
{
    const double dr = b[0] - a[0], dy = b[1] - a[1], length = hypot(dr, dy);
    out[0] = dy / length;
    out[1] = -dr / length;
}

// The normal at the end of a piece, blended with its neighbour's where that goes on smoothly.
static void blend(const double own[2], const double *neighbour, double out[2])
{
    out[0] = own[0];
    out[1] = own[1];
    if (!neighbour || own[0] * neighbour[0] + own[1] * neighbour[1] < cos(GLINT_SHAPE_CREASE))
        return;
    const double r = own[0] + neighbour[0], y = own[1] + neighbour[1], length = hypot(r, y);
    out[0] = r / length;
    out[1] = y / length;
}

static void add_ring(struct glint_shape *s, const double point[2], const double normal[2],
                     double from, double to, int segments)
{
    for (int i = 0; i <= segments; i++) {
        const double a = from + (to - from) * i / segments, x = sin(a), z = cos(a);
        add_vertex(s, (double[]){point[0] * x, point[1], point[0] * z},
                   (double[]){normal[0] * x, normal[1], normal[0] * z});
    }
}

// The mean of the normals of the pieces that meet at point i.
static void point_normal(const struct glint_profile *profile, size_t i, double out[2])
{
    double before[2], after[2];
    const size_t last = profile->points - 1, a = i ? i - 1 : 0, b = i < last ? i : last - 1;
    piece_normal(profile->point[a], profile->point[a + 1], before);
    piece_normal(profile->point[b], profile->point[b + 1], after);
    const double r = before[0] + after[0], y = before[1] + after[1], length = hypot(r, y);
    out[0] = r / length;
    out[1] = y / length;
}

void glint_shape_extrude(struct glint_shape *out, const struct glint_profile *profile, double width)
{
    const uint32_t first = (uint32_t)out->vertices;
    for (size_t i = 0; i < profile->points; i++) {
        const double *p = profile->point[i];
        double n[2];
        point_normal(profile, i, n);
        for (int side = 0; side < 2; side++)
            add_vertex(out, (double[]){width * (side - 0.5), p[1], p[0]},
                       (double[]){0, n[1], n[0]});
    }
    add_grid(out, first, (int)profile->points - 1, 1);
}

void glint_shape_field(struct glint_shape *out, double size, int steps,
                       void (*at)(double x, double z, double *height, double normal[3]))
{
    const uint32_t first = (uint32_t)out->vertices;
    for (int j = 0; j <= steps; j++)
        for (int i = 0; i <= steps; i++) {
            const double x = size * ((double)i / steps - 0.5), z = size * (0.5 - (double)j / steps);
            double height, normal[3];
            at(x, z, &height, normal);
            add_vertex(out, (double[]){x, height, z}, normal);
        }
    add_grid(out, first, steps, steps);
}

void glint_shape_lathe(struct glint_shape *out, const struct glint_profile *profile, double from,
                       double to, int segments)
{
    const size_t pieces = profile->points - 1;
    const double *end = profile->point[pieces];
    const int closed = hypot(profile->point[0][0] - end[0], profile->point[0][1] - end[1]) < 1e-9;
    double normal[256][2];
    for (size_t i = 0; i < pieces; i++)
        piece_normal(profile->point[i], profile->point[i + 1], normal[i]);
    for (size_t i = 0; i < pieces; i++) {
        const double *before = i ? normal[i - 1] : closed ? normal[pieces - 1] : NULL;
        const double *after = i + 1 < pieces ? normal[i + 1] : closed ? normal[0] : NULL;
        const uint32_t first = (uint32_t)out->vertices;
        double n[2];
        blend(normal[i], before, n);
        add_ring(out, profile->point[i], n, from, to, segments);
        blend(normal[i], after, n);
        add_ring(out, profile->point[i + 1], n, from, to, segments);
        add_grid(out, first, 1, segments);
    }
}

void glint_shape_cap(struct glint_shape *out, const struct glint_profile *profile, double angle,
                     double base, int side)
{
    const double x = sin(angle), z = cos(angle), n[3] = {side * z, 0, side * -x};
    for (size_t i = 0; i + 1 < profile->points; i++) {
        const double *a = profile->point[i], *b = profile->point[i + 1];
        const uint32_t first = (uint32_t)out->vertices;
        add_vertex(out, (double[]){a[0] * x, base, a[0] * z}, n);
        add_vertex(out, (double[]){b[0] * x, base, b[0] * z}, n);
        add_vertex(out, (double[]){b[0] * x, b[1], b[0] * z}, n);
        add_vertex(out, (double[]){a[0] * x, a[1], a[0] * z}, n);
        const uint32_t v = side > 0 ? 1 : 3, w = 4 - v;
        add_triangle(out, first, first + w, first + 2);
        add_triangle(out, first, first + 2, first + v);
    }
}

void glint_shape_torus(struct glint_shape *out, double major, double minor, int around, int across)
{
    for (int r = 0; r <= across; r++)
        for (int c = 0; c <= around; c++) {
            const double u = 2 * M_PI * c / around, v = 2 * M_PI * r / across;
            const double n[3] = {cos(v) * sin(u), sin(v), cos(v) * cos(u)};
            const double p[3] = {major * sin(u) + minor * n[0], minor * n[1],
                                 major * cos(u) + minor * n[2]};
            add_vertex(out, p, n);
        }
    add_grid(out, 0, across, around);
}

// Where the grid lines of a rounded box run along one axis, -half..half.
static double grid_line(int i, int steps, double half, double radius)
{
    const int last = 2 * steps + 1, from_end = i <= steps ? i : last - i;
    const double inset = radius * (1 - tan(M_PI / 4 * (steps - from_end) / steps));
    return i <= steps ? inset - half : half - inset;
}

// Moves a point of the sharp box onto the round one.
static void round_off(const double half[3], double radius, double p[3], double n[3])
{
    double q[3], length = 0;
    for (int k = 0; k < 3; k++) {
        q[k] = fmin(fmax(p[k], radius - half[k]), half[k] - radius);
        n[k] = p[k] - q[k];
        length += n[k] * n[k];
    }
    for (int k = 0; k < 3; k++) {
        n[k] /= sqrt(length);
        p[k] = q[k] + radius * n[k];
    }
}

void glint_shape_box(struct glint_shape *out, const double size[3], double radius, int steps)
{
    const double half[3] = {size[0] / 2, size[1] / 2, size[2] / 2};
    const int last = 2 * steps + 1;
    for (int face = 0; face < 6; face++) {
        const int w = face % 3, u = (w + 1) % 3, v = (w + 2) % 3;
        const double side = face < 3 ? 1 : -1;
        const uint32_t first = (uint32_t)out->vertices;
        for (int r = 0; r <= last; r++)
            for (int c = 0; c <= last; c++) {
                double p[3], n[3];
                p[w] = side * half[w];
                p[u] = side * grid_line(c, steps, half[u], radius);
                p[v] = grid_line(r, steps, half[v], radius);
                round_off(half, radius, p, n);
                add_vertex(out, p, n);
            }
        add_grid(out, first, last, last);
    }
}

static double bump(const double wave[6][4], const double d[3])
{
    double height = 1;
    for (int i = 0; i < 6; i++)
        height +=
            0.035 * sin(wave[i][0] * d[0] + wave[i][1] * d[1] + wave[i][2] * d[2] + wave[i][3]);
    return height;
}

// A point of the pebble above direction (u, v), 0..1 around and from pole to pole.
static void pebble_point(const double wave[6][4], double u, double v, double p[3])
{
    const double a = 2 * M_PI * u, b = M_PI * v;
    const double d[3] = {sin(b) * sin(a), -cos(b), sin(b) * cos(a)}, h = bump(wave, d);
    for (int k = 0; k < 3; k++)
        p[k] = h * d[k];
}

// By differences of the direction's height: n ~ h d - grad h on the sphere.
static void pebble_normal(const double wave[6][4], double u, double v, double n[3])
{
    const double a = 2 * M_PI * u, b = M_PI * v, step = 1e-4;
    const double d[3] = {sin(b) * sin(a), -cos(b), sin(b) * cos(a)}, h = bump(wave, d);
    double gradient[3], along = 0, length = 0;
    for (int k = 0; k < 3; k++) {
        double e[3] = {d[0], d[1], d[2]};
        e[k] += step;
        gradient[k] = (bump(wave, e) - h) / step;
        along += gradient[k] * d[k];
    }
    for (int k = 0; k < 3; k++) {
        n[k] = h * d[k] - (gradient[k] - along * d[k]);
        length += n[k] * n[k];
    }
    for (int k = 0; k < 3; k++)
        n[k] /= sqrt(length);
}

void glint_shape_pebble(struct glint_shape *out, uint32_t seed, int segments)
{
    double wave[6][4];
    struct glint_dice dice = {seed};
    for (int i = 0; i < 6; i++)
        for (int k = 0; k < 4; k++)
            wave[i][k] = glint_dice_range(&dice, -4, 4);
    for (int r = 0; r <= segments / 2; r++)
        for (int c = 0; c <= segments; c++) {
            const double u = (double)(c % segments) / segments, v = 2.0 * r / segments;
            double p[3], n[3];
            pebble_point(wave, u, v, p);
            pebble_normal(wave, u, v, n);
            add_vertex(out, p, n);
        }
    add_grid(out, 0, segments / 2, segments);
}
