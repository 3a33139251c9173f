// gltf_textures.c - textures, their samplers, and the images that are in use.
#include "scene/gltf_file.h"

#include "scene/data_uri.h"
#include "scene/image_decode.h"

#include <stdio.h>
#include <stdlib.h>

#define MAX_SHIFT 1e6f // of texture coordinates, and their scale

static bool read_wrap(const struct glint_json *sampler, const char *key, enum glint_wrap *out)
{
    const struct glint_json at = glint_json_member(sampler, key);
    uint32_t mode = 10497;
    if (!glint_json_uint(&at, 0, UINT32_MAX, &mode))
        return false;
    switch (mode) {
    case 10497:
        *out = GLINT_WRAP_REPEAT;
        return true;
    case 33071:
        *out = GLINT_WRAP_CLAMP;
        return true;
    case 33648:
        *out = GLINT_WRAP_MIRROR;
        return true;
    default:
        return glint_json_fault(&at, "%u is no wrapping mode", mode);
    }
}

// Textures have one size here, so that the filters for distant ones say nothing.
static bool read_filter(const struct glint_json *sampler, enum glint_filtering *out)
{
    const struct glint_json at = glint_json_member(sampler, "magFilter");
    uint32_t filter = 9729;
    if (!glint_json_uint(&at, 0, UINT32_MAX, &filter))
        return false;
    if (filter != 9728 && filter != 9729)
        return glint_json_fault(&at, "%u is no magnification filter", filter);
    *out = filter == 9728 ? GLINT_FILTERING_NEAREST : GLINT_FILTERING_LINEAR;
    return true;
}

static bool decode(struct glint_gltf *g, uint32_t i, const uint8_t *bytes, size_t size,
                   struct glint_pixels *out)
{
    char pointer[32];
    snprintf(pointer, sizeof pointer, "/images/%u", i);
    return glint_image_decode(out, &g->scene->arena, bytes, size, pointer, g->err) == GLINT_OK;
}

static bool decode_uri(struct glint_gltf *g, uint32_t i, const struct glint_json *uri,
                       struct glint_pixels *out)
{
    char pointer[32];
    uint8_t *bytes = NULL;
    size_t size;
    snprintf(pointer, sizeof pointer, "/images/%u/uri", i);
    if (!cJSON_IsString(uri->value))
        return glint_json_fault(uri, "a string is expected");
    const struct glint_file *file = glint_files_find_uri(g->files, uri->value->valuestring);
    if (file && !glint_data_uri_is(uri->value->valuestring))
        return decode(g, i, file->bytes, file->size, out);
    if (glint_data_uri_decode(uri->value->valuestring, &bytes, &size, pointer, g->err))
        return false;
    const bool done = decode(g, i, bytes, size, out);
    free(bytes);
    return done;
}

static bool decode_image(struct glint_gltf *g, uint32_t i, struct glint_pixels *out)
{
    const struct glint_json at = glint_gltf_item(g, GLTF_IMAGES, i);
    const struct glint_json uri = glint_json_member(&at, "uri");
    if (uri.value)
        return decode_uri(g, i, &uri, out);
    const uint32_t view = glint_gltf_index(g, &at, "bufferView", GLTF_VIEWS);
    if (view == GLINT_NONE)
        return glint_json_fault(&at, "the image has no data: neither uri nor bufferView");
    if (!g->view[view].data.bytes)
        return glint_json_fault(&at, "buffer view %u has no data", view);
    return decode(g, i, g->view[view].data.bytes, g->view[view].data.size, out);
}

// The scene's image of a glTF image, decoded at the first call.
static uint32_t use_image(struct glint_gltf *g, uint32_t i)
{
    struct glint_pixels p;
    if (g->image_read[i])
        return g->image[i];
    g->image_read[i] = true;
    g->image[i] = GLINT_NONE;
    if (!decode_image(g, i, &p))
        return GLINT_NONE;
    const struct glint_json at = glint_gltf_item(g, GLTF_IMAGES, i);
    const char *name = glint_gltf_name(g, &at);
    char number[24];
    snprintf(number, sizeof number, "image_%u", i);
    struct glint_image *image = &g->scene->image[g->scene->images];
    *image = (struct glint_image){.width = p.width, .height = p.height, .format = p.format};
    image->pixels = p.pixels;
    image->id =
        glint_gltf_names_id(&g->ids[GLTF_ID_IMAGE], &g->scene->arena, *name ? name : number);
    if (!image->id)
        glint_gltf_nomem(g);
    g->image[i] = g->scene->images++;
    return g->image[i];
}

