// scene_parse.c - the native JSON as a whole: collections, references, assets.
//
// Collections are read in the order in which they refer to each other. A fault leaves its item with
// defaults and the reading goes on, so that all faults are named; the scene is thrown away then.
#include "protocol/scene_parts.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

// Inline arrays make up most of the values; what is larger belongs into an asset.
static const struct glint_json_limits limits = {
    .bytes = (size_t)1 << 30, .depth = 16, .values = (size_t)1 << 23};

bool glint_scene_no_memory(struct glint_scene_reader *r)
{
    glint_fail(r->err, GLINT_E_NOMEM, "", "no memory for the scene");
    return false;
}

// ---- assets

static int by_hash(const void *a, const void *b)
{
    return strcmp((*(const struct glint_asset *const *)a)->sha256,
                  (*(const struct glint_asset *const *)b)->sha256);
}

static bool sort_assets(struct glint_scene_reader *r, const struct glint_asset *asset,
                        size_t assets)
{
    r->asset = glint_arena_array(&r->scratch, assets, sizeof *r->asset);
    if (!r->asset)
        return glint_scene_no_memory(r);
    for (size_t i = 0; i < assets; i++)
        r->asset[i] = &asset[i];
    r->assets = assets;
    qsort(r->asset, assets, sizeof *r->asset, by_hash);
    return true;
}

static bool is_hash(const char *text)
{
    return strlen(text) == 64 && strspn(text, "0123456789abcdef") == 64;
}

