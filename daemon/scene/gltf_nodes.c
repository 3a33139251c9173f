// gltf_nodes.c - the node hierarchy, walked once: world transforms, names, assets.
#include "scene/gltf_file.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define MAX_DEPTH 512u

static bool read_doubles(const struct glint_json *node, const char *key, size_t count, double *out)
{
    float f[16];
    for (size_t i = 0; i < count; i++)
        f[i] = (float)out[i];
    const struct glint_json at = glint_json_member(node, key);
    if (!glint_json_floats(&at, count, -3.4e38f, 3.4e38f, f))
        return false;
    // the text's own digits where there are any: far from the origin they matter
    const cJSON *child = at.value ? at.value->child : NULL;
    for (size_t i = 0; child; child = child->next)
        out[i++] = child->valuedouble;
    return true;
}

static void read_matrix(const struct glint_json *node, double out[16])
{
    const struct glint_json at = glint_json_member(node, "matrix");
    if (!read_doubles(node, "matrix", 16, out))
        return;
    if (out[3] != 0 || out[7] != 0 || out[11] != 0 || out[15] != 1)
        glint_json_fault(&at, "the last row must be 0 0 0 1");
}

static void read_local(const struct glint_json *node, struct glint_gltf_node *n)
{
    static const struct glint_gltf_node rest = {
        .rotation = {0, 0, 0, 1},
        .scale = {1, 1, 1},
        .local = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
    };
    double *q = n->rotation;
    *n = rest;
    n->matrix = glint_json_member(node, "matrix").value != NULL;
    if (n->matrix) {
        read_matrix(node, n->local);
        return;
    }
    if (!read_doubles(node, "translation", 3, n->translation) ||
        !read_doubles(node, "rotation", 4, q) || !read_doubles(node, "scale", 3, n->scale))
        return;
    const double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    const struct glint_json rotation = glint_json_member(node, "rotation");
    if (!(length > 1e-6 && isfinite(length))) {
        glint_json_fault(&rotation, "a quaternion of length %g is no rotation", length);
        return;
    }
    for (int i = 0; i < 4; i++)
        q[i] /= length;
    glint_matrix_compose(n->local, n->translation, q, n->scale);
}

static const char *read_asset(struct glint_gltf *g, const struct glint_json *node)
{
    const struct glint_json extras = glint_json_member(node, "extras");
    const struct glint_json asset = glint_json_member(&extras, "asset");
    if (!asset.value || !cJSON_IsString(asset.value))
        return NULL; // extras are the author's own
    char *text = NULL;
    glint_json_string(&asset, &g->scene->arena, &text);
    return text;
}

static void read_node(struct glint_gltf *g, uint32_t i, uint32_t parent)
{
    const struct glint_json at = glint_gltf_item(g, GLTF_NODES, i);
    static const char *const known[] = {"EXT_mesh_gpu_instancing", "KHR_lights_punctual", NULL};
    struct glint_gltf_node *n = &g->node[i];
    const struct glint_gltf_node *above = parent == GLINT_NONE ? NULL : &g->node[parent];
    read_local(&at, n);
    n->reached = true;
    n->parent = parent;
    n->frame = GLINT_NONE;
    n->depth = above ? above->depth + 1 : 0;
    n->name = glint_gltf_name(g, &at);
    n->asset = read_asset(g, &at);
    if (!n->asset && above)
        n->asset = above->asset;
    if (above)
        glint_matrix_multiply(n->world, above->world, n->local);
    else
        memcpy(n->world, n->local, sizeof n->local);
    glint_gltf_ignored(g, &at, "node", n->name, known);
}

struct step {
    uint32_t node, parent;
};

struct stack {
    struct step *step;
    uint32_t count;
};

// Puts the elements of a list of nodes on the stack, last first. False after a fault.
static bool push(struct glint_gltf *g, struct stack *s, const struct glint_json *list,
                 uint32_t parent)
{
    size_t length = 0, i = 0;
    if (!glint_json_length(list, &length))
        return false;
    if (length > g->list[GLTF_NODES].count - s->count)
        return glint_json_fault(list, "the nodes do not form a tree");
    for (const cJSON *c = length ? list->value->child : NULL; c; c = c->next, i++) {
        const struct glint_json at = glint_json_item(list, c, i);
        uint32_t node = 0;
        if (!glint_json_uint(&at, 0, UINT32_MAX, &node))
            return false;
        if (node >= g->list[GLTF_NODES].count)
            return glint_json_fault(&at, "%u: the file has %u nodes", node,
                                    g->list[GLTF_NODES].count);
        s->step[s->count + length - 1 - i] = (struct step){node, parent};
    }
    s->count += (uint32_t)length;
    return true;
}

