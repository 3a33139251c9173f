// resident.c - builds, counts and answers for a resident revision.
#include "scene/internal.h"

#include "base/clock.h"

#include <stdio.h>
#include <stdlib.h>

// Seen with instances expanded: a structure of high quality takes 1.1 us of the processor for each.
#define LARGE_TRIANGLES 65536u

const char *const glint_part_name[GLINT_PARTS] = {
    [GLINT_PART_MESHES] = "meshes",
    [GLINT_PART_TEXTURES] = "textures",
    [GLINT_PART_MATERIALS] = "materials",
    [GLINT_PART_INSTANCES] = "instances",
    [GLINT_PART_LIGHTS] = "lights",
    [GLINT_PART_ENVIRONMENT] = "environment",
    [GLINT_PART_BVH] = "bvh",
    [GLINT_PART_PLACEMENT] = "placement",
};

static void release_tables(struct glint_resident *r)
{
    for (int t = 0; t < GLINT_TABLES; t++)
        glint_buffer_destroy(&r->table[t]);
}

static void destroy(struct glint_resident *r)
{
    for (int g = 0; g < 4; g++)
        glint_geometry_destroy(&r->geometry[g / 2][g % 2]);
    release_tables(r);
    for (uint32_t i = 0; i < r->kepts; i++)
        glint_shape_release(&r->kept[i].shape);
    glint_tracer_release(&r->tracer);
    glint_pose_release(&r->pose);
    free(r->kept);
    free(r->row);
    free(r->motion);
    free(r->matte);
    pthread_mutex_destroy(&r->building);
    glint_arena_finish(&r->names);
    pthread_mutex_destroy(&r->mutex);
    free(r);
}

// ---- the stages of a build

static glint_status build_shown(struct glint_resident *r, struct glint_error *err)
{
    const glint_status st = glint_resident_build_rows(r, err);
    return st ? st : glint_resident_build_mattes(r, err);
}

static glint_status build_textures(struct glint_resident *r, struct glint_error *err)
{
    return glint_share_textures(r) ? GLINT_OK : glint_resident_build_textures(r, err);
}

static glint_status build_lights(struct glint_resident *r, struct glint_error *err)
{
    return glint_share_lights(r) ? GLINT_OK : glint_resident_build_lights(r, err);
}

// A scene that nobody has seen yet is most likely rendered next: by a batch job, which begins with a
// sketch where the structure takes a while. One that follows another has what its jobs trace now.
static glint_status build_geometry(struct glint_resident *r, struct glint_error *err)
{
    if (r->from)
        return glint_share_geometry(r, err);
    if (!glint_resident_is_large(r))
        return glint_resident_build_geometry(r, GLINT_GEOMETRY_FLAT, false, err);
    r->change.fate[GLINT_PART_BVH] = GLINT_LATER;
    return GLINT_OK;
}

typedef glint_status build_stage(struct glint_resident *r, struct glint_error *err);

// Runs a stage and charges its time to a part and to one of the sums of the resource.
static glint_status stage(struct glint_resident *r, build_stage *run, enum glint_part part,
                          double *sum, struct glint_error *err)
{
    const double start = glint_now();
    const glint_status st = run(r, err);
    r->change.seconds[part] += glint_now() - start;
    *sum += glint_now() - start;
    return st;
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
    const struct {
        build_stage *run;
        enum glint_part part;
        double *sum;
    } stages[] = {
        {build_shown, GLINT_PART_INSTANCES, &s->geometry_seconds},
        {build_textures, GLINT_PART_TEXTURES, &s->texture_seconds},
        {glint_resident_build_materials, GLINT_PART_MATERIALS, &s->texture_seconds},
        {glint_resident_build_records, GLINT_PART_MESHES, &s->geometry_seconds},
        {glint_resident_build_instances, GLINT_PART_INSTANCES, &s->geometry_seconds},
        {build_lights, GLINT_PART_LIGHTS, &s->light_seconds},
        {glint_resident_build_environment, GLINT_PART_ENVIRONMENT, &s->light_seconds},
        {fill_gaps, GLINT_PART_MESHES, &s->geometry_seconds},
    };
    glint_status st = GLINT_OK;
    for (size_t i = 0; !st && i < sizeof stages / sizeof *stages; i++)
        st = stage(r, stages[i].run, stages[i].part, stages[i].sum, err);
    if (!st)
        glint_share_settle(r);
    return st ? st : build_geometry(r, err);
}

// ---- sizes

#define LIGHT_TABLES                                                                      \
    (1u << GLINT_TABLE_LIGHTS | 1u << GLINT_TABLE_ALIAS | 1u << GLINT_TABLE_LIGHT_CELLS | \
     1u << GLINT_TABLE_ENV_TEXELS | 1u << GLINT_TABLE_ENV_CELLS)
#define ROW_TABLES                                                                      \
    (1u << GLINT_TABLE_INSTANCES | 1u << GLINT_TABLE_MOVERS | 1u << GLINT_TABLE_TURNS | \
     1u << GLINT_TABLE_FLOWS | 1u << GLINT_TABLE_MATERIALS)

