#include "http/media.h"

#include <string.h>
#include <strings.h>

const char *const glint_media_scenes[GLINT_MAX_MEDIA] = {
    "model/gltf-binary", "model/gltf+json",  "model/obj",           "model/stl",
    "application/ply",   "application/json", "multipart/form-data", "application/octet-stream",
};

// In the order of the list above; the last has none of its own.
static const enum glint_scene_type type_of_media[] = {
    GLINT_SCENE_GLB, GLINT_SCENE_GLTF,   GLINT_SCENE_OBJ,      GLINT_SCENE_STL,
    GLINT_SCENE_PLY, GLINT_SCENE_NATIVE, GLINT_SCENE_MULTIPART};

enum kind { UNKNOWN, GLB, PLY, JSON, OTHER };

// Files that say by their first bytes what they are.
static const struct {
    const char *magic;
    size_t length;
    enum kind kind;
    const char *name;
} signatures[] = {
    {"glTF", 4, GLB, "GLB"},
    {"ply\n", 4, PLY, "PLY"},
    {"ply\r", 4, PLY, "PLY"},
    {"\x89PNG\r\n\x1a\n", 8, OTHER, "PNG"},
    {"\xff\xd8\xff", 3, OTHER, "JPEG"},
    {"\x76\x2f\x31\x01", 4, OTHER, "OpenEXR"},
    {"#?RADIANCE", 10, OTHER, "Radiance HDR"},
    {"PK\x03\x04", 4, OTHER, "ZIP"},
    {"\x1f\x8b", 2, OTHER, "gzip"},
    {"Kaydara FBX", 11, OTHER, "FBX"},
    {"RIFF", 4, OTHER, "RIFF"},
    {"<?xml", 5, OTHER, "XML"},
};

bool glint_media_is(const char *header, const char *type)
{
    const size_t length = strlen(type);
    return !strncasecmp(header, type, length) && strchr("; \t", header[length]);
}

// What the bytes tell; *name for people.
static enum kind sniff(const uint8_t *bytes, size_t size, const char **name)
{
    for (size_t i = 0; i < sizeof signatures / sizeof *signatures; i++)
        if (size >= signatures[i].length &&
            !memcmp(bytes, signatures[i].magic, signatures[i].length)) {
            *name = signatures[i].name;
            return signatures[i].kind;
        }
    size_t blank = 0;
    while (blank < size && bytes[blank] && strchr(" \t\r\n", bytes[blank]))
        blank++;
    *name = "JSON";
    return blank < size && bytes[blank] == '{' ? JSON : UNKNOWN;
}

// The text beside which a body that says what it is can stand.
static bool fits(enum glint_scene_type type, enum kind kind)
{
    switch (type) {
    case GLINT_SCENE_GLB:
        return kind == GLB || kind == UNKNOWN; // the importer tells what is wrong with the rest
    case GLINT_SCENE_PLY:
        return kind == PLY || kind == UNKNOWN;
    case GLINT_SCENE_NATIVE:
    case GLINT_SCENE_GLTF:
        return kind == JSON || kind == UNKNOWN;
    default:
        return kind == UNKNOWN;
    }
}

// glTF and native JSON both begin with a brace, but only one has asset.version.
static bool is_gltf(const uint8_t *bytes, size_t size)
{
    static const char *const members[] = {"\"accessors\"", "\"bufferViews\"", "\"scenes\"",
                                          "\"extensionsUsed\""};
    if (!memmem(bytes, size, "\"asset\"", 7) || !memmem(bytes, size, "\"version\"", 9))
        return false;
    for (size_t i = 0; i < sizeof members / sizeof *members; i++)
        if (memmem(bytes, size, members[i], strlen(members[i])))
            return true;
    return false;
}

static glint_status refuse(struct glint_error *err, const char *format, const char *a,
                           const char *b)
{
    return glint_fail(err, GLINT_E_MEDIA_TYPE, "", format, a, b);
}

// A body without a type tells by its bytes, or not at all.
static glint_status guess(const uint8_t *bytes, size_t size, enum glint_scene_type *out,
                          struct glint_error *err)
{
    const char *name;
    switch (sniff(bytes, size, &name)) {
    case GLB:
        *out = GLINT_SCENE_GLB;
        return GLINT_OK;
    case PLY:
        *out = GLINT_SCENE_PLY;
        return GLINT_OK;
    case JSON:
        *out = is_gltf(bytes, size) ? GLINT_SCENE_GLTF : GLINT_SCENE_NATIVE;
        return GLINT_OK;
    case OTHER:
        return refuse(err, "the body is %s, which is no scene%s", name, "");
    default:
        return refuse(err,
                      "the bytes do not tell what they are; say so in Content-Type: %s, %s, "
                      "model/gltf+json, model/obj, model/stl, application/ply or "
                      "multipart/form-data",
                      "model/gltf-binary", "application/json");
    }
}

static bool read_boundary(const char *header, char out[GLINT_MAX_BOUNDARY + 1])
{
    static const char allowed[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789"
                                  "'()+_,-./:=? ";
    const char *at = strcasestr(header, "boundary=");
    if (!at)
        return false;
    at += strlen("boundary=");
    const bool quoted = *at == '"';
    at += quoted;
    const size_t length = quoted ? strcspn(at, "\"") : strcspn(at, "; \t");
    if (!length || length > GLINT_MAX_BOUNDARY || (quoted && !at[length]) ||
        strspn(at, allowed) < length || at[length - 1] == ' ')
        return false;
    memcpy(out, at, length);
    out[length] = '\0';
    return true;
}

// The type that the header names, or GLINT_SCENE_TYPES: any bytes, or no header.
static enum glint_scene_type named(const char *header)
{
    for (size_t i = 0; header && i < sizeof type_of_media / sizeof *type_of_media; i++)
        if (glint_media_is(header, glint_media_scenes[i]))
            return type_of_media[i];
    return GLINT_SCENE_TYPES;
}

glint_status glint_media_source(struct glint_request *r, char boundary[GLINT_MAX_BOUNDARY + 1],
                                struct glint_import_source *out, struct glint_error *err)
{
    const char *header = glint_request_header(r, "Content-Type"), *name;
    const struct glint_body *b = &r->body;
    *out = (struct glint_import_source){
        .type = named(header), .bytes = b->bytes, .size = b->length, .fd = b->fd};
    if (!b->length)
        return glint_fail(err, GLINT_E_SYNTAX, "", "the body is empty");
    if (out->type == GLINT_SCENE_TYPES)
        return guess(b->bytes, b->length, &out->type, err);
    if (out->type == GLINT_SCENE_MULTIPART) {
        out->boundary = boundary;
        return read_boundary(header, boundary)
                   ? GLINT_OK
                   : refuse(err,
                            "Content-Type: %.80s: a boundary of 1 to 70 characters is "
                            "expected%s",
                            header, "");
    }
    if (!fits(out->type, sniff(b->bytes, b->length, &name)))
        return refuse(err, "Content-Type: %.80s, but the body is %s", header, name);
    return GLINT_OK;
}
