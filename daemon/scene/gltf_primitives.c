// gltf_primitives.c - the accessors of a triangle primitive; equal primitives are one geometry.
#include "scene/gltf_file.h"

#include <stdio.h>
#include <string.h>

#define MAX_TARGETS 256u
#define MAX_DISPLACED (1u << 27) // vertices of all morph targets

static const struct {
    const char *name;
    enum glint_gltf_part part;
    uint32_t components;
} attribute[] = {
    {"POSITION", GLTF_POSITION, 3}, {"NORMAL", GLTF_NORMAL, 3},     {"TANGENT", GLTF_TANGENT, 4},
    {"TEXCOORD_0", GLTF_UV, 2},     {"TEXCOORD_1", GLTF_UV1, 2},    {"COLOR_0", GLTF_COLOR, 0},
    {"JOINTS_0", GLTF_JOINTS, 4},   {"WEIGHTS_0", GLTF_WEIGHTS, 4},
};
#define ATTRIBUTES (sizeof attribute / sizeof *attribute)

// The count and shape that it must have are checked; 0: three or four components.
static bool read_part(struct glint_gltf *g, const struct glint_json *attributes, const char *name,
                      uint32_t components, uint32_t vertices, struct glint_gltf_accessor *out)
{
    const struct glint_json at = glint_json_member(attributes, name);
    const uint32_t index = glint_gltf_index(g, attributes, name, GLTF_ACCESSORS);
    if (index == GLINT_NONE)
        return !at.value;
    if (!glint_gltf_accessor_read(g, index, out))
        return false;
    const bool shaped =
        components ? out->components == components : out->components == 3 || out->components == 4;
    if (!shaped || out->type == GLTF_U32)
        return glint_json_fault(&at, "accessor %u has the wrong type for it", index);
    return !vertices || out->count == vertices ||
           glint_json_fault(&at, "accessor %u has %u elements, the positions have %u", index,
                            out->count, vertices);
}

static bool read_indices(struct glint_gltf *g, const struct glint_json *primitive,
                         struct glint_gltf_accessor *out)
{
    const struct glint_json at = glint_json_member(primitive, "indices");
    const uint32_t index = glint_gltf_index(g, primitive, "indices", GLTF_ACCESSORS);
    if (index == GLINT_NONE)
        return !at.value;
    if (!glint_gltf_accessor_read(g, index, out))
        return false;
    return (out->components == 1 &&
            (out->type == GLTF_U8 || out->type == GLTF_U16 || out->type == GLTF_U32)) ||
           glint_json_fault(&at, "accessor %u does not hold unsigned integers", index);
}

static bool read_parts(struct glint_gltf *g, const struct glint_json *at,
                       struct glint_gltf_geometry *geometry)
{
    const struct glint_json a = glint_gltf_object(at, "attributes");
    uint32_t vertices = 0;
    for (size_t i = 0; i < ATTRIBUTES; i++) {
        struct glint_gltf_accessor *out = &geometry->part[attribute[i].part];
        if (!read_part(g, &a, attribute[i].name, attribute[i].components, vertices, out))
            return false;
        vertices = geometry->part[GLTF_POSITION].count;
        if (!vertices)
            return true; // nothing to show
    }
    return read_indices(g, at, &geometry->part[GLTF_INDEX]);
}

// Joints are whole numbers, and come with weights.
static bool check_joints(const struct glint_json *at, const struct glint_gltf_geometry *geometry)
{
    const struct glint_json a = glint_gltf_object(at, "attributes");
    const struct glint_json joints = glint_json_member(&a, "JOINTS_0");
    const struct glint_json weights = glint_json_member(&a, "WEIGHTS_0");
    const struct glint_gltf_accessor *j = &geometry->part[GLTF_JOINTS];
    const struct glint_gltf_accessor *w = &geometry->part[GLTF_WEIGHTS];
    if (j->count && (j->normalized || (j->type != GLTF_U8 && j->type != GLTF_U16)))
        return glint_json_fault(&joints, "joints are unsigned integers of 8 or 16 bits");
    if (w->count && w->type != GLTF_F32 && !w->normalized)
        return glint_json_fault(&weights, "weights are floats or normalised integers");
    if (!j->count != !w->count)
        return glint_json_fault(&a, "JOINTS_0 and WEIGHTS_0 come together");
    return true;
}

