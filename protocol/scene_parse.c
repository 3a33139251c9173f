// scene_parse.c - the native JSON as a whole: collections, references, assets.
//
// Collections are read in the order in which they refer to each other. A fault leaves its item with
// defaults and the reading goes on, so that all faults are named; the scene is thrown away then.
#include "protocol/scene_parts.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

// Inline arrays make up most of the values; what is larger belongs into an asset.
static const char *const lists[] = {"positions", "normals", "uvs",    "tangents",
                                    "uvs1",      "colors",  "joints", "weights",
                                    "indices",   "times",   "values", NULL};
static const struct glint_json_limits limits = {
    .bytes = (size_t)1 << 30, .depth = 16, .values = (size_t)1 << 23, .lists = lists};

// How often assets may be walked, and bytes that nobody counts.
#define MOST_TIMES 4
#define FREE_BYTES (1ull << 30)

bool glint_scene_no_memory(struct glint_scene_reader *r)
{
    glint_fail(r->err, GLINT_E_NOMEM, "", "no memory for the scene");
    return false;
}

// ---- assets

static bool index_assets(struct glint_scene_reader *r, const struct glint_asset *asset,
                         size_t assets)
{
    r->asset = asset;
    r->budget = FREE_BYTES;
    for (size_t i = 0; i < assets; i++)
        if (!glint_hashes_add(&r->assets, asset[i].sha256, (uint32_t)i))
            return glint_scene_no_memory(r);
    for (size_t i = 0; i < assets; i++)
        r->budget += MOST_TIMES * (uint64_t)asset[i].size;
    return true;
}

static bool is_hash(const char *text)
{
    return strlen(text) == 64 && strspn(text, "0123456789abcdef") == 64;
}

static const struct glint_asset *find_asset(const struct glint_scene_reader *r, const char *hash)
{
    const uint32_t i = glint_hashes_find(&r->assets, hash);
    return i != GLINT_NONE && strcmp(r->asset[i].sha256, hash) == 0 ? &r->asset[i] : NULL;
}

static const void *aligned(struct glint_scene_reader *r, const struct glint_asset *asset)
{
    if ((uintptr_t)asset->bytes % 4 == 0)
        return asset->bytes;
    void *copy = glint_arena_alloc(&r->scene->arena, asset->size);
    if (!copy) {
        glint_scene_no_memory(r);
        return NULL;
    }
    return memcpy(copy, asset->bytes, asset->size);
}

const void *glint_scene_asset(struct glint_scene_reader *r, const struct glint_json *at,
                              uint64_t bytes, char *hash)
{
    const char *text = cJSON_GetStringValue(at->value);
    if (!text || !is_hash(text)) {
        glint_json_fault(at, "64 lower-case hexadecimal digits of a SHA-256 are expected");
        return NULL;
    }
    const struct glint_asset *asset = find_asset(r, text);
    if (!asset) {
        glint_json_fault(at, "no asset %s is there", text);
        return NULL;
    }
    if (asset->size != bytes) {
        glint_json_fault(at, "the asset has %zu bytes; what is said of it makes %llu", asset->size,
                         (unsigned long long)bytes);
        return NULL;
    }
    memcpy(hash, text, 65);
    return aligned(r, asset);
}

bool glint_scene_charge(struct glint_scene_reader *r, const struct glint_json *at, uint64_t bytes)
{
    if (bytes > r->budget)
        return glint_json_fault(at,
                                "the same assets are named so often that they would have to be "
                                "checked more than %d times over",
                                MOST_TIMES);
    r->budget -= bytes;
    return true;
}

// ---- references and collections

uint32_t glint_scene_reference(const struct glint_json *at, const struct glint_ids *ids,
                               const char *what)
{
    if (!at->value)
        return GLINT_NONE;
    const char *id = cJSON_GetStringValue(at->value);
    const uint32_t index = id ? glint_ids_find(ids, id) : GLINT_NONE;
    if (index == GLINT_NONE && id)
        glint_json_fault(at, "no %s has the id \"%.80s\"", what, id);
    else if (index == GLINT_NONE)
        glint_json_fault(at, "the id of the %s is expected, a string", what);
    return index;
}

