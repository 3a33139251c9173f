// scene_reach.c - how far anything can get, at rest and at any time of any animation.
//
// A point at the distance d from the origin of a node is at most stretch d + shift from that of the
// world: both follow along the chain of parents from bounds of each transform alone, the largest
// that its keys can make of it. Looser than what any one time reaches, never tighter, and linear.
#include "protocol/scene_parts.h"

#include <math.h>

// |h10| and |h11| of a cubic Hermite spline are at most 4/27, and h00 + h01 is 1.
#define OVERSHOOT (4.0 / 27.0)

struct bound {
    double stretch, shift;
};

struct reach {
    struct glint_scene_reader *reader;
    const struct glint_scene *scene;
    double (*world)[16]; // of each node at rest
    struct bound *node;  // its own, then to the world
    struct bound *skin;  // of what all its joints make of the mesh's space
    double *weight;      // largest |weight| that an animation gives instances on it
};

static double length3(const float v[3])
{
    return sqrt((double)v[0] * v[0] + (double)v[1] * v[1] + (double)v[2] * v[2]);
}

static double largest(const float *v, uint32_t width)
{
    double most = 0;
    for (uint32_t i = 0; i < width; i++)
        most = fmax(most, fabs((double)v[i]));
    return most;
}

// ---- channels

static double size_of(const struct glint_animation_channel *c, const float *value)
{
    return c->path == GLINT_PATH_TRANSLATION ? length3(value) : largest(value, c->width);
}

static double longest_segment(const struct glint_animation_channel *c)
{
    double most = 0;
    for (uint32_t i = 1; i < c->keys; i++)
        most = fmax(most, (double)c->time[i] - c->time[i - 1]);
    return most;
}

static double channel_bound(const struct glint_animation_channel *c)
{
    const bool cubic = c->interpolation == GLINT_INTERPOLATION_CUBICSPLINE;
    const size_t w = c->width;
    double value = 0, tangent = 0;
    for (size_t i = 0; i < c->keys; i++) {
        const float *key = c->value + i * w * (cubic ? 3 : 1);
        value = fmax(value, size_of(c, cubic ? key + w : key));
        if (cubic)
            tangent = fmax(tangent, fmax(size_of(c, key), size_of(c, key + 2 * w)));
    }
    return value + 2 * OVERSHOOT * longest_segment(c) * tangent;
}

static void include_channel(struct reach *x, const struct glint_animation_channel *c)
{
    const double most = channel_bound(c);
    struct bound *b = &x->node[c->node];
    if (c->path == GLINT_PATH_TRANSLATION)
        b->shift = fmax(b->shift, most);
    else if (c->path == GLINT_PATH_SCALE)
        b->stretch = fmax(b->stretch, most);
    else if (c->path == GLINT_PATH_WEIGHTS)
        x->weight[c->node] = fmax(x->weight[c->node], most);
}

// ---- nodes

static void own_bounds(struct reach *x)
{
    for (uint32_t i = 0; i < x->scene->nodes; i++) {
        const struct glint_node *n = &x->scene->node[i];
        x->node[i] = (struct bound){.stretch = n->matrix ? glint_transform_stretch(n->transform)
                                                         : largest(n->scale, 3),
                                    .shift = length3(n->transform + 12)};
    }
    for (uint32_t a = 0; a < x->scene->animations; a++)
        for (uint32_t c = 0; c < x->scene->animation[a].channels; c++)
            include_channel(x, &x->scene->animation[a].channel[c]);
}

static bool world_bounds(struct reach *x)
{
    struct glint_node_order all;
    if (!glint_nodes_order(x->scene, &x->reader->scratch, &all))
        return false;
    for (uint32_t i = 0; i < x->scene->nodes; i++) {
        const struct glint_node *n = &x->scene->node[all.order[i]];
        struct bound *own = &x->node[all.order[i]];
        if (n->parent == GLINT_NONE)
            continue;
        const struct bound above = x->node[n->parent];
        own->shift = above.stretch * own->shift + above.shift;
        own->stretch *= above.stretch;
    }
    return true;
}

static double through(struct bound b, double distance)
{
    return b.stretch * distance + b.shift;
}

static bool within(const struct glint_json *at, const char *what, double reach)
{
    return reach <= GLINT_MAX_COORDINATE ||
           glint_json_fault(at, "%s reaches to %g metres; the limit is %g", what, reach,
                            GLINT_MAX_COORDINATE);
}

static void check_nodes(struct reach *x, const struct glint_json *nodes)
{
    for (uint32_t i = 0; i < x->scene->nodes; i++) {
        const struct glint_json at = {
            .parent = nodes, .key = x->scene->node[i].id, .err = nodes->err};
        if (within(&at, "the node", x->node[i].shift) && !glint_transform_invertible(x->world[i]))
            glint_json_fault(&at, "the transform is singular together with those of its parents");
    }
}

