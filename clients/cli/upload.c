#include "upload.h"
#include "bundle.h"
#include "output.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const struct {
    const char *extension, *type;
} types[] = {
    {"glb", "model/gltf-binary"}, {"gltf", "model/gltf+json"}, {"json", "application/json"},
    {"obj", "model/obj"},         {"ply", "application/ply"},  {"stl", "model/stl"},
};

const char *glint_upload_type(const char *path)
{
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (glint_output_is(path, types[i].extension))
            return types[i].type;
    return NULL;
}

void glint_upload_name(const char *path, char name[129])
{
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path;
    const char *dot = strrchr(base, '.');
    size_t length = dot && dot > base ? (size_t)(dot - base) : strlen(base);
    length = length > 128 ? 128 : length;
    for (size_t i = 0; i < length; i++) {
        const unsigned char c = (unsigned char)base[i];
        name[i] = (char)((c < 0x80 && isalnum(c)) || strchr("._-", c) ? c : '-');
    }
    name[length] = '\0';
    if (!length || strspn(name, ".") == length)
        strcpy(name, "scene");
}

static glint_status put(struct glint_session *s, const char *name, const struct glint_body *body,
                        cJSON **scene, struct glint_error *err)
{
    char *path = glint_client_path("/v1/scenes/", name, "");
    if (!path)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory");
    const struct glint_request request = {.method = "PUT", .path = path, .body = body};
    const glint_status status = glint_client_json(s->client, &request, scene, err);
    free(path);
    return status;
}

static glint_status put_file(struct glint_session *s, const char *path, const char *name,
                             const char *type, cJSON **scene, struct glint_error *err)
{
    struct stat info;
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return glint_fail(err, GLINT_E_IO, "", "%s: %s", path, strerror(errno));
    glint_status status;
    if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode))
        status = glint_fail(err, GLINT_E_IO, "", "%s: not a regular file", path);
    else
        status = put(s, name,
                     &(struct glint_body){.type = type, .fd = fd, .size = (uint64_t)info.st_size},
                     scene, err);
    close(fd);
    return status;
}

glint_status glint_upload_scene(struct glint_session *s, const char *path, const char *name,
                                cJSON **scene, struct glint_error *err)
{
    const char *type = glint_upload_type(path);
    struct glint_bundle bundle = {.fd = -1};
    glint_status status = GLINT_OK;
    *scene = NULL;
    if (!type)
        return glint_fail(err, GLINT_E_MEDIA_TYPE, "", "%s: not known as a scene by its extension",
                          path);
    if (glint_output_is(path, "gltf"))
        status = glint_bundle_gltf(path, &bundle, err);
    else if (glint_output_is(path, "obj"))
        status = glint_bundle_obj(path, &bundle, err);
    if (status)
        return status;
    if (bundle.fd < 0)
        return put_file(s, path, name, type, scene, err);
    status = put(s, name,
                 &(struct glint_body){.type = bundle.type, .fd = bundle.fd, .size = bundle.size},
                 scene, err);
    glint_bundle_finish(&bundle);
    return status;
}
