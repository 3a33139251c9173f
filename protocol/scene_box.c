// scene_box.c - where everything is: around what is visible, at rest and where animations take it.
#include "protocol/scene_parts.h"

#include <math.h>
#include <string.h>

#define MOST_KEYS 64u // of a channel that are looked at

struct box {
    double low[3], high[3];
    bool any;
};

struct boxes {
    const struct glint_scene *scene;
    struct glint_arena scratch;
    struct box *mesh;
    struct box *node; // of what hangs on a node and below it, in the node's frame
    double (*world)[16];
    struct glint_node_order order;
    struct box all;
};

static const double unmoved[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static void include_point(struct box *b, const double p[3])
{
    for (int k = 0; k < 3; k++) {
        b->low[k] = b->any ? fmin(b->low[k], p[k]) : p[k];
        b->high[k] = b->any ? fmax(b->high[k], p[k]) : p[k];
    }
    b->any = true;
}

static void include(struct box *b, const struct box *from, const double m[16])
{
    for (int corner = 0; from->any && corner < 8; corner++) {
        double p[3];
        for (int k = 0; k < 3; k++) {
            p[k] = m[12 + k];
            for (int i = 0; i < 3; i++)
                p[k] += m[4 * i + k] * (corner >> i & 1 ? from->high[i] : from->low[i]);
        }
        include_point(b, p);
    }
}

static void include_after(struct box *b, const struct box *from, const float m[16])
{
    double wide[16];
    glint_transform_product(wide, unmoved, m);
    include(b, from, wide);
}

static void mesh_box(struct box *b, const struct glint_mesh *m)
{
    float low[3], high[3];
    if (m->checked) {
        memcpy(low, m->low, sizeof low);
        memcpy(high, m->high, sizeof high);
    } else {
        glint_mesh_box(m, low, high);
    }
    for (int k = 0; k < 3; k++) {
        b->low[k] = low[k];
        b->high[k] = high[k];
    }
    b->any = true;
}

// What all joints make of the box holds what any mixture of them makes of it.
static void include_skinned(struct boxes *x, const struct glint_instance *in)
{
    const struct glint_skin *skin = &x->scene->skin[in->skin];
    double after[16];
    glint_transform_product(after, unmoved, in->transform);
    for (uint32_t j = 0; j < skin->joints; j++) {
        double joint[16], world[16];
        glint_transform_product(joint, x->world[skin->joint[j]],
                                skin->inverse_bind + 16 * (size_t)j);
        glint_transform_chain(world, after, joint);
        include(&x->all, &x->mesh[in->mesh], world);
    }
}

static void include_instance(struct boxes *x, const struct glint_instance *in)
{
    if (in->skin != GLINT_NONE)
        include_skinned(x, in);
    else
        include_after(in->node == GLINT_NONE ? &x->all : &x->node[in->node], &x->mesh[in->mesh],
                      in->transform);
}

// Children come after their parents in the order.
static void include_nodes(struct boxes *x)
{
    for (uint32_t i = x->scene->nodes; i-- > 0;) {
        const uint32_t n = x->order.order[i], parent = x->scene->node[n].parent;
        include(&x->all, &x->node[n], x->world[n]);
        if (parent != GLINT_NONE)
            include_after(&x->node[parent], &x->node[n], x->scene->node[n].transform);
    }
}

// The node's transform with one of its three parts replaced by a key's.
static void transform_at(const struct glint_node *n, const struct glint_animation_channel *c,
                         uint32_t key, float out[16])
{
    const bool cubic = c->interpolation == GLINT_INTERPOLATION_CUBICSPLINE;
    const float *value = c->value + ((size_t)key * (cubic ? 3 : 1) + cubic) * c->width;
    glint_transform_compose(c->path == GLINT_PATH_TRANSLATION ? value : n->translation,
                            c->path == GLINT_PATH_ROTATION ? value : n->rotation,
                            c->path == GLINT_PATH_SCALE ? value : n->scale, out);
}

static void include_channel(struct boxes *x, const struct glint_animation_channel *c)
{
    const struct glint_node *n = &x->scene->node[c->node];
    const uint32_t step = c->keys / MOST_KEYS + 1;
    if (c->path == GLINT_PATH_WEIGHTS || n->matrix || !x->node[c->node].any)
        return;
    for (uint32_t key = 0; key < c->keys; key += step) {
        float local[16];
        double world[16];
        transform_at(n, c, key, local);
        glint_transform_product(world, n->parent == GLINT_NONE ? unmoved : x->world[n->parent],
                                local);
        include(&x->all, &x->node[c->node], world);
    }
}

static bool prepare(struct boxes *x)
{
    const struct glint_scene *s = x->scene;
    x->mesh = glint_arena_array(&x->scratch, s->meshes, sizeof *x->mesh);
    x->node = glint_arena_array(&x->scratch, s->nodes, sizeof *x->node);
    x->world = glint_nodes_world(s, &x->scratch);
    return x->mesh && x->node && x->world && glint_nodes_order(s, &x->scratch, &x->order);
}

static void fill(struct boxes *x)
{
    const struct glint_scene *s = x->scene;
    for (uint32_t i = 0; i < s->meshes; i++)
        mesh_box(&x->mesh[i], &s->mesh[i]);
    for (uint32_t i = 0; i < s->instances; i++)
        if (s->instance[i].visible)
            include_instance(x, &s->instance[i]);
    include_nodes(x);
    for (uint32_t a = 0; a < s->animations; a++)
        for (uint32_t c = 0; c < s->animation[a].channels; c++)
            include_channel(x, &s->animation[a].channel[c]);
}

bool glint_scene_box(const struct glint_scene *scene, double low[3], double high[3], bool *any)
{
    struct boxes x = {.scene = scene};
    const bool fine = prepare(&x);
    if (fine)
        fill(&x);
    glint_arena_finish(&x.scratch);
    *any = x.all.any;
    memcpy(low, x.all.low, sizeof x.all.low);
    memcpy(high, x.all.high, sizeof x.all.high);
    return fine;
}
