// files.h - the files that a scene was sent with, by name.
//
// Names are relative paths with '/' between their parts, as the sender wrote them but for "./" and
// '\'. Nothing is ever opened: a name finds a part of the request, or nothing.
//
// Thread-safety: one owner.
#ifndef GLINT_SCENE_FILES_H
#define GLINT_SCENE_FILES_H

#include "protocol/arena.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct glint_file {
    char *name;
    const uint8_t *bytes; // borrowed
    size_t size;
    bool used;
};

// Zero-initialise before use. Everything but the bytes is in the arena that was given.
struct glint_files {
    struct glint_file *file;
    uint32_t count;
};

// The file that a path names, marked as used, or NULL: the one with this path, else the only one
// whose last part is that of the path, because senders often leave folders out.
struct glint_file *glint_files_find(struct glint_files *files, const char *path);

// The same for the URI of a glTF: percent escapes are read first. Neither an absolute URI nor one
// that leaves the folder finds anything.
struct glint_file *glint_files_find_uri(struct glint_files *files, const char *uri);

// Makes a name of the kind above of a path, in place.
void glint_files_tidy(char *path);

#endif
