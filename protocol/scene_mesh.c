// scene_mesh.c - a mesh from an asset, from a primitive, or from inline arrays.
#include "protocol/scene_parts.h"

// Vertices that the primitives of one scene may make: some bytes of JSON must not cost gigabytes.
#define MAX_PRIMITIVE_VERTICES (1u << 24)

const char *const glint_primitive_names[5] = {"sphere", "quad", "box", "disk", NULL};

// ---- from an asset

// The bits of the names that a list has, the first of `names` being `first`.
static bool read_attributes(const struct glint_json *at, const char *const *names, unsigned first,
                            unsigned *attributes)
{
    size_t count, i = 0;
    if (!glint_json_length(at, &count))
        return false;
    bool fine = true;
    for (const cJSON *c = count ? at->value->child : NULL; c; c = c->next, i++) {
        const struct glint_json item = glint_json_item(at, c, i);
        int bit = -1;
        if (!glint_json_choice(&item, names, &bit))
            fine = false;
        else if (*attributes & first << bit)
            fine = glint_json_fault(&item, "the attribute is listed twice");
        else
            *attributes |= first << bit;
    }
    return fine;
}

static bool read_counts(const struct glint_json *at, struct glint_mesh *m)
{
    const struct glint_json vertices = glint_json_member(at, "vertices");
    const struct glint_json triangles = glint_json_member(at, "triangles");
    const struct glint_json targets = glint_json_member(at, "targets");
    bool fine = glint_json_require(&vertices) &&
                glint_json_uint(&vertices, 1, GLINT_MAX_MESH_COUNT, &m->vertices);
    fine &= glint_json_require(&triangles) &&
            glint_json_uint(&triangles, 1, GLINT_MAX_MESH_COUNT, &m->triangles);
    return glint_json_uint(&targets, 0, GLINT_MAX_TARGETS, &m->targets) && fine;
}

static void borrow(struct glint_mesh *m, const struct glint_mesh_layout *layout, const char *bytes)
{
    for (size_t i = 0; i < GLINT_MESH_ARRAYS; i++)
        if (layout->size[i])
            glint_mesh_set_array(m, i, bytes + layout->at[i]);
}

static bool read_asset(struct glint_scene_reader *r, const struct glint_json *at,
                       struct glint_mesh *m)
{
    static const char *const known[] = {"asset",          "vertices", "triangles",
                                        "attributes",     "targets",  "target_attributes",
                                        "target_weights", NULL};
    const struct glint_json asset = glint_json_member(at, "asset");
    const struct glint_json list = glint_json_member(at, "attributes");
    const struct glint_json target_list = glint_json_member(at, "target_attributes");
    unsigned has = 0;
    bool fine = glint_json_only(at, known);
    fine &= read_counts(at, m);
    fine &= read_attributes(&list, glint_mesh_attribute_names, 1, &has);
    fine &=
        read_attributes(&target_list, glint_target_attribute_names, GLINT_MESH_TARGET_NORMAL, &has);
    fine &= glint_mesh_read_weights(r, at, "target_weights", m->targets, &m->target_weight);
    if (!fine)
        return false;
    const struct glint_mesh_layout layout = glint_mesh_layout(m, has);
    const char *bytes = glint_scene_asset(r, &asset, layout.bytes, m->asset);
    if (!bytes)
        return false;
    borrow(m, &layout, bytes);
    return true;
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

static bool check_asset(struct glint_scene_reader *r, const struct glint_json *asset,
                        struct glint_mesh *m)
{
    const uint64_t bytes = glint_mesh_layout(m, glint_mesh_attributes(m)).bytes;
    return glint_scene_charge(r, asset, bytes) && glint_mesh_check(r, asset, m) &&
           glint_trust_own_mesh(r, m);
}

static bool read_kind(struct glint_scene_reader *r, const struct glint_json *at,
                      struct glint_mesh *out)
{
    const struct glint_json asset = glint_json_member(at, "asset");
    const struct glint_json primitive = glint_json_member(at, "primitive");
    if (primitive.value)
        return read_primitive(r, at, out) && glint_mesh_check(r, at, out);
    if (asset.value)
        return read_asset(r, at, out) && (glint_trust_mesh(r, out) || check_asset(r, &asset, out));
    return glint_mesh_read_inline(r, at, out) && glint_mesh_check(r, at, out);
}

void glint_mesh_read(struct glint_scene_reader *r, const struct glint_json *at,
                     struct glint_mesh *out)
{
    if (!read_kind(r, at, out))
        *out = (struct glint_mesh){.id = out->id}; // nothing more is to be said of it
}