// --- morph targets

static bool read_target(struct glint_gltf *g, const struct glint_json *at,
                        struct glint_gltf_geometry *geometry, struct glint_gltf_target *out)
{
    const uint32_t vertices = geometry->part[GLTF_POSITION].count;
    g->displaced += vertices;
    if (g->displaced > MAX_DISPLACED)
        return glint_json_fault(at, "the morph targets have more than %u vertices", MAX_DISPLACED);
    for (const cJSON *c = at->value->child; c; c = c->next)
        if (strncmp(c->string, "COLOR_", 6) == 0 || strncmp(c->string, "TEXCOORD_", 9) == 0)
            glint_gltf_note(g, "morph targets of other attributes",
                            "morph targets of mesh \"%.200s\" move %.40s, which stays",
                            geometry->name, c->string);
    return read_part(g, at, "POSITION", 3, vertices, &out->position) &&
           read_part(g, at, "NORMAL", 3, vertices, &out->normal) &&
           read_part(g, at, "TANGENT", 3, vertices, &out->tangent);
}

static bool read_targets(struct glint_gltf *g, const struct glint_json *primitive,
                         struct glint_gltf_geometry *geometry)
{
    const struct glint_json list = glint_json_member(primitive, "targets");
    size_t length = 0, i = 0;
    if (!glint_json_length(&list, &length) || !length)
        return !list.value || !length;
    if (length > MAX_TARGETS)
        return glint_json_fault(&list, "%zu morph targets; at most %u", length, MAX_TARGETS);
    geometry->target = glint_arena_array(&g->scratch, length, sizeof *geometry->target);
    if (!geometry->target)
        return glint_gltf_nomem(g);
    for (const cJSON *c = list.value->child; c; c = c->next, i++) {
        const struct glint_json at = glint_json_item(&list, c, i);
        if (!cJSON_IsObject(c))
            return glint_json_fault(&at, "must be an object");
        if (!read_target(g, &at, geometry, &geometry->target[i]))
            return false;
    }
    geometry->targets = (uint32_t)length;
    return true;
}

uint32_t glint_gltf_targets(struct glint_gltf *g, const struct glint_json *node)
{
    const uint32_t index = glint_gltf_index(g, node, "mesh", GLTF_MESHES);
    if (index == GLINT_NONE)
        return 0;
    const struct glint_json mesh = glint_gltf_item(g, GLTF_MESHES, index);
    const struct glint_json list = glint_json_member(&mesh, "primitives");
    if (!cJSON_IsArray(list.value) || !list.value->child)
        return 0;
    const struct glint_json first = glint_json_item(&list, list.value->child, 0);
    const struct glint_json targets = glint_json_member(&first, "targets");
    size_t length = 0;
    return glint_json_length(&targets, &length) && length <= MAX_TARGETS ? (uint32_t)length : 0;
}

const float *glint_gltf_weights(struct glint_gltf *g, const struct glint_json *object,
                                uint32_t targets)
{
    const struct glint_json at = glint_json_member(object, "weights");
    float *weight = NULL;
    if (!at.value)
        return NULL;
    if (!targets) {
        glint_json_fault(&at, "the mesh has no morph targets");
        return NULL;
    }
    weight = glint_arena_array(&g->scene->arena, targets, sizeof *weight);
    if (!weight)
        glint_gltf_nomem(g);
    else
        glint_json_floats(&at, targets, -GLINT_MAX_WEIGHT, GLINT_MAX_WEIGHT, weight);
    return weight;
}

// --- geometries

static bool has(const struct glint_json *attributes, const char *name)
{
    return glint_json_member(attributes, name).value != NULL;
}

static void note_unused(struct glint_gltf *g, const struct glint_json *at, const char *name)
{
    static const char *const none[] = {NULL};
    const struct glint_json a = glint_json_member(at, "attributes");
    if (has(&a, "JOINTS_1"))
        glint_gltf_note(g, "more than four joints",
                        "vertices of mesh \"%.200s\" follow more than four joints; the first four "
                        "are kept",
                        name);
    if (has(&a, "COLOR_1"))
        glint_gltf_note(g, "second vertex colours",
                        "vertex colours 1 of mesh \"%.200s\" are ignored", name);
    glint_gltf_ignored(g, at, "mesh", name, none);
}

