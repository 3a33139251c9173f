// textures.c - images as tiled texels in pools, and a record for each way of using one.
#include "scene/internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define POOLS 4
#define POOL_TEXELS ((1u << 28) - 64u) // just under 1 GiB

// Where an image's texels lie.
struct spot {
    uint32_t pool, offset;
    bool used;
};

static size_t tiled_texels(const struct glint_image *image)
{
    return (size_t)((image->width + 7) / 8) * ((image->height + 7) / 8) * 64;
}

#define USES 10

// The ways in which a material uses images.
static const struct glint_texture *use_of(const struct glint_material *m, int use)
{
    const struct glint_texture *texture[USES] = {&m->base_color_texture,
                                                 &m->metallic_roughness_texture,
                                                 &m->normal_texture,
                                                 &m->emission_texture,
                                                 &m->specular_texture,
                                                 &m->specular_color_texture,
                                                 &m->transmission_texture,
                                                 &m->clearcoat_texture,
                                                 &m->clearcoat_roughness_texture,
                                                 &m->clearcoat_normal_texture};
    return texture[use];
}

// KHR_texture_transform: translation, rotation and scale, the last applied first. The rotation is
// counter-clockwise on the coordinates, whose v runs downwards.
static void fill_transform(const struct glint_texture *use, float m[6])
{
    const double c = cos((double)use->rotation), s = sin((double)use->rotation);
    const double x = use->scale[0], y = use->scale[1];
    const double exact[6] = {c * x, s * y, use->offset[0], -s * x, c * y, use->offset[1]};
    for (int i = 0; i < 6; i++)
        m[i] = (float)exact[i];
}

static bool is_transformed(const struct glint_texture *use)
{
    return use->offset[0] != 0.0f || use->offset[1] != 0.0f || use->scale[0] != 1.0f ||
           use->scale[1] != 1.0f || use->rotation != 0.0f;
}

static uint32_t flags_of(const struct glint_texture *use)
{
    return (uint32_t)use->wrap_u | (uint32_t)use->wrap_v << 2 |
           (use->filter == GLINT_FILTERING_NEAREST ? GK_TEXTURE_NEAREST : 0u) |
           (use->uv_set == 1 ? GK_TEXTURE_UV1 : 0u) |
           (is_transformed(use) ? GK_TEXTURE_TRANSFORMED : 0u);
}

// Finds room for every image that a material uses.
static glint_status place_images(const struct glint_resident *r, struct spot *spot,
                                 size_t used[POOLS], struct glint_error *err)
{
    uint32_t pool = 0;
    for (uint32_t i = 0; i < r->scene->images; i++) {
        const struct glint_image *image = &r->scene->image[i];
        if (!spot[i].used)
            continue;
        const size_t texels = tiled_texels(image);
        if (used[pool] + texels > POOL_TEXELS)
            pool++;
        if (pool == POOLS || texels > POOL_TEXELS)
            return glint_fail(err, GLINT_E_CAPACITY, "/images", "textures exceed %u pools of 1 GiB",
                              POOLS);
        spot[i].pool = pool;
        spot[i].offset = (uint32_t)used[pool];
        used[pool] += texels;
    }
    return GLINT_OK;
}

static void tile_image(uint32_t *out, const struct glint_image *image)
{
    const uint32_t tiles = (image->width + 7) / 8;
    for (uint32_t y = 0; y < image->height; y++)
        for (uint32_t x = 0; x < image->width; x++) {
            const size_t tile = (size_t)(y / 8) * tiles + x / 8;
            memcpy(&out[tile * 64 + (y % 8) * 8 + x % 8],
                   (const uint8_t *)image->pixels + 4 * ((size_t)y * image->width + x), 4);
        }
}

static void fill_decode(float *table)
{
    for (int i = 0; i < 256; i++) {
        const double c = i / 255.0;
        table[i] = (float)(c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4));
    }
}

static uint32_t find_record(const struct gk_texture *t, uint32_t n, const struct gk_texture *wanted)
{
    for (uint32_t i = 0; i < n; i++)
        if (memcmp(&t[i], wanted, sizeof *wanted) == 0)
            return i;
    return n;
}

static struct gk_texture record_of(const struct glint_resident *r, const struct spot *spot,
                                   const struct glint_texture *use)
{
    const struct glint_image *image = &r->scene->image[use->image];
    struct gk_texture t = {.width = image->width,
                           .height = image->height,
                           .offset = spot[use->image].offset,
                           .flags = flags_of(use),
                           .pool = spot[use->image].pool,
                           .image = use->image};
    fill_transform(use, t.transform);
    return t;
}

