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

// ---- tables that are made anew and turn out the same

static void settle(struct glint_resident *r, enum glint_part part, const enum glint_table *tables,
                   size_t count, uint32_t items)
{
    bool same = r->from != NULL;
    for (size_t t = 0; r->from && t < count; t++)
        same &= glint_share_equal_table(r, tables[t]);
    r->change.fate[part] = same ? GLINT_KEPT : GLINT_UPLOADED;
    r->change.items[part] = same ? 0 : items;
}

#define SETTLE(part, items, ...)                             \
    settle(r, part, (const enum glint_table[]){__VA_ARGS__}, \
           sizeof((const enum glint_table[]){__VA_ARGS__}) / sizeof(enum glint_table), items)

void glint_share_settle(struct glint_resident *r)
{
    const uint32_t meshes = r->change.items[GLINT_PART_MESHES];
    SETTLE(GLINT_PART_MESHES, meshes, GLINT_TABLE_TRIANGLES, GLINT_TABLE_TANGENTS, GLINT_TABLE_UV1,
           GLINT_TABLE_COLOURS);
    if (meshes) { // with records that are those of another by chance
        r->change.fate[GLINT_PART_MESHES] = GLINT_UPLOADED;
        r->change.items[GLINT_PART_MESHES] = meshes;
    }
    SETTLE(GLINT_PART_TEXTURES, r->scene->images, GLINT_TABLE_TEXTURES, GLINT_TABLE_DECODE,
           GLINT_TABLE_POOL0, GLINT_TABLE_POOL1, GLINT_TABLE_POOL2, GLINT_TABLE_POOL3);
    SETTLE(GLINT_PART_MATERIALS, r->scene->materials, GLINT_TABLE_MATERIALS, GLINT_TABLE_ENERGY);
    SETTLE(GLINT_PART_INSTANCES, r->rows, GLINT_TABLE_INSTANCES, GLINT_TABLE_MOVERS,
           GLINT_TABLE_TURNS, GLINT_TABLE_FLOWS);
    SETTLE(GLINT_PART_LIGHTS, r->lights, GLINT_TABLE_LIGHTS, GLINT_TABLE_ALIAS,
           GLINT_TABLE_LIGHT_CELLS);
    SETTLE(GLINT_PART_ENVIRONMENT, 1, GLINT_TABLE_ENV_TEXELS, GLINT_TABLE_ENV_CELLS);
}
