// resident.c - builds, counts and answers for a resident revision.
#include "scene/internal.h"

#include "base/clock.h"

#include <stdio.h>
#include <stdlib.h>

const char *const glint_part_name[GLINT_PARTS] = {
    [GLINT_PART_MESHES] = "meshes",       [GLINT_PART_TEXTURES] = "textures",
    [GLINT_PART_MATERIALS] = "materials", [GLINT_PART_INSTANCES] = "instances",
    [GLINT_PART_LIGHTS] = "lights",       [GLINT_PART_ENVIRONMENT] = "environment",
    [GLINT_PART_BVH] = "bvh",             [GLINT_PART_PLACEMENT] = "placement",
};

static void release_tables(struct glint_resident *r)
{
    for (int t = 0; t < GLINT_TABLES; t++)
        glint_buffer_destroy(&r->table[t]);
}

static void destroy(struct glint_resident *r)
{
    glint_geometry_destroy(&r->geometry[0]);
    glint_geometry_destroy(&r->geometry[1]);
    release_tables(r);
    for (uint32_t i = 0; r->kept && i <= r->scene->meshes; i++)
        free(r->kept[i].index);
    free(r->kept);
    free(r->row);
    free(r->matte);
    pthread_mutex_destroy(&r->mutex);
    free(r);
}

// One stage of the build and the clock that it is charged to.
static glint_status timed(glint_status (*stage)(struct glint_resident *, struct glint_error *),
                          struct glint_resident *r, double *seconds, struct glint_error *err)
{
    const double start = glint_now();
    const glint_status st = stage(r, err);
    *seconds += glint_now() - start;
    return st;
}

static glint_status build_fast_geometry(struct glint_resident *r, struct glint_error *err)
{
    return glint_resident_build_geometry(r, false, &r->geometry[0], err);
}

#define TABLE(t) (1u << GLINT_TABLE_##t)
#define RECORD_TABLES                                                                      \
    (TABLE(TRIANGLES) | TABLE(TANGENTS) | TABLE(UV1) | TABLE(COLOURS) | TABLE(INSTANCES) | \
     TABLE(MOVERS) | TABLE(TURNS) | TABLE(FLOWS) | TABLE(MATERIALS))
#define LIGHT_TABLES \
    (TABLE(LIGHTS) | TABLE(ALIAS) | TABLE(LIGHT_CELLS) | TABLE(ENV_TEXELS) | TABLE(ENV_CELLS))

static uint64_t bytes_of(const struct glint_resident *r, uint32_t tables)
{
    uint64_t bytes = 0;
    for (int t = 0; t < GLINT_TABLES; t++)
        bytes += tables & 1u << t ? glint_buffer_bytes(r->table[t]) : 0;
    return bytes;
}

// Kernels are given every table: those that nothing filled hold one entry of zeros.
static glint_status fill_gaps(struct glint_resident *r, struct glint_error *err)
{
    glint_status st = GLINT_OK;
    for (int t = 0; !st && t < GLINT_TABLES; t++)
        if (!r->table[t])
            st = glint_buffer_create(&r->table[t], r->devices, 256, err);
    return st;
}

static glint_status build(struct glint_resident *r, struct glint_error *err)
{
    struct glint_resident_stats *s = &r->stats;
    glint_status st = timed(glint_resident_build_rows, r, &s->geometry_seconds, err);
    if (!st)
        st = timed(glint_resident_build_textures, r, &s->texture_seconds, err);
    if (!st)
        st = timed(glint_resident_build_materials, r, &s->texture_seconds, err);
    if (!st)
        st = timed(glint_resident_build_records, r, &s->geometry_seconds, err);
    if (!st)
        st = timed(glint_resident_build_lights, r, &s->light_seconds, err);
    if (!st)
        st = timed(glint_resident_build_environment, r, &s->light_seconds, err);
    if (!st)
        st = timed(build_fast_geometry, r, &s->bvh_seconds, err);
    return st ? st : fill_gaps(r, err);
}

