#include "pack_gltf.h"
#include "uri.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define GLB_MAGIC 0x46546c67u
#define CHUNK_JSON 0x4e4f534au
#define CHUNK_BIN 0x004e4942u
#define HEADER_BYTES 12u
#define CHUNK_BYTES 8u

struct range {
    size_t base, size;
}; // of a buffer in the BIN chunk

struct packer {
    cJSON *root;
    char *directory; // real path
    uint8_t *bin;
    size_t size, capacity;
    struct range *buffer;
    size_t buffers;
    struct glint_error *err;
    glint_status status; // the first failure
};

static cJSON *member(const cJSON *object, const char *name)
{
    return cJSON_GetObjectItemCaseSensitive(object, name);
}

__attribute__((format(printf, 4, 5))) static void fault(struct packer *p, glint_status status,
                                                        const char *pointer, const char *format,
                                                        ...)
{
    char text[300];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    glint_fail(p->err, status, pointer, "%s", text);
    if (!p->status)
        p->status = status;
}

// A whole number, 0 where absent; false for anything else.
static bool read_size(const cJSON *object, const char *name, size_t *out)
{
    const cJSON *item = member(object, name);
    *out = 0;
    if (!item)
        return true;
    const double value = cJSON_IsNumber(item) ? item->valuedouble : -1;
    if (!(value >= 0 && value <= UINT32_MAX && value == floor(value)))
        return false;
    *out = (size_t)value;
    return true;
}

// Appends bytes on a boundary of 16, so that what was aligned stays aligned; the offset, or SIZE_MAX.
static size_t append(struct packer *p, const uint8_t *bytes, size_t size)
{
    const size_t base = (p->size + 15) / 16 * 16;
    if (base + size > UINT32_MAX - (HEADER_BYTES + 2 * CHUNK_BYTES))
        return SIZE_MAX;
    if (base + size > p->capacity) {
        const size_t capacity = base + size + p->capacity / 2;
        uint8_t *grown = realloc(p->bin, capacity);
        if (!grown)
            return SIZE_MAX;
        p->bin = grown;
        p->capacity = capacity;
    }
    memset(p->bin + p->size, 0, base - p->size);
    if (size)
        memcpy(p->bin + base, bytes, size);
    p->size = base + size;
    return base;
}

static void take_buffer(struct packer *p, const cJSON *buffer, struct range *out,
                        const char *pointer)
{
    const char *uri = cJSON_GetStringValue(member(buffer, "uri"));
    struct glint_blob blob;
    if (!uri || !read_size(buffer, "byteLength", &out->size)) {
        fault(p, GLINT_E_RANGE, pointer, "a buffer needs a uri and a byteLength");
        return;
    }
    const glint_status status = glint_uri_read(p->directory, uri, &blob, pointer, p->err);
    if (status) {
        p->status = p->status ? p->status : status;
        return;
    }
    if (blob.size < out->size)
        fault(p, GLINT_E_RANGE, pointer, "byteLength is %zu, the data has %zu bytes", out->size,
              blob.size);
    else if ((out->base = append(p, blob.bytes, out->size)) == SIZE_MAX)
        fault(p, GLINT_E_TOO_LARGE, pointer, "the buffers do not fit a GLB");
    free(blob.bytes);
}

static void take_buffers(struct packer *p)
{
    const cJSON *buffers = member(p->root, "buffers"), *buffer;
    p->buffers = (size_t)cJSON_GetArraySize(buffers);
    p->buffer = calloc(p->buffers + 1, sizeof *p->buffer);
    if (!p->buffer) {
        fault(p, GLINT_E_NOMEM, "/buffers", "no memory");
        return;
    }
    size_t i = 0;
    cJSON_ArrayForEach(buffer, buffers) {
        char pointer[40];
        snprintf(pointer, sizeof pointer, "/buffers/%zu", i);
        take_buffer(p, buffer, &p->buffer[i++], pointer);
    }
}

static void set_number(cJSON *object, const char *name, size_t value)
{
    cJSON_DeleteItemFromObjectCaseSensitive(object, name);
    cJSON_AddNumberToObject(object, name, (double)value);
}

// Points a view into the BIN chunk.
static void rebase(struct packer *p, cJSON *view, const char *pointer)
{
    size_t buffer, offset, length;
    if (!read_size(view, "buffer", &buffer) || !member(view, "buffer") || buffer >= p->buffers ||
        !read_size(view, "byteOffset", &offset) || !read_size(view, "byteLength", &length) ||
        offset + length > p->buffer[buffer].size) {
        fault(p, GLINT_E_RANGE, pointer, "a view that is not inside its buffer");
        return;
    }
    set_number(view, "buffer", 0);
    set_number(view, "byteOffset", offset + p->buffer[buffer].base);
}

static void rebase_views(struct packer *p)
{
    size_t i = 0;
    cJSON *view;
    cJSON_ArrayForEach(view, member(p->root, "bufferViews")) {
        char pointer[40];
        snprintf(pointer, sizeof pointer, "/bufferViews/%zu", i++);
        rebase(p, view, pointer);
        cJSON *packed = member(member(view, "extensions"), "EXT_meshopt_compression");
        if (packed)
            rebase(p, packed, pointer);
    }
}

static const char *image_type(const struct glint_blob *image)
{
    static const struct {
        const char *magic;
        size_t size;
        const char *type;
    } kinds[] = {
        {"\x89PNG", 4, "image/png"},
        {"\xff\xd8\xff", 3, "image/jpeg"},
        {"RIFF", 4, "image/webp"},
        {"\xabKTX 20", 7, "image/ktx2"},
    };
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (image->size >= kinds[i].size &&
            memcmp(image->bytes, kinds[i].magic, kinds[i].size) == 0)
            return kinds[i].type;
    return image->media[0] ? image->media : "application/octet-stream";
}

