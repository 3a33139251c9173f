// upload.h - scene files to the daemon.
#ifndef GLINT_CLI_UPLOAD_H
#define GLINT_CLI_UPLOAD_H

#include "session.h"

// Media type of a scene file by its extension, or NULL.
const char *glint_upload_type(const char *path);

// The scene's name for a file: its base name without the extension, with '-' for what names may
// not have ([A-Za-z0-9._-]{1,128}).
void glint_upload_name(const char *path, char name[129]);

// PUTs the file as scene `name`; *scene is its resource. A .gltf and an .obj are sent
// with the files that they name.
glint_status glint_upload_scene(struct glint_session *s, const char *path, const char *name,
                                cJSON **scene, struct glint_error *err);

#endif