static double number(const struct glint_json *at)
{
    return cJSON_IsNumber(at->value) ? at->value->valuedouble : -1;
}

// The accessors and the mode say all: primitives with equal ones show the same triangles. Those
// that morph are not compared.
static uint32_t *find_key(struct glint_gltf_primitives *p, const struct glint_json *at,
                          uint32_t mode, uint32_t mesh, uint32_t part)
{
    const struct glint_json a = glint_json_member(at, "attributes");
    const struct glint_json indices = glint_json_member(at, "indices");
    char key[320];
    int n = snprintf(key, sizeof key, "%u %.10g", mode, number(&indices));
    for (size_t i = 0; i < ATTRIBUTES; i++) {
        const struct glint_json v = glint_json_member(&a, attribute[i].name);
        n += snprintf(key + n, sizeof key - (size_t)n, " %.10g", number(&v));
    }
    if (glint_json_member(at, "targets").value)
        snprintf(key + n, sizeof key - (size_t)n, " %u.%u", mesh, part);
    return glint_gltf_names_at(&p->keys, &p->g->scratch, key);
}

static bool grow(struct glint_gltf_primitives *p)
{
    const uint32_t capacity = p->capacity ? 2 * p->capacity : 64;
    struct glint_gltf_geometry *more = glint_arena_array(&p->g->scratch, capacity, sizeof *more);
    if (!more)
        return glint_gltf_nomem(p->g);
    if (p->geometries)
        memcpy(more, p->geometry, p->geometries * sizeof *more);
    p->geometry = more;
    p->capacity = capacity;
    return true;
}

// A geometry that is new; GLINT_NONE when it has no triangle or a fault.
static uint32_t add_geometry(struct glint_gltf_primitives *p, const struct glint_json *at,
                             uint32_t mode, const float *weight, const char *name)
{
    struct glint_gltf_geometry new = {.mode = mode, .name = name};
    if (!read_parts(p->g, at, &new) || !check_joints(at, &new))
        return GLINT_NONE;
    const uint32_t vertices = new.part[GLTF_POSITION].count;
    const uint32_t elements = new.part[GLTF_INDEX].count ? new.part[GLTF_INDEX].count : vertices;
    if (!vertices || elements < 3) {
        glint_gltf_note(p->g, "mesh without triangles",
                        "a primitive of mesh \"%.200s\" has no triangles and is left out", name);
        return GLINT_NONE;
    }
    if (!read_targets(p->g, at, &new) || (p->geometries == p->capacity && !grow(p)))
        return GLINT_NONE;
    new.weight = new.targets ? weight : NULL;
    p->geometry[p->geometries] = new;
    return p->geometries++;
}

static uint32_t find_geometry(struct glint_gltf_primitives *p, const struct glint_json *at,
                              uint32_t mode, uint32_t *key, const float *weight, const char *name)
{
    if (!key) {
        glint_gltf_nomem(p->g);
        return GLINT_NONE;
    }
    if (!*key) {
        const uint32_t index = add_geometry(p, at, mode, weight, name);
        if (index == GLINT_NONE)
            return GLINT_NONE;
        *key = index + 1;
    }
    return *key - 1;
}

struct glint_gltf_primitive glint_gltf_read_primitive(struct glint_gltf_primitives *p,
                                                      const struct glint_json *at, uint32_t mesh,
                                                      uint32_t part, const float *weight,
                                                      const char *name)
{
    static const char *const kinds[] = {"points", "lines", "lines", "lines"};
    const struct glint_json member = glint_json_member(at, "mode");
    struct glint_gltf_primitive out = {GLINT_NONE, GLINT_NONE};
    uint32_t mode = 4;
    if (!glint_json_uint(&member, 0, 6, &mode))
        return out;
    if (mode < 4) {
        glint_gltf_note(p->g, kinds[mode], "%s of mesh \"%.200s\" are left out", kinds[mode], name);
        return out;
    }
    out.material = glint_gltf_index(p->g, at, "material", GLTF_MATERIALS);
    uint32_t *key = find_key(p, at, mode, mesh, part);
    out.geometry = find_geometry(p, at, mode, key, weight, name);
    note_unused(p->g, at, name);
    return out;
}
