// gltf_meshes.c - which meshes the scene shows, and the objects and instances that show them.
#include "scene/gltf_file.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define MAX_INSTANCES (1u << 24)

struct mesh {
    bool read;
    uint32_t primitives, targets;
    struct glint_gltf_primitive *primitive;
};

struct meshes {
    struct glint_gltf *g;
    struct mesh *mesh; // of each glTF mesh
    struct glint_gltf_primitives all;
    struct glint_gltf_names names; // of the nodes that show a mesh -> how many have it
};

// Every primitive of a mesh morphs alike.
static bool check_targets(const struct glint_json *at, uint32_t targets)
{
    const struct glint_json list = glint_json_member(at, "targets");
    size_t length = 0;
    return glint_json_length(&list, &length) &&
           (length == targets ||
            glint_json_fault(&list, "%zu morph targets; the first primitive has %u", length,
                             targets));
}

static uint32_t count_targets(const struct glint_json *list)
{
    const struct glint_json first = glint_json_item(list, list->value->child, 0);
    const struct glint_json targets = glint_json_member(&first, "targets");
    return cJSON_IsArray(targets.value) ? (uint32_t)cJSON_GetArraySize(targets.value) : 0;
}

static void read_primitives(struct meshes *m, struct mesh *mesh, uint32_t i, const char *name)
{
    const struct glint_json at = glint_gltf_item(m->g, GLTF_MESHES, i);
    const struct glint_json list = glint_json_member(&at, "primitives");
    size_t count = 0;
    glint_json_require(&list);
    glint_json_length(&list, &count);
    mesh->primitive = glint_arena_array(&m->g->scratch, count + 1, sizeof *mesh->primitive);
    if (!mesh->primitive)
        glint_gltf_nomem(m->g);
    if (!mesh->primitive || !count)
        return;
    mesh->targets = count_targets(&list);
    const float *weight = glint_gltf_weights(m->g, &at, mesh->targets);
    for (const cJSON *c = list.value->child; c; c = c->next) {
        const uint32_t k = mesh->primitives;
        const struct glint_json p = glint_json_item(&list, c, k);
        mesh->primitive[mesh->primitives++] =
            check_targets(&p, mesh->targets)
                ? glint_gltf_read_primitive(&m->all, &p, i, k, weight, name)
                : (struct glint_gltf_primitive){GLINT_NONE, GLINT_NONE};
    }
}

