// gltf_frames.c - the scene's nodes: what animations move, what hangs below it, joints, and what is
// above all of those. What stays where it is has its place baked into its transform instead.
#include "scene/gltf_file.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define TINY 1e-6 // of scales

// Marks with the frame 0 what is to become one. Parents come before their children in the order.
static uint32_t choose(struct glint_gltf *g)
{
    uint32_t count = 0;
    for (uint32_t k = 0; k < g->reached; k++) {
        struct glint_gltf_node *n = &g->node[g->order[k]];
        n->moves = n->animated || (n->parent != GLINT_NONE && g->node[n->parent].moves);
        n->frame = n->moves || n->weighs || n->joint ? 0 : GLINT_NONE;
    }
    for (uint32_t k = g->reached; k-- > 0;) {
        const struct glint_gltf_node *n = &g->node[g->order[k]];
        if (n->frame == GLINT_NONE)
            continue;
        count++;
        if (n->parent != GLINT_NONE)
            g->node[n->parent].frame = 0;
    }
    return count;
}

static void multiply_rest(struct glint_gltf_node *n, const struct glint_gltf_node *above)
{
    if (above)
        glint_matrix_multiply(n->rest, above->rest, n->local);
    else
        memcpy(n->rest, n->local, sizeof n->rest);
}

// Returns false when the matrix had shear.
static bool take_apart(struct glint_gltf_node *n)
{
    const bool clean = glint_gltf_decompose(n->local, n->translation, n->rotation, n->scale);
    n->matrix = false;
    glint_matrix_compose(n->local, n->translation, n->rotation, n->scale);
    return clean;
}

static void take_animated_apart(struct glint_gltf *g, struct glint_gltf_node *n, const char *name)
{
    const bool clean = take_apart(n);
    glint_gltf_note(g, "animated matrix",
                    "node \"%.200s\" is animated and has a matrix: it is taken apart into "
                    "translation, rotation and scale%s",
                    name, clean ? "" : ", and its shear is lost");
}

// Fills n->rest. Scales of 0, a common way to hide, become tiny ones that can be undone.
static bool stay_regular(struct glint_gltf *g, struct glint_gltf_node *n, const char *name)
{
    const struct glint_gltf_node *above = n->parent == GLINT_NONE ? NULL : &g->node[n->parent];
    float unused[16];
    n->shrunk = above && above->shrunk;
    multiply_rest(n, above);
    if (glint_gltf_to_float(unused, n->rest))
        return true;
    if (n->matrix)
        take_apart(n);
    for (int i = 0; i < 3; i++)
        if (fabs(n->scale[i]) < TINY)
            n->scale[i] = n->shrunk ? 1 : TINY;
    n->shrunk = true;
    glint_matrix_compose(n->local, n->translation, n->rotation, n->scale);
    multiply_rest(n, above);
    glint_gltf_note(g, "node without size",
                    "node \"%.200s\" has no size in some direction; it gets a tiny one", name);
    return glint_gltf_to_float(unused, n->rest);
}

static void to_floats(float *out, const double *in, int count)
{
    for (int i = 0; i < count; i++)
        out[i] = (float)in[i];
}

static void add_frame(struct glint_gltf *g, uint32_t i)
{
    struct glint_gltf_node *n = &g->node[i];
    struct glint_scene *s = g->scene;
    struct glint_node *out = &s->node[s->nodes];
    char number[24];
    snprintf(number, sizeof number, "node_%u", i);
    glint_node_init(out);
    out->name = glint_arena_string(&s->arena, *n->name ? n->name : number);
    out->id = out->name ? glint_gltf_names_id(&g->ids[GLTF_ID_NODE], &s->arena, out->name) : NULL;
    if (!out->id) {
        glint_gltf_nomem(g);
        return;
    }
    if (n->matrix && n->animated)
        take_animated_apart(g, n, out->name);
    const bool regular = stay_regular(g, n, out->name);
    out->parent = n->parent == GLINT_NONE ? GLINT_NONE : g->node[n->parent].frame;
    out->matrix = n->matrix;
    if (!n->matrix) {
        to_floats(out->translation, n->translation, 3);
        to_floats(out->rotation, n->rotation, 4);
        to_floats(out->scale, n->scale, 3);
    }
    if (!glint_gltf_fit(out->transform, n->local) || !regular) {
        snprintf(number, sizeof number, "/nodes/%u", i);
        glint_fail(g->err, GLINT_E_RANGE, number,
                   "its transform is singular, or passes the limit of %g",
                   (double)GLINT_MAX_COORDINATE);
    }
    n->frame = s->nodes++;
}

