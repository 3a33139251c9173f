// gltf_meshes.c - which meshes the scene shows, and the objects and instances that show them.
#include "scene/gltf_file.h"

#include <stdio.h>
#include <string.h>

#define MAX_INSTANCES (1u << 24)

struct primitive {
    uint32_t geometry; // GLINT_NONE: left out
    uint32_t material; // of the file, or GLINT_NONE
};

struct mesh {
    bool read;
    uint32_t primitives;
    struct primitive *primitive;
};

struct meshes {
    struct glint_gltf *g;
    struct mesh *mesh; // of each glTF mesh
    struct glint_gltf_geometry *geometry;
    uint32_t geometries, capacity;
    struct glint_gltf_names keys;  // accessors of a geometry -> its index + 1
    struct glint_gltf_names names; // of the nodes that show a mesh -> how many have it
};

// --- primitives

// Adds the attribute to a geometry's key; the count and shape it must have are checked.
static bool read_part(struct glint_gltf *g, const struct glint_json *attributes, const char *name,
                      uint32_t components, uint32_t vertices, struct glint_gltf_accessor *out)
{
    const struct glint_json at = glint_json_member(attributes, name);
    const uint32_t index = glint_gltf_index(g, attributes, name, GLTF_ACCESSORS);
    if (index == GLINT_NONE)
        return !at.value;
    if (!glint_gltf_accessor_read(g, index, out))
        return false;
    if (out->components != components || out->type == GLTF_U32)
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
    struct glint_gltf_accessor *part = geometry->part;
    if (!read_part(g, &a, "POSITION", 3, 0, &part[GLTF_POSITION]))
        return false;
    const uint32_t vertices = part[GLTF_POSITION].count;
    return read_part(g, &a, "NORMAL", 3, vertices, &part[GLTF_NORMAL]) &&
           read_part(g, &a, "TEXCOORD_0", 2, vertices, &part[GLTF_UV]) &&
           read_part(g, &a, "TANGENT", 4, vertices, &part[GLTF_TANGENT]) &&
           read_indices(g, at, &part[GLTF_INDEX]);
}

static void note_unused(struct glint_gltf *g, const struct glint_json *at, const char *name)
{
    static const char *const none[] = {NULL};
    const struct glint_json a = glint_json_member(at, "attributes");
    if (glint_json_member(&a, "COLOR_0").value)
        glint_gltf_note(g, "vertex colours", "vertex colours of mesh \"%.200s\" are ignored", name);
    if (glint_json_member(&a, "TEXCOORD_1").value)
        glint_gltf_note(g, "second texture coordinates",
                        "texture coordinates 1 of mesh \"%.200s\" are ignored", name);
    if (glint_json_member(at, "targets").value)
        glint_gltf_note(g, "morph targets", "morph targets of mesh \"%.200s\" are ignored", name);
    glint_gltf_ignored(g, at, "mesh", name, none);
}

// The accessors and the mode say all: primitives with equal ones show the same triangles.
static uint32_t *find_key(struct meshes *m, const struct glint_json *at, uint32_t mode)
{
    const struct glint_json a = glint_json_member(at, "attributes");
    static const char *const names[] = {"POSITION", "NORMAL", "TEXCOORD_0", "TANGENT"};
    char key[160];
    int n = snprintf(key, sizeof key, "%u", mode);
    for (int i = 0; i < 5; i++) {
        const struct glint_json v =
            i < 4 ? glint_json_member(&a, names[i]) : glint_json_member(at, "indices");
        n += snprintf(key + n, sizeof key - (size_t)n, " %.10g",
                      cJSON_IsNumber(v.value) ? v.value->valuedouble : -1.0);
    }
    return glint_gltf_names_at(&m->keys, &m->g->scratch, key);
}

