#include "scene/edit.h"

#include "base/clock.h"
#include "protocol/json.h"

#include <stdlib.h>
#include <string.h>

static const struct glint_json_limits limits = {
    .bytes = (size_t)1 << 30, .depth = 16, .values = (size_t)1 << 23};

// ---- the patch

static bool merge_member(cJSON *target, const cJSON *member)
{
    const char *name = member->string;
    cJSON *old = cJSON_GetObjectItemCaseSensitive(target, name);
    if (cJSON_IsNull(member)) {
        cJSON_Delete(cJSON_DetachItemViaPointer(target, old));
        return true;
    }
    if (old && cJSON_IsObject(old) && cJSON_IsObject(member))
        return glint_edit_merge(old, member) != NULL;
    // An object that is new is merged with nothing: its nulls do not stay.
    cJSON *made = cJSON_IsObject(member) ? glint_edit_merge(cJSON_CreateObject(), member)
                                         : cJSON_Duplicate(member, true);
    if (!made)
        return false;
    return old ? cJSON_ReplaceItemInObjectCaseSensitive(target, name, made)
               : cJSON_AddItemToObject(target, name, made);
}

cJSON *glint_edit_merge(cJSON *target, const cJSON *patch)
{
    bool ok = target;
    for (const cJSON *m = patch->child; ok && m; m = m->next)
        ok = merge_member(target, m);
    return ok ? target : NULL;
}

static glint_status no_memory(struct glint_error *err)
{
    return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the edited scene");
}

// The text of the edited scene, malloc'd.
static glint_status apply(const struct glint_edit *e, const char *text, size_t length, char **out,
                          struct glint_error *err)
{
    cJSON *patch = NULL;
    *out = NULL;
    glint_status st = glint_json_parse(&patch, text, length, &limits, err);
    if (!st && !cJSON_IsObject(patch))
        st = glint_fail(err, GLINT_E_RANGE, "", "a merge patch of a scene is an object");
    if (!st) {
        // Our own text, which needs no check.
        cJSON *tree = cJSON_ParseWithLength(e->import->text, e->import->length);
        if (tree && glint_edit_merge(tree, patch))
            *out = cJSON_PrintUnformatted(tree);
        cJSON_Delete(tree);
        st = *out ? GLINT_OK : no_memory(err);
    }
    cJSON_Delete(patch);
    return st;
}

// ---- what an import would give

// A text and what it was read with.
struct told {
    const char *text;
    size_t length;
    char **warning;
    size_t warnings;
};

static size_t bytes_of(char **warning, size_t count)
{
    size_t bytes = 0;
    for (size_t i = 0; i < count; i++)
        bytes += strlen(warning[i]) + 1;
    return bytes;
}

static char *copy_warnings(struct glint_import *im, char *at, char **warning, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        im->warning[im->warnings++] = at;
        at = stpcpy(at, warning[i]) + 1;
    }
    return at;
}

// An import with a copy of the text, of the warnings of the scene before and of the new ones, in
// one block.
static struct glint_import *new_import(const struct glint_import *before, const struct told *told)
{
    const size_t bytes = told->length + 1 + bytes_of(before->warning, before->warnings) +
                         bytes_of(told->warning, told->warnings);
    struct glint_import *im = calloc(1, sizeof *im);
    char *block = malloc(bytes);
    if (im)
        im->warning = calloc(before->warnings + told->warnings + 1, sizeof *im->warning);
    if (im && im->warning && block)
        im->memory = glint_memory_ref_of_block(block, bytes);
    if (!im || !im->memory) {
        free(block);
        glint_import_destroy(&im);
        return NULL;
    }
    im->text = memcpy(block, told->text, told->length + 1);
    im->length = told->length;
    char *at = copy_warnings(im, block + told->length + 1, before->warning, before->warnings);
    copy_warnings(im, at, told->warning, told->warnings);
    return im;
}

// ---- warnings that an edit makes untrue

static bool same_environment(const struct glint_scene *a, const struct glint_scene *b)
{
    const struct glint_environment *e = &a->environment, *f = &b->environment;
    return a->has_environment == b->has_environment && e->image == f->image &&
           e->rotation == f->rotation && memcmp(e->radiance, f->radiance, sizeof e->radiance) == 0;
}

static const struct glint_camera *added_camera(const struct glint_scene *s)
{
    for (uint32_t i = 0; i < s->cameras; i++)
        if (!strcmp(s->camera[i].id, "camera"))
            return &s->camera[i];
    return NULL;
}

static bool same_camera(const struct glint_scene *a, const struct glint_scene *b)
{
    const struct glint_camera *c = added_camera(a), *d = added_camera(b);
    return c && d && c->projection == d->projection && c->node == d->node && c->yfov == d->yfov &&
           c->ymag == d->ymag && c->lens_radius == d->lens_radius &&
           c->focus_distance == d->focus_distance &&
           memcmp(c->transform, d->transform, sizeof c->transform) == 0;
}

static bool said(char **warning, size_t count, const char *text)
{
    for (size_t i = 0; i < count; i++)
        if (!strcmp(warning[i], text))
            return true;
    return false;
}

// Whether a warning of the scene before speaks of what is no more: of what glint_scene_complete added
// and the edit replaced, or of what every parse warns of, which has said it again where it is so.
static bool outdated(const struct glint_edit *e, const struct glint_scene *now, const char *warning)
{
    if (strstr(warning, GLINT_ENVIRONMENT_ADDED))
        return !same_environment(e->scene, now);
    if (strstr(warning, GLINT_CAMERA_ADDED))
        return !same_camera(e->scene, now);
    return said(e->scene->warning, e->scene->warnings, warning);
}

