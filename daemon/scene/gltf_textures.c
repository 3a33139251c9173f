// gltf_textures.c - textures, their samplers, and the images that are in use.
#include "scene/gltf_file.h"

#include "scene/data_uri.h"
#include "scene/image_decode.h"

#include <stdio.h>
#include <stdlib.h>

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

static bool is_nearest(const struct glint_json *sampler, const char *key)
{
    const struct glint_json at = glint_json_member(sampler, key);
    uint32_t filter = 0;
    if (!glint_json_uint(&at, 0, UINT32_MAX, &filter))
        return false;
    return filter == 9728 || filter == 9984 || filter == 9986; // NEAREST, with mipmaps or without
}

// Only what is in use is looked at, and what cannot be granted is said once for each sampler.
static void note_filter(struct glint_gltf *g, uint32_t i)
{
    if (g->sampler_read[i])
        return;
    g->sampler_read[i] = true;
    const struct glint_json at = glint_gltf_item(g, GLTF_SAMPLERS, i);
    const bool magnified = is_nearest(&at, "magFilter"), minified = is_nearest(&at, "minFilter");
    if (magnified || minified)
        glint_gltf_note(
            g, "nearest filtering",
            "sampler %u asks for nearest filtering%s%s; textures are filtered bilinearly", i,
            magnified ? " (magFilter)" : "", minified ? " (minFilter)" : "");
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
    if (!glint_data_uri_is(uri->value->valuestring))
        return glint_json_fault(uri, "\"%.80s\" lies outside of the file; its data must be in it",
                                uri->value->valuestring);
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
    struct glint_texture t = {.image = GLINT_NONE};
    char number[24];
    snprintf(number, sizeof number, "%u", i);
    glint_gltf_ignored(g, &at, "texture", number, none);
    const uint32_t sampler = glint_gltf_index(g, &at, "sampler", GLTF_SAMPLERS);
    if (sampler != GLINT_NONE) {
        const struct glint_json s = glint_gltf_item(g, GLTF_SAMPLERS, sampler);
        read_wrap(&s, "wrapS", &t.wrap_u);
        read_wrap(&s, "wrapT", &t.wrap_v);
        note_filter(g, sampler);
    }
    const uint32_t image = glint_gltf_index(g, &at, "source", GLTF_IMAGES);
    if (image != GLINT_NONE)
        t.image = use_image(g, image);
    else if (!glint_json_member(&at, "source").value)
        glint_gltf_note(g, "texture without image", "texture %u has no image that can be read", i);
    return t;
}

struct glint_texture glint_gltf_texture(struct glint_gltf *g, const struct glint_json *info,
                                        const char *material)
{
    static const char *const none[] = {NULL};
    struct glint_texture t = {.image = GLINT_NONE};
    if (!info->value)
        return t;
    const struct glint_json index = glint_json_member(info, "index");
    const struct glint_json set = glint_json_member(info, "texCoord");
    uint32_t coordinates = 0;
    glint_json_require(&index);
    const uint32_t i = glint_gltf_index(g, info, "index", GLTF_TEXTURES);
    if (!glint_json_uint(&set, 0, UINT32_MAX, &coordinates) || i == GLINT_NONE)
        return t;
    if (coordinates)
        glint_gltf_note(g, "texture coordinates",
                        "material \"%.200s\" uses texture coordinates %u; set 0 is used instead",
                        material, coordinates);
    glint_gltf_ignored(g, info, "texture of material", material, none);
    if (!g->texture_read[i]) {
        g->texture_read[i] = true;
        g->texture[i] = read_texture(g, i);
    }
    return g->texture[i];
}
