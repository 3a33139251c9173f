// bundle.h - a .gltf or .obj and the files that it names, as one multipart/form-data body.
//
// URIs are data URIs or relative paths, percent-encoded, and reach no file outside the directory of
// the .gltf, by ".." or by link. Of an .obj the material libraries and the pictures that these name
// are taken where they are found; what is missing is for the daemon to name.
//
// Source: RFC 7578.
//
// Thread-safety: reentrant.
#ifndef GLINT_CLI_BUNDLE_H
#define GLINT_CLI_BUNDLE_H

#include "protocol/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct glint_bundle {
    int fd; // of the body; -1: the file names no other and is sent by itself
    uint64_t size;
    char type[96]; // media type
};

// Every file that cannot be had is a fault at the pointer of its URI.
//   GLINT_E_IO      a file cannot be read
//   GLINT_E_SYNTAX  the .gltf is no JSON object
//   GLINT_E_RANGE   faults in it
glint_status glint_bundle_gltf(const char *path, struct glint_bundle *out, struct glint_error *err);
glint_status glint_bundle_obj(const char *path, struct glint_bundle *out, struct glint_error *err);
void glint_bundle_finish(struct glint_bundle *bundle);

#endif
