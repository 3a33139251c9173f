// import.h - untrusted scene files, decoded in a sandboxed child.
//
// The child (forked from a small single-threaded helper; seccomp, rlimits, no file or socket can
// be opened) turns a file of any kind into canonical native JSON plus binary assets, and answers
// over a memfd. Nothing that it says is trusted: the parent parses the text with the same checks
// and bounds every offset. A child that crashes, takes too long or talks nonsense is a line in the
// log and the fault of the file.
//
// Threads: start by main before any other thread exists; run by any loader thread.
#ifndef GLINT_SCENE_IMPORT_H
#define GLINT_SCENE_IMPORT_H

#include "protocol/scene.h"
#include "scene/assets.h"

typedef struct glint_importer glint_importer;

enum glint_scene_type {
    GLINT_SCENE_GLB,
    GLINT_SCENE_NATIVE,
    GLINT_SCENE_GLTF,      // JSON
    GLINT_SCENE_OBJ,       // without its materials
    GLINT_SCENE_PLY,       // text or binary
    GLINT_SCENE_STL,       // text or binary
    GLINT_SCENE_MULTIPART, // multipart/form-data of a .gltf or .obj and the files that it names
    GLINT_SCENE_TYPES
};

#define GLINT_MAX_BOUNDARY 70 // bytes, RFC 2046

// What is to be imported. Borrowed for the call.
struct glint_import_source {
    enum glint_scene_type type;
    const uint8_t *bytes;
    size_t size;
    int fd;               // memfd that holds the bytes from its start and can be sealed; 0: none
    const char *boundary; // of GLINT_SCENE_MULTIPART, else NULL
    glint_assets *assets; // what native text may name, and where the scene's go; NULL: none
};

struct glint_import_limits {
    size_t memory_bytes; // of the child
    double cpu_seconds;
};

// Forks the helper. It dies with the parent.
glint_status glint_importer_create(glint_importer **out, struct glint_error *err);
void glint_importer_destroy(glint_importer **importer);
// False once the helper has died: nothing is imported any more.
bool glint_importer_lives(const glint_importer *importer);

struct glint_import {
    char *text; // canonical native JSON
    size_t length;
    struct glint_asset *asset; // every one that the text names
    size_t assets;
    struct glint_asset_set set; // the same, counted, where the source had a store
    char **warning; // about what the file has and the scene has not: "KHR_x on node \"y\": ..."
    size_t warnings;
    glint_memory_ref *memory; // what text, warnings and the child's assets lie in
    double seconds;           // in the child
};

//   GLINT_E_SYNTAX, GLINT_E_RANGE  the file is at fault
//   GLINT_E_RANGE at ""            the child crashed, timed out or hit a limit (says which)
glint_status glint_import_run(glint_importer *importer, const struct glint_import_source *source,
                              const struct glint_import_limits *limits, struct glint_import **out,
                              struct glint_error *err);
void glint_import_destroy(struct glint_import **import);

#endif