static void add_records(struct glint_resident *r, const struct spot *spot)
{
    struct gk_texture *t = glint_table_host(r, GLINT_TABLE_TEXTURES);
    uint32_t n = 0;
    for (uint32_t i = 0; i < r->scene->materials; i++)
        for (int use = 0; use < USES; use++) {
            const struct glint_texture *of = use_of(&r->scene->material[i], use);
            if (of->image == GLINT_NONE)
                continue;
            const struct gk_texture wanted = record_of(r, spot, of);
            if (find_record(t, n, &wanted) == n)
                t[n++] = wanted;
        }
    if (n == 0) // what a kernel reads when it has no texture
        t[0] = (struct gk_texture){.width = 1, .height = 1};
}

static glint_status mark_used(const struct glint_resident *r, struct spot *spot,
                              struct glint_error *err)
{
    glint_status st = GLINT_OK;
    for (uint32_t i = 0; i < r->scene->materials; i++)
        for (int use = 0; use < USES; use++) {
            const uint32_t image = use_of(&r->scene->material[i], use)->image;
            if (image == GLINT_NONE || spot[image].used)
                continue;
            spot[image].used = true;
            if (r->scene->image[image].format != GLINT_IMAGE_RGBA8)
                st = glint_fail(err, GLINT_E_RANGE, "/images",
                                "image \"%s\" has half floats: only the environment reads those",
                                r->scene->image[image].id);
        }
    return st;
}

static glint_status fill_pools(struct glint_resident *r, const struct spot *spot,
                               const size_t used[POOLS], struct glint_error *err)
{
    glint_status st = GLINT_OK;
    for (int p = 0; !st && p < POOLS; p++) {
        st = glint_buffer_create(&r->table[GLINT_TABLE_POOL0 + p], r->devices,
                                 (used[p] ? used[p] : 64) * 4, err);
        r->pools += used[p] > 0;
        r->stats.texture_bytes += used[p] * 4;
    }
    for (uint32_t i = 0; !st && i < r->scene->images; i++)
        if (spot[i].used)
            tile_image((uint32_t *)glint_buffer_host(r->table[GLINT_TABLE_POOL0 + spot[i].pool]) +
                           spot[i].offset,
                       &r->scene->image[i]);
    r->facts.texture_pools = r->pools ? r->pools : 1;
    return st;
}

glint_status glint_resident_build_textures(struct glint_resident *r, struct glint_error *err)
{
    struct spot *spot = calloc((size_t)r->scene->images + 1, sizeof *spot);
    if (!spot)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u images", r->scene->images);
    size_t used[POOLS] = {0};
    const size_t records = (size_t)r->scene->materials * USES + 1;
    glint_status st = mark_used(r, spot, err);
    if (!st)
        st = place_images(r, spot, used, err);
    if (!st)
        st = glint_buffer_create(&r->table[GLINT_TABLE_TEXTURES], r->devices,
                                 records * sizeof(struct gk_texture), err);
    if (!st)
        st = glint_buffer_create(&r->table[GLINT_TABLE_DECODE], r->devices, 256 * sizeof(float),
                                 err);
    if (!st)
        st = fill_pools(r, spot, used, err);
    if (!st) {
        fill_decode(glint_table_host(r, GLINT_TABLE_DECODE));
        add_records(r, spot);
    }
    free(spot);
    return st;
}

uint32_t glint_resident_texture(const struct glint_resident *r, const struct glint_texture *use)
{
    if (use->image == GLINT_NONE)
        return GK_NONE;
    const struct gk_texture *t = glint_table_host(r, GLINT_TABLE_TEXTURES);
    const uint32_t flags = flags_of(use);
    float transform[6];
    fill_transform(use, transform);
    uint32_t i = 0;
    while (t[i].image != use->image || t[i].flags != flags ||
           memcmp(t[i].transform, transform, sizeof transform))
        i++; // glint_resident_build_textures() has made one for every use
    return i;
}

// Whether whole numbers of periods along an axis of the mesh move the coordinates of a use by whole
// numbers of its own periods: a clamped axis has none.
static bool periodic_along(const struct glint_texture *use, int axis)
{
    float m[6];
    fill_transform(use, m);
    const float along_u = m[axis], along_v = m[3 + axis];
    return (along_u == 0.0f || use->wrap_u != GLINT_WRAP_CLAMP) && along_u == rintf(along_u) &&
           (along_v == 0.0f || use->wrap_v != GLINT_WRAP_CLAMP) && along_v == rintf(along_v);
}

void glint_material_note_ends(const struct glint_material *m, uint32_t uv_set, bool ends[2])
{
    for (int use = 0; use < USES; use++) {
        const struct glint_texture *t = use_of(m, use);
        for (int axis = 0; axis < 2; axis++)
            ends[axis] |= t->image != GLINT_NONE && t->uv_set == uv_set && !periodic_along(t, axis);
    }
}
