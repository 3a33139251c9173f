#include "bundle.h"
#include "uri.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/mman.h>
#include <sys/random.h>
#include <unistd.h>

struct packer {
    struct glint_bundle *out;
    char *directory; // real path
    char boundary[40];
    char **sent; // names of the parts
    size_t count, capacity;
    struct glint_error *err;
    glint_status status; // the first failure
};

static void fail(struct packer *p, glint_status status, const char *what)
{
    glint_fail(p->err, status, "", "%.300s: %s", what, strerror(errno));
    if (!p->status)
        p->status = status;
}

// ---- the body

static void put(struct packer *p, const void *bytes, size_t size)
{
    for (const char *at = bytes; size && !p->status;) {
        const ssize_t n = write(p->out->fd, at, size);
        if (n <= 0) {
            fail(p, GLINT_E_IO, "the body");
            return;
        }
        at += n;
        size -= (size_t)n;
        p->out->size += (size_t)n;
    }
}

static void put_text(struct packer *p, const char *text)
{
    put(p, text, strlen(text));
}

static bool is_sent(struct packer *p, const char *name)
{
    for (size_t i = 0; i < p->count; i++)
        if (!strcmp(p->sent[i], name))
            return true;
    return false;
}

// Remembers the name; false where it was sent before.
static bool remember(struct packer *p, const char *name)
{
    if (is_sent(p, name))
        return false;
    if (p->count == p->capacity) {
        const size_t capacity = 2 * p->capacity + 16;
        char **more = realloc(p->sent, capacity * sizeof *more);
        if (!more) {
            fail(p, GLINT_E_NOMEM, name);
            return false;
        }
        p->sent = more;
        p->capacity = capacity;
    }
    p->sent[p->count] = strdup(name);
    if (!p->sent[p->count])
        fail(p, GLINT_E_NOMEM, name);
    else
        p->count++;
    return !p->status;
}

static void put_part(struct packer *p, const char *name, const struct glint_blob *blob)
{
    if (!remember(p, name))
        return;
    put_text(p, "--");
    put_text(p, p->boundary);
    put_text(p, "\r\nContent-Disposition: form-data; name=\"file\"; filename=\"");
    for (const char *c = name; *c; c++) {
        if (*c == '"' || *c == '\\')
            put_text(p, "\\");
        put(p, (unsigned char)*c < ' ' ? "_" : c, 1);
    }
    put_text(p, "\"\r\n\r\n");
    put(p, blob->bytes, blob->size);
    put_text(p, "\r\n");
}

// ---- files

static const char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
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

static bool start(struct packer *p, const char *path, struct glint_blob *scene)
{
    uint64_t random[2];
    *p->out = (struct glint_bundle){.fd = -1};
    p->status = glint_uri_read_file(path, scene, "", p->err);
    if (p->status)
        return false;
    p->directory = directory_of(path);
    p->out->fd = memfd_create("glint-bundle", MFD_CLOEXEC);
    if (!p->directory || p->out->fd < 0 || getrandom(random, sizeof random, 0) != sizeof random) {
        fail(p, GLINT_E_IO, path);
        return false;
    }
    snprintf(p->boundary, sizeof p->boundary, "glint-%016llx%016llx", (unsigned long long)random[0],
             (unsigned long long)random[1]);
    snprintf(p->out->type, sizeof p->out->type, "multipart/form-data; boundary=%s", p->boundary);
    put_part(p, base_name(path), scene);
    return true;
}

static glint_status finish(struct packer *p)
{
    const bool alone = p->count < 2;
    if (!p->status && !alone) {
        put_text(p, "--");
        put_text(p, p->boundary);
        put_text(p, "--\r\n");
    }
    if (p->status || alone)
        glint_bundle_finish(p->out);
    for (size_t i = 0; i < p->count; i++)
        free(p->sent[i]);
    free(p->sent);
    free(p->directory);
    return p->status;
}

void glint_bundle_finish(struct glint_bundle *bundle)
{
    if (bundle->fd >= 0)
        close(bundle->fd);
    bundle->fd = -1;
}

// ---- glTF

static void take_uri(struct packer *p, const cJSON *item, const char *pointer)
{
    const char *uri = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(item, "uri"));
    struct glint_blob blob;
    if (!uri || !strncasecmp(uri, "data:", 5))
        return;
    const glint_status status = glint_uri_read(p->directory, uri, &blob, pointer, p->err);
    if (status) {
        p->status = p->status ? p->status : status;
        return;
    }
    char *name = glint_uri_decode(uri);
    if (name)
        put_part(p, name, &blob);
    free(name);
    free(blob.bytes);
}