static void settle_warnings(const struct glint_edit *e, const struct glint_scene *now,
                            struct glint_import *im)
{
    size_t kept = 0;
    for (size_t i = 0; i < im->warnings; i++) {
        const bool old = i < e->import->warnings;
        if ((old && outdated(e, now, im->warning[i])) || said(im->warning, kept, im->warning[i]))
            continue;
        im->warning[kept++] = im->warning[i];
    }
    im->warnings = kept;
}

// ---- from a text to a scene

// Hands what the writer packed over to the store, which *set then holds as well. Takes the bytes.
static glint_status keep_packed(const struct glint_edit *e, struct glint_asset *asset, size_t count,
                                struct glint_asset_set *set, struct glint_error *err)
{
    glint_status st = GLINT_OK;
    set->ref = calloc(count + 1, sizeof *set->ref);
    if (!set->ref)
        st = no_memory(err);
    for (size_t i = 0; i < count; i++) {
        void *bytes = (void *)asset[i].bytes;
        glint_memory_ref *memory = st ? NULL : glint_memory_ref_of_block(bytes, asset[i].size);
        if (!memory) {
            free(bytes);
            st = st ? st : no_memory(err);
            continue;
        }
        st = glint_assets_add(e->assets, &asset[i], memory, &set->ref[set->count], err);
        set->count += !st;
        glint_memory_ref_release(&memory);
    }
    free(asset);
    return st;
}

// The canonical text of the edited scene; what it brought inline is in the store then, for as long
// as *packed holds it.
static glint_status canonical(const struct glint_edit *e, const struct glint_scene *scene,
                              struct glint_import **out, struct glint_asset_set *packed,
                              struct glint_error *err)
{
    char *text = NULL;
    size_t length = 0, count = 0;
    struct glint_asset *asset = NULL;
    glint_status st = glint_scene_write(scene, &text, &length, &asset, &count, err);
    if (!st)
        st = keep_packed(e, asset, count, packed, err);
    const struct told told = {text, length, scene->warning, scene->warnings};
    if (!st && !(*out = new_import(e->import, &told)))
        st = no_memory(err);
    free(text);
    return st;
}

static glint_status parse(const struct glint_edit *e, const char *text, size_t length,
                          const struct glint_asset_set *set, struct glint_scene **scene,
                          struct glint_error *err)
{
    return glint_scene_parse_from(scene, text, length, set->asset, set->count, e->scene, err);
}

// Gathers the assets of the import's text; and parses it, unless that of *scene said it all.
static glint_status settle(const struct glint_edit *e, struct glint_import *im, bool anew,
                           struct glint_scene **scene, struct glint_error *err)
{
    glint_status st = glint_assets_gather(e->assets, im->text, im->length, &im->set, err);
    im->asset = im->set.asset;
    im->assets = im->set.count;
    if (st || !anew)
        return st;
    glint_scene_destroy(scene);
    return parse(e, im->text, im->length, &im->set, scene, err);
}

static glint_status edit_here(const struct glint_edit *e, const char *text,
                              struct glint_import **import, struct glint_scene **scene,
                              struct glint_error *err)
{
    const size_t length = strlen(text);
    struct glint_asset_set named = {0}, packed = {0};
    glint_status st = glint_assets_gather(e->assets, text, length, &named, err);
    if (!st)
        st = parse(e, text, length, &named, scene, err);
    if (!st)
        st = canonical(e, *scene, import, &packed, err);
    if (!st)
        st = settle(e, *import, packed.count > 0, scene, err);
    glint_asset_set_release(&packed);
    glint_asset_set_release(&named);
    return st;
}

// Pictures are decoded where they can do no harm.
static glint_status edit_in_child(const struct glint_edit *e, const char *text,
                                  struct glint_import **import, struct glint_scene **scene,
                                  struct glint_error *err)
{
    const struct glint_import_source source = {.type = GLINT_SCENE_NATIVE,
                                               .bytes = (const uint8_t *)text,
                                               .size = strlen(text),
                                               .assets = e->assets};
    struct glint_import *child = NULL;
    glint_status st = glint_import_run(e->importer, &source, e->limits, &child, err);
    if (!st) {
        const struct told told = {child->text, child->length, child->warning, child->warnings};
        *import = new_import(e->import, &told);
        st = *import ? settle(e, *import, true, scene, err) : no_memory(err);
    }
    glint_import_destroy(&child);
    return st;
}

glint_status glint_edit_run(const struct glint_edit *e, const char *patch, size_t length,
                            struct glint_import **import, struct glint_scene **scene,
                            struct glint_error *err)
{
    const double start = glint_now();
    char *text;
    *import = NULL;
    *scene = NULL;
    glint_status st = apply(e, patch, length, &text, err);
    if (!st)
        st = memmem(patch, length, "\"images\"", 8) ? edit_in_child(e, text, import, scene, err)
                                                    : edit_here(e, text, import, scene, err);
    free(text);
    if (st) {
        glint_scene_destroy(scene);
        glint_import_destroy(import);
        return st;
    }
    settle_warnings(e, *scene, *import);
    (*import)->seconds = glint_now() - start;
    return GLINT_OK;
}
