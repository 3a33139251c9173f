// import_child.c - decode, complete, write, answer, exit.
#include "scene/import_child.h"

#include "base/clock.h"
#include "scene/gltf.h"
#include "scene/import_answer.h"

#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

glint_status glint_import_decode(enum glint_scene_type type, const uint8_t *bytes, size_t size,
                                 struct glint_scene **scene, struct glint_asset **asset,
                                 size_t *assets, struct glint_arena *arena, struct glint_error *err)
{
    *asset = NULL;
    *assets = 0;
    if (type == GLINT_SCENE_NATIVE)
        return glint_import_native(bytes, size, scene, asset, assets, arena, err);
    const glint_status st = glint_gltf_import(scene, bytes, size, err);
    return st ? st : glint_scene_complete(*scene, err);
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

void glint_import_child(const struct glint_import_request *request, int input, int output)
{
    const double start = glint_now();
    struct glint_error err = {0};
    struct glint_arena arena = {0};
    struct glint_scene *scene = NULL;
    struct glint_asset *asset = NULL;
    size_t assets = 0, length = 0;
    char *text = NULL;
    const void *bytes = "";
    if (request->size)
        bytes = mmap(NULL, request->size, PROT_READ, MAP_PRIVATE, input, 0);
    if (bytes == MAP_FAILED)
        glint_fail(&err, GLINT_E_NOMEM, "", "no memory for the file");
    else
        glint_import_decode((enum glint_scene_type)request->type, bytes, request->size, &scene,
                            &asset, &assets, &arena, &err);
    if (!err.status)
        glint_scene_write(scene, &text, &length, &asset, &assets, &err);
    const struct glint_answer answer = {
        .error = &err,
        .text = err.status ? NULL : text,
        .length = length,
        .asset = asset,
        .assets = err.status ? 0 : assets,
        .warning = scene ? scene->warning : NULL,
        .warnings = scene && !err.status ? scene->warnings : 0,
        .seconds = glint_now() - start,
    };
    _exit(say(output, request, &answer) ? GLINT_CHILD_NO_ROOM : GLINT_CHILD_ANSWERED);
}
