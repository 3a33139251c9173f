// share.c - what a revision takes over from the one before because it was made from the same.
#include "scene/internal.h"

#include <string.h>

void glint_share_table(struct glint_resident *r, enum glint_table table)
{
    glint_buffer_destroy(&r->table[table]);
    r->table[table] = glint_buffer_retain(r->from->table[table]);
}

bool glint_share_equal_table(struct glint_resident *r, enum glint_table table)
{
    glint_buffer *mine = r->table[table], *theirs = r->from->table[table];
    const size_t bytes = glint_buffer_bytes(theirs);
    if (mine != theirs && (glint_buffer_bytes(mine) != bytes ||
                           memcmp(glint_buffer_host(mine), glint_buffer_host(theirs), bytes) != 0))
        return false;
    glint_share_table(r, table);
    return true;
}

// ---- images

static bool same_image(const struct glint_image *a, const struct glint_image *b)
{
    if (a == b)
        return true;
    if (a->width != b->width || a->height != b->height || a->format != b->format ||
        strcmp(a->asset, b->asset) != 0)
        return false;
    const size_t texel = a->format == GLINT_IMAGE_RGBA8 ? 4 : 8;
    return *a->asset || memcmp(a->pixels, b->pixels, (size_t)a->width * a->height * texel) == 0;
}

// ---- textures

// Two scenes.
struct pair {
    const struct glint_scene *a, *b;
};

static bool same_use(const struct pair *p, const struct glint_texture *a,
                     const struct glint_texture *b)
{
    if (a->image != b->image || a->image == GLINT_NONE)
        return a->image == b->image;
    return a->wrap_u == b->wrap_u && a->wrap_v == b->wrap_v && a->filter == b->filter &&
           a->uv_set == b->uv_set && a->offset[0] == b->offset[0] && a->offset[1] == b->offset[1] &&
           a->scale[0] == b->scale[0] && a->scale[1] == b->scale[1] && a->rotation == b->rotation &&
           same_image(&p->a->image[a->image], &p->b->image[b->image]);
}

static bool same_uses(const struct pair *p, const struct glint_material *a,
                      const struct glint_material *b)
{
    return same_use(p, &a->base_color_texture, &b->base_color_texture) &&
           same_use(p, &a->metallic_roughness_texture, &b->metallic_roughness_texture) &&
           same_use(p, &a->normal_texture, &b->normal_texture) &&
           same_use(p, &a->emission_texture, &b->emission_texture) &&
           same_use(p, &a->specular_texture, &b->specular_texture) &&
           same_use(p, &a->specular_color_texture, &b->specular_color_texture) &&
           same_use(p, &a->transmission_texture, &b->transmission_texture) &&
           same_use(p, &a->clearcoat_texture, &b->clearcoat_texture) &&
           same_use(p, &a->clearcoat_roughness_texture, &b->clearcoat_roughness_texture) &&
           same_use(p, &a->clearcoat_normal_texture, &b->clearcoat_normal_texture);
}

bool glint_share_textures(struct glint_resident *r)
{
    static const enum glint_table part[] = {GLINT_TABLE_TEXTURES, GLINT_TABLE_POOL0,
                                            GLINT_TABLE_POOL1,    GLINT_TABLE_POOL2,
                                            GLINT_TABLE_POOL3,    GLINT_TABLE_DECODE};
    if (!r->from)
        return false;
    const struct pair p = {r->scene, r->from->scene};
    bool same = p.a->materials == p.b->materials;
    for (uint32_t i = 0; same && i < p.a->materials; i++)
        same = same_uses(&p, &p.a->material[i], &p.b->material[i]);
    for (size_t t = 0; same && t < sizeof part / sizeof *part; t++)
        glint_share_table(r, part[t]);
    if (same) {
        r->pools = r->from->pools;
        r->facts.texture_pools = r->from->facts.texture_pools;
        r->stats.texture_bytes = r->from->stats.texture_bytes;
    }
    return same;
}

// ---- environment

static const struct glint_image *image_of(const struct glint_resident *r)
{
    return r->facts.environment_image ? &r->scene->image[r->scene->environment.image] : NULL;
}

// Radiance and rotation are constants of a frame: texels and cells are of the image alone.
bool glint_share_environment(struct glint_resident *r)
{
    if (!r->from)
        return false;
    const struct glint_image *a = image_of(r), *b = image_of(r->from);
    if (!a != !b || (a && !same_image(a, b)))
        return false;
    glint_share_table(r, GLINT_TABLE_ENV_TEXELS);
    glint_share_table(r, GLINT_TABLE_ENV_CELLS);
    return true;
}

// ---- what moves

static bool same_nodes(const struct glint_scene *a, const struct glint_scene *b)
{
    bool same = a->nodes == b->nodes;
    for (uint32_t i = 0; same && i < a->nodes; i++) {
        const struct glint_node *m = &a->node[i], *n = &b->node[i];
        same = m->parent == n->parent && m->matrix == n->matrix &&
               memcmp(m->transform, n->transform, sizeof m->transform) == 0;
    }
    return same;
}

