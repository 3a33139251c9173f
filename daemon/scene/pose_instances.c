// pose_instances.c - instances on nodes: the shapes that they share, and their transforms.
#include "scene/pose_work.h"

#include <math.h>
#include <string.h>

static glint_status no_memory(struct glint_error *err)
{
    return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the pose of the scene");
}

static void widen(struct glint_pose_box *b, const float *p)
{
    for (int k = 0; k < 3; k++) {
        b->lo[k] = p[k] < b->lo[k] ? p[k] : b->lo[k];
        b->hi[k] = p[k] > b->hi[k] ? p[k] : b->hi[k];
    }
}

static const struct glint_pose_box *box_of(struct glint_pose_work *w, uint32_t mesh)
{
    struct glint_pose_box *b = &w->box[mesh];
    const struct glint_mesh *m = &w->scene->mesh[mesh];
    if (b->known)
        return b;
    for (int k = 0; k < 3; k++)
        b->lo[k] = b->hi[k] = m->position[k];
    for (size_t i = 0; i < m->vertices; i++)
        widen(b, m->position + 3 * i);
    b->known = true;
    return b;
}

static double reach_of(const struct glint_pose_box *b)
{
    double reach = 0;
    for (int k = 0; k < 3; k++)
        reach = fmax(reach, fmax(fabs(b->lo[k]), fabs(b->hi[k])));
    return reach;
}

static uint32_t skin_of(const struct glint_scene *scene, const struct glint_instance *in)
{
    return scene->mesh[in->mesh].joint ? in->skin : GLINT_NONE;
}

static const struct glint_animation_channel *weights_of(const struct glint_pose_work *w,
                                                        uint32_t node)
{
    return w->nodes.path && node != GLINT_NONE ? w->nodes.path[node][GLINT_PATH_WEIGHTS] : NULL;
}

static struct glint_pose_shape shape_wanted(const struct glint_pose_work *w,
                                            const struct glint_instance *in)
{
    const struct glint_mesh *mesh = &w->scene->mesh[in->mesh];
    return (struct glint_pose_shape){
        .mesh = in->mesh,
        .skin = skin_of(w->scene, in),
        .rest = in->weight ? in->weight : mesh->target_weight,
        .channel = mesh->targets ? weights_of(w, in->node) : NULL,
    };
}

static bool alike(const struct glint_pose_shape *a, const struct glint_pose_shape *b)
{
    return a->mesh == b->mesh && a->skin == b->skin && a->rest == b->rest &&
           a->channel == b->channel;
}

static uint32_t hash_of(const struct glint_pose_shape *s)
{
    uint64_t h = s->mesh + 0x9e3779b97f4a7c15u * s->skin;
    h = (h ^ (uintptr_t)s->rest) * 0xff51afd7ed558ccdu;
    h = (h ^ (uintptr_t)s->channel ^ h >> 29) * 0xc4ceb9fe1a85ec53u;
    return (uint32_t)(h >> 32);
}

// The shape of an instance, found or added; buckets are never full.
static uint32_t shape_for(struct glint_pose_work *w, const struct glint_instance *in)
{
    const struct glint_pose_shape wanted = shape_wanted(w, in);
    uint32_t at = hash_of(&wanted) & (w->buckets - 1);
    for (; w->bucket[at]; at = (at + 1) & (w->buckets - 1))
        if (alike(&w->shape[w->bucket[at] - 1], &wanted))
            return w->bucket[at] - 1;
    w->shape[w->shapes] = wanted;
    w->bucket[at] = ++w->shapes;
    return w->shapes - 1;
}

static bool may_deform(const struct glint_scene *scene, const struct glint_instance *in)
{
    return in->visible && (skin_of(scene, in) != GLINT_NONE || scene->mesh[in->mesh].targets);
}

static glint_status find_shapes(struct glint_pose_work *w, struct glint_error *err)
{
    const struct glint_scene *scene = w->scene;
    uint32_t count = 0;
    for (uint32_t i = 0; i < scene->instances; i++)
        count += may_deform(scene, &scene->instance[i]);
    for (w->buckets = 2; w->buckets / 2 < count; w->buckets *= 2)
        ;
    w->box = glint_arena_array(&w->scratch, scene->meshes, sizeof *w->box);
    w->shape_of = glint_arena_array(&w->scratch, scene->instances, sizeof *w->shape_of);
    w->shape = glint_arena_array(&w->scratch, count, sizeof *w->shape);
    w->bucket = glint_arena_array(&w->scratch, w->buckets, sizeof *w->bucket);
    if (!w->box || !w->shape_of || !w->shape || !w->bucket)
        return no_memory(err);
    for (uint32_t i = 0; i < scene->instances; i++)
        w->shape_of[i] =
            may_deform(scene, &scene->instance[i]) ? shape_for(w, &scene->instance[i]) : GLINT_NONE;
    return GLINT_OK;
}

static void need(struct glint_pose_work *w, uint32_t keys)
{
    w->keys = keys > w->keys ? keys : w->keys;
}

static glint_status measure_shapes(struct glint_pose_work *w, struct glint_error *err)
{
    glint_status st = GLINT_OK;
    for (uint32_t i = 0; !st && i < w->shapes; i++) {
        struct glint_pose_shape *s = &w->shape[i];
        const struct glint_pose_box *b = box_of(w, s->mesh);
        st = glint_pose_shape_measure(s, &w->scratch, &w->nodes, b->lo, b->hi, err);
        if (s->bends)
            need(w, s->keys);
    }
    return st;
}

