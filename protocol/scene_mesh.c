// scene_mesh.c - a mesh from inline arrays, from an asset or from a primitive.
#include "protocol/scene_parts.h"

#include <string.h>

// Vertices that the primitives of one scene may make: some bytes of JSON must not cost gigabytes.
#define MAX_PRIMITIVE_VERTICES (1u << 24)

const char *const glint_mesh_attribute_names[4] = {"normal", "uv", "tangent", NULL};
const char *const glint_primitive_names[5] = {"sphere", "quad", "box", "disk", NULL};

struct glint_mesh_layout glint_mesh_layout(uint32_t vertices, uint32_t triangles,
                                           unsigned attributes)
{
    struct glint_mesh_layout at = {.normal = 12ull * vertices};
    at.uv = at.normal + (attributes & GLINT_MESH_NORMAL ? 12ull * vertices : 0);
    at.tangent = at.uv + (attributes & GLINT_MESH_UV ? 8ull * vertices : 0);
    at.index = at.tangent + (attributes & GLINT_MESH_TANGENT ? 16ull * vertices : 0);
    at.bytes = at.index + 12ull * triangles;
    return at;
}

// ---- from an asset

static bool read_attributes(const struct glint_json *at, unsigned *attributes)
{
    size_t count, i = 0;
    if (!glint_json_length(at, &count))
        return false;
    for (const cJSON *c = count ? at->value->child : NULL; c; c = c->next, i++) {
        const struct glint_json item = glint_json_item(at, c, i);
        int bit;
        if (!glint_json_choice(&item, glint_mesh_attribute_names, &bit))
            return false;
        if (*attributes & 1u << bit)
            return glint_json_fault(&item, "the attribute is listed twice");
        *attributes |= 1u << bit;
    }
    return true;
}

static bool read_asset(struct glint_scene_reader *r, const struct glint_json *at,
                       struct glint_mesh *m)
{
    static const char *const known[] = {"asset", "vertices", "triangles", "attributes", NULL};
    const struct glint_json asset = glint_json_member(at, "asset");
    const struct glint_json vertices = glint_json_member(at, "vertices");
    const struct glint_json triangles = glint_json_member(at, "triangles");
    const struct glint_json list = glint_json_member(at, "attributes");
    unsigned has = 0;
    bool fine = glint_json_only(at, known);
    fine &= glint_json_require(&vertices) &&
            glint_json_uint(&vertices, 1, GLINT_MAX_MESH_COUNT, &m->vertices);
    fine &= glint_json_require(&triangles) &&
            glint_json_uint(&triangles, 1, GLINT_MAX_MESH_COUNT, &m->triangles);
    fine &= read_attributes(&list, &has);
    if (!fine)
        return false;
    const struct glint_mesh_layout layout = glint_mesh_layout(m->vertices, m->triangles, has);
    const char *bytes = glint_scene_asset(r, &asset, layout.bytes, m->asset);
    if (!bytes)
        return false;
    m->position = (const void *)bytes;
    m->normal = has & GLINT_MESH_NORMAL ? (const void *)(bytes + layout.normal) : NULL;
    m->uv = has & GLINT_MESH_UV ? (const void *)(bytes + layout.uv) : NULL;
    m->tangent = has & GLINT_MESH_TANGENT ? (const void *)(bytes + layout.tangent) : NULL;
    m->index = (const void *)(bytes + layout.index);
    return true;
}

// ---- inline

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
    return glint_json_floats(&at, count, -GLINT_MAX_COORDINATE, GLINT_MAX_COORDINATE, values);
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
        return glint_json_uints(&at, (size_t)m->triangles * 3, 0, m->vertices - 1, index);
    for (uint32_t i = 0; i < m->vertices; i++)
        index[i] = i;
    return true;
}

static bool read_inline(struct glint_scene_reader *r, const struct glint_json *at,
                        struct glint_mesh *m)
{
    static const char *const known[] = {"positions", "indices",   "normals", "uvs",
                                        "tangents",  "primitive", "asset",   NULL};
    const struct glint_json positions = glint_json_member(at, "positions");
    bool fine = glint_json_only(at, known);
    m->vertices = triples(&positions);
    if (!m->vertices)
        return false;
    fine &= read_floats(r, at, "positions", (size_t)m->vertices * 3, &m->position);
    fine &= read_floats(r, at, "normals", (size_t)m->vertices * 3, &m->normal);
    fine &= read_floats(r, at, "uvs", (size_t)m->vertices * 2, &m->uv);
    fine &= read_floats(r, at, "tangents", (size_t)m->vertices * 4, &m->tangent);
    fine &= read_indices(r, at, m);
    return fine;
}

// ---- a primitive

static const struct glint_field round_fields[] = {
    GLINT_FIELD_KNOWN("primitive"),
    GLINT_FIELD(FLOAT, struct glint_primitive, radius, .low = 1e-12, .high = 1e12),
    GLINT_FIELD(UINT, struct glint_primitive, segments, .low = 3, .high = 1024),
    {0},
};
static const struct glint_field quad_fields[] = {
    GLINT_FIELD_KNOWN("primitive"),
    GLINT_FIELD(FLOAT, struct glint_primitive, size, .count = 2, .low = 1e-12, .high = 1e12),
    {0},
};
static const struct glint_field box_fields[] = {
    GLINT_FIELD_KNOWN("primitive"),
    GLINT_FIELD(FLOAT, struct glint_primitive, size, .count = 3, .low = 1e-12, .high = 1e12),
    {0},
};
static const struct glint_field *const primitive_fields[] = {
    [GLINT_SPHERE] = round_fields,
    [GLINT_QUAD] = quad_fields,
    [GLINT_BOX] = box_fields,
    [GLINT_DISK] = round_fields,
};

static bool read_primitive(struct glint_scene_reader *r, const struct glint_json *at,
                           struct glint_mesh *m)
{
    struct glint_primitive p = {.radius = 1, .segments = 64, .size = {1, 1, 1}};
    const struct glint_json name = glint_json_member(at, "primitive");
    int kind = 0;
    if (!glint_json_choice(&name, glint_primitive_names, &kind))
        return false;
    p.kind = kind;
    if (!glint_fields_read(at, primitive_fields[kind], &r->scene->arena, &p))
        return false;
    glint_primitive_size(&p, &m->vertices, &m->triangles);
    r->primitive_vertices += m->vertices;
    if (r->primitive_vertices > MAX_PRIMITIVE_VERTICES)
        return glint_json_fault(at, "the primitives have more than %u vertices together",
                                MAX_PRIMITIVE_VERTICES);
    return glint_primitive_make(&p, &r->scene->arena, m) || glint_scene_no_memory(r);
}

void glint_mesh_read(struct glint_scene_reader *r, const struct glint_json *at,
                     struct glint_mesh *out, float *reach)
{
    const struct glint_json asset = glint_json_member(at, "asset");
    const struct glint_json primitive = glint_json_member(at, "primitive");
    if (primitive.value) {
        if (read_primitive(r, at, out))
            glint_mesh_check(r, at, out, reach);
    } else if (asset.value) {
        if (read_asset(r, at, out))
            glint_mesh_check(r, &asset, out, reach);
    } else if (read_inline(r, at, out)) {
        glint_mesh_check(r, at, out, reach);
    }
}