static bool same_skins(const struct glint_scene *a, const struct glint_scene *b)
{
    bool same = a->skins == b->skins;
    for (uint32_t i = 0; same && i < a->skins; i++) {
        const struct glint_skin *m = &a->skin[i], *n = &b->skin[i];
        same = m->joints == n->joints &&
               memcmp(m->joint, n->joint, m->joints * sizeof *m->joint) == 0 &&
               memcmp(m->inverse_bind, n->inverse_bind, m->joints * 16 * sizeof(float)) == 0;
    }
    return same;
}

static bool same_channel(const struct glint_animation_channel *a,
                         const struct glint_animation_channel *b)
{
    const size_t values =
        (size_t)a->keys * a->width * (a->interpolation == GLINT_INTERPOLATION_CUBICSPLINE ? 3 : 1);
    return a->node == b->node && a->path == b->path && a->interpolation == b->interpolation &&
           a->keys == b->keys && a->width == b->width &&
           memcmp(a->time, b->time, a->keys * sizeof *a->time) == 0 &&
           memcmp(a->value, b->value, values * sizeof *a->value) == 0;
}

static bool same_animations(const struct glint_scene *a, const struct glint_scene *b)
{
    bool same = a->animations == b->animations && (!a->animations || a->fps == b->fps);
    for (uint32_t i = 0; same && i < a->animations; i++) {
        const struct glint_animation *m = &a->animation[i], *n = &b->animation[i];
        same = m->channels == n->channels;
        for (uint32_t k = 0; same && k < m->channels; k++)
            same = same_channel(&m->channel[k], &n->channel[k]);
    }
    return same;
}

bool glint_share_motion(const struct glint_resident *r)
{
    const struct glint_scene *a = r->scene, *b = r->from->scene;
    return a == b || (same_nodes(a, b) && same_skins(a, b) && same_animations(a, b));
}

// ---- tables that are made anew and turn out the same

static void upload(struct glint_resident *r, enum glint_part part, uint32_t items)
{
    r->change.fate[part] = GLINT_UPLOADED;
    r->change.items[part] = items;
}

static bool same_row(const struct glint_row *a, const struct glint_row *b)
{
    return a->material == b->material && !a->motion && !b->motion &&
           memcmp(a->transform, b->transform, sizeof a->transform) == 0;
}

static bool same_rows(const struct glint_resident *r)
{
    bool same = r->rows == r->from->rows;
    for (uint32_t i = 0; same && i < r->rows; i++)
        same = same_row(&r->row[i], &r->from->row[i]);
    return same;
}

static bool same_sky(const struct glint_resident *r)
{
    const struct glint_scene_lighting *a = &r->lighting, *b = &r->from->lighting;
    return memcmp(a->environment, b->environment, sizeof a->environment) == 0 &&
           a->env_rotation == b->env_rotation;
}

// What a table does not hold, or not of every change: it reaches jobs in frame constants or in the
// traversal structure.
static void settle_numbers(struct glint_resident *r)
{
    if (r->from && !same_rows(r))
        upload(r, GLINT_PART_INSTANCES, r->rows);
    if (r->from && !same_sky(r))
        upload(r, GLINT_PART_ENVIRONMENT, 1);
}

static void settle(struct glint_resident *r, enum glint_part part, const enum glint_table *tables,
                   size_t count, uint32_t items)
{
    bool same = r->from != NULL;
    for (size_t t = 0; r->from && t < count; t++)
        same &= glint_share_equal_table(r, tables[t]);
    r->change.fate[part] = GLINT_KEPT;
    r->change.items[part] = 0;
    if (!same)
        upload(r, part, items);
}

#define SETTLE(part, items, ...)                             \
    settle(r, part, (const enum glint_table[]){__VA_ARGS__}, \
           sizeof((const enum glint_table[]){__VA_ARGS__}) / sizeof(enum glint_table), items)

void glint_share_settle(struct glint_resident *r)
{
    const uint32_t meshes = r->change.items[GLINT_PART_MESHES];
    SETTLE(GLINT_PART_MESHES, meshes, GLINT_TABLE_TRIANGLES, GLINT_TABLE_TANGENTS, GLINT_TABLE_UV1,
           GLINT_TABLE_COLOURS);
    if (meshes) // with records that are those of another by chance
        upload(r, GLINT_PART_MESHES, meshes);
    SETTLE(GLINT_PART_TEXTURES, r->scene->images, GLINT_TABLE_TEXTURES, GLINT_TABLE_DECODE,
           GLINT_TABLE_POOL0, GLINT_TABLE_POOL1, GLINT_TABLE_POOL2, GLINT_TABLE_POOL3);
    SETTLE(GLINT_PART_MATERIALS, r->scene->materials, GLINT_TABLE_MATERIALS, GLINT_TABLE_ENERGY);
    SETTLE(GLINT_PART_INSTANCES, r->rows, GLINT_TABLE_INSTANCES, GLINT_TABLE_MOVERS,
           GLINT_TABLE_TURNS, GLINT_TABLE_FLOWS);
    SETTLE(GLINT_PART_LIGHTS, r->lights, GLINT_TABLE_LIGHTS, GLINT_TABLE_ALIAS,
           GLINT_TABLE_LIGHT_CELLS);
    SETTLE(GLINT_PART_ENVIRONMENT, 1, GLINT_TABLE_ENV_TEXELS, GLINT_TABLE_ENV_CELLS);
    settle_numbers(r);
}
