// gltf.h - glTF 2.0 (GLB, or JSON that holds all its data in data URIs) to a scene.
//
// Assimp reads the geometry: it gets a small GLB made here, with nothing in it but the meshes that
// the scene shows, every offset checked. All else is read from the glTF JSON itself, because Assimp
// drops or changes it (emissive strength, fields of view, light units, names, interpolation) or
// misreads it (normalised integers, sparse accessors, indices out of range).
//
// What an animation moves, what is below it and joints keep their nodes; the places of all else are
// in the world.
//
// What a file has and the scene cannot show is a warning that names it.
//
// Runs in the import child. Thread-safety: reentrant.
#ifndef GLINT_SCENE_GLTF_H
#define GLINT_SCENE_GLTF_H

#include "protocol/scene.h"
#include "scene/files.h"

//   GLINT_E_SYNTAX  the container or the JSON is broken
//   GLINT_E_RANGE   faults, with pointers into the glTF JSON
//   GLINT_E_NOMEM
// The scene is not completed: it may lack a camera and an emitter.
// `files` are those that it may name beside its own data, NULL: none.
glint_status glint_gltf_import(struct glint_scene **out, const uint8_t *bytes, size_t size,
                               struct glint_files *files, struct glint_error *err);

#endif
