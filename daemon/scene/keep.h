// keep.h - scenes and their content in the state folder: what is kept there, read back, let go.
//
// The text of a revision is kept whole in the journal when it is short, in the vault when it is
// long, and as what differs from the revision before where a patch made it. Meshes and pictures are
// files of the vault. A revision is needed while a scene's name or a job that has not ended stands
// for it, while it is held in memory, or while another is told by its difference from it. What
// nobody needs is collected by a thread of this module, a moment after the last need has gone.
//
// Threads: any that may wait for a disk; hold and release wait for a round of collecting at most.
#ifndef GLINT_SCENE_KEEP_H
#define GLINT_SCENE_KEEP_H

#include "base/keeper.h"
#include "scene/import.h"

typedef struct glint_keep glint_keep;

// Both outlive it.
glint_status glint_keep_create(glint_keep **out, glint_keeper *keeper, glint_assets *assets,
                               struct glint_error *err);
// Stops collecting: what goes from now on is kept.
void glint_keep_stop(glint_keep *keep);
void glint_keep_destroy(glint_keep **keep);

// A revision is in memory, and may become needed; and is not any more. depth: as
// glint_keep_read() said, 0 for one that was not read.
void glint_keep_hold(glint_keep *keep, const char *id, uint32_t depth);
void glint_keep_release(glint_keep *keep, const char *id);

// A held revision that a name is to stand for.
struct glint_kept_scene {
    const char *name, *id;
    const struct glint_import *import;
    const char *parent_id; // the revision that it was made from, NULL: none; held and published
    const struct glint_import *parent;
    const char *resource; // JSON
};

// Keeps assets and a long text of the revision.
glint_status glint_keep_content(glint_keep *keep, const char *id, const struct glint_import *import,
                                struct glint_error *err);
// Begins to keep the same beside the caller, for whom glint_keep_content() has less to do once this has
// ended; what goes wrong is told there. NULL: nothing was begun, which is no error.
struct glint_keeping *glint_keep_begin(glint_keep *keep, const char *id,
                                       const struct glint_import *import);
void glint_keep_end(struct glint_keeping **keeping); // waits; NULL is fine
// From now on `name` stands for the revision, whose content is kept. Calls for one name follow one
// another.
glint_status glint_keep_publish(glint_keep *keep, const struct glint_kept_scene *scene,
                                struct glint_error *err);
glint_status glint_keep_remove(glint_keep *keep, const char *name, struct glint_error *err);

// An asset that a client put, which is held in `assets` already.
glint_status glint_keep_asset(glint_keep *keep, const struct glint_asset *asset,
                              struct glint_error *err);

// Calls `scene` for every name, in order, without a thread of the journal waiting.
glint_status glint_keep_scenes(glint_keep *keep,
                               bool (*scene)(void *user, const char *name, const char *revision,
                                             const char *warnings, const char *resource),
                               void *user, struct glint_error *err);

// What an import of the revision gave; warnings: JSON array of strings, or NULL.
//   GLINT_E_NOT_FOUND  it is not kept any more
//   GLINT_E_IO         its files are damaged
glint_status glint_keep_read(glint_keep *keep, const char *id, const char *warnings,
                             struct glint_import **out, uint32_t *depth, struct glint_error *err);

// Brings back what clients had put, and says which revisions are needed but could not be made
// resident, whose content stays; then collection begins.
void glint_keep_adopt(glint_keep *keep);
void glint_keep_pin(glint_keep *keep, const char *id);
void glint_keep_collect(glint_keep *keep);

#endif