static bool check_id(const struct glint_json *at)
{
    return at->key[0] || glint_json_fault(at, "an id must not be empty");
}

void *glint_collection_read(struct glint_scene_reader *r, const struct glint_json *at,
                            size_t item_bytes, glint_read_item *read, uint32_t extra,
                            uint32_t *count)
{
    *count = 0;
    if (at->value && !cJSON_IsObject(at->value)) {
        glint_json_fault(at, "an object keyed by ids is expected");
        return NULL;
    }
    size_t n = 0;
    for (const cJSON *m = at->value ? at->value->child : NULL; m; m = m->next)
        n++;
    char *items = glint_arena_array(&r->scene->arena, n + extra, item_bytes);
    if (!items) {
        glint_scene_no_memory(r);
        return NULL;
    }
    for (const cJSON *m = at->value ? at->value->child : NULL; m; m = m->next, ++*count) {
        const struct glint_json item = glint_json_item(at, m, 0);
        void *out = items + *count * item_bytes;
        char *id = glint_arena_string(&r->scene->arena, m->string);
        if (!id)
            glint_scene_no_memory(r);
        memcpy(out, &id, sizeof id);
        if (id && check_id(&item))
            read(r, &item, out);
    }
    return items;
}

// ---- one reader for each collection

#define READER(ITEM)                                                                              \
    static void read_##ITEM(struct glint_scene_reader *r, const struct glint_json *at, void *out) \
    {                                                                                             \
        glint_##ITEM##_read(r, at, out);                                                          \
    }
READER(image)
READER(material)
READER(mesh)
READER(node)
READER(skin)
READER(instance)
READER(animation)
READER(light)
READER(medium)

static void read_camera(struct glint_scene_reader *r, const struct glint_json *at, void *out)
{
    const char *id = ((struct glint_camera *)out)->id;
    glint_camera_read(at, id, &r->nodes, &r->scene->arena, out);
}

static void read_object(struct glint_scene_reader *r, const struct glint_json *at, void *out)
{
    struct glint_object *o = out;
    o->name = o->id;
    o->asset = glint_arena_string(&r->scene->arena, "");
    glint_fields_read(at, glint_object_fields, &r->scene->arena, o);
    if (!o->asset)
        glint_scene_no_memory(r);
}

// ---- the whole

static bool index_ids(struct glint_scene_reader *r, const struct glint_json *root)
{
    const struct {
        const char *name;
        struct glint_ids *ids;
    } all[] = {{"images", &r->images},   {"materials", &r->materials}, {"meshes", &r->meshes},
               {"objects", &r->objects}, {"nodes", &r->nodes},         {"skins", &r->skins}};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        const struct glint_json at = glint_json_member(root, all[i].name);
        const cJSON *collection = cJSON_IsObject(at.value) ? at.value : NULL;
        if (!glint_ids_index(all[i].ids, collection, &r->scratch))
            return glint_scene_no_memory(r);
    }
    return true;
}

static uint32_t members(const struct glint_json *root, const char *name)
{
    const struct glint_json at = glint_json_member(root, name);
    return cJSON_IsObject(at.value) ? (uint32_t)cJSON_GetArraySize(at.value) : 0;
}

static void check_parents(struct glint_scene_reader *r, const struct glint_json *root)
{
    const struct glint_json nodes = glint_json_member(root, "nodes");
    struct glint_node_order all;
    if (!glint_nodes_order(r->scene, &r->scratch, &all)) {
        glint_scene_no_memory(r);
        return;
    }
    for (uint32_t i = 0; i < all.loops; i++) {
        const struct glint_json node = glint_json_member(&nodes, r->scene->node[all.loop[i]].id);
        const struct glint_json parent = glint_json_member(&node, "parent");
        glint_json_fault(&parent, "the node is above itself: its parents lead back to it");
    }
}

