// instances.c - instance rows as kernels read them, and how those that move do so.
#include "scene/internal.h"

#include "scene/matrix.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Inverse transpose up to a positive factor: cofactors, with the sign of the determinant. `scale`
// is a power of two that keeps the products of normals in range, the same at all keys.
static void normal_matrix(const float t[16], bool mirrored, double scale, float out[9])
{
    double m[9]; // row-major
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            m[3 * i + j] = t[4 * j + i];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const int a = (i + 1) % 3, b = (i + 2) % 3, p = (j + 1) % 3, q = (j + 2) % 3;
            const double c = (m[3 * a + p] * m[3 * b + q] - m[3 * a + q] * m[3 * b + p]) * scale;
            out[3 * i + j] = (float)(mirrored ? -c : c);
        }
}

// 2^-2e where the largest element of the linear part is 2^e: the largest cofactor is near 1.
static double scale_of(const float t[16])
{
    double most = 0.0;
    for (int i = 0; i < 12; i++)
        most = fmax(most, i % 4 < 3 ? fabs((double)t[i]) : 0.0);
    return ldexp(1.0, -2 * ilogb(most));
}

// Metres of the mesh to one of the world.
static double shrink_of(const float t[16])
{
    double wide[16];
    glint_matrix_widen(wide, t);
    return 1.0 / cbrt(fabs(glint_matrix_determinant(wide)));
}

static bool same_linear(const float a[16], const float b[16])
{
    for (int i = 0; i < 12; i++)
        if (i % 4 < 3 && a[i] != b[i])
            return false;
    return true;
}

static const float identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static bool turns(const struct glint_resident *r, const struct glint_row *row)
{
    for (uint32_t k = 1; row->motion && k < glint_resident_keys(r); k++)
        if (!same_linear(row->motion, row->motion + 16 * (size_t)k))
            return true;
    return false;
}

static void fill_row(struct glint_resident *r, uint32_t index)
{
    const struct glint_row *row = &r->row[index];
    struct gk_instance *in = glint_table_host(r, GLINT_TABLE_INSTANCES);
    in += index;
    const bool mirrored = glint_row_mirrors(row);
    const bool transformed = !same_linear(row->transform, identity) || turns(r, row);
    in->triangle = row->triangle;
    in->material = row->material;
    in->matte = row->matte;
    in->flags =
        (transformed ? GK_INSTANCE_TRANSFORMED : 0u) | (mirrored ? GK_INSTANCE_MIRRORED : 0u);
    in->light = in->mover = GK_NONE;
    in->shrink = (float)shrink_of(row->transform);
    normal_matrix(row->transform, mirrored, scale_of(row->transform), in->normal);
    r->facts.instances |= transformed;
}

// ---- what moves

static bool flows(const struct glint_resident *r, const struct glint_row *row)
{
    return r->pose && r->pose->request.flow &&
           (row->flow || r->kept[row->kept].flow || glint_row_moves(r, row));
}

static bool has_mover(const struct glint_resident *r, const struct glint_row *row)
{
    return glint_row_moves(r, row) || flows(r, row);
}

struct counts {
    size_t movers, turns, flows;
};

static struct counts count(const struct glint_resident *r)
{
    struct counts n = {0};
    for (uint32_t i = 0; i < r->rows; i++) {
        const struct glint_row *row = &r->row[i];
        n.movers += has_mover(r, row);
        n.turns += turns(r, row) ? glint_resident_keys(r) : 0;
        n.flows += flows(r, row) ? r->kept[row->kept].triangles : 0;
    }
    return n;
}

static void fill_turns(const struct glint_resident *r, const struct glint_row *row,
                       struct gk_turn *out)
{
    const bool mirrored = glint_row_mirrors(row);
    const double scale = scale_of(row->transform);
    for (uint32_t k = 0; k < glint_resident_keys(r); k++)
        normal_matrix(row->motion + 16 * (size_t)k, mirrored, scale, out[k].normal);
}

// Where vertices are at one of the two other moments.
static void flow_point(const struct glint_row *row, const struct glint_kept *k, int moment,
                       uint32_t vertex, float out[3])
{
    const float *p = k->flow ? k->flow + 3 * ((size_t)moment * k->mesh->vertices + vertex)
                             : k->position + 3 * (size_t)vertex;
    const float *t = row->flow ? row->flow + 16 * moment : row->transform;
    for (int i = 0; i < 3; i++)
        out[i] = (float)((double)t[i] * p[0] + (double)t[4 + i] * p[1] + (double)t[8 + i] * p[2] +
                         (double)t[12 + i]);
}

static void fill_flows(const struct glint_resident *r, const struct glint_row *row,
                       struct gk_flow *out)
{
    const struct glint_kept *k = &r->kept[row->kept];
    for (uint32_t i = 0; i < k->triangles; i++)
        for (int c = 0; c < 3; c++) {
            const uint32_t vertex = k->index[3 * (size_t)i + c];
            flow_point(row, k, 0, vertex, out[i].before + 3 * c);
            flow_point(row, k, 1, vertex, out[i].after + 3 * c);
        }
}

static void fill_movers(struct glint_resident *r)
{
    struct gk_instance *in = glint_table_host(r, GLINT_TABLE_INSTANCES);
    struct gk_mover *mover = glint_table_host(r, GLINT_TABLE_MOVERS);
    struct gk_turn *turn = glint_table_host(r, GLINT_TABLE_TURNS);
    struct gk_flow *flow = glint_table_host(r, GLINT_TABLE_FLOWS);
    struct counts at = {0};
    for (uint32_t i = 0; i < r->rows; i++) {
        const struct glint_row *row = &r->row[i];
        const struct glint_kept *k = &r->kept[row->kept];
        if (!has_mover(r, row))
            continue;
        in[i].mover = (uint32_t)at.movers;
        r->facts.motion |= glint_row_moves(r, row);
        struct gk_mover *m = &mover[at.movers++];
        *m = (struct gk_mover){GK_NONE, k->keys > 1 ? k->triangles : 0, GK_NONE, 0};
        if (turns(r, row)) {
            m->turn = (uint32_t)at.turns;
            fill_turns(r, row, turn + at.turns);
            at.turns += glint_resident_keys(r);
        }
        if (flows(r, row)) {
            m->flow = (uint32_t)at.flows;
            fill_flows(r, row, flow + at.flows);
            at.flows += k->triangles;
        }
    }
}

static glint_status table(struct glint_resident *r, enum glint_table t, size_t entries, size_t size,
                          struct glint_error *err)
{
    return glint_buffer_create(&r->table[t], r->devices, (entries ? entries : 1) * size, err);
}

glint_status glint_resident_build_instances(struct glint_resident *r, struct glint_error *err)
{
    const struct counts n = count(r);
    glint_status st =
        table(r, GLINT_TABLE_INSTANCES, (size_t)r->rows + 1, sizeof(struct gk_instance), err);
    if (!st)
        st = table(r, GLINT_TABLE_MOVERS, n.movers, sizeof(struct gk_mover), err);
    if (!st)
        st = table(r, GLINT_TABLE_TURNS, n.turns, sizeof(struct gk_turn), err);
    if (!st)
        st = table(r, GLINT_TABLE_FLOWS, n.flows, sizeof(struct gk_flow), err);
    if (st)
        return st;
    for (uint32_t i = 0; i < r->rows; i++)
        fill_row(r, i);
    if (n.movers)
        fill_movers(r);
    return GLINT_OK;
}