static void read_mesh(struct meshes *m, uint32_t i)
{
    static const char *const none[] = {NULL};
    struct mesh *mesh = &m->mesh[i];
    if (mesh->read)
        return;
    mesh->read = true;
    const struct glint_json at = glint_gltf_item(m->g, GLTF_MESHES, i);
    const char *name = glint_gltf_name(m->g, &at);
    if (!*name)
        name = glint_arena_print(&m->g->scratch, "mesh_%u", i);
    if (!name) {
        glint_gltf_nomem(m->g);
        return;
    }
    read_primitives(m, mesh, i, name);
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

// What a node shows a mesh with, besides the mesh.
struct showing {
    uint32_t node, mesh, object;
    uint32_t skin;       // of the file, or GLINT_NONE
    const float *weight; // of morph targets, or NULL: the mesh's
};

static bool check_reach(struct glint_gltf *g, const struct showing *w, uint32_t geometry,
                        const double place[16])
{
    float world[16];
    const double reach = glint_gltf_fit(world, place) ? glint_gltf_reach(world, g->reach[geometry])
                                                      : (double)INFINITY;
    if (reach <= GLINT_MAX_COORDINATE)
        return true;
    glint_fail(g->err, GLINT_E_RANGE, "/nodes",
               "node \"%.200s\" reaches to %g metres; the limit is %g",
               g->scene->object[w->object].name, reach, (double)GLINT_MAX_COORDINATE);
    return false;
}

// Bound to the joints, which say where it is.
static void bind(struct glint_gltf *g, const struct showing *w, struct glint_instance *in)
{
    char pointer[40];
    in->skin = g->skin[w->skin];
    const uint32_t joints = g->scene->skin[in->skin].joints;
    snprintf(pointer, sizeof pointer, "/nodes/%u/skin", w->node);
    if (g->joints[in->mesh] > joints)
        glint_fail(g->err, GLINT_E_RANGE, pointer,
                   "the mesh of node \"%.200s\" asks for joint %u; the skin has %u",
                   g->scene->object[w->object].name, g->joints[in->mesh] - 1, joints);
}

// `below` is the transform below the node, of one of its copies.
static void place(struct glint_gltf *g, const struct showing *w, const double below[16],
                  struct glint_instance *in)
{
    const struct glint_gltf_node *n = &g->node[w->node];
    double world[16];
    glint_matrix_multiply(world, n->world, below);
    if (w->skin != GLINT_NONE) {
        bind(g, w, in);
        in->node = n->weighs ? n->frame : GLINT_NONE; // whose channels morph it
        return;
    }
    if (!check_reach(g, w, in->mesh, world))
        return;
    const bool framed = n->moves || n->weighs;
    in->node = framed ? n->frame : GLINT_NONE;
    glint_gltf_fit(in->transform, framed ? below : world);
}

static void add_instance(struct meshes *m, const struct showing *w,
                         const struct glint_gltf_primitive *p, const double below[16],
                         const char *id)
{
    struct glint_gltf *g = m->g;
    struct glint_instance *in = &g->scene->instance[g->scene->instances];
    glint_instance_init(in);
    in->object = w->object;
    in->mesh = p->geometry;
    in->material = glint_gltf_material(g, p->material);
    in->weight = w->weight;
    place(g, w, below, in);
    in->id = glint_gltf_names_id(&g->ids[GLTF_ID_INSTANCE], &g->scene->arena, id);
    if (in->id)
        g->scene->instances++;
    else
        glint_gltf_nomem(g);
}

// The ids of a copy's instances start with `base`.
static void add_instances(struct meshes *m, const struct showing *w, const double below[16],
                          const char *base)
{
    const struct mesh *shown = &m->mesh[w->mesh];
    for (uint32_t k = 0; k < shown->primitives; k++) {
        char id[112];
        if (shown->primitive[k].geometry == GLINT_NONE)
            continue;
        if (shown->primitives == 1)
            snprintf(id, sizeof id, "%s", base);
        else
            snprintf(id, sizeof id, "%s.%u", base, k);
        add_instance(m, w, &shown->primitive[k], below, id);
    }
}

// Scaled to nothing: a common way to hide. What moves may grow.
static bool has_volume(struct glint_gltf *g, const struct showing *w, const double below[16])
{
    const struct glint_gltf_node *n = &g->node[w->node];
    double world[16];
    float single[16];
    glint_matrix_multiply(world, n->moves ? n->rest : n->world, below);
    if (w->skin != GLINT_NONE || glint_gltf_to_float(single, world))
        return true;
    const char *name = n->name;
    glint_gltf_note(g, "node without volume",
                    "node \"%.200s\" is left out: its transform is singular or too large",
                    *name ? name : glint_gltf_node_path(g, w->node));
    return false;
}

static const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static void add_copies(struct meshes *m, const struct showing *w, const struct glint_json *at,
                       uint32_t count)
{
    const char *base = m->g->scene->object[w->object].id;
    double(*copy)[16] = count ? glint_gltf_read_copies(m->g, at) : NULL;
    if (!count)
        add_instances(m, w, identity, base);
    for (uint32_t i = 0; copy && i < count; i++) {
        char id[96];
        snprintf(id, sizeof id, "%s.%u", base, i);
        if (has_volume(m->g, w, copy[i]))
            add_instances(m, w, copy[i], id);
    }
}

static bool shows_something(const struct mesh *mesh)
{
    for (uint32_t k = 0; k < mesh->primitives; k++)
        if (mesh->primitive[k].geometry != GLINT_NONE)
            return true;
    return false;
}

// The skin of a node, if all that it shows has joints.
static uint32_t skin_of(struct meshes *m, const struct glint_json *node, uint32_t mesh,
                        const char *name)
{
    struct glint_gltf *g = m->g;
    const uint32_t skin = glint_gltf_index(g, node, "skin", GLTF_SKINS);
    const struct mesh *shown = &m->mesh[mesh];
    for (uint32_t k = 0; skin != GLINT_NONE && k < shown->primitives; k++) {
        const uint32_t geometry = shown->primitive[k].geometry;
        if (geometry == GLINT_NONE || g->joints[geometry])
            continue;
        glint_gltf_note(g, "skin without joints",
                        "node \"%.200s\" has a skin, but its mesh has no joints: it is not bound",
                        name);
        return GLINT_NONE;
    }
    return skin;
}

// How many times a node shows its mesh, 0: once, where it is. A skin says where.
static uint32_t copies_of(struct glint_gltf *g, const struct glint_json *node, uint32_t skin,
                          const char *name)
{
    const uint32_t copies = glint_gltf_copies(g, node);
    if (!copies || skin == GLINT_NONE)
        return copies;
    glint_gltf_note(g, "copies of a skin",
                    "EXT_mesh_gpu_instancing of node \"%.200s\" is ignored: it has a skin", name);
    return 0;
}

static bool name_object(struct meshes *m, const struct showing *w, const char *name)
{
    struct glint_gltf *g = m->g;
    struct glint_object *o = &g->scene->object[w->object];
    o->name = name ? glint_arena_string(&g->scene->arena, name) : NULL;
    o->asset = asset_of(g, w->node);
    o->id = name ? glint_gltf_names_id(&g->ids[GLTF_ID_OBJECT], &g->scene->arena, name) : NULL;
    return (o->name && o->asset && o->id) || glint_gltf_nomem(g);
}

static void add_object(struct meshes *m, uint32_t node, uint32_t mesh)
{
    struct glint_gltf *g = m->g;
    const struct glint_json at = glint_gltf_item(g, GLTF_NODES, node);
    struct showing w = {.node = node, .mesh = mesh, .object = g->scene->objects};
    const char *name = object_name(m, node, mesh);
    if (!shows_something(&m->mesh[mesh]))
        return;
    w.skin = skin_of(m, &at, mesh, name ? name : "");
    const uint32_t copies = copies_of(g, &at, w.skin, name ? name : "");
    if ((!copies && !has_volume(g, &w, identity)) || !name_object(m, &w, name))
        return;
    w.weight = glint_gltf_weights(g, &at, m->mesh[mesh].targets);
    g->scene->objects++;
    add_copies(m, &w, &at, copies);
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
        const struct glint_json at = glint_gltf_item(g, GLTF_NODES, g->order[k]);
        const uint32_t copies = glint_gltf_copies(g, &at);
        *instances += (uint64_t)m->mesh[mesh].primitives * (copies ? copies : 1);
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
    s->mesh = glint_arena_array(&s->arena, m->all.geometries + 1, sizeof *s->mesh);
    m->g->reach = glint_arena_array(&m->g->scratch, m->all.geometries + 1, sizeof *m->g->reach);
    m->g->joints = glint_arena_array(&m->g->scratch, m->all.geometries + 1, sizeof *m->g->joints);
    if (!s->mesh || !m->g->reach || !m->g->joints)
        return glint_gltf_nomem(m->g);
    for (uint32_t i = 0; i < m->all.geometries; i++) {
        s->mesh[i].id =
            glint_gltf_names_id(&m->g->ids[GLTF_ID_MESH], &s->arena, m->all.geometry[i].name);
        if (!s->mesh[i].id)
            return glint_gltf_nomem(m->g);
    }
    s->meshes = m->all.geometries;
    return true;
}

static void read_all(struct meshes *m)
{
    struct glint_gltf *g = m->g;
    uint64_t instances;
    if (!collect(m, &instances) || !name_meshes(m))
        return;
    glint_gltf_read_geometry(g, m->all.geometry, m->all.geometries);
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
    struct meshes m = {.g = g, .all = {.g = g}};
    m.mesh = glint_arena_array(&g->scratch, g->list[GLTF_MESHES].count + 1, sizeof *m.mesh);
    if (m.mesh)
        read_all(&m);
    else
        glint_gltf_nomem(g);
    glint_gltf_names_finish(&m.all.keys);
    glint_gltf_names_finish(&m.names);
}
