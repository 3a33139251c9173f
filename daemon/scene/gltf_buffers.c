// gltf_buffers.c - buffers and the views into them.
#include "scene/gltf_file.h"

#include "scene/data_uri.h"

#include <stdio.h>

static void check_files(struct glint_gltf *g, enum glint_gltf_kind kind)
{
    for (uint32_t i = 0; i < g->list[kind].count; i++) {
        const struct glint_json at = glint_gltf_item(g, kind, i);
        const struct glint_json uri = glint_json_member(&at, "uri");
        const char *text = cJSON_IsString(uri.value) ? uri.value->valuestring : NULL;
        if (!text || glint_data_uri_is(text) || glint_files_find_uri(g->files, text))
            continue;
        if (g->files)
            glint_json_fault(&uri, "\"%.80s\" is not among the files that were sent", text);
        else
            glint_json_fault(&uri,
                             "\"%.80s\" lies outside of the file; send both as "
                             "multipart/form-data",
                             text);
    }
}

void glint_gltf_check_files(struct glint_gltf *g)
{
    check_files(g, GLTF_BUFFERS);
    check_files(g, GLTF_IMAGES);
}

// Whose data an extension unpacks; nothing here does.
static void check_compressed(const struct glint_json *buffer)
{
    static const char *const names[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};
    struct glint_json hold[2];
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (glint_gltf_extension(buffer, names[i], hold))
            glint_json_fault(
                &hold[1], "the buffer has no data but what %s packs, which is not read", names[i]);
}

// The binary chunk of a GLB is buffer 0 where that has no URI; it may be padded to a multiple of 4.
// A buffer may have no data at all, for an extension to fill: a fault only for who reads from it.
static struct glint_gltf_span find_buffer(struct glint_gltf *g, uint32_t i,
                                          const struct glint_json *at)
{
    const struct glint_json uri = glint_json_member(at, "uri");
    struct glint_gltf_span data = {0};
    if (!uri.value) {
        if (i == 0 && g->bin.bytes)
            return g->bin;
        if (i == 0 && g->glb)
            glint_json_fault(at, "the GLB has no BIN chunk");
        check_compressed(at);
    } else if (!cJSON_IsString(uri.value)) {
        glint_json_fault(&uri, "a string is expected");
    } else if (!glint_data_uri_is(uri.value->valuestring)) {
        const struct glint_file *file = glint_files_find_uri(g->files, uri.value->valuestring);
        if (file)
            data = (struct glint_gltf_span){file->bytes, file->size};
    } else {
        char pointer[48];
        snprintf(pointer, sizeof pointer, "/buffers/%u/uri", i);
        if (!glint_data_uri_decode(uri.value->valuestring, &g->decoded[i], &data.size, pointer,
                                   g->err))
            data.bytes = g->decoded[i];
    }
    return data;
}

static void read_buffer(struct glint_gltf *g, uint32_t i)
{
    const struct glint_json at = glint_gltf_item(g, GLTF_BUFFERS, i);
    const struct glint_json length = glint_json_member(&at, "byteLength");
    struct glint_gltf_span data = find_buffer(g, i, &at);
    uint32_t bytes = 0;
    if (!glint_json_require(&length) || !glint_json_uint(&length, 1, UINT32_MAX, &bytes) ||
        !data.bytes)
        return;
    if (bytes > data.size)
        glint_json_fault(&length, "%u bytes, but the data has %zu", bytes, data.size);
    else
        g->buffer[i] = (struct glint_gltf_span){data.bytes, bytes};
}

static void read_view(struct glint_gltf *g, uint32_t i)
{
    const struct glint_json at = glint_gltf_item(g, GLTF_VIEWS, i);
    const struct glint_json member = glint_json_member(&at, "buffer");
    const struct glint_json offset = glint_json_member(&at, "byteOffset");
    const struct glint_json length = glint_json_member(&at, "byteLength");
    const struct glint_json stride = glint_json_member(&at, "byteStride");
    struct glint_gltf_view *v = &g->view[i];
    uint32_t from = 0, bytes = 0;
    glint_json_require(&member);
    const uint32_t buffer = glint_gltf_index(g, &at, "buffer", GLTF_BUFFERS);
    if (!glint_json_require(&length) || !glint_json_uint(&offset, 0, UINT32_MAX, &from) ||
        !glint_json_uint(&length, 1, UINT32_MAX, &bytes) ||
        !glint_json_uint(&stride, 4, 252, &v->stride) || buffer == GLINT_NONE)
        return;
    const struct glint_gltf_span *b = &g->buffer[buffer];
    if (!b->bytes)
        return; // no data to point into
    if (from > b->size || bytes > b->size - from)
        glint_json_fault(&length, "bytes %u to %llu of a buffer of %zu", from,
                         (unsigned long long)from + bytes, b->size);
    else
        v->data = (struct glint_gltf_span){b->bytes + from, bytes};
}

void glint_gltf_read_buffers(struct glint_gltf *g)
{
    const uint32_t buffers = g->list[GLTF_BUFFERS].count, views = g->list[GLTF_VIEWS].count;
    g->buffer = glint_arena_array(&g->scratch, buffers + 1, sizeof *g->buffer);
    g->decoded = glint_arena_array(&g->scratch, buffers + 1, sizeof *g->decoded);
    g->view = glint_arena_array(&g->scratch, views + 1, sizeof *g->view);
    if (!g->buffer || !g->decoded || !g->view) {
        glint_gltf_nomem(g);
        return;
    }
    for (uint32_t i = 0; i < buffers; i++)
        read_buffer(g, i);
    for (uint32_t i = 0; i < views; i++)
        read_view(g, i);
}
