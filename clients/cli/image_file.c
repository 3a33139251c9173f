#include "image_file.h"
#include "protocol/cryptomatte.h"
#include "protocol/exr.h"
#include "uri.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const char prefix[] = "cryptomatte/";

glint_status glint_image_file_parse(struct glint_image_file *out, const void *bytes, size_t size,
                                    struct glint_error *err)
{
    *out = (struct glint_image_file){0};
    return glint_exr_read(&out->frame, bytes, size, err);
}

static char *directory_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    char *folder = slash ? strndup(path, (size_t)(slash - path) + 1) : strdup(".");
    char *real = folder ? realpath(folder, NULL) : NULL;
    free(folder);
    return real;
}

glint_status glint_image_file_read(struct glint_image_file *out, const char *path,
                                   struct glint_error *err)
{
    struct glint_blob text;
    *out = (struct glint_image_file){0};
    glint_status status = glint_uri_read_file(path, &text, "", err);
    if (status)
        return status;
    struct glint_error faults = {0};
    status = glint_image_file_parse(out, text.bytes, text.size, &faults);
    free(text.bytes);
    if (status)
        glint_fail(err, status, "", "%s: %s", path, glint_error_text(&faults));
    glint_error_finish(&faults);
    out->directory = status ? NULL : directory_of(path);
    return status;
}

void glint_image_file_finish(struct glint_image_file *file)
{
    glint_frame_destroy(&file->frame);
    free(file->directory);
    *file = (struct glint_image_file){0};
}

// "cryptomatte/KEY/name" -> its KEY's length; 0 for other attributes.
static size_t key_of(const struct glint_attribute *a)
{
    const size_t start = strlen(prefix), length = strlen(a->name);
    const bool is_name = a->kind == GLINT_ATTR_STRING && length > start + 5 &&
                         strncmp(a->name, prefix, start) == 0 &&
                         strcmp(a->name + length - 5, "/name") == 0;
    return is_name ? length - start - 5 : 0;
}

// The attribute beside the type's name, "manifest" for example, or NULL.
static const char *find_beside(const struct glint_frame *frame, const char *type, const char *what)
{
    for (uint32_t i = 0; i < frame->attributes; i++) {
        const struct glint_attribute *a = &frame->attribute[i];
        const size_t key = key_of(a);
        char name[300];
        if (!key || strcmp(a->text, type) != 0)
            continue;
        snprintf(name, sizeof name, "%s%.*s/%s", prefix, (int)(key < 200 ? key : 200),
                 a->name + strlen(prefix), what);
        const struct glint_attribute *found = glint_frame_attribute(frame, name);
        if (found && found->kind == GLINT_ATTR_STRING)
            return found->text;
    }
    return NULL;
}

static bool ends_with(const char *text, const char *end)
{
    const size_t length = strlen(text), tail = strlen(end);
    return length >= tail && strcasecmp(text + length - tail, end) == 0;
}

static void list_types(const struct glint_frame *frame, char text[400])
{
    size_t used = 0;
    *text = '\0';
    for (uint32_t i = 0; i < frame->attributes && used < 300; i++)
        if (key_of(&frame->attribute[i]))
            used += (size_t)snprintf(text + used, 400 - used, "%s%.60s", used ? ", " : "",
                                     frame->attribute[i].text);
}

// Whether the type is that of a layer of what is seen directly: "CryptoObject" for "object".
static bool is_primary(const char *type, const char *layer)
{
    return strlen(type) == strlen(layer) + 6 && !strncmp(type, "Crypto", 6);
}

// The types that `layer` may mean, and one of them; all types for NULL.
static unsigned count_types(const struct glint_frame *frame, const char *layer, const char **type)
{
    unsigned count = 0;
    for (uint32_t i = 0; i < frame->attributes; i++) {
        const struct glint_attribute *a = &frame->attribute[i];
        if (!key_of(a) || (layer && !ends_with(a->text, layer)))
            continue;
        *type = a->text;
        if (layer && (strcmp(a->text, layer) == 0 || is_primary(a->text, layer)))
            return 1;
        count++;
    }
    return count;
}

glint_status glint_image_file_type(const struct glint_image_file *file, const char *layer,
                                   const char **type, struct glint_error *err)
{
    char there[400];
    if (!layer && count_types(file->frame, NULL, type) == 1)
        return GLINT_OK;
    layer = layer ? layer : "object";
    const unsigned count = count_types(file->frame, layer, type);
    if (count == 1)
        return GLINT_OK;
    list_types(file->frame, there);
    if (!*there)
        return glint_fail(err, GLINT_E_NOT_FOUND, "", "the picture has no Cryptomatte layers");
    return glint_fail(err, GLINT_E_NOT_FOUND, "",
                      "%s Cryptomatte layer of the picture is '%s'; there are: %s",
                      count ? "more than one" : "no", layer, there);
}

// The manifest of the type; *out stays NULL where the file has none.
static glint_status read_manifest(const struct glint_image_file *file, const char *type,
                                  cJSON **out, struct glint_error *err)
{
    const char *text = find_beside(file->frame, type, "manifest");
    const char *name = find_beside(file->frame, type, "manif_file");
    struct glint_blob blob = {0};
    *out = NULL;
    if (!text && name && file->directory) {
        const glint_status status = glint_uri_read_path(file->directory, name, &blob, "", err);
        if (status)
            return status;
        text = (const char *)blob.bytes;
    }
    if (text)
        *out = cJSON_Parse(text);
    free(blob.bytes);
    return !text || cJSON_IsObject(*out)
               ? GLINT_OK
               : glint_fail(err, GLINT_E_SYNTAX, "", "the manifest of '%s' is no JSON object",
                            type);
}

static bool read_id(const cJSON *value, uint32_t *id)
{
    const char *hex = cJSON_GetStringValue(value);
    return hex && strlen(hex) == 8 && strspn(hex, "0123456789abcdefABCDEF") == 8 &&
           sscanf(hex, "%" SCNx32, id) == 1;
}

// The first names of a manifest, as many as a line holds.
static void list_names(const cJSON *manifest, char text[400])
{
    size_t used = 0;
    const cJSON *entry;
    *text = '\0';
    cJSON_ArrayForEach(entry, manifest) {
        if (used > 200) {
            snprintf(text + used, 400 - used, ", ...");
            return;
        }
        used +=
            (size_t)snprintf(text + used, 400 - used, "%s%.60s", used ? ", " : "", entry->string);
    }
}

static glint_status find_ids(const cJSON *manifest, const char *type, const char *const *names,
                             size_t count, uint32_t *ids, struct glint_error *err)
{
    glint_status status = GLINT_OK;
    for (size_t i = 0; i < count; i++) {
        ids[i] = glint_cryptomatte_id(names[i]);
        if (manifest && !read_id(cJSON_GetObjectItemCaseSensitive(manifest, names[i]), &ids[i]))
            status = glint_fail(err, GLINT_E_NOT_FOUND, "", "%s has nothing called '%s'", type,
                                names[i]);
    }
    char there[400];
    list_names(manifest, there);
    if (status)
        glint_fail(err, status, "", "there are: %s", there);
    return status;
}

glint_status glint_image_file_ids(const struct glint_image_file *file, const char *type,
                                  const char *const *names, size_t count, uint32_t *ids,
                                  struct glint_error *err)
{
    cJSON *manifest;
    glint_status status = read_manifest(file, type, &manifest, err);
    if (!status)
        status = find_ids(manifest, type, names, count, ids, err);
    cJSON_Delete(manifest);
    return status;
}
