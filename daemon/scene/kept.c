// kept.c - the meshes that rows draw: those of the scene, the quad of area lights and what a pose
// deforms; shared with the revision before where their content is the same.
#include "base/thread.h"
#include "scene/internal.h"

#include <stdlib.h>
#include <string.h>

static const float quad_position[12] = {-0.5f, -0.5f, 0, 0.5f,  -0.5f, 0,
                                        0.5f,  0.5f,  0, -0.5f, 0.5f,  0};
static const float quad_uv[8] = {0, 1, 1, 1, 1, 0, 0, 0};
static const uint32_t quad_index[6] = {0, 2, 1, 0, 3, 2}; // faces -z, where area lights look

// ---- equal meshes

// Which arrays there are says where each lies in an asset.
static bool same_layout(const struct glint_mesh *a, const struct glint_mesh *b)
{
    return !a->normal == !b->normal && !a->uv == !b->uv && !a->tangent == !b->tangent &&
           !a->uv1 == !b->uv1 && !a->color == !b->color && !a->joint == !b->joint &&
           !a->weight == !b->weight && a->targets == b->targets &&
           !a->target_normal == !b->target_normal && !a->target_tangent == !b->target_tangent;
}

static bool same_array(const void *a, const void *b, size_t bytes)
{
    return !a == !b && (!a || memcmp(a, b, bytes) == 0);
}

static bool same_content(const struct glint_mesh *a, const struct glint_mesh *b)
{
    const size_t n = a->vertices;
    return same_array(a->position, b->position, n * 12) &&
           same_array(a->normal, b->normal, n * 12) && same_array(a->uv, b->uv, n * 8) &&
           same_array(a->tangent, b->tangent, n * 16) && same_array(a->uv1, b->uv1, n * 8) &&
           same_array(a->color, b->color, n * 16) &&
           same_array(a->index, b->index, (size_t)a->triangles * 12);
}

static bool same_mesh(const struct glint_mesh *a, const struct glint_mesh *b)
{
    if (a == b)
        return true;
    if (a->vertices != b->vertices || a->triangles != b->triangles ||
        strcmp(a->asset, b->asset) != 0)
        return false;
    return *a->asset ? same_layout(a, b) : same_content(a, b);
}

// ---- the mesh of the revision before that is the same

struct finder {
    const struct glint_resident *from;
    uint32_t *slot; // [mask + 1] mesh + 1, 0: empty
    uint32_t mask;
};

static uint32_t hash_of(const struct glint_mesh *m)
{
    uint32_t h = m->vertices * 2654435761u ^ m->triangles * 40503u;
    for (const char *c = m->asset; *c; c++)
        h = (h ^ (unsigned char)*c) * 16777619u;
    return h ^ h >> 15;
}

static glint_status finder_open(struct finder *f, const struct glint_resident *from,
                                struct glint_error *err)
{
    const uint32_t meshes = from ? from->scene->meshes : 0;
    f->from = from;
    f->mask = 1;
    while (f->mask < 2ull * meshes)
        f->mask = 2 * f->mask + 1;
    f->slot = calloc((size_t)f->mask + 1, sizeof *f->slot);
    if (!f->slot)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u meshes", meshes);
    for (uint32_t i = 0; i < meshes; i++) {
        uint32_t at = hash_of(&from->scene->mesh[i]) & f->mask;
        while (f->slot[at])
            at = (at + 1) & f->mask;
        f->slot[at] = i + 1;
    }
    return GLINT_OK;
}

// It, NULL: there is none.
static const struct glint_kept *find(const struct finder *f, const struct glint_mesh *m,
                                     uint32_t guess)
{
    if (!f->from)
        return NULL;
    const struct glint_scene *s = f->from->scene;
    if (guess < s->meshes && same_mesh(m, &s->mesh[guess]))
        return &f->from->kept[guess];
    for (uint32_t at = hash_of(m) & f->mask; f->slot[at]; at = (at + 1) & f->mask)
        if (same_mesh(m, &s->mesh[f->slot[at] - 1]))
            return &f->from->kept[f->slot[at] - 1];
    return NULL;
}

// ---- the list

static void init_kept(struct glint_kept *k, const struct glint_mesh *m)
{
    k->mesh = m;
    k->keys = 1;
    k->position = m->position;
    k->normal = m->normal;
    k->tangent = m->tangent;
}

static void init_deformed(const struct glint_resident *r, struct glint_kept *k, uint32_t instance)
{
    const struct glint_pose_instance *p = &r->pose->instance[instance];
    init_kept(k, &r->scene->mesh[r->scene->instance[instance].mesh]);
    k->keys = p->bends ? r->pose->keys : 1;
    k->position = p->position;
    k->normal = p->normal;
    k->tangent = p->tangent;
    k->flow = p->flow_position;
    k->deforms = true;
}