static const char *const path_name[] = {"translation", "rotation", "scale", "weights"};

static void point_channels(struct glint_gltf *g, struct glint_animation *a)
{
    struct glint_gltf_names ids = {0};
    for (uint32_t i = 0; i < a->channels; i++) {
        struct glint_animation_channel *c = &a->channel[i];
        c->node = g->node[c->node].frame;
        char id[96];
        snprintf(id, sizeof id, "%.50s.%s", g->scene->node[c->node].id, path_name[c->path]);
        c->id = glint_gltf_names_id(&ids, &g->scene->arena, id);
        if (!c->id)
            glint_gltf_nomem(g);
    }
    glint_gltf_names_finish(&ids);
}

void glint_gltf_make_frames(struct glint_gltf *g)
{
    struct glint_scene *s = g->scene;
    const uint32_t count = choose(g);
    s->node = glint_arena_array(&s->arena, count + 1, sizeof *s->node);
    if (!s->node) {
        glint_gltf_nomem(g);
        return;
    }
    for (uint32_t k = 0; k < g->reached && !g->err->status; k++)
        if (g->node[g->order[k]].frame != GLINT_NONE)
            add_frame(g, g->order[k]);
    if (g->err->status)
        return; // not all nodes have their frame
    for (uint32_t i = 0; i < s->animations; i++)
        point_channels(g, &s->animation[i]);
    for (uint32_t i = 0; i < s->skins; i++)
        for (uint32_t j = 0; j < s->skin[i].joints; j++)
            s->skin[i].joint[j] = g->node[s->skin[i].joint[j]].frame;
}

// Morph targets of what is shown on each node of the scene, 0 for none.
static uint32_t *count_targets(struct glint_gltf *g)
{
    const struct glint_scene *s = g->scene;
    uint32_t *targets = glint_arena_array(&g->scratch, s->nodes + 1, sizeof *targets);
    if (!targets)
        glint_gltf_nomem(g);
    for (uint32_t i = 0; targets && i < s->instances; i++)
        if (s->instance[i].node != GLINT_NONE && s->mesh[s->instance[i].mesh].targets)
            targets[s->instance[i].node] = s->mesh[s->instance[i].mesh].targets;
    return targets;
}

static void drop_channels(struct glint_gltf *g, struct glint_animation *a, const uint32_t *targets)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < a->channels; i++) {
        const struct glint_animation_channel *c = &a->channel[i];
        if (c->path != GLINT_PATH_WEIGHTS || targets[c->node] == c->width)
            a->channel[kept++] = *c;
        else
            glint_gltf_note(g, "weights of nothing",
                            "weights of animation \"%.200s\" are ignored: node \"%.200s\" shows "
                            "nothing",
                            a->name, g->scene->node[c->node].name);
    }
    a->channels = kept;
}

void glint_gltf_drop_idle_channels(struct glint_gltf *g)
{
    struct glint_scene *s = g->scene;
    const uint32_t *targets = g->err->status ? NULL : count_targets(g);
    uint32_t kept = 0;
    for (uint32_t i = 0; targets && i < s->animations; i++) {
        drop_channels(g, &s->animation[i], targets);
        if (s->animation[i].channels)
            s->animation[kept++] = s->animation[i];
    }
    s->animations = kept;
}

bool glint_gltf_place(const struct glint_gltf *g, uint32_t node, float transform[16],
                      uint32_t *frame)
{
    const struct glint_gltf_node *n = &g->node[node];
    *frame = GLINT_NONE;
    if (!n->moves)
        return glint_gltf_rigid(transform, n->world);
    static const float identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    memcpy(transform, identity, sizeof identity);
    *frame = n->frame;
    return true;
}
