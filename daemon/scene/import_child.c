// import_child.c - decode, complete, write, answer, exit.
#include "scene/import_child.h"

#include "base/clock.h"
#include "scene/gltf.h"
#include "scene/import_answer.h"
#include "scene/model.h"

#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

glint_status glint_import_decode(struct glint_import_work *w, struct glint_error *err)
{
    switch (w->type) {
    case GLINT_SCENE_NATIVE:
        return glint_import_native(w, err);
    case GLINT_SCENE_MULTIPART:
        return glint_import_multipart(w, err);
    default: {
        const glint_status st = glint_import_file(w, w->type, w->bytes, w->size, NULL, err);
        return st ? st : glint_scene_complete_file(w->scene, err);
    }
    }
}

glint_status glint_import_file(struct glint_import_work *w, enum glint_scene_type type,
                               const uint8_t *bytes, size_t size, struct glint_files *files,
                               struct glint_error *err)
{
    switch (type) {
    case GLINT_SCENE_OBJ:
        return glint_obj_import(&w->scene, bytes, size, files, err);
    case GLINT_SCENE_PLY:
        return glint_ply_import(&w->scene, bytes, size, err);
    case GLINT_SCENE_STL:
        return glint_stl_import(&w->scene, bytes, size, err);
    default:
        return glint_gltf_import(&w->scene, bytes, size, files, err);
    }
}

// Out of memory in the jail means over the limit: it is the file's size that is at fault.
static glint_status say(int output, const struct glint_import_request *request,
                        const struct glint_answer *answer)
{
    if (answer->error->status != GLINT_E_NOMEM)
        return glint_answer_write(output, answer);
    char detail[120];
    snprintf(detail, sizeof detail, "importing the file needs more than the %zu MiB allowed",
             request->limits.memory_bytes >> 20);
    struct glint_fault fault = {"", detail};
    const struct glint_error error = {.status = GLINT_E_RANGE, .count = 1, .fault = &fault};
    const struct glint_answer instead = {.error = &error, .seconds = answer->seconds};
    return glint_answer_write(output, &instead);
}

// The assets that came along; they stay mapped until the process ends.
static glint_status take_given(struct glint_import_work *w, int fd, struct glint_error *err)
{
    struct glint_import *given;
    const glint_status st = glint_answer_read(fd, true, &given, err);
    if (st)
        return st;
    w->asset = given->asset;
    w->given = w->assets = given->assets;
    return GLINT_OK;
}

static glint_status take_input(struct glint_import_work *w,
                               const struct glint_import_request *request, int input, int assets,
                               struct glint_error *err)
{
    const void *bytes = "";
    if (request->size)
        bytes = mmap(NULL, request->size, PROT_READ, MAP_PRIVATE, input, 0);
    if (bytes == MAP_FAILED)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the file");
    w->type = (enum glint_scene_type)request->type;
    w->bytes = bytes;
    w->size = request->size;
    w->boundary = request->boundary;
    return request->assets ? take_given(w, assets, err) : GLINT_OK;
}

void glint_import_child(const struct glint_import_request *request, int input, int assets,
                        int output)
{
    const double start = glint_now();
    struct glint_error err = {0};
    struct glint_import_work w = {0};
    size_t length = 0;
    char *text = NULL;
    if (!take_input(&w, request, input, assets, &err))
        glint_import_decode(&w, &err);
    if (!err.status)
        glint_scene_write(w.scene, &text, &length, &w.asset, &w.assets, &err);
    const struct glint_answer answer = {
        .error = &err,
        .text = err.status ? NULL : text,
        .length = length,
        .asset = w.asset + w.given,
        .assets = err.status ? 0 : w.assets - w.given,
        .warning = w.scene ? w.scene->warning : NULL,
        .warnings = w.scene && !err.status ? w.scene->warnings : 0,
        .seconds = glint_now() - start,
    };
    _exit(say(output, request, &answer) ? GLINT_CHILD_NO_ROOM : GLINT_CHILD_ANSWERED);
}
