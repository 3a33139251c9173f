// import_child.h - what runs inside the jail: untrusted bytes in, one answer out.
#ifndef GLINT_SCENE_IMPORT_CHILD_H
#define GLINT_SCENE_IMPORT_CHILD_H

#include "scene/import_helper.h"

// Reads the input memfd, writes the answer to the output memfd and exits with one of the exit
// codes of import_helper.h.
void glint_import_child(const struct glint_import_request *request, int input, int output)
    __attribute__((noreturn));

// The import itself, in whatever process. On GLINT_OK *scene is complete, and *asset (malloc'd)
// are the pictures that a native text held in data URIs, their bytes in `arena`.
glint_status glint_import_decode(enum glint_scene_type type, const uint8_t *bytes, size_t size,
                                 struct glint_scene **scene, struct glint_asset **asset,
                                 size_t *assets, struct glint_arena *arena,
                                 struct glint_error *err);

// Native JSON: pictures in data URIs become assets, then the text is parsed.
glint_status glint_import_native(const uint8_t *bytes, size_t size, struct glint_scene **scene,
                                 struct glint_asset **asset, size_t *assets,
                                 struct glint_arena *arena, struct glint_error *err);

#endif
