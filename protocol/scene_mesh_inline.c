// scene_mesh_inline.c - a mesh whose arrays are in the JSON.
#include "protocol/json_lists.h"
#include "protocol/scene_parts.h"

#include <string.h>

static bool read_floats(struct glint_scene_reader *r, const struct glint_json *mesh,
                        const char *key, size_t count, const float **out)
{
    const struct glint_json at = glint_json_member(mesh, key);
    if (!at.value)
        return true;
    size_t length;
    if (!glint_json_length(&at, &length))
        return false;
    if (length != count)
        return glint_json_fault(&at, "%zu numbers are expected for these positions, not %zu", count,
                                length);
    float *values = glint_arena_array(&r->scene->arena, count, sizeof *values);
    if (!values)
        return glint_scene_no_memory(r);
    *out = values;
    return glint_json_all_floats(&at, -GLINT_MAX_COORDINATE, GLINT_MAX_COORDINATE, values);
}

// The number of triples in a list, or 0 with a fault.
static uint32_t triples(const struct glint_json *at)
{
    size_t length;
    if (!glint_json_require(at) || !glint_json_length(at, &length))
        return 0;
    if (length == 0 || length % 3 || length / 3 > GLINT_MAX_MESH_COUNT) {
        glint_json_fault(at, "a multiple of 3 numbers, at least 3, is expected, not %zu", length);
        return 0;
    }
    return (uint32_t)(length / 3);
}

static bool read_indices(struct glint_scene_reader *r, const struct glint_json *mesh,
                         struct glint_mesh *m)
{
    const struct glint_json at = glint_json_member(mesh, "indices");
    const struct glint_json positions = glint_json_member(mesh, "positions");
    if (!at.value && m->vertices % 3)
        return glint_json_fault(&positions, "%u vertices without indices are no triangles",
                                m->vertices);
    m->triangles = at.value ? triples(&at) : m->vertices / 3;
    if (!m->triangles)
        return false;
    uint32_t *index = glint_arena_array(&r->scene->arena, m->triangles, 3 * sizeof *index);
    if (!index)
        return glint_scene_no_memory(r);
    m->index = index;
    if (at.value)
        return glint_json_all_uints(&at, 0, m->vertices - 1, index);
    for (uint32_t i = 0; i < m->vertices; i++)
        index[i] = i;
    return true;
}

static bool read_joints(struct glint_scene_reader *r, const struct glint_json *mesh,
                        struct glint_mesh *m)
{
    const struct glint_json at = glint_json_member(mesh, "joints");
    size_t length, i = 0;
    if (!at.value || !glint_json_length(&at, &length))
        return !at.value;
    if (length != (size_t)m->vertices * 4)
        return glint_json_fault(&at, "4 indices are expected for each of %u vertices, not %zu",
                                m->vertices, length);
    uint16_t *joint = glint_arena_array(&r->scene->arena, length, sizeof *joint);
    if (!joint)
        return glint_scene_no_memory(r);
    m->joint = joint;
    bool fine = true;
    struct glint_json_walk walk = glint_json_walk(at.value);
    for (const cJSON *c; (c = glint_json_next(&walk)); i++) {
        const struct glint_json item = glint_json_item(&at, c, i);
        uint32_t index = 0;
        fine &= glint_json_uint(&item, 0, UINT16_MAX, &index);
        joint[i] = (uint16_t)index;
    }
    return fine;
}

// ---- morph targets

// What a target says of one array. An array exists where any target speaks of it; the others' parts
// of it are zero.
static bool read_displacements(struct glint_scene_reader *r, const struct glint_json *target,
                               const char *key, const struct glint_mesh *m, const float **out)
{
    const struct glint_json at = glint_json_member(target, key);
    const size_t count = (size_t)m->vertices * 3;
    size_t length;
    if (!at.value)
        return true;
    if (!glint_json_length(&at, &length))
        return false;
    if (length != count)
        return glint_json_fault(&at, "%zu numbers are expected for these positions, not %zu", count,
                                length);
    if (!*out)
        *out = glint_arena_array(&r->scene->arena, m->targets, count * sizeof **out);
    if (!*out)
        return glint_scene_no_memory(r);
    float *values = (float *)*out + target->index * count;
    return glint_json_all_floats(&at, -GLINT_MAX_COORDINATE, GLINT_MAX_COORDINATE, values);
}

