// obj_meshes.c - the triangles of an OBJ file as meshes, one for each object and material.
#include "scene/obj_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool normal_of(const struct glint_obj *o, const struct glint_obj_triangle *t, double n[3])
{
    const float *a = o->position.value + 3 * (size_t)t->corner[0].position;
    const float *b = o->position.value + 3 * (size_t)t->corner[1].position;
    const float *c = o->position.value + 3 * (size_t)t->corner[2].position;
    double u[3], v[3];
    for (int i = 0; i < 3; i++) {
        u[i] = (double)b[i] - a[i];
        v[i] = (double)c[i] - a[i];
    }
    for (int i = 0; i < 3; i++)
        n[i] = u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3];
    return n[0] != 0 || n[1] != 0 || n[2] != 0;
}

// ---- a hash of three numbers to one

struct slot {
    struct glint_obj_corner key;
    uint32_t value; // GLINT_NONE: free
};

struct table {
    struct slot *slot;
    uint32_t mask;
};

static bool table_start(struct glint_obj *o, struct table *t, uint64_t entries)
{
    uint64_t slots = 64;
    while (slots < 2 * entries)
        slots *= 2;
    t->slot = slots <= UINT32_MAX ? malloc(slots * sizeof *t->slot) : NULL;
    t->mask = (uint32_t)(slots - 1);
    for (uint64_t i = 0; t->slot && i < slots; i++)
        t->slot[i].value = GLINT_NONE;
    return t->slot || glint_model_nomem(&o->model);
}

static struct slot *table_at(const struct table *t, const struct glint_obj_corner *key)
{
    uint64_t h = key->position * 0x9e3779b97f4a7c15u;
    h = (h ^ (h >> 29) ^ key->uv) * 0xbf58476d1ce4e5b9u;
    h = (h ^ (h >> 32) ^ key->normal) * 0x94d049bb133111ebu;
    uint32_t i = (uint32_t)(h >> 32) & t->mask;
    while (t->slot[i].value != GLINT_NONE && memcmp(&t->slot[i].key, key, sizeof *key))
        i = (i + 1) & t->mask;
    t->slot[i].key = *key;
    return &t->slot[i];
}

// ---- normals that the file leaves to its reader

static uint32_t add_normal(struct glint_obj *o, const double n[3])
{
    if (!glint_model_grow(&o->model, (void **)&o->normal.value, o->normal.count,
                          &o->normal.capacity, 3 * sizeof(float)))
        return GLINT_NONE;
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    float *to = o->normal.value + 3 * (size_t)o->normal.count;
    for (int i = 0; i < 3; i++)
        to[i] = length > 0 ? (float)(n[i] / length) : (float)(i == 2);
    return o->normal.count++;
}

struct sum {
    double n[3];
    uint32_t normal; // its number, once it is made
};

static bool waits(const struct glint_obj_triangle *t, int corner)
{
    return t->smooth && t->corner[corner].normal == GLINT_NONE;
}

// Sums of what meets at each (position, group), weighted by area as the cross product is.
static bool sum_normals(struct glint_obj *o, struct table *t, struct sum *sum, uint32_t *sums)
{
    for (uint32_t i = 0; i < o->triangles; i++) {
        const struct glint_obj_triangle *tri = &o->triangle[i];
        double n[3];
        normal_of(o, tri, n);
        for (int k = 0; k < 3; k++) {
            if (!waits(tri, k))
                continue;
            const struct glint_obj_corner key = {tri->corner[k].position, tri->smooth, 0};
            struct slot *s = table_at(t, &key);
            if (s->value == GLINT_NONE) {
                s->value = (*sums)++;
                sum[s->value] = (struct sum){.normal = GLINT_NONE};
            }
            for (int c = 0; c < 3; c++)
                sum[s->value].n[c] += n[c];
        }
    }
    return true;
}

static void give_normals(struct glint_obj *o, const struct table *t, struct sum *sum)
{
    for (uint32_t i = 0; i < o->triangles; i++)
        for (int k = 0; k < 3; k++) {
            struct glint_obj_triangle *tri = &o->triangle[i];
            if (!waits(tri, k))
                continue;
            const struct glint_obj_corner key = {tri->corner[k].position, tri->smooth, 0};
            struct sum *s = &sum[table_at(t, &key)->value];
            if (s->normal == GLINT_NONE)
                s->normal = add_normal(o, s->n);
            tri->corner[k].normal = s->normal;
        }
}

void glint_obj_smooth(struct glint_obj *o)
{
    uint64_t corners = 0;
    uint32_t sums = 0;
    for (uint32_t i = 0; i < o->triangles; i++)
        for (int k = 0; k < 3; k++)
            corners += waits(&o->triangle[i], k);
    if (!corners)
        return;
    struct table t;
    struct sum *sum = malloc(corners * sizeof *sum);
    if (!table_start(o, &t, corners) || !sum)
        glint_model_nomem(&o->model);
    else if (sum_normals(o, &t, sum, &sums))
        give_normals(o, &t, sum);
    free(t.slot);
    free(sum);
}

// ---- one part

struct welder {
    struct glint_obj *o;
    struct table table;
    uint32_t *index;
    struct glint_obj_corner *vertex;
    uint32_t vertices, triangles;
    bool normal, uv;
};