static struct glint_texture read_texture(struct glint_gltf *g, uint32_t i)
{
    static const char *const none[] = {NULL};
    const struct glint_json at = glint_gltf_item(g, GLTF_TEXTURES, i);
    struct glint_texture t;
    char number[24];
    glint_texture_init(&t);
    snprintf(number, sizeof number, "%u", i);
    glint_gltf_ignored(g, &at, "texture", number, none);
    const uint32_t sampler = glint_gltf_index(g, &at, "sampler", GLTF_SAMPLERS);
    if (sampler != GLINT_NONE) {
        const struct glint_json s = glint_gltf_item(g, GLTF_SAMPLERS, sampler);
        read_wrap(&s, "wrapS", &t.wrap_u);
        read_wrap(&s, "wrapT", &t.wrap_v);
        read_filter(&s, &t.filter);
    }
    const uint32_t image = glint_gltf_index(g, &at, "source", GLTF_IMAGES);
    if (image != GLINT_NONE)
        t.image = use_image(g, image);
    else if (!glint_json_member(&at, "source").value)
        glint_gltf_note(g, "texture without image", "texture %u has no image that can be read", i);
    return t;
}

// Where the coordinates come from: the set, and KHR_texture_transform, which may name another.
static void read_coordinates(struct glint_gltf *g, const struct glint_json *info,
                             const char *material, struct glint_texture *t)
{
    const struct glint_json set = glint_json_member(info, "texCoord");
    struct glint_json hold[2];
    uint32_t coordinates = 0;
    glint_json_uint(&set, 0, UINT32_MAX, &coordinates);
    if (glint_gltf_extension(info, "KHR_texture_transform", hold)) {
        const struct glint_json offset = glint_json_member(&hold[1], "offset");
        const struct glint_json scale = glint_json_member(&hold[1], "scale");
        const struct glint_json rotation = glint_json_member(&hold[1], "rotation");
        const struct glint_json other = glint_json_member(&hold[1], "texCoord");
        glint_json_floats(&offset, 2, -MAX_SHIFT, MAX_SHIFT, t->offset);
        glint_json_floats(&scale, 2, -MAX_SHIFT, MAX_SHIFT, t->scale);
        glint_json_float(&rotation, -MAX_SHIFT, MAX_SHIFT, &t->rotation);
        glint_json_uint(&other, 0, UINT32_MAX, &coordinates);
    }
    if (coordinates > 1)
        glint_gltf_note(g, "texture coordinates",
                        "material \"%.200s\" uses texture coordinates %u; set 0 is used instead",
                        material, coordinates);
    t->uv_set = coordinates == 1;
}

struct glint_texture glint_gltf_texture(struct glint_gltf *g, const struct glint_json *info,
                                        const char *material)
{
    static const char *const known[] = {"KHR_texture_transform", NULL};
    struct glint_texture t;
    glint_texture_init(&t);
    if (!info->value)
        return t;
    const struct glint_json index = glint_json_member(info, "index");
    glint_json_require(&index);
    const uint32_t i = glint_gltf_index(g, info, "index", GLTF_TEXTURES);
    if (i == GLINT_NONE)
        return t;
    if (!g->texture_read[i]) {
        g->texture_read[i] = true;
        g->texture[i] = read_texture(g, i);
    }
    t = g->texture[i];
    read_coordinates(g, info, material, &t);
    glint_gltf_ignored(g, info, "texture of material", material, known);
    return t;
}

struct glint_texture glint_gltf_texture_member(struct glint_gltf *g,
                                               const struct glint_json *object, const char *key,
                                               const char *material)
{
    const struct glint_json info = glint_gltf_object(object, key);
    return glint_gltf_texture(g, &info, material);
}