static bool walk(struct glint_gltf *g, struct stack *s)
{
    while (s->count) {
        const struct step next = s->step[--s->count];
        const struct glint_json at = glint_gltf_item(g, GLTF_NODES, next.node);
        if (g->node[next.node].reached)
            return glint_json_fault(&at, "the node is in two places, or inside of itself");
        read_node(g, next.node, next.parent);
        if (g->node[next.node].depth > MAX_DEPTH)
            return glint_json_fault(&at, "the nodes are more than %u deep", MAX_DEPTH);
        g->order[g->reached++] = next.node;
        const struct glint_json children = glint_json_member(&at, "children");
        if (!push(g, s, &children, next.node))
            return false;
    }
    return true;
}

// Every node that is no node's child, for files without a scene.
static void push_roots(struct glint_gltf *g, struct stack *s)
{
    const uint32_t count = g->list[GLTF_NODES].count;
    bool *child = glint_arena_array(&g->scratch, count + 1, sizeof *child);
    if (!child) {
        glint_gltf_nomem(g);
        return;
    }
    for (uint32_t i = 0; i < count; i++) {
        const struct glint_json at = glint_gltf_item(g, GLTF_NODES, i);
        const struct glint_json children = glint_json_member(&at, "children");
        const cJSON *c = cJSON_IsArray(children.value) ? children.value->child : NULL;
        for (; c; c = c->next)
            if (cJSON_IsNumber(c) && c->valuedouble >= 0 && c->valuedouble < count)
                child[(uint32_t)c->valuedouble] = true;
    }
    for (uint32_t i = count; i-- > 0;)
        if (!child[i])
            s->step[s->count++] = (struct step){i, GLINT_NONE};
}

static void push_scene(struct glint_gltf *g, struct stack *s)
{
    const uint32_t scenes = g->list[GLTF_SCENES].count;
    uint32_t shown = glint_gltf_index(g, &g->root, "scene", GLTF_SCENES);
    if (!scenes) {
        push_roots(g, s);
        return;
    }
    if (shown == GLINT_NONE)
        shown = 0;
    const struct glint_json scene = glint_gltf_item(g, GLTF_SCENES, shown);
    const struct glint_json nodes = glint_json_member(&scene, "nodes");
    push(g, s, &nodes, GLINT_NONE);
    if (scenes > 1)
        glint_gltf_note(g, "scenes", "the file has %u scenes; only scene %u is shown", scenes,
                        shown);
}

void glint_gltf_read_nodes(struct glint_gltf *g)
{
    const uint32_t count = g->list[GLTF_NODES].count;
    struct stack s = {glint_arena_array(&g->scratch, count + 1, sizeof *s.step), 0};
    g->node = glint_arena_array(&g->scratch, count + 1, sizeof *g->node);
    g->order = glint_arena_array(&g->scratch, count + 1, sizeof *g->order);
    if (!s.step || !g->node || !g->order) {
        glint_gltf_nomem(g);
        return;
    }
    push_scene(g, &s);
    if (!g->err->status)
        walk(g, &s);
}

char *glint_gltf_node_path(struct glint_gltf *g, uint32_t node)
{
    uint32_t chain[MAX_DEPTH + 2], n = 0;
    size_t bytes = 1;
    for (uint32_t i = node; i != GLINT_NONE; i = g->node[i].parent) {
        chain[n++] = i;
        bytes += strlen(g->node[i].name) + 20; // a slash, or "/node_" and a number
    }
    char *path = glint_arena_alloc(&g->scratch, bytes), *end = path;
    while (path && n--) {
        const char *name = g->node[chain[n]].name;
        if (end != path)
            *end++ = '/';
        end += *name ? sprintf(end, "%s", name) : sprintf(end, "node_%u", chain[n]);
    }
    return path;
}
