// pack_gltf.h - a .gltf and the files it names, as one GLB in memory.
//
// Buffers become one BIN chunk; images get buffer views in it. URIs are data URIs or relative
// paths, percent-encoded, and reach no file outside the directory of the .gltf, by ".." or by link.
//
// Source: glTF 2.0 specification, 3.6.1.1 "GLB-stored buffer", 4.4 "GLB file format".
//
// Thread-safety: reentrant.
#ifndef GLINT_CLI_PACK_GLTF_H
#define GLINT_CLI_PACK_GLTF_H

#include "protocol/status.h"

#include <stddef.h>
#include <stdint.h>

// *glb is malloc'd. Every buffer and image that cannot be had is a fault at its pointer.
//   GLINT_E_IO      the .gltf cannot be read
//   GLINT_E_SYNTAX  it is no JSON object
//   GLINT_E_RANGE   faults in it
glint_status glint_pack_gltf(const char *path, uint8_t **glb, size_t *size,
                             struct glint_error *err);

#endif
