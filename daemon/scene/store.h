// store.h - the named scenes of the daemon and their resident revisions.
//
// A scene is replaced whole; a job keeps the revision it started on for as long as it holds a
// reference. The revision is the SHA-256 of the canonical text and its asset hashes.
//
// Threads: any; one mutex, held for look-ups only. Loading runs on the caller's thread.
#ifndef GLINT_SCENE_STORE_H
#define GLINT_SCENE_STORE_H

#include "scene/import.h"
#include "scene/resident.h"

#include <cjson/cJSON.h>

typedef struct glint_store glint_store;
typedef struct glint_revision glint_revision; // counted: resident scene + native text + resource

glint_status glint_store_create(glint_store **out, glint_devices *devices, glint_importer *importer,
                                const struct glint_import_limits *limits, struct glint_error *err);
void glint_store_destroy(glint_store **store); // no revision may be in use

// What its scenes name by hash; borrowed. What clients put there may be half of what an import may
// use.
glint_assets *glint_store_assets(glint_store *store);

// Imports, builds and publishes under `name` ([A-Za-z0-9._-]{1,128}); source->assets is set here.
// if_match: the revision that must be current, or NULL. *created tells 201 from 200. *out is
// retained for the caller.
glint_status glint_store_put(glint_store *store, const char *name,
                             const struct glint_import_source *source, const char *if_match,
                             glint_revision **out, bool *created, struct glint_error *err);
glint_status glint_store_get(glint_store *store, const char *name, glint_revision **out,
                             struct glint_error *err);
// Names it no longer; revisions in use live on. GLINT_E_CONFLICT while jobs use it unless `force`.
glint_status glint_store_delete(glint_store *store, const char *name, const char *if_match,
                                bool force, struct glint_error *err);
cJSON *glint_store_list(glint_store *store); // {"scenes": [resource, ...]} by name

struct glint_store_stats {
    uint32_t scenes;
    uint64_t resident_bytes; // of every revision that lives, named or only in use
    uint64_t imports, import_failures;
};
void glint_store_stats(glint_store *store, struct glint_store_stats *out);

glint_revision *glint_revision_retain(glint_revision *revision);
void glint_revision_release(glint_revision **revision);
void glint_revision_use(glint_revision *revision, int delta); // jobs that hold it: +1, -1
struct glint_resident *glint_revision_resident(const glint_revision *revision); // borrowed
const char *glint_revision_id(const glint_revision *revision);                  // 64 hex digits
const char *glint_revision_native(const glint_revision *revision, size_t *length);
// The scene resource of PROTOCOL.md with warnings, effects, bytes by kind, seconds by load stage.
cJSON *glint_revision_resource(const glint_revision *revision);

#endif