// A geometry that is new; GLINT_NONE when it has no triangle or a fault.
static uint32_t add_geometry(struct meshes *m, const struct glint_json *at, uint32_t mode,
                             const char *name)
{
    struct glint_gltf_geometry new = {.mode = mode, .name = name};
    if (!read_parts(m->g, at, &new))
        return GLINT_NONE;
    const uint32_t vertices = new.part[GLTF_POSITION].count;
    const uint32_t elements = new.part[GLTF_INDEX].count ? new.part[GLTF_INDEX].count : vertices;
    if (!vertices || elements < 3) {
        glint_gltf_note(m->g, "mesh without triangles",
                        "a primitive of mesh \"%.200s\" has no triangles and is left out", name);
        return GLINT_NONE;
    }
    if (m->geometries == m->capacity) {
        const uint32_t capacity = m->capacity ? 2 * m->capacity : 64;
        struct glint_gltf_geometry *more =
            glint_arena_array(&m->g->scratch, capacity, sizeof *more);
        if (!more) {
            glint_gltf_nomem(m->g);
            return GLINT_NONE;
        }
        if (m->geometries)
            memcpy(more, m->geometry, m->geometries * sizeof *more);
        m->geometry = more;
        m->capacity = capacity;
    }
    m->geometry[m->geometries] = new;
    return m->geometries++;
}

static uint32_t find_geometry(struct meshes *m, const struct glint_json *at, uint32_t mode,
                              const char *name)
{
    uint32_t *key = find_key(m, at, mode);
    if (!key) {
        glint_gltf_nomem(m->g);
        return GLINT_NONE;
    }
    if (!*key) {
        const uint32_t index = add_geometry(m, at, mode, name);
        if (index == GLINT_NONE)
            return GLINT_NONE;
        *key = index + 1;
    }
    return *key - 1;
}

static struct primitive read_primitive(struct meshes *m, const struct glint_json *at,
                                       const char *name)
{
    static const char *const kinds[] = {"points", "lines", "lines", "lines"};
    const struct glint_json member = glint_json_member(at, "mode");
    struct primitive p = {GLINT_NONE, GLINT_NONE};
    uint32_t mode = 4;
    if (!glint_json_uint(&member, 0, 6, &mode))
        return p;
    if (mode < 4) {
        glint_gltf_note(m->g, kinds[mode], "%s of mesh \"%.200s\" are left out", kinds[mode], name);
        return p;
    }
    p.material = glint_gltf_index(m->g, at, "material", GLTF_MATERIALS);
    p.geometry = find_geometry(m, at, mode, name);
    note_unused(m->g, at, name);
    return p;
}

static void read_mesh(struct meshes *m, uint32_t i)
{
    static const char *const none[] = {NULL};
    struct mesh *mesh = &m->mesh[i];
    if (mesh->read)
        return;
    mesh->read = true;
    const struct glint_json at = glint_gltf_item(m->g, GLTF_MESHES, i);
    const struct glint_json list = glint_json_member(&at, "primitives");
    const char *name = glint_gltf_name(m->g, &at);
    if (!*name)
        name = glint_arena_print(&m->g->scratch, "mesh_%u", i);
    size_t count = 0, k = 0;
    glint_json_require(&list);
    glint_json_length(&list, &count);
    mesh->primitive = glint_arena_array(&m->g->scratch, count + 1, sizeof *mesh->primitive);
    if (!name || !mesh->primitive) {
        glint_gltf_nomem(m->g);
        return;
    }
    for (const cJSON *c = count ? list.value->child : NULL; c; c = c->next, k++) {
        const struct glint_json p = glint_json_item(&list, c, k);
        mesh->primitive[mesh->primitives++] = read_primitive(m, &p, name);
    }
    glint_gltf_ignored(m->g, &at, "mesh", name, none);
}

// --- objects and instances

static const char *mesh_name(struct glint_gltf *g, uint32_t mesh)
{
    const struct glint_json at = glint_gltf_item(g, GLTF_MESHES, mesh);
    return glint_gltf_name(g, &at);
}

