// gltf_file.c - the JSON of a file: its lists, version and required extensions.
#include "scene/gltf_file.h"

#include <stdlib.h>
#include <string.h>

static const struct glint_json_limits limits = {
    .bytes = (size_t)512 << 20, .depth = 64, .values = 8000000};

static const char *const list_name[GLTF_KINDS] = {
    [GLTF_ACCESSORS] = "accessors", [GLTF_ANIMATIONS] = "animations", [GLTF_BUFFERS] = "buffers",
    [GLTF_VIEWS] = "bufferViews",   [GLTF_CAMERAS] = "cameras",       [GLTF_IMAGES] = "images",
    [GLTF_MATERIALS] = "materials", [GLTF_MESHES] = "meshes",         [GLTF_NODES] = "nodes",
    [GLTF_SAMPLERS] = "samplers",   [GLTF_SCENES] = "scenes",         [GLTF_SKINS] = "skins",
    [GLTF_TEXTURES] = "textures",
};

bool glint_gltf_nomem(struct glint_gltf *g)
{
    if (g->err->status != GLINT_E_NOMEM)
        glint_fail(g->err, GLINT_E_NOMEM, "", "no memory to read the glTF file");
    return false;
}

struct glint_json glint_gltf_item(const struct glint_gltf *g, enum glint_gltf_kind kind,
                                  uint32_t index)
{
    const struct glint_gltf_list *l = &g->list[kind];
    return glint_json_item(&l->at, l->item[index], index);
}

uint32_t glint_gltf_index(const struct glint_gltf *g, const struct glint_json *object,
                          const char *key, enum glint_gltf_kind kind)
{
    const struct glint_json at = glint_json_member(object, key);
    uint32_t index = GLINT_NONE;
    if (!glint_json_uint(&at, 0, GLINT_NONE - 1, &index) || index == GLINT_NONE)
        return GLINT_NONE;
    if (index < g->list[kind].count)
        return index;
    glint_json_fault(&at, "%u: the file has %u %s", index, g->list[kind].count, list_name[kind]);
    return GLINT_NONE;
}

struct glint_json glint_gltf_object(const struct glint_json *object, const char *key)
{
    struct glint_json at = glint_json_member(object, key);
    if (at.value && !cJSON_IsObject(at.value)) {
        glint_json_fault(&at, "must be an object");
        at.value = NULL;
    }
    return at;
}

bool glint_gltf_extension(const struct glint_json *object, const char *name,
                          struct glint_json hold[2])
{
    hold[0] = glint_gltf_object(object, "extensions");
    hold[1] = glint_gltf_object(&hold[0], name);
    return hold[1].value != NULL;
}

const char *glint_gltf_name(struct glint_gltf *g, const struct glint_json *object)
{
    const struct glint_json at = glint_json_member(object, "name");
    char *name = NULL;
    glint_json_string(&at, &g->scene->arena, &name);
    return name ? name : "";
}

static bool read_list(struct glint_gltf *g, enum glint_gltf_kind kind)
{
    struct glint_gltf_list *l = &g->list[kind];
    l->at = glint_json_member(&g->root, list_name[kind]);
    size_t count = 0;
    glint_json_length(&l->at, &count);
    l->item = glint_arena_array(&g->scratch, count + 1, sizeof *l->item);
    if (!l->item)
        return glint_gltf_nomem(g);
    const cJSON *child = count ? l->at.value->child : NULL;
    for (; child; child = child->next) {
        l->item[l->count] = child;
        const struct glint_json at = glint_json_item(&l->at, child, l->count++);
        if (!cJSON_IsObject(child))
            glint_json_fault(&at, "must be an object");
    }
    return true;
}

static void check_version(struct glint_gltf *g)
{
    const struct glint_json asset = glint_gltf_object(&g->root, "asset");
    if (!glint_json_require(&asset))
        return;
    const struct glint_json version = glint_json_member(&asset, "version");
    const struct glint_json minimum = glint_json_member(&asset, "minVersion");
    char *text = NULL;
    if (!glint_json_require(&version) || !glint_json_string(&version, &g->scratch, &text))
        return;
    if (strncmp(text, "2.", 2) != 0)
        glint_json_fault(&version, "\"%.20s\": only glTF 2 is read", text);
    text = NULL;
    if (!glint_json_string(&minimum, &g->scratch, &text) || !text)
        return;
    if (strncmp(text, "2.", 2) != 0)
        glint_json_fault(&minimum, "\"%.20s\": only glTF 2 is read", text);
    else if (strcmp(text, "2.0") != 0)
        g->newer = text;
}

// What a file may insist on.
static const char *const understood[] = {
    "EXT_mesh_gpu_instancing",         "KHR_lights_punctual",   "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength", "KHR_materials_ior",     "KHR_materials_specular",
    "KHR_materials_transmission",      "KHR_materials_unlit",   "KHR_materials_volume",
    "KHR_mesh_quantization",           "KHR_texture_transform", NULL,
};

static void check_required(struct glint_gltf *g)
{
    const struct glint_json list = glint_json_member(&g->root, "extensionsRequired");
    size_t count = 0, i = 0;
    glint_json_length(&list, &count);
    for (const cJSON *c = count ? list.value->child : NULL; c; c = c->next, i++) {
        const struct glint_json at = glint_json_item(&list, c, i);
        char *name = NULL;
        if (!glint_json_string(&at, &g->scratch, &name) || !name)
            continue;
        const char *const *known = understood;
        while (*known && strcmp(*known, name) != 0)
            known++;
        if (!*known)
            glint_json_fault(&at, "the file requires %s, which is not read", name);
    }
}

glint_status glint_gltf_open(struct glint_gltf *g)
{
    const glint_status st =
        glint_json_parse(&g->tree, (const char *)g->json.bytes, g->json.size, &limits, g->err);
    if (st)
        return st;
    g->root = glint_json_root(g->tree, g->err);
    if (!cJSON_IsObject(g->tree)) {
        glint_json_fault(&g->root, "must be an object");
        return g->err->status;
    }
    check_version(g);
    check_required(g);
    for (int kind = 0; kind < GLTF_KINDS; kind++)
        if (!read_list(g, (enum glint_gltf_kind)kind))
            return g->err->status;
    glint_gltf_check_files(g);
    if (!g->err->status)
        glint_gltf_read_buffers(g);
    return g->err->status;
}

void glint_gltf_close(struct glint_gltf *g)
{
    for (uint32_t i = 0; g->decoded && i < g->list[GLTF_BUFFERS].count; i++)
        free(g->decoded[i]);
    for (int i = 0; i < GLTF_ID_KINDS; i++)
        glint_gltf_names_finish(&g->ids[i]);
    glint_gltf_names_finish(&g->noted);
    cJSON_Delete(g->tree);
    glint_arena_finish(&g->scratch);
}
