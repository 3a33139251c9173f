// gltf_skins.c - the skins that are in use, and their joints.
//
// Source: glTF 2.0, "Skins". `skeleton` says nothing that changes a vertex and is not read.
#include "scene/gltf_file.h"

#include <math.h>

#define MAX_JOINTS 65535u

static uint32_t read_joints(struct glint_gltf *g, const struct glint_json *list, uint32_t **out)
{
    size_t length = 0, i = 0;
    if (!glint_json_require(list) || !glint_json_length(list, &length))
        return 0;
    if (length < 1 || length > MAX_JOINTS) {
        glint_json_fault(list, "%zu joints: a skin has 1 to %u", length, MAX_JOINTS);
        return 0;
    }
    uint32_t *joint = glint_arena_array(&g->scene->arena, length, sizeof *joint);
    if (!joint) {
        glint_gltf_nomem(g);
        return 0;
    }
    for (const cJSON *c = list->value->child; c; c = c->next, i++) {
        const struct glint_json at = glint_json_item(list, c, i);
        uint32_t node = 0;
        if (!glint_json_uint(&at, 0, UINT32_MAX, &node))
            return 0;
        if (node >= g->list[GLTF_NODES].count || !g->node[node].reached) {
            glint_json_fault(&at, "node %u is not in the scene", node);
            return 0;
        }
        joint[i] = node;
    }
    *out = joint;
    return (uint32_t)length;
}

// Affine, each number within the limit of coordinates.
static bool check_bind(struct glint_gltf *g, const struct glint_gltf_accessor *a, const float *bind,
                       uint32_t joints)
{
    for (uint32_t j = 0; j < joints; j++) {
        const float *m = bind + (size_t)j * 16;
        for (int i = 0; i < 16; i++)
            if (!(fabsf(m[i]) <= GLINT_MAX_COORDINATE))
                return glint_gltf_accessor_fault(g, a, "matrix %u has the number %g", j,
                                                 (double)m[i]);
        if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
            return glint_gltf_accessor_fault(g, a, "the last row of matrix %u must be 0 0 0 1", j);
    }
    return true;
}

static float *unit_matrices(struct glint_gltf *g, uint32_t count)
{
    float *m = glint_arena_array(&g->scene->arena, count, 16 * sizeof *m);
    if (!m)
        glint_gltf_nomem(g);
    for (size_t i = 0; m && i < (size_t)count * 4; i++)
        m[i / 4 * 16 + i % 4 * 5] = 1;
    return m;
}

static const float *read_bind(struct glint_gltf *g, const struct glint_json *skin, uint32_t joints)
{
    const struct glint_json at = glint_json_member(skin, "inverseBindMatrices");
    const uint32_t index = glint_gltf_index(g, skin, "inverseBindMatrices", GLTF_ACCESSORS);
    struct glint_gltf_accessor a;
    if (!at.value)
        return unit_matrices(g, joints);
    if (index == GLINT_NONE || !glint_gltf_accessor_read(g, index, &a))
        return NULL;
    if (a.components != 16 || a.type != GLTF_F32 || a.count < joints) {
        glint_json_fault(&at, "accessor %u does not hold %u matrices of floats", index, joints);
        return NULL;
    }
    float *m = glint_arena_array(&g->scene->arena, a.count, 16 * sizeof *m);
    if (!m)
        glint_gltf_nomem(g);
    return m && glint_gltf_accessor_floats(g, &a, m) && check_bind(g, &a, m, joints) ? m : NULL;
}

static void read_skin(struct glint_gltf *g, uint32_t i)
{
    static const char *const none[] = {NULL};
    struct glint_scene *s = g->scene;
    struct glint_skin *skin = &s->skin[s->skins];
    const struct glint_json at = glint_gltf_item(g, GLTF_SKINS, i);
    const struct glint_json joints = glint_json_member(&at, "joints");
    const char *name = glint_gltf_name(g, &at);
    if (!*name)
        name = glint_arena_print(&g->scratch, "skin_%u", i);
    skin->joints = read_joints(g, &joints, &skin->joint);
    skin->inverse_bind = skin->joints ? read_bind(g, &at, skin->joints) : NULL;
    if (!skin->inverse_bind)
        return;
    skin->id = name ? glint_gltf_names_id(&g->ids[GLTF_ID_SKIN], &s->arena, name) : NULL;
    if (!skin->id) {
        glint_gltf_nomem(g);
        return;
    }
    for (uint32_t j = 0; j < skin->joints; j++)
        g->node[skin->joint[j]].joint = true;
    glint_gltf_ignored(g, &at, "skin", name, none);
    g->skin[i] = s->skins++;
}

void glint_gltf_read_skins(struct glint_gltf *g)
{
    const uint32_t count = g->list[GLTF_SKINS].count;
    bool *seen = glint_arena_array(&g->scratch, count + 1, sizeof *seen);
    g->skin = glint_arena_array(&g->scratch, count + 1, sizeof *g->skin);
    g->scene->skin = glint_arena_array(&g->scene->arena, count + 1, sizeof *g->scene->skin);
    if (!seen || !g->skin || !g->scene->skin) {
        glint_gltf_nomem(g);
        return;
    }
    for (uint32_t i = 0; i < count; i++)
        g->skin[i] = GLINT_NONE;
    for (uint32_t k = 0; k < g->reached; k++) {
        const struct glint_json node = glint_gltf_item(g, GLTF_NODES, g->order[k]);
        const uint32_t skin = glint_gltf_index(g, &node, "skin", GLTF_SKINS);
        if (skin == GLINT_NONE || seen[skin])
            continue;
        seen[skin] = true;
        read_skin(g, skin);
    }
}