static bool read_target(struct glint_scene_reader *r, const struct glint_json *at,
                        struct glint_mesh *m)
{
    static const char *const known[] = {"positions", "normals", "tangents", NULL};
    bool fine = glint_json_only(at, known);
    fine &= read_displacements(r, at, "positions", m, &m->target_position);
    fine &= read_displacements(r, at, "normals", m, &m->target_normal);
    fine &= read_displacements(r, at, "tangents", m, &m->target_tangent);
    return fine;
}

static bool read_targets(struct glint_scene_reader *r, const struct glint_json *mesh,
                         struct glint_mesh *m)
{
    const struct glint_json at = glint_json_member(mesh, "targets");
    size_t count, i = 0;
    if (!glint_json_length(&at, &count))
        return false;
    if (count > GLINT_MAX_TARGETS)
        return glint_json_fault(&at, "%zu targets; the limit is %u", count, GLINT_MAX_TARGETS);
    m->targets = (uint32_t)count;
    bool fine = glint_mesh_read_weights(r, mesh, "target_weights", m->targets, &m->target_weight);
    for (const cJSON *c = count ? at.value->child : NULL; c; c = c->next, i++) {
        const struct glint_json item = glint_json_item(&at, c, i);
        fine &= read_target(r, &item, m);
    }
    if (count && !m->target_position) // all of them leave the positions
        m->target_position = glint_arena_array(&r->scene->arena, (size_t)m->targets * m->vertices,
                                               3 * sizeof *m->target_position);
    return fine && (!count || m->target_position || glint_scene_no_memory(r));
}

bool glint_mesh_read_weights(struct glint_scene_reader *r, const struct glint_json *at,
                             const char *key, uint32_t targets, const float **out)
{
    const struct glint_json list = glint_json_member(at, key);
    size_t length;
    if (!list.value)
        return true;
    if (!glint_json_length(&list, &length))
        return false;
    if (length != targets)
        return glint_json_fault(&list, "the mesh has %u targets; %zu weights are given", targets,
                                length);
    float *weight = glint_arena_array(&r->scene->arena, targets, sizeof *weight);
    if (!weight)
        return glint_scene_no_memory(r);
    *out = targets ? weight : NULL;
    return glint_json_floats(&list, targets, -GLINT_MAX_WEIGHT, GLINT_MAX_WEIGHT, weight);
}

bool glint_mesh_read_inline(struct glint_scene_reader *r, const struct glint_json *at,
                            struct glint_mesh *m)
{
    static const char *const known[] = {"positions", "indices", "normals",        "uvs",
                                        "tangents",  "uvs1",    "colors",         "joints",
                                        "weights",   "targets", "target_weights", "primitive",
                                        "asset",     NULL};
    const struct glint_json positions = glint_json_member(at, "positions");
    bool fine = glint_json_only(at, known);
    m->vertices = triples(&positions);
    if (!m->vertices)
        return false;
    fine &= read_floats(r, at, "positions", (size_t)m->vertices * 3, &m->position);
    fine &= read_floats(r, at, "normals", (size_t)m->vertices * 3, &m->normal);
    fine &= read_floats(r, at, "uvs", (size_t)m->vertices * 2, &m->uv);
    fine &= read_floats(r, at, "tangents", (size_t)m->vertices * 4, &m->tangent);
    fine &= read_floats(r, at, "uvs1", (size_t)m->vertices * 2, &m->uv1);
    fine &= read_floats(r, at, "colors", (size_t)m->vertices * 4, &m->color);
    fine &= read_joints(r, at, m);
    fine &= read_floats(r, at, "weights", (size_t)m->vertices * 4, &m->weight);
    fine &= read_indices(r, at, m);
    fine &= read_targets(r, at, m);
    return fine;
}