// The index of a new view of [base, base + size).
static size_t add_view(struct packer *p, size_t base, size_t size)
{
    cJSON *views = member(p->root, "bufferViews");
    if (!cJSON_IsArray(views)) {
        cJSON_DeleteItemFromObjectCaseSensitive(p->root, "bufferViews");
        views = cJSON_AddArrayToObject(p->root, "bufferViews");
    }
    cJSON *view = cJSON_CreateObject();
    set_number(view, "buffer", 0);
    set_number(view, "byteOffset", base);
    set_number(view, "byteLength", size);
    cJSON_AddItemToArray(views, view);
    return (size_t)cJSON_GetArraySize(views) - 1;
}

static void take_image(struct packer *p, cJSON *image, const char *uri, const char *pointer)
{
    struct glint_blob blob;
    const glint_status status = glint_uri_read(p->directory, uri, &blob, pointer, p->err);
    if (status) {
        p->status = p->status ? p->status : status;
        return;
    }
    const size_t base = append(p, blob.bytes, blob.size);
    if (base == SIZE_MAX) {
        fault(p, GLINT_E_TOO_LARGE, pointer, "the images do not fit a GLB");
    } else {
        set_number(image, "bufferView", add_view(p, base, blob.size));
        cJSON_DeleteItemFromObjectCaseSensitive(image, "uri");
        if (!member(image, "mimeType"))
            cJSON_AddStringToObject(image, "mimeType", image_type(&blob));
    }
    free(blob.bytes);
}

static void take_images(struct packer *p)
{
    size_t i = 0;
    cJSON *image;
    cJSON_ArrayForEach(image, member(p->root, "images")) {
        const char *uri = cJSON_GetStringValue(member(image, "uri"));
        char pointer[40];
        snprintf(pointer, sizeof pointer, "/images/%zu/uri", i++);
        if (uri)
            take_image(p, image, uri, pointer);
    }
}

static void replace_buffers(struct packer *p)
{
    cJSON_DeleteItemFromObjectCaseSensitive(p->root, "buffers");
    if (!p->size)
        return;
    cJSON *buffer = cJSON_CreateObject();
    set_number(buffer, "byteLength", p->size);
    cJSON_AddItemToArray(cJSON_AddArrayToObject(p->root, "buffers"), buffer);
}

static uint8_t *put_u32(uint8_t *to, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        *to++ = (uint8_t)(value >> 8 * i);
    return to;
}

static uint8_t *put_chunk(uint8_t *to, uint32_t type, const void *bytes, size_t size, int padding)
{
    const size_t padded = (size + 3) / 4 * 4;
    to = put_u32(to, (uint32_t)padded);
    to = put_u32(to, type);
    memcpy(to, bytes, size);
    memset(to + size, padding, padded - size);
    return to + padded;
}

static void write_glb(struct packer *p, uint8_t **glb, size_t *size)
{
    char *json = cJSON_PrintUnformatted(p->root);
    const uint64_t length = json ? strlen(json) : 0;
    const uint64_t bin = p->size ? CHUNK_BYTES + (p->size + 3) / 4 * 4 : 0;
    const uint64_t total = HEADER_BYTES + CHUNK_BYTES + (length + 3) / 4 * 4 + bin;
    uint8_t *to = json && total <= UINT32_MAX ? malloc(total) : NULL;
    if (to) {
        *glb = to;
        *size = total;
        to = put_u32(put_u32(put_u32(to, GLB_MAGIC), 2), (uint32_t)total);
        to = put_chunk(to, CHUNK_JSON, json, length, ' ');
        if (bin)
            put_chunk(to, CHUNK_BIN, p->bin, p->size, 0);
    } else {
        fault(p, GLINT_E_TOO_LARGE, "", "no memory for a GLB of %llu bytes",
              (unsigned long long)total);
    }
    free(json);
}

// The real path of the directory that a file is in; malloc'd, or NULL.
static char *directory_of(const char *path)
{
    char *copy = strdup(path), *slash = copy ? strrchr(copy, '/') : NULL;
    if (slash)
        slash[1] = '\0';
    char *real = copy ? realpath(slash ? copy : ".", NULL) : NULL;
    free(copy);
    return real;
}

static void pack(struct packer *p, uint8_t **glb, size_t *size)
{
    take_buffers(p);
    if (p->buffer)
        rebase_views(p);
    take_images(p);
    replace_buffers(p);
    if (!p->status)
        write_glb(p, glb, size);
}

glint_status glint_pack_gltf(const char *path, uint8_t **glb, size_t *size, struct glint_error *err)
{
    struct glint_blob text;
    struct packer p = {.err = err};
    *glb = NULL;
    *size = 0;
    p.status = glint_uri_read_file(path, &text, "", err);
    if (p.status)
        return p.status;
    p.root = cJSON_ParseWithLength((const char *)text.bytes, text.size);
    free(text.bytes);
    p.directory = directory_of(path);
    if (!cJSON_IsObject(p.root))
        fault(&p, GLINT_E_SYNTAX, "", "%s: no JSON object", path);
    else if (!p.directory)
        fault(&p, GLINT_E_IO, "", "%s: %s", path, strerror(errno));
    else
        pack(&p, glb, size);
    cJSON_Delete(p.root);
    free(p.directory);
    free(p.buffer);
    free(p.bin);
    return p.status;
}
