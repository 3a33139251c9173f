// place.c - hands the kept triangles of every row to the traversal structure.
#include "kernels/gk_sampler.h"
#include "scene/internal.h"

#include <stdlib.h>

static bool has_holes(const struct glint_resident *r, const struct glint_row *row)
{
    if (row->material >= r->scene->materials)
        return false;
    const struct glint_material *m = &r->scene->material[row->material];
    return m->alpha_mode == GLINT_ALPHA_BLEND ||
           (m->alpha_mode == GLINT_ALPHA_MASK && m->alpha_cutoff > 0.0f);
}

static bool template_has_holes(const struct glint_resident *r, uint32_t template_index)
{
    for (uint32_t i = 0; i < r->rows; i++)
        if (r->row[i].template_index == template_index && has_holes(r, &r->row[i]))
            return true;
    return false;
}

// The opacity test of a hit: what kernels compute, compiled for the host. A blended surface is there
// with the probability of its opacity, so that the mean of many rays sees its share of it.
static bool hole_at(const void *user, uint32_t row, uint32_t primitive, float u, float v,
                    uint32_t chance)
{
    const struct glint_resident *r = user;
    const struct gk_material *m =
        (const struct gk_material *)glint_table_host(r, GLINT_TABLE_MATERIALS) +
        r->row[row].material;
    if (m->flags & GK_MATERIAL_BLEND)
        return gk_unit_float(chance) >= glint_resident_opacity(r, row, primitive, u, v);
    return m->cutoff > 0.0f && glint_resident_opacity(r, row, primitive, u, v) < m->cutoff;
}

// World positions of a baked row and its indices, winding turned where it mirrors; malloc'd.
static glint_status baked_mesh(const struct glint_resident *r, const struct glint_row *row,
                               struct glint_geometry_mesh *out, struct glint_error *err)
{
    const struct glint_kept *k = glint_row_kept(r, row);
    float *position = malloc((size_t)row->mesh->vertices * 12);
    uint32_t *index = malloc((size_t)k->triangles * 12 + 12);
    if (!position || !index) {
        free(position);
        free(index);
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u vertices", row->mesh->vertices);
    }
    for (size_t i = 0; i < row->mesh->vertices; i++) {
        double p[3];
        glint_row_point(row, row->mesh->position + 3 * i, p);
        for (int c = 0; c < 3; c++)
            position[3 * i + c] = (float)p[c];
    }
    const bool flip = glint_row_determinant(row) < 0.0;
    for (size_t i = 0; i < k->triangles; i++)
        for (int c = 0; c < 3; c++)
            index[3 * i + c] = k->index[3 * i + (flip && c ? 3 - c : c)];
    *out = (struct glint_geometry_mesh){position, row->mesh->vertices, index, k->triangles,
                                        has_holes(r, row)};
    return GLINT_OK;
}

static glint_status add_row(const struct glint_resident *r, glint_geometry *g, uint32_t index,
                            bool *made, struct glint_error *err)
{
    const struct glint_row *row = &r->row[index];
    const struct glint_kept *k = glint_row_kept(r, row);
    if (!k->triangles)
        return GLINT_OK;
    if (row->template_index == GLINT_NONE) {
        struct glint_geometry_mesh mesh;
        glint_status st = baked_mesh(r, row, &mesh, err);
        if (st)
            return st;
        st = glint_geometry_add_mesh(g, index, &mesh, err);
        free((void *)mesh.position);
        free((void *)mesh.index);
        return st;
    }
    glint_status st = GLINT_OK;
    if (!made[row->template_index]) { // templates are numbered in the order of their first row
        const struct glint_geometry_mesh mesh = {row->mesh->position, row->mesh->vertices, k->index,
                                                 k->triangles,
                                                 template_has_holes(r, row->template_index)};
        uint32_t number;
        st = glint_geometry_add_template(g, &mesh, &number, err);
        made[row->template_index] = true;
    }
    return st ? st : glint_geometry_place(g, index, row->template_index, row->transform, err);
}

glint_status glint_resident_build_geometry(struct glint_resident *r, bool robust,
                                           glint_geometry **out, struct glint_error *err)
{
    glint_status st = glint_geometry_create(out, robust, hole_at, r, err);
    bool *made = calloc((size_t)r->scene->meshes + 1, sizeof *made);
    if (!st && !made)
        st = glint_fail(err, GLINT_E_NOMEM, "", "no memory for the templates");
    for (uint32_t i = 0; !st && i < r->rows; i++)
        st = add_row(r, *out, i, made, err);
    free(made);
    if (!st)
        st = glint_geometry_commit(*out, err);
    if (st)
        glint_geometry_destroy(out);
    return st;
}