static uint64_t bytes_of(const struct glint_resident *r, uint32_t tables)
{
    uint64_t bytes = 0;
    for (int t = 0; t < GLINT_TABLES; t++)
        bytes += tables & 1u << t ? glint_buffer_bytes(r->table[t]) : 0;
    return bytes;
}

static void count_bytes(struct glint_resident *r)
{
    struct glint_resident_stats *s = &r->stats;
    s->record_bytes += bytes_of(r, ROW_TABLES); // those of triangles are counted as they are made
    s->light_bytes = bytes_of(r, LIGHT_TABLES);
    for (uint32_t i = 0; i < r->scene->meshes; i++) {
        const struct glint_mesh *m = &r->scene->mesh[i];
        const uint64_t vertex = 12u + (m->normal ? 12u : 0u) + (m->uv ? 8u : 0u) +
                                (m->tangent ? 16u : 0u) + (m->uv1 ? 8u : 0u) +
                                (m->color ? 16u : 0u) + (m->joint ? 24u : 0u);
        s->geometry_bytes += m->vertices * vertex + m->triangles * 12ull;
    }
    s->geometry_bytes += r->pose ? r->pose->bytes : 0;
}

// Of what is built by now. Bodies of a placed structure count for every revision that has them.
static uint64_t bvh_bytes(struct glint_resident *r)
{
    uint64_t bytes = 0;
    for (int robust = 0; robust < 2; robust++) {
        const glint_geometry *flat = r->geometry[GLINT_GEOMETRY_FLAT][robust];
        const glint_geometry *placed = r->geometry[GLINT_GEOMETRY_PLACED][robust];
        bytes += flat ? glint_world_tracer_bytes(glint_geometry_world(flat)) : 0;
        bytes += placed ? glint_world_bytes(glint_geometry_world(placed)) : 0;
    }
    for (uint32_t i = 0; i < r->kepts; i++)
        bytes += r->kept[i].shape ? glint_shape_bytes(r->kept[i].shape) : 0;
    return bytes;
}

// ---- life

static glint_status begin(struct glint_resident *r, const struct glint_resident_order *order,
                          struct glint_error *err)
{
    const struct glint_pose_request rest = glint_pose_rest();
    r->scene = order->scene;
    r->from = order->from;
    if (r->from && r->from->scene == r->scene)
        r->owner = glint_resident_retain((glint_resident *)r->from);
    for (int p = 0; p < GLINT_PARTS && !r->from; p++)
        r->change.fate[p] = GLINT_UPLOADED;
    if (r->from)
        r->tracer = glint_tracer_retain(r->from->tracer);
    else if (glint_tracer_create(&r->tracer, err))
        return err->status;
    if (order->pose)
        r->pose = glint_pose_retain(order->pose);
    else if (glint_pose_needed(r->scene))
        return glint_pose_create(&r->pose, r->scene, &rest, err);
    return GLINT_OK;
}

glint_status glint_resident_create(glint_resident **out, glint_devices *devices,
                                   const struct glint_resident_order *order,
                                   struct glint_error *err)
{
    *out = NULL;
    struct glint_resident *r = calloc(1, sizeof *r);
    if (!r)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a scene");
    pthread_mutex_init(&r->building, NULL);
    pthread_mutex_init(&r->mutex, NULL);
    atomic_init(&r->references, 1);
    r->devices = devices;
    glint_status st = begin(r, order, err);
    if (!st)
        st = build(r, err);
    if (st) {
        glint_resident *owner = r->owner;
        destroy(r);
        glint_resident_release(&owner);
        return st;
    }
    count_bytes(r);
    glint_kept_forget(r);
    r->from = NULL;
    r->made = true;
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

void glint_resident_stats(const glint_resident *resident, struct glint_resident_stats *out)
{
    struct glint_resident *r = (struct glint_resident *)resident;
    pthread_mutex_lock(&r->mutex);
    *out = r->stats;
    out->bvh_bytes = bvh_bytes(r);
    pthread_mutex_unlock(&r->mutex);
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

uint32_t glint_resident_segments(const glint_resident *r)
{
    return glint_resident_keys(r) - 1;
}

// Who waits for a structure holds nobody up who asks what there is.
glint_status glint_resident_geometry(glint_resident *r, enum glint_geometry_kind kind, bool robust,
                                     const struct glint_geometry **out, struct glint_error *err)
{
    glint_status st = GLINT_OK;
    pthread_mutex_lock(&r->building);
    if (!r->geometry[kind][robust])
        st = glint_resident_build_geometry(r, kind, robust, err);
    *out = r->geometry[kind][robust];
    pthread_mutex_unlock(&r->building);
    return st;
}

bool glint_resident_is_large(const glint_resident *resident)
{
    return resident->stats.instanced_triangles >= LARGE_TRIANGLES;
}

bool glint_resident_has_geometry(const glint_resident *resident, enum glint_geometry_kind kind,
                                 bool robust)
{
    struct glint_resident *r = (struct glint_resident *)resident;
    pthread_mutex_lock(&r->mutex);
    const bool has = r->geometry[kind][robust] != NULL;
    pthread_mutex_unlock(&r->mutex);
    return has;
}

uint32_t glint_resident_mattes(const glint_resident *r, const struct glint_matte_key **keys)
{
    *keys = r->matte;
    return r->mattes;
}
