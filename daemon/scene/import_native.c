// import_native.c - native scenes: pictures in data URIs become assets before the parse.
#include "base/sha256.h"
#include "scene/data_uri.h"
#include "scene/image_decode.h"
#include "scene/import_child.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// "/images/ID/MEMBER" with the id escaped (RFC 6901).
static void pointer_to(char *out, size_t capacity, const char *id, const char *member)
{
    size_t n = (size_t)snprintf(out, capacity, "/images/");
    for (; *id && n + 8 < capacity; id++) {
        if (*id == '~' || *id == '/') {
            out[n++] = '~';
            out[n++] = *id == '~' ? '0' : '1';
        } else {
            out[n++] = *id;
        }
    }
    snprintf(out + n, capacity - n, "/%s", member);
}

static bool add_asset(struct glint_import_work *w, const struct glint_pixels *pixels, char hex[65],
                      struct glint_error *err)
{
    struct glint_asset *more = realloc(w->asset, (w->assets + 1) * sizeof *more);
    if (!more) {
        glint_fail(err, GLINT_E_NOMEM, "", "no memory for an asset");
        return false;
    }
    w->asset = more;
    struct glint_asset *a = &more[w->assets];
    a->bytes = pixels->pixels;
    a->size = pixels->bytes;
    glint_sha256(a->bytes, a->size, a->sha256);
    memcpy(hex, a->sha256, 65);
    w->assets++;
    return true;
}

static bool decode_uri(struct glint_import_work *w, const char *uri, const char *pointer,
                       struct glint_pixels *out, struct glint_error *err)
{
    uint8_t *bytes = NULL;
    size_t size;
    if (glint_data_uri_decode(uri, &bytes, &size, pointer, err))
        return false;
    const glint_status st = glint_image_decode(out, &w->arena, bytes, size, pointer, err);
    free(bytes);
    return st == GLINT_OK;
}

// An asset that is a file, not pixels. One that is not there is left for the parser to refuse.
static bool decode_asset(struct glint_import_work *w, const char *name, const char *pointer,
                         struct glint_pixels *out, struct glint_error *err)
{
    for (size_t i = 0; i < w->given; i++)
        if (!strcmp(w->asset[i].sha256, name))
            return glint_image_decode(out, &w->arena, w->asset[i].bytes, w->asset[i].size, pointer,
                                      err) == GLINT_OK;
    return false;
}

static void say_pixels(cJSON *image, const struct glint_pixels *pixels, const char *hex,
                       struct glint_error *err)
{
    cJSON_DeleteItemFromObjectCaseSensitive(image, "data");
    cJSON_DeleteItemFromObjectCaseSensitive(image, "asset");
    const char *format = pixels->format == GLINT_IMAGE_RGBA8 ? "rgba8" : "rgba16f";
    if (!cJSON_AddStringToObject(image, "asset", hex) ||
        !cJSON_AddNumberToObject(image, "width", pixels->width) ||
        !cJSON_AddNumberToObject(image, "height", pixels->height) ||
        !cJSON_AddStringToObject(image, "format", format))
        glint_fail(err, GLINT_E_NOMEM, "", "no memory for an image");
}

// {"data": URI}, or {"asset": NAME} of an encoded picture, becomes {"asset", "width", "height",
// "format"}; other members stay, for the parser to judge.
static void replace(struct glint_import_work *w, cJSON *image, struct glint_error *err)
{
    char pointer[512], hex[65];
    struct glint_pixels pixels;
    const cJSON *data = cJSON_GetObjectItemCaseSensitive(image, "data");
    const cJSON *asset = cJSON_GetObjectItemCaseSensitive(image, "asset");
    pointer_to(pointer, sizeof pointer, image->string, data ? "data" : "asset");
    if (data && asset) {
        glint_fail(err, GLINT_E_RANGE, pointer, "an image has either data or an asset");
        return;
    }
    bool decoded = false;
    if (cJSON_IsString(data))
        decoded = decode_uri(w, data->valuestring, pointer, &pixels, err);
    else if (cJSON_IsString(asset) && !cJSON_GetObjectItemCaseSensitive(image, "width") &&
             !cJSON_GetObjectItemCaseSensitive(image, "height") &&
             !cJSON_GetObjectItemCaseSensitive(image, "format"))
        decoded = decode_asset(w, asset->valuestring, pointer, &pixels, err);
    if (decoded && add_asset(w, &pixels, hex, err)) {
        say_pixels(image, &pixels, hex, err);
        w->clamped += pixels.clamped;
    }
}

static void replace_all(struct glint_import_work *w, cJSON *tree, struct glint_error *err)
{
    cJSON *images = cJSON_GetObjectItemCaseSensitive(tree, "images");
    for (cJSON *i = cJSON_IsObject(images) ? images->child : NULL; i; i = i->next)
        if (cJSON_IsObject(i))
            replace(w, i, err);
}

glint_status glint_import_native(struct glint_import_work *w, struct glint_error *err)
{
    cJSON *tree;
    glint_status st = glint_scene_parse_text(&tree, (const char *)w->bytes, w->size, err);
    if (st)
        return st;
    replace_all(w, tree, err);
    st = err->status ? err->status
                     : glint_scene_parse_tree(&w->scene, tree, w->asset, w->assets, err);
    // The tree goes with the process: somebody waits for it, and a number of a mesh is a block of
    // its own (measured: a sixth of the import).
    if (!st && w->clamped)
        glint_scene_warn(w->scene,
                         "%llu values of OpenEXR pictures were negative, above 65504 or no number: "
                         "clamped",
                         (unsigned long long)w->clamped);
    return st;
}
