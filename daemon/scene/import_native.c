// import_native.c - native scenes: pictures in data URIs become assets before the parse.
#include "protocol/json.h"
#include "scene/data_uri.h"
#include "scene/image_decode.h"
#include "scene/import_child.h"
#include "scene/sha256.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct glint_json_limits limits = {
    .bytes = (size_t)1 << 30, .depth = 16, .values = (size_t)1 << 23};

struct pictures {
    struct glint_asset **asset;
    size_t *assets;
    struct glint_arena *arena;
    struct glint_error *err;
};

// "/images/ID/data" with the id escaped (RFC 6901).
static void pointer_to(char *out, size_t capacity, const char *id)
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
    snprintf(out + n, capacity - n, "/data");
}

static bool add_asset(struct pictures *p, const struct glint_pixels *pixels, char hex[65])
{
    struct glint_asset *more = realloc(*p->asset, (*p->assets + 1) * sizeof *more);
    if (!more) {
        glint_fail(p->err, GLINT_E_NOMEM, "", "no memory for an asset");
        return false;
    }
    *p->asset = more;
    struct glint_asset *a = &more[*p->assets];
    a->bytes = pixels->pixels;
    a->size = pixels->bytes;
    glint_sha256(a->bytes, a->size, a->sha256);
    memcpy(hex, a->sha256, 65);
    ++*p->assets;
    return true;
}

static bool decode(struct pictures *p, const char *uri, const char *pointer,
                   struct glint_pixels *out)
{
    uint8_t *bytes = NULL;
    size_t size;
    if (glint_data_uri_decode(uri, &bytes, &size, pointer, p->err))
        return false;
    const glint_status st = glint_image_decode(out, p->arena, bytes, size, pointer, p->err);
    free(bytes);
    return st == GLINT_OK;
}

// {"data": URI} becomes {"asset", "width", "height", "format"}; other members stay, for the parser
// to judge.
static void replace(struct pictures *p, cJSON *image)
{
    char pointer[512], hex[65];
    struct glint_pixels pixels;
    const cJSON *data = cJSON_GetObjectItemCaseSensitive(image, "data");
    if (!cJSON_IsString(data))
        return;
    pointer_to(pointer, sizeof pointer, image->string);
    if (cJSON_GetObjectItemCaseSensitive(image, "asset")) {
        glint_fail(p->err, GLINT_E_RANGE, pointer, "an image has either data or an asset");
        return;
    }
    if (!decode(p, data->valuestring, pointer, &pixels) || !add_asset(p, &pixels, hex))
        return;
    cJSON_DeleteItemFromObjectCaseSensitive(image, "data");
    const char *format = pixels.format == GLINT_IMAGE_RGBA8 ? "rgba8" : "rgba16f";
    if (!cJSON_AddStringToObject(image, "asset", hex) ||
        !cJSON_AddNumberToObject(image, "width", pixels.width) ||
        !cJSON_AddNumberToObject(image, "height", pixels.height) ||
        !cJSON_AddStringToObject(image, "format", format))
        glint_fail(p->err, GLINT_E_NOMEM, "", "no memory for an image");
}

// The text with its pictures replaced, malloc'd; NULL after a fault.
static char *with_assets(struct pictures *p, const char *text, size_t length)
{
    cJSON *tree = NULL;
    char *out = NULL;
    if (glint_json_parse(&tree, text, length, &limits, p->err))
        return NULL;
    cJSON *images = cJSON_GetObjectItemCaseSensitive(tree, "images");
    for (cJSON *i = cJSON_IsObject(images) ? images->child : NULL; i; i = i->next)
        if (cJSON_IsObject(i))
            replace(p, i);
    if (!p->err->status) {
        out = cJSON_PrintUnformatted(tree);
        if (!out)
            glint_fail(p->err, GLINT_E_NOMEM, "", "no memory for the text");
    }
    cJSON_Delete(tree);
    return out;
}

glint_status glint_import_native(const uint8_t *bytes, size_t size, struct glint_scene **scene,
                                 struct glint_asset **asset, size_t *assets,
                                 struct glint_arena *arena, struct glint_error *err)
{
    const char *text = (const char *)bytes;
    char *replaced = NULL;
    *scene = NULL;
    if (memmem(text, size, "\"data\"", 6)) {
        struct pictures p = {asset, assets, arena, err};
        replaced = with_assets(&p, text, size);
        if (!replaced)
            return err->status;
        text = replaced;
        size = strlen(replaced);
    }
    const glint_status st = glint_scene_parse(scene, text, size, *asset, *assets, err);
    free(replaced);
    return st;
}