static void take_uris(struct packer *p, const cJSON *root, const char *list)
{
    const cJSON *item;
    size_t i = 0;
    cJSON_ArrayForEach(item, cJSON_GetObjectItemCaseSensitive(root, list)) {
        char pointer[48];
        snprintf(pointer, sizeof pointer, "/%s/%zu/uri", list, i++);
        take_uri(p, item, pointer);
    }
}

glint_status glint_bundle_gltf(const char *path, struct glint_bundle *out, struct glint_error *err)
{
    struct packer p = {.out = out, .err = err};
    struct glint_blob scene = {0};
    cJSON *root = NULL;
    if (start(&p, path, &scene)) {
        root = cJSON_ParseWithLength((const char *)scene.bytes, scene.size);
        if (!cJSON_IsObject(root))
            p.status = glint_fail(err, GLINT_E_SYNTAX, "", "%s: no JSON object", path);
        take_uris(&p, root, "buffers");
        take_uris(&p, root, "images");
    }
    cJSON_Delete(root);
    free(scene.bytes);
    return finish(&p);
}

// ---- OBJ

// A file that is named as these formats do it, with '\' perhaps; false where it is not there.
static bool take_path(struct packer *p, const char *path, struct glint_blob *blob)
{
    char *tidy = strdup(path);
    for (char *c = tidy; c && *c; c++)
        *c = *c == '\\' ? '/' : *c;
    const char *name = tidy;
    while (name && !strncmp(name, "./", 2))
        name += 2;
    const bool there = name && *name && !glint_uri_read_path(p->directory, name, blob, "", NULL);
    if (there)
        put_part(p, name, blob);
    free(tidy);
    return there;
}

// Lines that begin with one of the words: calls `take` with what follows, terminated.
static void each_line(struct packer *p, const struct glint_blob *text, const char *const *words,
                      void (*take)(struct packer *p, char *rest))
{
    char *copy = strdup((const char *)text->bytes), *next;
    for (char *line = copy ? strtok_r(copy, "\r\n", &next) : NULL; line;
         line = strtok_r(NULL, "\r\n", &next)) {
        line += strspn(line, " \t");
        const size_t length = strcspn(line, " \t");
        for (size_t i = 0; words[i]; i++)
            if (strlen(words[i]) == length && !strncasecmp(line, words[i], length))
                take(p, line + length + strspn(line + length, " \t"));
    }
    free(copy);
}

// Options come before the path, which may have blanks in it: the longest end of the line that is a
// file is it.
static void take_picture(struct packer *p, char *rest)
{
    struct glint_blob blob;
    for (size_t end = strlen(rest); end && strchr(" \t", rest[end - 1]); end--)
        rest[end - 1] = '\0';
    for (char *at = rest; *at; at += strcspn(at, " \t"), at += strspn(at, " \t"))
        if (take_path(p, at, &blob)) {
            free(blob.bytes);
            return;
        }
}

static void take_library(struct packer *p, char *rest)
{
    static const char *const maps[] = {"map_Kd", "map_Ks", "map_Ke",   "map_d", "map_Pr", "map_Pm",
                                       "norm",   "map_Kn", "map_Bump", "bump",  NULL};
    struct glint_blob library;
    char *next;
    for (size_t end = strlen(rest); end && strchr(" \t", rest[end - 1]); end--)
        rest[end - 1] = '\0';
    if (take_path(p, rest, &library)) {
        each_line(p, &library, maps, take_picture);
        free(library.bytes);
        return;
    }
    for (char *name = strtok_r(rest, " \t", &next); name; name = strtok_r(NULL, " \t", &next))
        if (take_path(p, name, &library)) {
            each_line(p, &library, maps, take_picture);
            free(library.bytes);
        }
}

glint_status glint_bundle_obj(const char *path, struct glint_bundle *out, struct glint_error *err)
{
    static const char *const libraries[] = {"mtllib", NULL};
    struct packer p = {.out = out, .err = err};
    struct glint_blob scene = {0};
    if (start(&p, path, &scene))
        each_line(&p, &scene, libraries, take_library);
    free(scene.bytes);
    return finish(&p);
}
