// place.c - hands the kept triangles of every row to the traversal structures.
#include "base/clock.h"
#include "base/memory.h"
#include "kernels/gk_sampler.h"
#include "scene/internal.h"

#include <stdlib.h>
#include <string.h>

// In a flat structure a mesh that is drawn often is kept once and placed many times; below this many
// triangles in all its uses, copies trace faster than placements (by 8-17 %) and cost little.
#define BAKE_LIMIT 65536u

static bool has_holes(const struct glint_resident *r, const struct glint_row *row)
{
    if (row->material >= r->scene->materials)
        return false;
    const struct glint_material *m = &r->scene->material[row->material];
    return m->alpha_mode == GLINT_ALPHA_BLEND ||
           (m->alpha_mode == GLINT_ALPHA_MASK && m->alpha_cutoff > 0.0f);
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

// ---- one row

// A structure while it is filled, and the bodies that it is filled with.
struct filling {
    struct glint_resident *r;
    glint_tracer *tracer;
    struct glint_geometry_build build;
    bool flat;
    glint_body **body;     // [rows], borrowed; NULL: the row is baked
    glint_body *(*own)[2]; // [kepts][holes] of a flat structure
    uint32_t built;
};

// The vertices of a row in the world at all its keys; malloc'd.
static float *baked_positions(const struct glint_resident *r, const struct glint_row *row,
                              uint32_t keys)
{
    const uint32_t vertices = row->mesh->vertices;
    float *position = malloc((size_t)keys * vertices * 12);
    for (uint32_t k = 0; position && k < keys; k++)
        for (uint32_t i = 0; i < vertices; i++) {
            double p[3];
            glint_row_vertex(r, row, k, i, p);
            for (int c = 0; c < 3; c++)
                position[3 * ((size_t)k * vertices + i) + c] = (float)p[c];
        }
    return position;
}

static glint_status bake_row(const struct filling *f, glint_world *world, uint32_t index,
                             struct glint_error *err)
{
    const struct glint_row *row = &f->r->row[index];
    const struct glint_kept *k = &f->r->kept[row->kept];
    const uint32_t keys = glint_row_moves(f->r, row) ? glint_resident_keys(f->r) : 1;
    float *position = baked_positions(f->r, row, keys);
    if (!position)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u vertices", row->mesh->vertices);
    const struct glint_geometry_mesh mesh = {.position = position,
                                             .vertices = row->mesh->vertices,
                                             .index = k->index,
                                             .triangles = k->triangles,
                                             .keys = keys,
                                             .holes = has_holes(f->r, row)};
    const glint_status st = glint_world_add_mesh(world, index, &mesh, err);
    free(position);
    return st;
}

// From where the vertices of a body are to the scene's centre.
static void placed_transform(const float t[16], const float origin[3], float out[16])
{
    memcpy(out, t, 16 * sizeof *out);
    for (int i = 0; i < 3; i++)
        out[12 + i] = (float)((double)t[i] * origin[0] + (double)t[4 + i] * origin[1] +
                              (double)t[8 + i] * origin[2] + (double)t[12 + i]);
}

static glint_status place_row(const struct filling *f, glint_world *world, uint32_t index,
                              struct glint_error *err)
{
    const struct glint_row *row = &f->r->row[index];
    const uint32_t keys = row->motion ? glint_resident_keys(f->r) : 1;
    float origin[3], transform[GLINT_POSE_MAX_KEYS * 16];
    glint_shape_origin(f->r->kept[row->kept].shape, origin);
    for (uint32_t k = 0; k < keys; k++)
        placed_transform(row->motion ? row->motion + 16 * (size_t)k : row->transform, origin,
                         transform + 16 * k);
    return glint_world_place(world, index, f->body[index], transform, keys, err);
}

static glint_status fill_world(glint_world *world, void *user, struct glint_error *err)
{
    const struct filling *f = user;
    glint_status st = GLINT_OK;
    for (uint32_t i = 0; !st && i < f->r->rows; i++)
        if (f->body[i])
            st = place_row(f, world, i, err);
        else if (f->r->kept[f->r->row[i].kept].triangles)
            st = bake_row(f, world, i, err);
    uint32_t *ring = NULL;
    if (!st)
        st = glint_ties_find(&ring, f->r, err);
    glint_world_tie(world, ring);
    return st;
}

// ---- bodies

// Bent vertices are baked: a body of them serves one row alone.
static bool wants_body(const struct filling *f, const struct glint_row *row)
{
    const struct glint_kept *k = &f->r->kept[row->kept];
    if (!f->flat)
        return true;
    return k->keys == 1 &&
           (row->motion || (k->uses > 1 && (uint64_t)k->uses * k->triangles > BAKE_LIMIT));
}

static glint_status find_body(struct filling *f, const struct glint_row *row, glint_body **out,
                              struct glint_error *err)
{
    const struct glint_kept *k = &f->r->kept[row->kept];
    struct glint_geometry_mesh mesh = {.position = k->position,
                                       .vertices = row->mesh->vertices,
                                       .index = k->index,
                                       .triangles = k->triangles,
                                       .keys = k->keys,
                                       .holes = has_holes(f->r, row)};
    bool built = false;
    glint_status st = GLINT_OK;
    if (!f->flat) {
        st = glint_shape_body(k->shape, f->tracer, &mesh, &f->build, out, &built, err);
    } else {
        glint_body **own = &f->own[row->kept][mesh.holes];
        glint_shape_origin(k->shape, mesh.origin);
        built = !*own;
        if (built)
            st = glint_body_create(own, f->tracer, &mesh, &f->build, err);
        *out = *own;
    }
    f->built += built;
    return st;
}

static glint_status find_bodies(struct filling *f, struct glint_error *err)
{
    glint_status st = GLINT_OK;
    for (uint32_t i = 0; !st && i < f->r->rows; i++) {
        const struct glint_row *row = &f->r->row[i];
        if (f->r->kept[row->kept].triangles && wants_body(f, row))
            st = find_body(f, row, &f->body[i], err);
    }
    return st;
}

// ---- structures

static glint_status open_filling(struct filling *f, struct glint_error *err)
{
    const struct glint_resident *r = f->r;
    f->body = calloc((size_t)r->rows + 1, sizeof *f->body);
    f->own = calloc((size_t)r->kepts + 1, sizeof *f->own);
    if (!f->body || !f->own)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u instances", r->rows);
    if (!f->flat) {
        f->tracer = glint_tracer_retain(r->tracer);
        return GLINT_OK;
    }
    return glint_tracer_create(&f->tracer, err); // of its own: a long build holds nobody up
}

static void close_filling(struct filling *f)
{
    for (uint32_t i = 0; f->own && i < f->r->kepts; i++)
        for (int holes = 0; holes < 2; holes++)
            glint_body_release(&f->own[i][holes]);
    free(f->own);
    free(f->body);
    glint_tracer_release(&f->tracer);
}

static void charge(struct glint_resident *r, const struct filling *f, double bodies, double world)
{
    const enum glint_part part = f->flat ? GLINT_PART_BVH : GLINT_PART_PLACEMENT;
    struct glint_resident_change *c = &r->change;
    pthread_mutex_lock(&r->mutex);
    r->stats.bvh_seconds += bodies + world;
    pthread_mutex_unlock(&r->mutex);
    if (r->made)
        return;
    c->seconds[GLINT_PART_BVH] += bodies;
    c->seconds[part] += world;
    c->items[GLINT_PART_BVH] += f->built;
    c->items[part]++;
    if (f->built)
        c->fate[GLINT_PART_BVH] = GLINT_REBUILT;
    c->fate[part] = GLINT_REBUILT;
}

static glint_status view(const struct glint_resident *r, glint_world *world, glint_geometry **out,
                         struct glint_error *err)
{
    *out = glint_geometry_create(world, hole_at, r);
    return *out ? GLINT_OK : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a geometry");
}

// What Embree takes from the heap for a triangle of a flat structure.
#define HEAP_BYTES 112u

// *placing: when the bodies were there.
static glint_status build(struct filling *f, glint_geometry **out, double *placing,
                          struct glint_error *err)
{
    glint_world *world = NULL;
    if (f->flat)
        glint_memory_expect(f->r->stats.instanced_triangles * HEAP_BYTES);
    glint_status st = open_filling(f, err);
    if (!st)
        st = find_bodies(f, err);
    *placing = glint_now();
    if (!st)
        st = glint_world_create(&world, f->tracer, &f->build, fill_world, f, err);
    if (!st)
        st = view(f->r, world, out, err);
    glint_world_release(&world);
    close_filling(f);
    if (f->flat)
        glint_memory_settle();
    return st;
}

static void keep(struct glint_resident *r, glint_geometry **at, glint_geometry *geometry)
{
    pthread_mutex_lock(&r->mutex);
    *at = geometry;
    pthread_mutex_unlock(&r->mutex);
}

glint_status glint_resident_build_geometry(struct glint_resident *r, enum glint_geometry_kind kind,
                                           bool robust, struct glint_error *err)
{
    const bool flat = kind == GLINT_GEOMETRY_FLAT;
    struct filling f = {
        .r = r,
        .flat = flat,
        .build = {robust, flat ? GLINT_GEOMETRY_FINE : GLINT_GEOMETRY_BRISK},
    };
    glint_geometry *made = NULL;
    double placing;
    const double start = glint_now();
    const glint_status st = build(&f, &made, &placing, err);
    if (st)
        return st;
    charge(r, &f, placing - start, glint_now() - placing);
    keep(r, &r->geometry[kind][robust], made);
    return GLINT_OK;
}

glint_status glint_resident_sketch(glint_resident *r, bool robust, glint_geometry **out,
                                   struct glint_error *err)
{
    struct filling f = {.r = r, .flat = true, .build = {robust, GLINT_GEOMETRY_QUICK}};
    double placing;
    *out = NULL;
    return build(&f, out, &placing, err);
}

// ---- sharing

static bool same_place(const struct glint_resident *r, uint32_t i)
{
    const struct glint_row *a = &r->row[i], *b = &r->from->row[i];
    const struct glint_kept *k = &r->kept[a->kept], *l = &r->from->kept[b->kept];
    return k->shape == l->shape && k->keys == 1 && !a->motion && !b->motion &&
           memcmp(a->transform, b->transform, sizeof a->transform) == 0 &&
           has_holes(r, a) == has_holes(r->from, b);
}

static bool same_places(const struct glint_resident *r)
{
    bool same = r->rows == r->from->rows;
    for (uint32_t i = 0; same && i < r->rows; i++)
        same = same_place(r, i);
    return same;
}

// Structures of other things that nobody has asked for yet.
static void defer(struct glint_resident_change *c)
{
    static const enum glint_part part[] = {GLINT_PART_BVH, GLINT_PART_PLACEMENT};
    for (size_t i = 0; i < sizeof part / sizeof *part; i++)
        if (c->fate[part[i]] == GLINT_KEPT)
            c->fate[part[i]] = GLINT_LATER;
}

glint_status glint_share_geometry(struct glint_resident *r, struct glint_error *err)
{
    glint_geometry *known[2][2];
    pthread_mutex_t *mutex = (pthread_mutex_t *)&r->from->mutex;
    const bool same = same_places(r);
    glint_status st = GLINT_OK;
    // What `from` has it keeps: only that it is there is read under its lock.
    pthread_mutex_lock(mutex);
    memcpy(known, r->from->geometry, sizeof known);
    pthread_mutex_unlock(mutex);
    for (int kind = 0; kind < 2; kind++)
        for (int robust = 0; !st && robust < 2; robust++)
            if (known[kind][robust] && same)
                st = view(r, glint_geometry_world(known[kind][robust]), &r->geometry[kind][robust],
                          err);
            else if (known[kind][robust] && kind == GLINT_GEOMETRY_PLACED)
                st = glint_resident_build_geometry(r, kind, robust, err);
    if (!same || !glint_share_motion(r))
        defer(&r->change);
    return st;
}
