// scene_nodes.c - frames of reference and where their chains lead.
#include "protocol/scene_parts.h"

#include <string.h>

void glint_node_read(struct glint_scene_reader *r, const struct glint_json *at,
                     struct glint_node *out)
{
    const struct glint_json parent = glint_json_member(at, "parent");
    const struct glint_json transform = glint_json_member(at, "transform");
    char *id = out->id;
    glint_node_init(out);
    out->id = out->name = id;
    glint_fields_read(at, glint_node_fields, &r->scene->arena, out);
    out->parent = glint_scene_reference(&parent, &r->nodes, "node");
    glint_transform_read_node(&transform, out);
}

// ---- order

enum { UNSEEN, CLIMBING, PLACED };

struct climb {
    const struct glint_node *node;
    unsigned char *state;
    uint32_t *order, *loop;
    uint32_t nodes, placed, loops;
};

// Up from `start` to what is placed already or has no parent. The way is noted in the part of the
// order that is free yet, from its end, so that it can be placed from the top.
static void place_chain(struct climb *c, uint32_t start)
{
    uint32_t steps = 0, at = start;
    while (at != GLINT_NONE && c->state[at] == UNSEEN) {
        c->state[at] = CLIMBING;
        c->order[c->nodes - ++steps] = at;
        at = c->node[at].parent;
    }
    if (at != GLINT_NONE && c->state[at] == CLIMBING)
        c->loop[c->loops++] = at;
    memmove(c->order + c->placed, c->order + c->nodes - steps, steps * sizeof *c->order);
    for (uint32_t i = 0; i < steps; i++)
        c->state[c->order[c->placed + i]] = PLACED;
    c->placed += steps;
}

bool glint_nodes_order(const struct glint_scene *scene, struct glint_arena *arena,
                       struct glint_node_order *out)
{
    const size_t nodes = scene->nodes;
    struct climb c = {.node = scene->node,
                      .state = glint_arena_alloc(arena, nodes),
                      .order = glint_arena_array(arena, nodes, sizeof *c.order),
                      .loop = glint_arena_array(arena, nodes, sizeof *c.loop),
                      .nodes = scene->nodes};
    if (!c.state || !c.order || !c.loop)
        return false;
    for (uint32_t i = 0; i < nodes; i++)
        place_chain(&c, i);
    *out = (struct glint_node_order){c.order, c.loop, c.loops};
    return true;
}

static const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

double (*glint_nodes_world(const struct glint_scene *scene, struct glint_arena *arena))[16]
{
    struct glint_node_order all;
    double(*world)[16] = glint_arena_array(arena, scene->nodes, sizeof *world);
    if (!world || !glint_nodes_order(scene, arena, &all))
        return NULL;
    for (uint32_t i = 0; i < scene->nodes; i++) {
        const struct glint_node *n = &scene->node[all.order[i]];
        const double *above = n->parent == GLINT_NONE ? identity : world[n->parent];
        glint_transform_product(world[all.order[i]], above, n->transform);
    }
    return world;
}