// The name that stands for a node before it is made unique: its own, its mesh's, or its number.
static const char *short_name(struct glint_gltf *g, uint32_t node, uint32_t mesh)
{
    const char *name = g->node[node].name;
    if (!*name)
        name = mesh_name(g, mesh);
    return *name ? name : glint_arena_print(&g->scratch, "node_%u", node);
}

// CONVENTIONS: the unique node name, else the path. Nodes that show nothing do not count.
static const char *object_name(struct meshes *m, uint32_t node, uint32_t mesh)
{
    struct glint_gltf *g = m->g;
    const char *name = short_name(g, node, mesh);
    uint32_t *shared = name ? glint_gltf_names_at(&m->names, &g->scratch, name) : NULL;
    if (!shared)
        return NULL;
    const char *path = *shared > 1 ? glint_gltf_node_path(g, node) : name;
    return !path || strlen(path) <= GLINT_MAX_NAME ? path : name;
}

static char *asset_of(struct glint_gltf *g, uint32_t node)
{
    const struct glint_gltf_node *n = &g->node[node];
    if (n->asset)
        return glint_arena_string(&g->scene->arena, n->asset);
    const char *colon = strrchr(n->name, ':');
    return glint_arena_print(&g->scene->arena, "%.*s", colon ? (int)(colon - n->name) : 0, n->name);
}

static void add_instance(struct meshes *m, const struct primitive *p, uint32_t object,
                         const float transform[16], const char *id)
{
    struct glint_gltf *g = m->g;
    const double reach = glint_gltf_reach(transform, g->reach[p->geometry]);
    if (reach > GLINT_MAX_COORDINATE) {
        glint_fail(g->err, GLINT_E_RANGE, "/nodes",
                   "node \"%.200s\" reaches to %g metres; the "
                   "limit is %g",
                   g->scene->object[object].name, reach, (double)GLINT_MAX_COORDINATE);
        return;
    }
    struct glint_instance *in = &g->scene->instance[g->scene->instances];
    *in = (struct glint_instance){.object = object, .mesh = p->geometry, .visible = true};
    in->material = glint_gltf_material(g, p->material);
    memcpy(in->transform, transform, sizeof in->transform);
    in->id = glint_gltf_names_id(&g->ids[GLTF_ID_INSTANCE], &g->scene->arena, id);
    if (in->id)
        g->scene->instances++;
    else
        glint_gltf_nomem(g);
}

static void add_instances(struct meshes *m, uint32_t mesh, uint32_t object,
                          const float transform[16])
{
    const struct mesh *shown = &m->mesh[mesh];
    const char *base = m->g->scene->object[object].id;
    for (uint32_t k = 0; k < shown->primitives; k++) {
        char id[96];
        if (shown->primitive[k].geometry == GLINT_NONE)
            continue;
        if (shown->primitives == 1)
            snprintf(id, sizeof id, "%s", base);
        else
            snprintf(id, sizeof id, "%s.%u", base, k);
        add_instance(m, &shown->primitive[k], object, transform, id);
    }
}

static void note_skin(struct glint_gltf *g, const struct glint_json *at, const char *name)
{
    if (glint_json_member(at, "skin").value)
        glint_gltf_note(g, "skin on a node",
                        "the skin of node \"%.200s\" is ignored: its mesh does not move", name);
}

static bool shows_something(const struct mesh *mesh)
{
    for (uint32_t k = 0; k < mesh->primitives; k++)
        if (mesh->primitive[k].geometry != GLINT_NONE)
            return true;
    return false;
}

static void add_object(struct meshes *m, uint32_t node, uint32_t mesh)
{
    struct glint_gltf *g = m->g;
    const struct glint_json at = glint_gltf_item(g, GLTF_NODES, node);
    float transform[16];
    const char *name = object_name(m, node, mesh);
    struct glint_object *o = &g->scene->object[g->scene->objects];
    if (!shows_something(&m->mesh[mesh]))
        return;
    if (!glint_gltf_to_float(transform, g->node[node].world)) {
        glint_gltf_note(g, "node without volume",
                        "node \"%.200s\" is left out: its transform is singular or too large",
                        name ? name : "");
        return; // scaled to nothing: a common way to hide
    }
    o->name = glint_arena_string(&g->scene->arena, name);
    o->asset = asset_of(g, node);
    o->id = name ? glint_gltf_names_id(&g->ids[GLTF_ID_OBJECT], &g->scene->arena, name) : NULL;
    if (!o->name || !o->asset || !o->id) {
        glint_gltf_nomem(g);
        return;
    }
    note_skin(g, &at, name);
    add_instances(m, mesh, g->scene->objects++, transform);
}

