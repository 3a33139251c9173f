// import.h - untrusted scene files, decoded in a sandboxed child.
//
// The child (forked from a small single-threaded helper; seccomp, rlimits, no file or socket can
// be opened) turns GLB or native JSON into canonical native JSON plus binary assets, and answers
// over a memfd. Nothing that it says is trusted: the parent parses the text with the same checks
// and bounds every offset.
//
// Threads: start by main before any other thread exists; run by any loader thread.
#ifndef GLINT_SCENE_IMPORT_H
#define GLINT_SCENE_IMPORT_H

#include "protocol/scene.h"

typedef struct glint_importer glint_importer;

enum glint_scene_type { GLINT_SCENE_GLB, GLINT_SCENE_NATIVE };

struct glint_import_limits {
    size_t memory_bytes; // of the child
    double cpu_seconds;
};

// Forks the helper. It dies with the parent.
glint_status glint_importer_create(glint_importer **out, struct glint_error *err);
void glint_importer_destroy(glint_importer **importer);

struct glint_import {
    char *text; // canonical native JSON
    size_t length;
    struct glint_asset *asset; // borrow the mapping
    size_t assets;
    char **warning; // about what the file has and the scene has not: "KHR_x on node \"y\": ..."
    size_t warnings;
    void *mapping; // memfd
    size_t mapping_bytes;
    double seconds; // in the child
};

//   GLINT_E_SYNTAX, GLINT_E_RANGE  the file is at fault
//   GLINT_E_RANGE at ""            the child crashed, timed out or hit a limit (says which)
glint_status glint_import_run(glint_importer *importer, enum glint_scene_type type,
                              const uint8_t *bytes, size_t size,
                              const struct glint_import_limits *limits, struct glint_import **out,
                              struct glint_error *err);
void glint_import_destroy(struct glint_import **import);

#endif
