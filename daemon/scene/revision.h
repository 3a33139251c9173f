// revision.h - how the store makes a revision; everybody else sees store.h.
//
// Threads: any; the counts are atomic, the rest is immutable once made.
#ifndef GLINT_SCENE_REVISION_H
#define GLINT_SCENE_REVISION_H

#include "scene/edit.h"
#include "scene/keep.h"
#include "scene/store.h"

#include <stdatomic.h>

// Jobs that hold any revision of one scene. Counted, because revisions outlive the scene's name.
struct glint_usage {
    atomic_uint references;
    atomic_int jobs;
};

struct glint_usage *glint_usage_create(void); // NULL without memory
struct glint_usage *glint_usage_retain(struct glint_usage *usage);
void glint_usage_release(struct glint_usage **usage);

// What a revision is made of. All but the borrowed members are taken, also by a failure.
struct glint_revision_order {
    const char *name; // borrowed
    struct glint_import *import;
    struct glint_scene *scene; // of the import; NULL: to be parsed
    struct glint_usage *usage;
    const glint_revision *from;       // borrowed: the one before, with which it shares; NULL: none
    _Atomic uint64_t *resident_bytes; // borrowed for its life: grows by its size until it is freed
    glint_keep *keep;                 // borrowed for its life; NULL: nothing is kept
};
glint_status glint_revision_create(glint_revision **out, glint_devices *devices,
                                   const struct glint_revision_order *order,
                                   struct glint_error *err);

// A revision that is only known by what was told of it: everything else is read back when it is
// loaded.
struct glint_revision_memory {
    const char *name, *id;
    const char *warnings, *resource; // JSON, NULL: nobody asks for them
    struct glint_usage *usage;       // taken, also by a failure
    _Atomic uint64_t *resident_bytes;
    glint_keep *keep;
};
glint_status glint_revision_recall(glint_revision **out, glint_devices *devices,
                                   const struct glint_revision_memory *memory,
                                   struct glint_error *err);
bool glint_revision_loaded(const glint_revision *revision);

// What an edit of the loaded revision starts from; borrows.
void glint_revision_edit(const glint_revision *revision, struct glint_edit *out);

// The usage that a next revision of the scene shares; borrowed.
struct glint_usage *glint_revision_usage(const glint_revision *revision);

// 64 hex digits and a terminator: SHA-256 of the canonical text. The text names every mesh and
// image by the hash of its bytes, so it covers the assets too.
void glint_revision_hash(const struct glint_import *import, char id[65]);

#endif
