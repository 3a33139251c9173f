// scene_mesh_layout.c - the arrays of a mesh: which there are, how large, where in an asset.
#include "protocol/scene_parts.h"

#include <string.h>

const char *const glint_mesh_attribute_names[8] = {"normal", "uv",     "tangent", "uv1",
                                                   "color",  "joints", "weights", NULL};
const char *const glint_target_attribute_names[3] = {"normal", "tangent", NULL};

enum { VERTICES, TARGETS, TRIANGLES };

static const struct glint_mesh_array {
    size_t member;      // of struct glint_mesh, a pointer
    unsigned attribute; // 0: always there
    unsigned per;       // how often an element is there: VERTICES, TARGETS * VERTICES, TRIANGLES
    size_t bytes;       // of an element
} arrays[GLINT_MESH_ARRAYS] = {
    {offsetof(struct glint_mesh, position), 0, VERTICES, 12},
    {offsetof(struct glint_mesh, normal), GLINT_MESH_NORMAL, VERTICES, 12},
    {offsetof(struct glint_mesh, uv), GLINT_MESH_UV, VERTICES, 8},
    {offsetof(struct glint_mesh, tangent), GLINT_MESH_TANGENT, VERTICES, 16},
    {offsetof(struct glint_mesh, uv1), GLINT_MESH_UV1, VERTICES, 8},
    {offsetof(struct glint_mesh, color), GLINT_MESH_COLOR, VERTICES, 16},
    {offsetof(struct glint_mesh, joint), GLINT_MESH_JOINTS, VERTICES, 8},
    {offsetof(struct glint_mesh, weight), GLINT_MESH_WEIGHTS, VERTICES, 16},
    {offsetof(struct glint_mesh, target_position), 0, TARGETS, 12},
    {offsetof(struct glint_mesh, target_normal), GLINT_MESH_TARGET_NORMAL, TARGETS, 12},
    {offsetof(struct glint_mesh, target_tangent), GLINT_MESH_TARGET_TANGENT, TARGETS, 12},
    {offsetof(struct glint_mesh, index), 0, TRIANGLES, 12},
};

static uint64_t size_of(const struct glint_mesh_array *a, const struct glint_mesh *m)
{
    const uint64_t often[] = {[VERTICES] = m->vertices,
                              [TARGETS] = (uint64_t)m->vertices * m->targets,
                              [TRIANGLES] = m->triangles};
    return often[a->per] * a->bytes;
}

// 2^31 vertices of 100 bytes and 256 targets of 36 stay far below 2^64.
struct glint_mesh_layout glint_mesh_layout(const struct glint_mesh *m, unsigned attributes)
{
    struct glint_mesh_layout layout = {.bytes = 0};
    for (size_t i = 0; i < GLINT_MESH_ARRAYS; i++) {
        const struct glint_mesh_array *a = &arrays[i];
        const bool there = !a->attribute || attributes & a->attribute;
        layout.at[i] = layout.bytes;
        layout.size[i] = there ? size_of(a, m) : 0;
        layout.bytes += layout.size[i];
    }
    return layout;
}

const void *glint_mesh_array(const struct glint_mesh *m, size_t array)
{
    const void *values;
    memcpy(&values, (const char *)m + arrays[array].member, sizeof values);
    return values;
}

void glint_mesh_set_array(struct glint_mesh *m, size_t array, const void *values)
{
    memcpy((char *)m + arrays[array].member, &values, sizeof values);
}

unsigned glint_mesh_attributes(const struct glint_mesh *m)
{
    unsigned attributes = 0;
    for (size_t i = 0; i < GLINT_MESH_ARRAYS; i++)
        attributes |= glint_mesh_array(m, i) ? arrays[i].attribute : 0;
    return attributes;
}
