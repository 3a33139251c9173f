// scene_asset.c - bytes and their names; meshes and images packed into assets.
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

unsigned glint_mesh_attributes(const struct glint_mesh *m)
{
    return (m->normal ? GLINT_MESH_NORMAL : 0) | (m->uv ? GLINT_MESH_UV : 0) |
           (m->tangent ? GLINT_MESH_TANGENT : 0);
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
    p->asset[p->count++] = asset;
    return true;
}

static bool there(const struct glint_packing *p, const char *sha256)
{
    for (size_t i = 0; i < p->count; i++)
        if (memcmp(p->asset[i].sha256, sha256, 65) == 0)
            return true;
    return false;
}

// Takes the bytes.
static bool keep(struct glint_packing *p, uint8_t *bytes, size_t size, char sha256[65])
{
    struct glint_asset asset = {.bytes = bytes, .size = size};
    const bool named = glint_asset_name(bytes, size, asset.sha256);
    if (named)
        memcpy(sha256, asset.sha256, 65);
    if (named && !there(p, sha256) && append(p, asset))
        return true;
    free(bytes);
    return named && there(p, sha256);
}

static void put(uint8_t *at, const void *from, size_t count, size_t size)
{
    if (from)
        memcpy(at, from, count * size);
}

bool glint_pack_mesh(struct glint_packing *p, const struct glint_mesh *m, char sha256[65])
{
    const struct glint_mesh_layout at =
        glint_mesh_layout(m->vertices, m->triangles, glint_mesh_attributes(m));
    uint8_t *bytes = malloc(at.bytes);
    if (!bytes)
        return false;
    put(bytes, m->position, m->vertices, 3 * sizeof(float));
    put(bytes + at.normal, m->normal, m->vertices, 3 * sizeof(float));
    put(bytes + at.uv, m->uv, m->vertices, 2 * sizeof(float));
    put(bytes + at.tangent, m->tangent, m->vertices, 4 * sizeof(float));
    put(bytes + at.index, m->index, m->triangles, 3 * sizeof(uint32_t));
    return keep(p, bytes, at.bytes, sha256);
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