static bool deforms(const struct glint_resident *r, uint32_t instance)
{
    return r->pose && r->pose->instance[instance].deforms && glint_resident_draws(r, instance);
}

uint32_t glint_kept_of(const struct glint_resident *r, uint32_t instance)
{
    if (!deforms(r, instance))
        return r->scene->instance[instance].mesh;
    uint32_t k = r->scene->meshes + 1;
    while (r->kept[k].position != r->pose->instance[instance].position)
        k++;
    return k;
}

// Those that deform alike have one entry.
static void list_deformed(struct glint_resident *r)
{
    const uint32_t first = r->scene->meshes + 1;
    for (uint32_t i = 0; i < r->scene->instances; i++) {
        if (!deforms(r, i))
            continue;
        uint32_t k = first;
        while (k < r->kepts && r->kept[k].position != r->pose->instance[i].position)
            k++;
        if (k == r->kepts)
            init_deformed(r, &r->kept[r->kepts++], i);
    }
}

glint_status glint_resident_list_kept(struct glint_resident *r, struct glint_error *err)
{
    const struct glint_scene *s = r->scene;
    size_t capacity = (size_t)s->meshes + 1;
    for (uint32_t i = 0; i < s->instances; i++)
        capacity += deforms(r, i);
    r->quad = (struct glint_mesh){.id = "area light",
                                  .vertices = 4,
                                  .triangles = 2,
                                  .position = quad_position,
                                  .uv = quad_uv,
                                  .index = quad_index};
    r->kept = calloc(capacity, sizeof *r->kept);
    if (!r->kept)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %zu meshes", capacity);
    for (uint32_t i = 0; i < s->meshes; i++)
        init_kept(&r->kept[i], &s->mesh[i]);
    init_kept(&r->kept[s->meshes], &r->quad);
    r->kepts = s->meshes + 1;
    list_deformed(r);
    return GLINT_OK;
}

// What the mesh was in the revision before; NULL: it was not there, or nothing drew it.
static const struct glint_kept *source_of(const struct glint_resident *r, const struct finder *f,
                                          uint32_t i)
{
    const struct glint_kept *source = NULL;
    if (i < r->scene->meshes)
        source = find(f, r->kept[i].mesh, i);
    else if (i == r->scene->meshes && f->from)
        source = &f->from->kept[f->from->scene->meshes];
    return source && source->shape ? source : NULL;
}

static void find_sources(struct glint_resident *r, const struct finder *f)
{
    for (uint32_t i = 0; i < r->kepts; i++) {
        struct glint_kept *k = &r->kept[i];
        k->source = source_of(r, f, i);
        if (k->source) // also of a mesh that nothing draws now: it may be shown again
            k->shape = glint_shape_retain(k->source->shape);
        else if (k->uses)
            r->change.items[GLINT_PART_MESHES]++;
    }
}

struct shaping {
    struct glint_resident *r;
    atomic_int failed; // relaxed: the end of all publishes it
};

static void shape_one(void *user, size_t i)
{
    struct shaping *s = user;
    struct glint_kept *k = &s->r->kept[i];
    if (k->uses && !k->shape && glint_shape_create(&k->shape, k->mesh, k->position, k->keys, NULL))
        atomic_store_explicit(&s->failed, 1, memory_order_relaxed);
    if (k->shape) {
        k->index = k->shape->index ? k->shape->index : k->mesh->index;
        k->triangles = k->shape->triangles;
    }
}

static glint_status make_shapes(struct glint_resident *r, struct glint_error *err)
{
    struct shaping s = {.r = r};
    glint_thread_each("shapes", r->kepts, shape_one, &s);
    return s.failed ? glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u meshes", r->kepts)
                    : GLINT_OK;
}

glint_status glint_resident_keep(struct glint_resident *r, struct glint_error *err)
{
    struct finder f;
    glint_status st = finder_open(&f, r->from, err);
    if (!st) {
        find_sources(r, &f);
        st = make_shapes(r, err);
    }
    free(f.slot);
    for (uint32_t i = 0; !st && i < r->rows; i++)
        r->stats.instanced_triangles += r->kept[r->row[i].kept].triangles;
    for (uint32_t i = 0; !st && i < r->kepts; i++)
        r->stats.dropped += r->kept[i].uses ? r->kept[i].shape->dropped : 0;
    return st;
}

void glint_kept_forget(struct glint_resident *r)
{
    for (uint32_t i = 0; i < r->kepts; i++)
        r->kept[i].source = NULL;
}