// ---- skins

static void skin_bound(struct reach *x, uint32_t i)
{
    const struct glint_skin *skin = &x->scene->skin[i];
    struct bound *b = &x->skin[i];
    for (uint32_t j = 0; j < skin->joints; j++) {
        const float *bind = skin->inverse_bind + 16 * (size_t)j;
        const struct bound joint = x->node[skin->joint[j]];
        b->stretch = fmax(b->stretch, joint.stretch * glint_transform_stretch(bind));
        b->shift = fmax(b->shift, through(joint, length3(bind + 12)));
    }
}

// ---- instances

static double rest_weight(const struct glint_instance *in, const struct glint_mesh *m, uint32_t t)
{
    const float *weight = in->weight ? in->weight : m->target_weight;
    return weight ? fabs((double)weight[t]) : 0;
}

// Of the mesh's vertices, on each axis.
static double deformed(const struct reach *x, const struct glint_instance *in)
{
    const struct glint_mesh *m = &x->scene->mesh[in->mesh];
    const double animated = in->node == GLINT_NONE ? 0 : x->weight[in->node];
    double weights = 0;
    for (uint32_t t = 0; t < m->targets; t++)
        weights += fmax(animated, rest_weight(in, m, t));
    return m->reach + weights * m->target_reach;
}

static double instance_reach(const struct reach *x, const struct glint_instance *in, double local)
{
    const double distance = sqrt(3) * local;
    const double stretch = glint_transform_stretch(in->transform);
    const double moved = length3(in->transform + 12);
    if (in->skin != GLINT_NONE)
        return stretch * through(x->skin[in->skin], distance) + moved;
    if (in->node != GLINT_NONE)
        return through(x->node[in->node], stretch * distance + moved);
    return glint_transform_reach(in->transform, (float)local);
}

static bool placed(const struct reach *x, const struct glint_json *at, uint32_t node,
                   const float transform[16])
{
    double world[16];
    if (node == GLINT_NONE)
        return true;
    glint_transform_product(world, x->world[node], transform);
    return glint_transform_invertible(world) ||
           glint_json_fault(at, "the transform is singular together with that of the node");
}

static void check_instance(const struct reach *x, const struct glint_json *at,
                           const struct glint_instance *in)
{
    const double local = deformed(x, in);
    if (within(at, "the deformed mesh", local) &&
        within(at, "the instance", instance_reach(x, in, local)) && in->skin == GLINT_NONE)
        placed(x, at, in->node, in->transform);
}

static void check_placement(const struct reach *x, const struct glint_json *at, const char *what,
                            uint32_t node, const float transform[16])
{
    if (node != GLINT_NONE && within(at, what, through(x->node[node], length3(transform + 12))))
        placed(x, at, node, transform);
}

// ---- all of them

static bool prepare(struct reach *x)
{
    struct glint_arena *scratch = &x->reader->scratch;
    x->world = glint_nodes_world(x->scene, scratch);
    x->node = glint_arena_array(scratch, x->scene->nodes, sizeof *x->node);
    x->skin = glint_arena_array(scratch, x->scene->skins, sizeof *x->skin);
    x->weight = glint_arena_array(scratch, x->scene->nodes, sizeof *x->weight);
    if (!x->world || !x->node || !x->skin || !x->weight)
        return false;
    own_bounds(x);
    if (!world_bounds(x))
        return false;
    for (uint32_t i = 0; i < x->scene->skins; i++)
        skin_bound(x, i);
    return true;
}

void glint_scene_check_reach(struct glint_scene_reader *r, const struct glint_json *root)
{
    const struct glint_scene *s = r->scene;
    const struct glint_json nodes = glint_json_member(root, "nodes");
    const struct glint_json instances = glint_json_member(root, "instances");
    const struct glint_json lights = glint_json_member(root, "lights");
    const struct glint_json cameras = glint_json_member(root, "cameras");
    struct reach x = {.reader = r, .scene = s};
    if (!prepare(&x)) {
        glint_scene_no_memory(r);
        return;
    }
    check_nodes(&x, &nodes);
    for (uint32_t i = 0; i < s->instances; i++) {
        const struct glint_json at = {
            .parent = &instances, .key = s->instance[i].id, .err = r->err};
        check_instance(&x, &at, &s->instance[i]);
    }
    for (uint32_t i = 0; i < s->lights; i++) {
        const struct glint_json at = {.parent = &lights, .key = s->light[i].id, .err = r->err};
        check_placement(&x, &at, "the light", s->light[i].node, s->light[i].transform);
    }
    for (uint32_t i = 0; i < s->cameras; i++) {
        const struct glint_json at = {.parent = &cameras, .key = s->camera[i].id, .err = r->err};
        check_placement(&x, &at, "the camera", s->camera[i].node, s->camera[i].transform);
    }
}