static const struct glint_asset *find_asset(const struct glint_scene_reader *r, const char *hash)
{
    struct glint_asset key;
    memcpy(key.sha256, hash, sizeof key.sha256);
    const struct glint_asset *wanted = &key;
    const struct glint_asset *const *found =
        bsearch(&wanted, r->asset, r->assets, sizeof *r->asset, by_hash);
    return found ? *found : NULL;
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

typedef void read_item(struct glint_scene_reader *r, const struct glint_json *at, void *out);

struct collection {
    const char *name;
    size_t item_bytes; // each item begins with its id
    read_item *read;
};

static bool check_id(const struct glint_json *at)
{
    return at->key[0] || glint_json_fault(at, "an id must not be empty");
}

// Allocates `extra` more items than the document has. *count grows with each that was read.
static void *read_collection(struct glint_scene_reader *r, const struct glint_json *root,
                             const struct collection *c, uint32_t extra, uint32_t *count)
{
    const struct glint_json at = glint_json_member(root, c->name);
    *count = 0;
    if (at.value && !cJSON_IsObject(at.value)) {
        glint_json_fault(&at, "an object keyed by ids is expected");
        return NULL;
    }
    size_t n = 0;
    for (const cJSON *m = at.value ? at.value->child : NULL; m; m = m->next)
        n++;
    char *items = glint_arena_array(&r->scene->arena, n + extra, c->item_bytes);
    if (!items) {
        glint_scene_no_memory(r);
        return NULL;
    }
    for (const cJSON *m = at.value ? at.value->child : NULL; m; m = m->next, ++*count) {
        const struct glint_json item = glint_json_item(&at, m, 0);
        void *out = items + *count * c->item_bytes;
        char *id = glint_arena_string(&r->scene->arena, m->string);
        if (!id)
            glint_scene_no_memory(r);
        memcpy(out, &id, sizeof id);
        if (id && check_id(&item))
            c->read(r, &item, out);
    }
    return items;
}

// ---- one reader for each collection

static void read_image(struct glint_scene_reader *r, const struct glint_json *at, void *out)
{
    glint_image_read(r, at, out);
}

static void read_material(struct glint_scene_reader *r, const struct glint_json *at, void *out)
{
    glint_material_read(r, at, out);
}

static void read_mesh(struct glint_scene_reader *r, const struct glint_json *at, void *out)
{
    glint_mesh_read(r, at, out, &r->reach[r->scene->meshes]); // read so far
}

static void read_light(struct glint_scene_reader *r, const struct glint_json *at, void *out)
{
    glint_light_read(r, at, out);
}

static void read_camera(struct glint_scene_reader *r, const struct glint_json *at, void *out)
{
    glint_camera_read(at, ((struct glint_camera *)out)->id, &r->scene->arena, out);
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

// The object that the instance names, one with the instance's id, or a new one of that id.
static uint32_t object_of(struct glint_scene_reader *r, const struct glint_json *at,
                          const struct glint_instance *in)
{
    const struct glint_json named = glint_json_member(at, "object");
    if (named.value)
        return glint_scene_reference(&named, &r->objects, "object");
    const uint32_t same = glint_ids_find(&r->objects, in->id);
    if (same != GLINT_NONE)
        return same;
    struct glint_object *o = &r->scene->object[r->scene->objects];
    *o = (struct glint_object){in->id, in->id, glint_arena_string(&r->scene->arena, "")};
    if (!o->asset)
        glint_scene_no_memory(r);
    return r->scene->objects++;
}

static void read_instance(struct glint_scene_reader *r, const struct glint_json *at, void *out)
{
    struct glint_instance *in = out;
    const struct glint_json mesh = glint_json_member(at, "mesh");
    const struct glint_json material = glint_json_member(at, "material");
    const struct glint_json transform = glint_json_member(at, "transform");
    in->visible = true;
    in->mesh = in->material = GLINT_NONE;
    memcpy(in->transform, glint_identity, sizeof in->transform);
    glint_fields_read(at, glint_instance_fields, &r->scene->arena, in);
    if (glint_json_require(&mesh))
        in->mesh = glint_scene_reference(&mesh, &r->meshes, "mesh");
    if (glint_json_require(&material))
        in->material = glint_scene_reference(&material, &r->materials, "material");
    in->object = object_of(r, at, in);
    if (!glint_transform_read(&transform, in->transform) || in->mesh >= r->scene->meshes)
        return;
    const double reach = glint_transform_reach(in->transform, r->reach[in->mesh]);
    if (reach > GLINT_MAX_COORDINATE)
        glint_json_fault(at, "the instance reaches to %g metres; the limit is %g", reach,
                         GLINT_MAX_COORDINATE);
}

// ---- the whole

static bool index_ids(struct glint_scene_reader *r, const struct glint_json *root)
{
    const struct {
        const char *name;
        struct glint_ids *ids;
    } all[] = {{"images", &r->images},
               {"materials", &r->materials},
               {"meshes", &r->meshes},
               {"objects", &r->objects}};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        const struct glint_json at = glint_json_member(root, all[i].name);
        const cJSON *collection = cJSON_IsObject(at.value) ? at.value : NULL;
        if (!glint_ids_index(all[i].ids, collection, &r->scratch))
            return glint_scene_no_memory(r);
    }
    r->reach = glint_arena_array(&r->scratch, r->meshes.count, sizeof *r->reach);
    return r->reach || glint_scene_no_memory(r);
}

static uint32_t members(const struct glint_json *root, const char *name)
{
    const struct glint_json at = glint_json_member(root, name);
    return cJSON_IsObject(at.value) ? (uint32_t)cJSON_GetArraySize(at.value) : 0;
}

#define COLLECTION(NAME, ITEM) \
    (&(const struct collection){NAME, sizeof(struct glint_##ITEM), read_##ITEM})

static void read_all(struct glint_scene_reader *r, const struct glint_json *root)
{
    static const char *const known[] = {"images",  "materials",   "meshes",
                                        "objects", "instances",   "lights",
                                        "cameras", "environment", NULL};
    struct glint_scene *s = r->scene;
    const struct glint_json environment = glint_json_member(root, "environment");
    glint_json_only(root, known);
    s->image = read_collection(r, root, COLLECTION("images", image), 0, &s->images);
    s->material = read_collection(r, root, COLLECTION("materials", material), 0, &s->materials);
    s->mesh = read_collection(r, root, COLLECTION("meshes", mesh), 0, &s->meshes);
    s->object = read_collection(r, root, COLLECTION("objects", object), members(root, "instances"),
                                &s->objects);
    s->light = read_collection(r, root, COLLECTION("lights", light), 0, &s->lights);
    s->camera = read_collection(r, root, COLLECTION("cameras", camera), 0, &s->cameras);
    if (s->object) // new objects have room there
        s->instance = read_collection(r, root, COLLECTION("instances", instance), 0, &s->instances);
    s->has_environment = environment.value != NULL;
    if (environment.value)
        glint_environment_read(r, &environment, &s->environment);
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
                              struct glint_error *err)
{
    struct glint_error faults = {0}; // of this parse alone, whatever `err` holds already
    struct glint_scene_reader r = {.scene = scene, .err = &faults};
    const struct glint_json root = glint_json_root(tree, &faults);
    if (sort_assets(&r, asset, assets) && index_ids(&r, &root))
        read_all(&r, &root);
    glint_arena_finish(&r.scratch);
    const glint_status status = finish(scene, &faults, err);
    glint_error_finish(&faults);
    return status;
}

glint_status glint_scene_parse(struct glint_scene **out, const char *text, size_t length,
                               const struct glint_asset *asset, size_t assets,
                               struct glint_error *err)
{
    assert(out && text);
    *out = NULL;
    cJSON *tree;
    glint_status status = glint_json_parse(&tree, text, length, &limits, err);
    if (status)
        return status;
    struct glint_scene *scene = calloc(1, sizeof *scene);
    status = scene ? read_tree(scene, tree, asset, assets, err)
                   : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a scene");
    cJSON_Delete(tree);
    if (status)
        glint_scene_destroy(&scene);
    *out = scene;
    return status;
}