// A triangle without normals among others that have some keeps its own.
static bool fill_normals(struct welder *w, struct glint_obj_triangle *t)
{
    uint32_t own = GLINT_NONE;
    double n[3];
    for (int k = 0; w->normal && k < 3; k++) {
        if (t->corner[k].normal != GLINT_NONE)
            continue;
        if (own == GLINT_NONE) {
            normal_of(w->o, t, n);
            own = add_normal(w->o, n);
        }
        if (own == GLINT_NONE)
            return false;
        t->corner[k].normal = own;
    }
    return true;
}

static bool weld(struct welder *w, struct glint_obj_triangle *t)
{
    if (!fill_normals(w, t))
        return false;
    for (int k = 0; k < 3; k++) {
        struct slot *s = table_at(&w->table, &t->corner[k]);
        if (s->value == GLINT_NONE) {
            s->value = w->vertices;
            w->vertex[w->vertices++] = t->corner[k];
        }
        w->index[3 * (size_t)w->triangles + (size_t)k] = s->value;
    }
    w->triangles++;
    return true;
}

static float *gather(struct welder *w, const struct glint_obj_floats *from, uint32_t width,
                     size_t member)
{
    static const float none[4] = {0};
    float *out = glint_arena_array(&w->o->model.scene->arena, w->vertices, width * sizeof *out);
    if (!out)
        glint_model_nomem(&w->o->model);
    for (uint32_t i = 0; out && i < w->vertices; i++) {
        uint32_t number;
        memcpy(&number, (const char *)&w->vertex[i] + member, sizeof number);
        memcpy(out + (size_t)i * width,
               number == GLINT_NONE ? none : from->value + (size_t)number * width,
               width * sizeof *out);
    }
    return out;
}

static bool fill_mesh(struct welder *w, struct glint_mesh *m)
{
    const struct glint_obj *o = w->o;
    uint32_t *index = glint_arena_array(&o->model.scene->arena, w->triangles, 3 * sizeof *index);
    if (!index)
        return glint_model_nomem(&w->o->model);
    memcpy(index, w->index, (size_t)w->triangles * 3 * sizeof *index);
    m->index = index;
    m->vertices = w->vertices;
    m->triangles = w->triangles;
    m->position = gather(w, &o->position, 3, offsetof(struct glint_obj_corner, position));
    if (o->has_color)
        m->color = gather(w, &o->color, 4, offsetof(struct glint_obj_corner, position));
    if (w->uv)
        m->uv = gather(w, &o->uv, 2, offsetof(struct glint_obj_corner, uv));
    if (w->normal)
        m->normal = gather(w, &o->normal, 3, offsetof(struct glint_obj_corner, normal));
    if (m->normal)
        glint_model_clean_normals(m);
    return o->model.err->status == GLINT_OK;
}

// The triangles of part `number`, which are order[0..triangles).
static bool make_mesh(struct glint_obj *o, uint32_t number, const uint32_t *order)
{
    const struct glint_obj_part *part = &o->part[number];
    struct welder w = {.o = o};
    for (uint32_t i = 0; i < part->triangles; i++)
        for (int k = 0; k < 3; k++) {
            w.normal |= o->triangle[order[i]].corner[k].normal != GLINT_NONE;
            w.uv |= o->triangle[order[i]].corner[k].uv != GLINT_NONE;
        }
    const uint64_t corners = 3ull * part->triangles;
    w.index = malloc(corners * sizeof *w.index);
    w.vertex = malloc(corners * sizeof *w.vertex);
    bool made = table_start(o, &w.table, corners) && w.index && w.vertex;
    for (uint32_t i = 0; made && i < part->triangles; i++)
        made = weld(&w, &o->triangle[order[i]]);
    struct glint_mesh *mesh =
        made ? glint_model_mesh(&o->model, o->scene_object[part->object],
                                o->scene_material[part->material], o->objects.name[part->object])
             : NULL;
    made = mesh && fill_mesh(&w, mesh);
    if (!made)
        glint_model_nomem(&o->model);
    free(w.table.slot);
    free(w.index);
    free(w.vertex);
    return made;
}

// Numbers of the triangles, those of each part together.
static uint32_t *sort(const struct glint_obj *o)
{
    uint32_t *order = malloc((size_t)o->triangles * sizeof *order);
    uint32_t *next = calloc(o->parts, sizeof *next);
    for (uint32_t i = 1; order && next && i < o->parts; i++)
        next[i] = next[i - 1] + o->part[i - 1].triangles;
    for (uint32_t i = 0; order && next && i < o->triangles; i++)
        order[next[o->triangle[i].part]++] = i;
    if (!next) {
        free(order);
        order = NULL;
    }
    free(next);
    return order;
}

// In the order in which their faces come.
static bool make_objects(struct glint_obj *o)
{
    o->scene_object = glint_arena_array(&o->scratch, o->objects.count, sizeof *o->scene_object);
    if (!o->scene_object)
        return glint_model_nomem(&o->model);
    memset(o->scene_object, 0xff, o->objects.count * sizeof *o->scene_object);
    for (uint32_t i = 0; i < o->parts; i++) {
        uint32_t *object = &o->scene_object[o->part[i].object];
        if (*object != GLINT_NONE)
            continue;
        *object = glint_model_object(&o->model, o->objects.name[o->part[i].object]);
        if (*object == GLINT_NONE)
            return false;
    }
    return true;
}

void glint_obj_make_meshes(struct glint_obj *o)
{
    uint32_t first = 0, *order = sort(o);
    bool made = order ? make_objects(o) : glint_model_nomem(&o->model);
    for (uint32_t i = 0; made && i < o->parts; i++) {
        made = make_mesh(o, i, order + first);
        first += o->part[i].triangles;
    }
    free(order);
}
