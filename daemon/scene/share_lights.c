// share_lights.c - the light table of the revision before, where nothing that it is made from differs.
#include "scene/internal.h"

#include <string.h>

static const struct gk_material *material_of(const struct glint_resident *r,
                                             const struct glint_row *row)
{
    return (const struct gk_material *)glint_table_host(r, GLINT_TABLE_MATERIALS) + row->material;
}

static bool same_glow(const struct glint_resident *r, const struct glint_row *a,
                      const struct glint_row *b)
{
    const struct gk_material *m = material_of(r, a), *n = material_of(r->from, b);
    const bool same_texels = r->table[GLINT_TABLE_POOL0] == r->from->table[GLINT_TABLE_POOL0] &&
                             r->table[GLINT_TABLE_TEXTURES] == r->from->table[GLINT_TABLE_TEXTURES];
    return a->material == b->material && m->flags == n->flags &&
           memcmp(m->emission, n->emission, sizeof m->emission) == 0 &&
           m->emission_texture == n->emission_texture &&
           (m->emission_texture == GK_NONE || same_texels);
}

static bool same_emitter(const struct glint_resident *r, const struct glint_row *a,
                         const struct glint_row *b)
{
    return r->kept[a->kept].shape == r->from->kept[b->kept].shape && a->triangle == b->triangle &&
           !glint_row_moves(r, a) && !glint_row_moves(r->from, b) &&
           memcmp(a->transform, b->transform, sizeof a->transform) == 0 && same_glow(r, a, b);
}

// The first emitting row from i on.
static uint32_t emitting(const struct glint_resident *r, uint32_t i)
{
    while (i < r->rows && !r->row[i].emits)
        i++;
    return i;
}

static bool same_emitters(const struct glint_resident *r)
{
    const struct glint_resident *from = r->from;
    uint32_t i = emitting(r, 0), j = emitting(from, 0);
    while (i < r->rows && j < from->rows && same_emitter(r, &r->row[i], &from->row[j])) {
        i = emitting(r, i + 1);
        j = emitting(from, j + 1);
    }
    return i == r->rows && j == from->rows;
}

static bool moves(const struct glint_resident *r, uint32_t light)
{
    return r->pose && r->pose->light[light].moves;
}

static bool same_light(const struct glint_resident *r, uint32_t i)
{
    const struct glint_light *a = &r->scene->light[i], *b = &r->from->scene->light[i];
    double p[16], q[16];
    if (a->kind != b->kind || moves(r, i) || moves(r->from, i))
        return false;
    if (a->kind == GLINT_LIGHT_AREA)
        return true; // a row
    glint_pose_light_at(r->pose, r->scene, i, 0, p);
    glint_pose_light_at(r->from->pose, r->from->scene, i, 0, q);
    return memcmp(p, q, sizeof p) == 0 && memcmp(a->color, b->color, sizeof a->color) == 0 &&
           a->intensity == b->intensity && a->inner_cone == b->inner_cone &&
           a->outer_cone == b->outer_cone;
}

static bool same_frame(const struct glint_resident *r)
{
    return memcmp(r->centre, r->from->centre, sizeof r->centre) == 0 &&
           memcmp(r->half, r->from->half, sizeof r->half) == 0 && r->radius == r->from->radius;
}

static bool same_lights(const struct glint_resident *r)
{
    bool same = r->scene->lights == r->from->scene->lights;
    for (uint32_t i = 0; same && i < r->scene->lights; i++)
        same = same_light(r, i);
    return same;
}

// Rows may have other numbers: those that emit are in the same order.
static void take_places(struct glint_resident *r)
{
    struct gk_instance *in = glint_table_host(r, GLINT_TABLE_INSTANCES);
    const struct gk_instance *known = glint_table_host(r->from, GLINT_TABLE_INSTANCES);
    uint32_t j = emitting(r->from, 0);
    for (uint32_t i = emitting(r, 0); i < r->rows; i = emitting(r, i + 1)) {
        in[i].light = known[j].light;
        j = emitting(r->from, j + 1);
    }
}

bool glint_share_lights(struct glint_resident *r)
{
    if (!r->from || !same_frame(r) || !same_emitters(r) || !same_lights(r))
        return false;
    glint_share_table(r, GLINT_TABLE_LIGHTS);
    glint_share_table(r, GLINT_TABLE_ALIAS);
    glint_share_table(r, GLINT_TABLE_LIGHT_CELLS);
    take_places(r);
    r->lights = r->stats.lights = r->from->lights;
    r->facts.light_table = r->from->facts.light_table;
    r->facts.light_grid = r->from->facts.light_grid;
    r->facts.light_grid_many = r->from->facts.light_grid_many;
    r->lighting = r->from->lighting; // the environment's members are filled anew
    memset(r->lighting.environment, 0, sizeof r->lighting.environment);
    return true;
}
