// gltf_container.c - the GLB header and its chunks.
//
// Source: glTF 2.0, "GLB File Format Specification".
#include "scene/gltf_file.h"

#include <string.h>

#define MAGIC 0x46546c67u // "glTF"
#define CHUNK_JSON 0x4e4f534au
#define CHUNK_BIN 0x004e4942u

static uint32_t u32(const uint8_t *p)
{
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static glint_status check_header(struct glint_gltf *g, const uint8_t *bytes, size_t size)
{
    if (size < 12)
        return glint_fail(g->err, GLINT_E_SYNTAX, "",
                          "the file ends inside the GLB header: %zu of 12 bytes", size);
    if (u32(bytes) != MAGIC)
        return glint_fail(g->err, GLINT_E_SYNTAX, "", "the file does not start with \"glTF\"");
    if (u32(bytes + 4) != 2)
        return glint_fail(g->err, GLINT_E_SYNTAX, "", "the GLB version is %u, not 2",
                          u32(bytes + 4));
    if (u32(bytes + 8) < 12 || u32(bytes + 8) > size)
        return glint_fail(g->err, GLINT_E_SYNTAX, "",
                          "the GLB header says %u bytes, the file has %zu", u32(bytes + 8), size);
    return GLINT_OK;
}

// The chunk at *at; moves *at behind it.
static glint_status read_chunk(struct glint_gltf *g, const uint8_t *bytes, size_t size, size_t *at,
                               uint32_t *type, struct glint_gltf_span *data)
{
    if (size - *at < 8)
        return glint_fail(g->err, GLINT_E_SYNTAX, "",
                          "the file ends inside a chunk header at byte %zu", *at);
    const uint32_t length = u32(bytes + *at);
    *type = u32(bytes + *at + 4);
    if (length > size - *at - 8)
        return glint_fail(g->err, GLINT_E_SYNTAX, "",
                          "the chunk at byte %zu has a length of %u, %zu bytes are left", *at,
                          length, size - *at - 8);
    if (length % 4)
        return glint_fail(g->err, GLINT_E_SYNTAX, "",
                          "the chunk at byte %zu has a length of %u, no multiple of 4", *at,
                          length);
    *data = (struct glint_gltf_span){bytes + *at + 8, length};
    *at += 8 + (size_t)length;
    return GLINT_OK;
}

static glint_status split_glb(struct glint_gltf *g, const uint8_t *bytes, size_t size)
{
    glint_status st = check_header(g, bytes, size);
    if (st)
        return st;
    g->glb = true;
    g->trailing = size - u32(bytes + 8);
    size -= g->trailing;
    size_t at = 12;
    for (unsigned i = 0; !st && (at < size || i == 0); i++) {
        struct glint_gltf_span data = {0};
        uint32_t type = 0;
        st = read_chunk(g, bytes, size, &at, &type, &data);
        if (st)
            return st;
        if ((i == 0) != (type == CHUNK_JSON))
            return glint_fail(g->err, GLINT_E_SYNTAX, "",
                              i ? "the file has a second JSON chunk"
                                : "the first chunk of the file is not JSON");
        if (i == 0)
            g->json = data;
        else if (i == 1 && type == CHUNK_BIN)
            g->bin = data;
        else if (type == CHUNK_BIN)
            return glint_fail(g->err, GLINT_E_SYNTAX, "", "chunk %u is a BIN chunk, not the second",
                              i);
    }
    return st;
}

static bool looks_like_json(const uint8_t *bytes, size_t size)
{
    size_t i = 0;
    while (i < size && strchr(" \t\r\n", bytes[i]) && bytes[i])
        i++;
    return i < size && bytes[i] == '{';
}

glint_status glint_gltf_split(struct glint_gltf *g, const uint8_t *bytes, size_t size)
{
    if (!looks_like_json(bytes, size))
        return split_glb(g, bytes, size);
    g->json = (struct glint_gltf_span){bytes, size};
    return GLINT_OK;
}
