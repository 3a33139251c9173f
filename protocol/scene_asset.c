// scene_asset.c - bytes and their names; long arrays packed into assets.
#include "protocol/scene_parts.h"

#include <openssl/evp.h>
#include <stdlib.h>
#include <string.h>

bool glint_asset_name(const void *bytes, size_t size, char sha256[65])
{
    static const char digit[] = "0123456789abcdef";
    unsigned char hash[EVP_MAX_MD_SIZE];
    unsigned length = 0;
    if (!EVP_Digest(bytes, size, hash, &length, EVP_sha256(), NULL) || length != 32)
        return false;
    for (unsigned i = 0; i < 32; i++) {
        sha256[2 * i] = digit[hash[i] >> 4];
        sha256[2 * i + 1] = digit[hash[i] & 15];
    }
    sha256[64] = '\0';
    return true;
}

bool glint_packing_start(struct glint_packing *p, struct glint_asset *asset, size_t count)
{
    *p = (struct glint_packing){.asset = asset, .count = count, .capacity = count};
    for (size_t i = 0; i < count; i++)
        if (!glint_hashes_add(&p->there, asset[i].sha256, (uint32_t)i))
            return false;
    return true;
}

static bool append(struct glint_packing *p, struct glint_asset asset)
{
    if (p->count == p->capacity) {
        const size_t capacity = p->capacity ? 2 * p->capacity : 16;
        struct glint_asset *more = realloc(p->asset, capacity * sizeof *more);
        if (!more)
            return false;
        p->asset = more;
        p->capacity = capacity;
    }
    if (!glint_hashes_add(&p->there, asset.sha256, (uint32_t)p->count))
        return false;
    p->asset[p->count++] = asset;
    return true;
}

// Takes the bytes.
static bool keep(struct glint_packing *p, uint8_t *bytes, size_t size, char sha256[65])
{
    struct glint_asset asset = {.bytes = bytes, .size = size};
    const bool named = glint_asset_name(bytes, size, asset.sha256);
    const bool there = named && glint_hashes_find(&p->there, asset.sha256) != GLINT_NONE;
    if (named)
        memcpy(sha256, asset.sha256, 65);
    if (named && !there && append(p, asset))
        return true;
    free(bytes);
    return there;
}

bool glint_pack_mesh(struct glint_packing *p, const struct glint_mesh *m, char sha256[65])
{
    const struct glint_mesh_layout layout = glint_mesh_layout(m, glint_mesh_attributes(m));
    uint8_t *bytes = malloc(layout.bytes);
    if (!bytes)
        return false;
    for (size_t i = 0; i < GLINT_MESH_ARRAYS; i++)
        if (layout.size[i])
            memcpy(bytes + layout.at[i], glint_mesh_array(m, i), layout.size[i]);
    return keep(p, bytes, layout.bytes, sha256);
}

bool glint_pack_image(struct glint_packing *p, const struct glint_image *image, char sha256[65])
{
    const size_t size =
        (size_t)image->width * image->height * (image->format == GLINT_IMAGE_RGBA8 ? 4 : 8);
    uint8_t *bytes = malloc(size);
    if (!bytes)
        return false;
    memcpy(bytes, image->pixels, size);
    return keep(p, bytes, size, sha256);
}

static bool pack_floats(struct glint_packing *p, const float *first, size_t firsts,
                        const float *second, size_t seconds, char sha256[65])
{
    const size_t size = (firsts + seconds) * sizeof(float);
    uint8_t *bytes = malloc(size);
    if (!bytes)
        return false;
    memcpy(bytes, first, firsts * sizeof(float));
    if (seconds)
        memcpy(bytes + firsts * sizeof(float), second, seconds * sizeof(float));
    return keep(p, bytes, size, sha256);
}

bool glint_pack_skin(struct glint_packing *p, const struct glint_skin *skin, char sha256[65])
{
    return pack_floats(p, skin->inverse_bind, (size_t)skin->joints * 16, NULL, 0, sha256);
}

bool glint_pack_channel(struct glint_packing *p, const struct glint_animation_channel *channel,
                        char sha256[65])
{
    return pack_floats(p, channel->time, channel->keys, channel->value,
                       glint_channel_values(channel), sha256);
}