// Of an instance that a node or a skin carries: how many moments are filled, 0: none carries it.
static uint32_t moments_of(const struct glint_pose_work *w, uint32_t i)
{
    const struct glint_instance *in = &w->scene->instance[i];
    if (skin_of(w->scene, in) != GLINT_NONE)
        return 1;
    if (in->node == GLINT_NONE)
        return 0;
    return glint_pose_touches(&w->nodes, in->node) ? w->nodes.moments : 1;
}

static void multiply_all(const struct glint_pose_work *w, uint32_t i, struct glint_pose_track *t,
                         uint32_t moments)
{
    const struct glint_instance *in = &w->scene->instance[i];
    if (skin_of(w->scene, in) != GLINT_NONE) {
        double own[16];
        glint_matrix_widen(own, in->transform);
        glint_matrix_multiply(t->m[0], own, w->shape[w->shape_of[i]].frame);
        return;
    }
    for (uint32_t m = 0; m < moments; m++)
        glint_pose_multiply_float(t->m[m], glint_pose_world(&w->nodes, in->node, m), in->transform);
}

// What has no extent at a moment of flow is taken to shrink to where it is then.
static void repair_flow(struct glint_pose_track *t, const struct glint_pose_nodes *n, double reach)
{
    for (uint32_t m = n->shutter; m < n->moments; m++) {
        glint_pose_matrix two[2];
        memcpy(two[0], t->m[0], sizeof two[0]);
        memcpy(two[1], t->m[m], sizeof two[1]);
        glint_pose_repair(two, 2, reach);
        memcpy(t->m[m], two[1], sizeof two[1]);
    }
}

enum sight { UNCARRIED, SEEN, UNSEEN };

// The transforms of a visible instance at all moments; *mended: some of them are not what the nodes
// say.
static enum sight track_of(struct glint_pose_work *w, uint32_t i, struct glint_pose_track *t,
                           bool *mended)
{
    const struct glint_pose_nodes *n = &w->nodes;
    const uint32_t moments = moments_of(w, i);
    t->moves = t->flows = *mended = false;
    if (!moments)
        return UNCARRIED;
    multiply_all(w, i, t, moments);
    const double reach = reach_of(box_of(w, w->scene->instance[i].mesh));
    const uint32_t shutter = moments > 1 ? n->shutter : 1;
    const uint32_t bad = glint_pose_repair(t->m, shutter, reach);
    *mended = bad;
    if (bad == shutter)
        return UNSEEN;
    if (moments > 1) {
        repair_flow(t, n, reach);
        glint_pose_track_compare(t, n);
    }
    return SEEN;
}

static void measure_instance(struct glint_pose_work *w, uint32_t i)
{
    struct glint_pose_track t;
    bool mended;
    const enum sight sight = track_of(w, i, &t, &mended);
    w->pose->collapsed += mended;
    if (sight != SEEN)
        return;
    glint_pose_track_count(&t, w);
    if (!t.moves || w->keys == GLINT_POSE_MAX_KEYS)
        return;
    const struct glint_pose_box *b = box_of(w, w->scene->instance[i].mesh);
    need(w, glint_pose_box_keys(t.m, b->lo, b->hi, w->keys));
}

glint_status glint_pose_instances_measure(struct glint_pose_work *w, struct glint_error *err)
{
    glint_status st = find_shapes(w, err);
    if (!st)
        st = measure_shapes(w, err);
    for (uint32_t i = 0; !st && i < w->scene->instances; i++)
        if (w->scene->instance[i].visible)
            measure_instance(w, i);
    return st;
}

static void take_shape(struct glint_pose_instance *out, const struct glint_pose_shape *s)
{
    out->deforms = s->position;
    out->bends = s->position && s->bends;
    out->position = s->position;
    out->normal = s->normal;
    out->tangent = s->tangent;
    out->flow_position = s->flow_position;
}

static bool fill_instance(struct glint_pose_work *w, uint32_t i)
{
    struct glint_pose_instance *out = &w->pose->instance[i];
    struct glint_pose_track t;
    bool mended;
    const enum sight sight = track_of(w, i, &t, &mended);
    out->hidden = sight == UNSEEN;
    out->moves = sight == SEEN && t.moves && w->pose->keys > 1;
    if (w->shape_of[i] != GLINT_NONE)
        take_shape(out, &w->shape[w->shape_of[i]]);
    return sight != SEEN || glint_pose_track_store(&t, w, &out->transform, &out->flow_transform);
}

glint_status glint_pose_instances_fill(struct glint_pose_work *w, struct glint_error *err)
{
    glint_status st = GLINT_OK;
    for (uint32_t i = 0; !st && i < w->shapes; i++) {
        w->shape[i].bends &= w->pose->keys > 1;
        st = glint_pose_shape_fill(&w->shape[i], &w->pose->arena, &w->nodes, w->pose->keys, err);
    }
    for (uint32_t i = 0; !st && i < w->scene->instances; i++) {
        if (!w->scene->instance[i].visible)
            w->pose->instance[i].hidden = true;
        else if (!fill_instance(w, i))
            st = no_memory(err);
    }
    return st;
}
