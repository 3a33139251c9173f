// edit.h - a merge patch (RFC 7396) of a scene's native form.
//
// The text is a client's: it is checked by the parser as any other, here, because nothing in it has
// to be decoded; where the patch has images, which may be encoded, the import child decodes them.
//
// Threads: any loader.
#ifndef GLINT_SCENE_EDIT_H
#define GLINT_SCENE_EDIT_H

#include "scene/import.h"

#include <cjson/cJSON.h>

// A scene that was imported before, and what an edit may use.
struct glint_edit {
    const struct glint_import *import;
    const struct glint_scene *scene; // of it
    glint_importer *importer;
    const struct glint_import_limits *limits;
    glint_assets *assets;
};

// The edited scene: *import is what an import of it would give, with the warnings of the scene
// before, but for those about an added camera or environment that is another now, and with those of
// what the patch brings; *scene is parsed from it. Both are the caller's, who destroys the scene first. Equal
// texts: nothing has changed.
//   GLINT_E_SYNTAX, GLINT_E_RANGE  pointers into the edited scene
glint_status glint_edit_run(const struct glint_edit *edit, const char *patch, size_t length,
                            struct glint_import **import, struct glint_scene **scene,
                            struct glint_error *err);

// RFC 7396 for two objects: `target` becomes the result and is returned; NULL without memory, or
// where it was NULL.
cJSON *glint_edit_merge(cJSON *target, const cJSON *patch);

#endif
