// records.c - shading records of every kept triangle, and the instance rows that point at them.
#include "scene/internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// A mesh that is drawn often is kept once and placed many times; below this many triangles in all
// its uses, copies trace faster than placements (by 8-17 %) and cost little.
#define BAKE_LIMIT 65536u

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

static void cross(const double a[3], const double b[3], double c[3])
{
    for (int k = 0; k < 3; k++)
        c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static bool degenerate(const struct glint_mesh *m, const uint32_t *t)
{
    double u[3], v[3], w[3], n[3];
    edge(m->position + 3 * (size_t)t[0], m->position + 3 * (size_t)t[1], u);
    edge(m->position + 3 * (size_t)t[0], m->position + 3 * (size_t)t[2], v);
    edge(m->position + 3 * (size_t)t[1], m->position + 3 * (size_t)t[2], w);
    cross(u, v, n);
    const double longest = fmax(dot(u, u), fmax(dot(v, v), dot(w, w)));
    return !(sqrt(dot(n, n)) > SLIVER * longest);
}

static glint_status keep_triangles(struct glint_resident *r, const struct glint_mesh *m,
                                   struct glint_kept *kept, struct glint_error *err)
{
    kept->index = malloc((size_t)m->triangles * 12);
    if (!kept->index)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u triangles", m->triangles);
    for (uint32_t i = 0; i < m->triangles; i++) {
        const uint32_t *t = m->index + 3 * (size_t)i;
        if (degenerate(m, t)) {
            r->stats.dropped++;
            continue;
        }
        memcpy(kept->index + 3 * (size_t)kept->triangles++, t, 12);
    }
    kept->template_index = GLINT_NONE;
    kept->prepared = true;
    return GLINT_OK;
}

struct glint_kept *glint_row_kept(const struct glint_resident *r, const struct glint_row *row)
{
    const bool quad = row->mesh == &r->quad;
    return &r->kept[quad ? r->scene->meshes : (size_t)(row->mesh - r->scene->mesh)];
}

static bool wants_template(const struct glint_resident *r, const struct glint_row *row)
{
    const struct glint_kept *k = glint_row_kept(r, row);
    return k->uses > 1 && !row->emits && glint_row_determinant(row) > 0.0 &&
           (uint64_t)k->uses * k->triangles > BAKE_LIMIT;
}

// Gives every row its first record; templates share theirs. Returns the number of records.
static uint64_t place_records(struct glint_resident *r)
{
    uint64_t next = 0;
    uint32_t templates = 0;
    for (uint32_t i = 0; i < r->rows; i++) {
        struct glint_row *row = &r->row[i];
        struct glint_kept *k = glint_row_kept(r, row);
        r->stats.instanced_triangles += k->triangles;
        if (!wants_template(r, row)) {
            row->triangle = (uint32_t)next;
            next += k->triangles;
            continue;
        }
        if (k->template_index == GLINT_NONE) {
            k->template_index = templates++;
            k->first = (uint32_t)next;
            next += k->triangles;
        }
        row->template_index = k->template_index;
        row->triangle = k->first;
        r->facts.instances = true;
    }
    return next;
}

static void turn(const double m[9], const float v[3], double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = m[3 * k] * v[0] + m[3 * k + 1] * v[1] + m[3 * k + 2] * v[2];
}

static void store_unit(const double v[3], float out[3])
{
    const double length = sqrt(dot(v, v));
    for (int k = 0; k < 3; k++)
        out[k] = length > 0.0 ? (float)(v[k] / length) : 0.0f;
}

static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

// Along which axes a texture on the row, or on any other that shares its template, has an end.
static void find_clamps(const struct glint_resident *r, const struct glint_row *row, bool clamps[2])
{
    const bool alone = row->template_index == GLINT_NONE;
    const struct glint_row *other = alone ? row : r->row;
    const struct glint_row *const end = alone ? row + 1 : r->row + r->rows;
    for (; other < end; other++) {
        if (other->template_index != row->template_index || other->material >= r->scene->materials)
            continue;
        glint_material_note_ends(&r->scene->material[other->material], 0, clamps);
    }
}

// Takes whole periods off the three coordinates of an axis: far from 0 a float has no digits left
// for the fraction. In pairs, which a mirroring wrap does not see either.
static void centre_periods(float *uv)
{
    const double lo = fmin(uv[0], fmin(uv[2], uv[4])), hi = fmax(uv[0], fmax(uv[2], uv[4]));
    const double periods = 2.0 * rint((lo + hi) / 4.0);
    for (int c = 0; c < 3; c++)
        uv[2 * c] = (float)(uv[2 * c] - periods);
}

// flip: the winding is turned, so that the geometric normal keeps its side under a mirroring.
static void fill_triangles(struct gk_triangle *out, const struct glint_mesh *m,
                           const struct glint_kept *k, const double normal[9], bool flip,
                           const bool clamps[2])
{
    for (uint32_t i = 0; i < k->triangles; i++) {
        struct gk_triangle *t = &out[i];
        memset(t, 0, sizeof *t);
        for (int c = 0; c < 3; c++) {
            const size_t v = k->index[3 * (size_t)i + (flip && c ? 3 - c : c)];
            double n[3];
            if (m->normal) {
                turn(normal, m->normal + 3 * v, n);
                store_unit(n, t->normal + 3 * c);
            }
            if (m->uv)
                memcpy(t->uv + 2 * c, m->uv + 2 * v, 8);
        }
        for (int axis = 0; axis < 2; axis++)
            if (!clamps[axis])
                centre_periods(t->uv + axis);
    }
}

// Sum over a vertex's triangles of dP/du, the direction in which the texture runs, and the sign of
// the bitangent: v runs downwards in the image, the normal map's y upwards.
static void add_face_tangent(const struct glint_mesh *m, const uint32_t *t, double *sum)
{
    double e1[3], e2[3], n[3], tangent[3], bitangent[3], side[3];
    edge(m->position + 3 * (size_t)t[0], m->position + 3 * (size_t)t[1], e1);
    edge(m->position + 3 * (size_t)t[0], m->position + 3 * (size_t)t[2], e2);
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
static float *derive_tangents(const struct glint_mesh *m)
{
    double *sum = calloc(m->vertices, 4 * sizeof *sum);
    float *out = malloc((size_t)m->vertices * 16);
    if (sum && out) {
        for (uint32_t i = 0; m->uv && i < m->triangles; i++)
            add_face_tangent(m, m->index + 3 * (size_t)i, sum);
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

static glint_status fill_tangents(struct gk_tangent *out, const struct glint_mesh *m,
                                  const struct glint_kept *k, const double turnm[9], bool flip,
                                  struct glint_error *err)
{
    float *derived = m->tangent ? NULL : derive_tangents(m);
    const float *tangent = m->tangent ? m->tangent : derived;
    if (!tangent)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for tangents");
    for (uint32_t i = 0; i < k->triangles; i++)
        for (int c = 0; c < 3; c++) {
            const size_t v = k->index[3 * (size_t)i + (flip && c ? 3 - c : c)];
            double t[3];
            turn(turnm, tangent + 4 * v, t);
            store_unit(t, out[i].tangent + 4 * c);
            out[i].tangent[4 * c + 3] = flip ? -tangent[4 * v + 3] : tangent[4 * v + 3];
        }
    free(derived);
    return GLINT_OK;
}

static void linear_part(const struct glint_row *row, double m[9])
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            m[3 * i + j] = row->transform[4 * j + i];
}

static glint_status fill_row(struct glint_resident *r, uint32_t index, bool *filled,
                             struct glint_error *err)
{
    const struct glint_row *row = &r->row[index];
    const struct glint_kept *k = glint_row_kept(r, row);
    const bool placed = row->template_index != GLINT_NONE;
    struct gk_instance *in =
        (struct gk_instance *)glint_table_host(r, GLINT_TABLE_INSTANCES) + index;
    double normal[9], linear[9];
    glint_row_normal_matrix(row, normal);
    linear_part(row, linear);
    in->triangle = row->triangle;
    in->material = row->material;
    in->matte = row->matte;
    in->flags = placed ? GK_INSTANCE_TRANSFORMED : 0;
    in->light = in->mover = GK_NONE;
    for (int i = 0; i < 9; i++)
        in->normal[i] = (float)(placed ? normal[i] : identity[i]);
    if (placed && filled[row->template_index])
        return GLINT_OK;
    if (placed)
        filled[row->template_index] = true;
    const bool flip = !placed && glint_row_determinant(row) < 0.0;
    struct gk_triangle *t =
        (struct gk_triangle *)glint_table_host(r, GLINT_TABLE_TRIANGLES) + row->triangle;
    bool clamps[2] = {false, false};
    find_clamps(r, row, clamps);
    fill_triangles(t, row->mesh, k, placed ? identity : normal, flip, clamps);
    if (!r->facts.normal_maps)
        return GLINT_OK;
    struct gk_tangent *g =
        (struct gk_tangent *)glint_table_host(r, GLINT_TABLE_TANGENTS) + row->triangle;
    return fill_tangents(g, row->mesh, k, placed ? identity : linear, flip, err);
}

static glint_status allocate(struct glint_resident *r, struct glint_error *err)
{
    const uint64_t records = r->triangles ? r->triangles : 1;
    glint_status st = glint_buffer_create(&r->table[GLINT_TABLE_TRIANGLES], r->devices,
                                          records * sizeof(struct gk_triangle), err);
    if (!st)
        st = glint_buffer_create(&r->table[GLINT_TABLE_TANGENTS], r->devices,
                                 (r->facts.normal_maps ? records : 1) * sizeof(struct gk_tangent),
                                 err);
    if (!st)
        st = glint_buffer_create(&r->table[GLINT_TABLE_INSTANCES], r->devices,
                                 ((size_t)r->rows + 1) * sizeof(struct gk_instance), err);
    return st;
}

glint_status glint_resident_build_records(struct glint_resident *r, struct glint_error *err)
{
    glint_status st = GLINT_OK;
    for (uint32_t i = 0; !st && i < r->rows; i++) {
        struct glint_kept *k = glint_row_kept(r, &r->row[i]);
        if (!k->prepared)
            st = keep_triangles(r, r->row[i].mesh, k, err);
    }
    if (st)
        return st;
    const uint64_t records = place_records(r);
    if (records > UINT32_MAX / 2)
        return glint_fail(err, GLINT_E_CAPACITY, "/meshes", "%llu triangles are too many",
                          (unsigned long long)records);
    r->triangles = (uint32_t)records;
    r->stats.triangles = records;
    st = allocate(r, err);
    bool *filled = calloc((size_t)r->scene->meshes + 1, sizeof *filled);
    if (!st && !filled)
        st = glint_fail(err, GLINT_E_NOMEM, "", "no memory for the instance rows");
    for (uint32_t i = 0; !st && i < r->rows; i++)
        st = fill_row(r, i, filled, err);
    free(filled);
    return st;
}