// The items of a collection of the scene, into its array and count.
#define READ(MEMBER, COUNT, ITEM, EXTRA)                                                       \
    do {                                                                                       \
        const struct glint_json list = glint_json_member(root, #COUNT);                        \
        s->MEMBER =                                                                            \
            glint_collection_read(r, &list, sizeof *s->MEMBER, read_##ITEM, EXTRA, &s->COUNT); \
    } while (0)

static void read_things(struct glint_scene_reader *r, const struct glint_json *root)
{
    struct glint_scene *s = r->scene;
    READ(image, images, image, 0);
    READ(material, materials, material, 0);
    READ(mesh, meshes, mesh, 0);
    READ(object, objects, object, members(root, "instances"));
    READ(node, nodes, node, 0);
    if (s->node)
        check_parents(r, root);
    READ(skin, skins, skin, 0);
    READ(light, lights, light, 0);
    READ(camera, cameras, camera, 0);
    READ(medium, media, medium, 0);
    if (s->object) // new objects have room there
        READ(instance, instances, instance, 0);
    if (s->node && s->mesh && glint_animations_prepare(r))
        READ(animation, animations, animation, 0);
}

static void read_all(struct glint_scene_reader *r, const struct glint_json *root)
{
    struct glint_scene *s = r->scene;
    const struct glint_json environment = glint_json_member(root, "environment");
    s->fps = GLINT_DEFAULT_FPS;
    glint_fields_read(root, glint_scene_fields, &s->arena, s);
    read_things(r, root);
    s->has_environment = environment.value != NULL;
    if (environment.value)
        glint_environment_read(r, &environment, &s->environment);
    if (!r->err->status)
        glint_scene_check_reach(r, root);
}

static glint_status finish(struct glint_scene *scene, const struct glint_error *faults,
                           struct glint_error *err)
{
    for (size_t i = 0; i < faults->count; i++)
        glint_fail(err, faults->status, faults->fault[i].pointer, "%s", faults->fault[i].detail);
    if (faults->status)
        return faults->status;
    if (!scene->instances)
        glint_scene_warn(scene, "the scene is empty: it has no instances");
    return glint_scene_complete(scene, err);
}

static glint_status read_tree(struct glint_scene *scene, const cJSON *tree,
                              const struct glint_asset *asset, size_t assets,
                              const struct glint_scene *checked, struct glint_error *err)
{
    struct glint_error faults = {0}; // of this parse alone, whatever `err` holds already
    struct glint_scene_reader r = {.scene = scene, .err = &faults, .trust.scene = checked};
    const struct glint_json root = glint_json_root(tree, &faults);
    if (index_assets(&r, asset, assets) && index_ids(&r, &root))
        read_all(&r, &root);
    glint_arena_finish(&r.scratch);
    glint_hashes_finish(&r.assets);
    glint_trust_finish(&r.trust);
    const glint_status status = finish(scene, &faults, err);
    glint_error_finish(&faults);
    return status;
}

static glint_status parse_tree(struct glint_scene **out, const cJSON *tree,
                               const struct glint_asset *asset, size_t assets,
                               const struct glint_scene *checked, struct glint_error *err)
{
    struct glint_scene *scene = calloc(1, sizeof *scene);
    const glint_status status = scene ? read_tree(scene, tree, asset, assets, checked, err)
                                      : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a scene");
    if (status)
        glint_scene_destroy(&scene);
    *out = scene;
    return status;
}

glint_status glint_scene_parse_tree(struct glint_scene **out, const cJSON *tree,
                                    const struct glint_asset *asset, size_t assets,
                                    struct glint_error *err)
{
    assert(out && tree);
    return parse_tree(out, tree, asset, assets, NULL, err);
}

glint_status glint_scene_parse_from(struct glint_scene **out, const char *text, size_t length,
                                    const struct glint_asset *asset, size_t assets,
                                    const struct glint_scene *checked, struct glint_error *err)
{
    assert(out && text);
    *out = NULL;
    cJSON *tree;
    glint_status status = glint_scene_parse_text(&tree, text, length, err);
    if (status)
        return status;
    status = parse_tree(out, tree, asset, assets, checked, err);
    cJSON_Delete(tree);
    return status;
}

glint_status glint_scene_parse(struct glint_scene **out, const char *text, size_t length,
                               const struct glint_asset *asset, size_t assets,
                               struct glint_error *err)
{
    return glint_scene_parse_from(out, text, length, asset, assets, NULL, err);
}

glint_status glint_scene_parse_text(cJSON **out, const char *text, size_t length,
                                    struct glint_error *err)
{
    return glint_json_parse(out, text, length, &limits, err);
}
