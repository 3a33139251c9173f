// uri.h - the bytes behind a URI of a glTF file.
//
// Thread-safety: reentrant.
#ifndef GLINT_CLI_URI_H
#define GLINT_CLI_URI_H

#include "protocol/status.h"

#include <stddef.h>
#include <stdint.h>

#define GLINT_URI_MEDIA 64

struct glint_blob {
    uint8_t *bytes; // malloc'd
    size_t size;
    char media[GLINT_URI_MEDIA]; // of a data URI, else ""
};

// Reads a data URI, or a file by a path relative to `directory` (a real path) that stays inside it.
// Faults go to `pointer`.
glint_status glint_uri_read(const char *directory, const char *uri, struct glint_blob *out,
                            const char *pointer, struct glint_error *err);

// Reads the file by its plain path relative to `directory`, which it has to be in.
glint_status glint_uri_read_path(const char *directory, const char *name, struct glint_blob *out,
                                 const char *pointer, struct glint_error *err);

// A whole regular file of at most 4 GiB, with a terminator behind it.
glint_status glint_uri_read_file(const char *path, struct glint_blob *out, const char *pointer,
                                 struct glint_error *err);

// %41 -> A; malloc'd. NULL: a malformed escape, %00, or no memory.
char *glint_uri_decode(const char *text);

#endif
