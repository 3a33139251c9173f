// store_parts.h - the inside of the store, shared by the file that serves it and the one that brings
// it back after a restart.
#ifndef GLINT_SCENE_STORE_PARTS_H
#define GLINT_SCENE_STORE_PARTS_H

#include "scene/keep.h"
#include "scene/revision.h"
#include "scene/store.h"

#include <pthread.h>
#include <stdatomic.h>

#define GLINT_MAX_SCENES 4096
#define GLINT_STORE_EDITORS 16u // scenes that can be patched at once

struct glint_named {
    char *name;
    glint_revision *current; // retained
};

struct glint_store {
    glint_devices *devices;
    glint_importer *importer;
    glint_keep *keep; // NULL: nothing is kept
    struct glint_import_limits limits;
    glint_assets *assets;
    _Atomic uint64_t resident_bytes, imports, import_failures;
    pthread_t loader;
    bool loading;         // the thread was started
    atomic_bool stop;     // the thread is to end
    char (*recalled)[65]; // [recalls] revisions that jobs need
    size_t recalls;
    void (*published)(void *user, const char *name);
    void *user;
    pthread_mutex_t editing[GLINT_STORE_EDITORS]; // by a hash of the name: taken before `mutex`
    pthread_mutex_t mutex;                        // guards what follows
    struct glint_named scene[GLINT_MAX_SCENES];   // by name
    size_t scenes;
};

// Index of the name, or where it would stand (*found false). With the mutex.
size_t glint_store_find(const glint_store *store, const char *name, bool *found);

// *out: every current revision, retained, in a malloc'd array.
bool glint_store_retain_all(glint_store *store, glint_revision ***out, size_t *count);

// Takes up the scenes of the journal, by name; before any other thread knows of the store.
glint_status glint_store_recall_scenes(glint_store *store, glint_keeper *keeper,
                                       struct glint_error *err);

#endif