static void count_bytes(struct glint_resident *r)
{
    struct glint_resident_stats *s = &r->stats;
    s->record_bytes = bytes_of(r, RECORD_TABLES);
    s->light_bytes = bytes_of(r, LIGHT_TABLES);
    for (uint32_t i = 0; i < r->scene->meshes; i++) {
        const struct glint_mesh *m = &r->scene->mesh[i];
        const uint64_t vertex =
            12u + (m->normal ? 12u : 0u) + (m->uv ? 8u : 0u) + (m->tangent ? 16u : 0u);
        s->geometry_bytes += m->vertices * vertex + m->triangles * 12ull;
    }
    s->bvh_bytes = glint_geometry_bytes(r->geometry[0]);
}

glint_status glint_resident_create(glint_resident **out, glint_devices *devices,
                                   const struct glint_resident_order *order,
                                   struct glint_error *err)
{
    *out = NULL;
    struct glint_resident *r = calloc(1, sizeof *r);
    if (!r)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a scene");
    pthread_mutex_init(&r->mutex, NULL);
    atomic_init(&r->references, 1);
    r->devices = devices;
    for (int p = 0; p < GLINT_PARTS; p++)
        r->change.fate[p] = GLINT_REBUILT;
    r->scene = order->scene;
    const glint_status st = build(r, err);
    if (st) {
        destroy(r);
        return st;
    }
    count_bytes(r);
    if (order->from && order->from->scene == order->scene)
        r->owner = glint_resident_retain((glint_resident *)order->from);
    r->free_assets = order->free_assets;
    r->assets = order->assets;
    *out = r;
    return GLINT_OK;
}

const struct glint_resident_change *glint_resident_change(const glint_resident *r)
{
    return &r->change;
}

glint_resident *glint_resident_retain(glint_resident *r)
{
    atomic_fetch_add_explicit(&r->references, 1, memory_order_relaxed);
    return r;
}

void glint_resident_release(glint_resident **resident)
{
    struct glint_resident *r = *resident;
    *resident = NULL;
    // Acquire-release: the last holder sees all that the others did before it frees.
    if (!r || atomic_fetch_sub_explicit(&r->references, 1, memory_order_acq_rel) != 1)
        return;
    struct glint_scene *scene = r->owner ? NULL : r->scene;
    glint_resident *owner = r->owner;
    void (*free_assets)(void *) = r->free_assets;
    void *assets = r->assets;
    destroy(r);
    glint_scene_destroy(&scene);
    glint_resident_release(&owner);
    if (free_assets)
        free_assets(assets);
}

const struct glint_scene *glint_resident_scene(const glint_resident *r)
{
    return r->scene;
}

void glint_resident_set_revision(glint_resident *r, const char *revision)
{
    snprintf(r->revision, sizeof r->revision, "%s", revision);
}

const char *glint_resident_revision(const glint_resident *r)
{
    return r->revision;
}

void glint_resident_stats(const glint_resident *r, struct glint_resident_stats *out)
{
    *out = r->stats;
}

const struct glint_scene_facts *glint_resident_facts(const glint_resident *r)
{
    return &r->facts;
}

const struct glint_scene_lighting *glint_resident_lighting(const glint_resident *r)
{
    return &r->lighting;
}

void glint_resident_centre(const glint_resident *r, double centre[3])
{
    for (int k = 0; k < 3; k++)
        centre[k] = r->centre[k];
}

glint_buffer *glint_resident_table(const glint_resident *r, enum glint_table table)
{
    return r->table[table];
}

glint_status glint_resident_geometry(glint_resident *r, enum glint_geometry_kind kind, bool robust,
                                     const struct glint_geometry **out, struct glint_error *err)
{
    glint_status st = GLINT_OK;
    (void)kind;
    pthread_mutex_lock(&r->mutex);
    if (!r->geometry[robust])
        st = glint_resident_build_geometry(r, robust, &r->geometry[robust], err);
    *out = r->geometry[robust];
    pthread_mutex_unlock(&r->mutex);
    return st;
}

uint32_t glint_resident_mattes(const glint_resident *r, const struct glint_matte_key **keys)
{
    *keys = r->matte;
    return r->mattes;
}
