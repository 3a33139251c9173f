// glb_maker.c - header, JSON chunk, binary chunk.
#include "tests/unit/glb_maker.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const struct glb_quad glb_quad_data = {
    .position = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0},
    .normal = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1},
    .uv = {0, 1, 1, 1, 1, 0, 0, 0},
    .index = {0, 1, 2, 0, 2, 3},
};

static void put_u32(uint8_t *at, size_t value)
{
    for (int i = 0; i < 4; i++)
        at[i] = (uint8_t)(value >> (8 * i));
}

uint8_t *glb_make(const char *json, const void *bin, size_t bin_bytes, size_t *size)
{
    const size_t length = strlen(json), text = (length + 3) / 4 * 4;
    const size_t data = (bin_bytes + 3) / 4 * 4;
    *size = 20 + text + (bin ? 8 + data : 0);
    uint8_t *glb = calloc(1, *size);
    if (!glb)
        abort();
    memcpy(glb, "glTF", 4);
    put_u32(glb + 4, 2);
    put_u32(glb + 8, *size);
    put_u32(glb + 12, text);
    memcpy(glb + 16, "JSON", 4);
    memset(glb + 20, ' ', text);
    for (size_t i = 0; i < length; i++)
        glb[20 + i] = json[i] == '\'' ? '"' : (uint8_t)json[i];
    if (bin) {
        put_u32(glb + 20 + text, data);
        memcpy(glb + 24 + text, "BIN", 4);
        memcpy(glb + 28 + text, bin, bin_bytes);
    }
    return glb;
}

uint8_t *glb_quad(const char *rest, size_t *size)
{
    char *json;
    if (asprintf(&json, "{" GLB_QUAD ",%s}", rest) < 0)
        abort();
    uint8_t *glb = glb_make(json, &glb_quad_data, sizeof glb_quad_data, size);
    free(json);
    return glb;
}