// --- all of them

// The mesh that a reached node shows, or GLINT_NONE.
static uint32_t mesh_of(const struct glint_gltf *g, uint32_t node)
{
    const struct glint_json at = glint_gltf_item(g, GLTF_NODES, node);
    return glint_gltf_index(g, &at, "mesh", GLTF_MESHES);
}

// First pass over the nodes: what they show, how often each name is used, how many instances.
static bool collect(struct meshes *m, uint64_t *instances)
{
    struct glint_gltf *g = m->g;
    *instances = 0;
    for (uint32_t k = 0; k < g->reached; k++) {
        const uint32_t mesh = mesh_of(g, g->order[k]);
        if (mesh == GLINT_NONE)
            continue;
        read_mesh(m, mesh);
        *instances += m->mesh[mesh].primitives;
        const char *name = short_name(g, g->order[k], mesh);
        uint32_t *uses = name ? glint_gltf_names_at(&m->names, &g->scratch, name) : NULL;
        if (!uses)
            return glint_gltf_nomem(g);
        ++*uses;
    }
    if (*instances > MAX_INSTANCES)
        glint_fail(g->err, GLINT_E_RANGE, "/nodes", "the nodes make %llu instances; at most %u",
                   (unsigned long long)*instances, MAX_INSTANCES);
    return g->err->status == GLINT_OK;
}

static bool name_meshes(struct meshes *m)
{
    struct glint_scene *s = m->g->scene;
    s->mesh = glint_arena_array(&s->arena, m->geometries + 1, sizeof *s->mesh);
    m->g->reach = glint_arena_array(&m->g->scratch, m->geometries + 1, sizeof *m->g->reach);
    if (!s->mesh || !m->g->reach)
        return glint_gltf_nomem(m->g);
    for (uint32_t i = 0; i < m->geometries; i++) {
        s->mesh[i].id =
            glint_gltf_names_id(&m->g->ids[GLTF_ID_MESH], &s->arena, m->geometry[i].name);
        if (!s->mesh[i].id)
            return glint_gltf_nomem(m->g);
    }
    s->meshes = m->geometries;
    return true;
}

static void read_all(struct meshes *m)
{
    struct glint_gltf *g = m->g;
    uint64_t instances;
    if (!collect(m, &instances) || !name_meshes(m))
        return;
    glint_gltf_read_geometry(g, m->geometry, m->geometries);
    if (g->err->status)
        return;
    g->scene->object =
        glint_arena_array(&g->scene->arena, g->reached + 1, sizeof *g->scene->object);
    g->scene->instance =
        glint_arena_array(&g->scene->arena, instances + 1, sizeof *g->scene->instance);
    if (!g->scene->object || !g->scene->instance) {
        glint_gltf_nomem(g);
        return;
    }
    for (uint32_t k = 0; k < g->reached; k++) {
        const uint32_t mesh = mesh_of(g, g->order[k]);
        if (mesh != GLINT_NONE)
            add_object(m, g->order[k], mesh);
    }
}

void glint_gltf_read_meshes(struct glint_gltf *g)
{
    struct meshes m = {.g = g};
    m.mesh = glint_arena_array(&g->scratch, g->list[GLTF_MESHES].count + 1, sizeof *m.mesh);
    if (m.mesh)
        read_all(&m);
    else
        glint_gltf_nomem(g);
    glint_gltf_names_finish(&m.keys);
    glint_gltf_names_finish(&m.names);
}
