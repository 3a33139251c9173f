// import_child.h - what runs inside the jail: untrusted bytes in, one answer out.
#ifndef GLINT_SCENE_IMPORT_CHILD_H
#define GLINT_SCENE_IMPORT_CHILD_H

#include "scene/files.h"
#include "scene/import_helper.h"

// Reads the input memfd, writes the answer to the output memfd and exits with one of the exit
// codes of import_helper.h.
void glint_import_child(const struct glint_import_request *request, int input, int assets,
                        int output) __attribute__((noreturn));

// The import itself, in whatever process.
struct glint_import_work {
    enum glint_scene_type type;
    const uint8_t *bytes;
    size_t size;
    const char *boundary; // of multipart
    // malloc'd: first those that the text may name, then those that the import made.
    struct glint_asset *asset;
    size_t given, assets;
    struct glint_arena arena; // holds the bytes of those that it made
    uint64_t clamped;         // values of pictures that no light can have
    struct glint_scene *scene;
};

// On GLINT_OK work->scene is complete.
glint_status glint_import_decode(struct glint_import_work *work, struct glint_error *err);

// One file of any kind but native, into w->scene, which is not completed.
glint_status glint_import_file(struct glint_import_work *w, enum glint_scene_type type,
                               const uint8_t *bytes, size_t size, struct glint_files *files,
                               struct glint_error *err);

// Native JSON: pictures in data URIs and in encoded assets become assets, then the text is parsed.
glint_status glint_import_native(struct glint_import_work *work, struct glint_error *err);

// multipart/form-data: the .gltf or .obj in it, with the other parts as its files.
glint_status glint_import_multipart(struct glint_import_work *work, struct glint_error *err);

#endif
