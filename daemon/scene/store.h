// store.h - the named scenes of the daemon and their resident revisions.
//
// A scene is replaced whole; a job keeps the revision it started on for as long as it holds a
// reference. The revision is the SHA-256 of the canonical text and its asset hashes.
//
// Threads: any; one mutex, held for look-ups only. Loading runs on the caller's thread.
#ifndef GLINT_SCENE_STORE_H
#define GLINT_SCENE_STORE_H

#include "base/keeper.h"
#include "scene/import.h"
#include "scene/posed.h"

#include <cjson/cJSON.h>

typedef struct glint_store glint_store;
typedef struct glint_revision glint_revision; // counted: resident scene + native text + resource

// keeper: where scenes and assets are kept across restarts; NULL: nowhere.
glint_status glint_store_create(glint_store **out, glint_devices *devices, glint_importer *importer,
                                const struct glint_import_limits *limits, glint_keeper *keeper,
                                struct glint_error *err);
void glint_store_destroy(glint_store **store); // no revision may be in use

// To be called once whoever knows of more revisions has recalled them: a thread brings the scenes
// back into memory, one after the other, and then what nobody needs is collected.
glint_status glint_store_begin(glint_store *store, struct glint_error *err);
// A revision of the scene `name`, which a job was submitted for before a restart; retained. needed:
// the job has not ended.
glint_status glint_store_recall(glint_store *store, const char *name, const char *id, bool needed,
                                glint_revision **out, struct glint_error *err);

// What its scenes name by hash; borrowed. What clients put there may be half of what an import may
// use.
glint_assets *glint_store_assets(glint_store *store);

// Takes an asset of a client, and keeps it: see glint_assets_put().
glint_status glint_store_put_asset(glint_store *store, const struct glint_asset *asset,
                                   glint_memory_ref *memory, bool *created,
                                   struct glint_error *err);

// Imports, builds and publishes under `name` ([A-Za-z0-9._-]{1,128}); source->assets is set here.
// if_match: the revision that must be current, or NULL. *created tells 201 from 200. *out is
// retained for the caller.
glint_status glint_store_put(glint_store *store, const char *name,
                             const struct glint_import_source *source, const char *if_match,
                             glint_revision **out, bool *created, struct glint_error *err);
// Applies a merge patch (RFC 7396) to the native form of the scene and publishes what comes of it,
// as put. Two patches of one scene are applied one after the other. *report says what was made
// anew; a patch that changes nothing keeps the revision.
//   GLINT_E_NOT_FOUND  no such scene
//   GLINT_E_STALE      if_match is not, or was not any more, the current revision
//   others             as put, with pointers into the patched scene; nothing has changed
struct glint_patch_report {
    bool changed;
    struct glint_resident_change change; // all kept where nothing changed
    double parse_seconds, total_seconds;
};
glint_status glint_store_patch(glint_store *store, const char *name, const char *text,
                               size_t length, const char *if_match, glint_revision **out,
                               struct glint_patch_report *report, struct glint_error *err);

// Called after every change of what a name stands for but its removal, on the thread that made it,
// without a lock. NULL: none. To be set while no scene changes.
void glint_store_on_publish(glint_store *store, void (*published)(void *user, const char *name),
                            void *user);

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
bool glint_store_imports(const glint_store *store); // false: it can take no more files

glint_revision *glint_revision_retain(glint_revision *revision);
void glint_revision_release(glint_revision **revision);
void glint_revision_use(glint_revision *revision, int delta); // jobs that hold it: +1, -1
// After a restart a revision is known before it is in memory again. Whoever needs its content loads
// it first, which takes as long as building the scene; the calls below but use, id and resource are
// for loaded ones.
//   GLINT_E_DAMAGED  its files are damaged or gone
//   GLINT_E_CAPACITY, GLINT_E_NOMEM  it does not fit now
glint_status glint_revision_load(glint_revision *revision, struct glint_error *err);
struct glint_resident *glint_revision_resident(const glint_revision *revision); // borrowed
// Loads the revision. What the job renders of it: at rest, or the pose of its frame, which is kept for other
// jobs within bounds. *out is retained for the caller.
//   GLINT_E_RANGE     no such animation, at /animation
//   GLINT_E_CAPACITY  the pose does not fit
glint_status glint_revision_pose(glint_revision *revision, const struct glint_job *job,
                                 struct glint_posed *out, struct glint_error *err);
// Counts the bytes of structures that were built for the scene at rest since it was loaded.
void glint_revision_weigh(glint_revision *revision);
const char *glint_revision_id(const glint_revision *revision); // 64 hex digits
const char *glint_revision_native(const glint_revision *revision, size_t *length);
// The scene resource of PROTOCOL.md with warnings, effects, bytes by kind, seconds by load stage.
cJSON *glint_revision_resource(const glint_revision *revision);
// {"rebuilt": [names of parts], "uploaded": [...], "later": [...], "kept": [...],
//  "items": {name: made anew}, "milliseconds": {name: ..., "parse": ..., "total": ...}}
cJSON *glint_patch_describe(const struct glint_patch_report *report);

#endif
