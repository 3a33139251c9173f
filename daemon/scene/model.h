// model.h - what the readers of plain mesh files share: OBJ, PLY and STL to the items of a scene.
//
// These formats are read here and not by Assimp, which would lose what users ask about: it names no
// line or element of a fault, drops faces with indices out of range without a word, gives every
// corner a vertex of its own, merges or renames groups, has no word for half of what MTL files say,
// reads no strips, and takes the counts of a PLY header for granted.
//
// Runs in the import child. Thread-safety: reentrant.
#ifndef GLINT_SCENE_MODEL_H
#define GLINT_SCENE_MODEL_H

#include "protocol/scene.h"
#include "scene/files.h"

struct glint_model_ids; // given so far

struct glint_model {
    struct glint_scene *scene; // being built
    struct glint_error *err;
    struct glint_model_ids *ids;
};

// Readers. Each gives a scene that is not completed: it has neither camera nor emitter.
//   GLINT_E_SYNTAX  the file is not of this format, or ends too early
//   GLINT_E_RANGE   faults, each with its line or element
//   GLINT_E_NOMEM
// `files` are those that came along, NULL where there cannot be any.
glint_status glint_obj_import(struct glint_scene **out, const uint8_t *bytes, size_t size,
                              struct glint_files *files, struct glint_error *err);
glint_status glint_ply_import(struct glint_scene **out, const uint8_t *bytes, size_t size,
                              struct glint_error *err);
glint_status glint_stl_import(struct glint_scene **out, const uint8_t *bytes, size_t size,
                              struct glint_error *err);

// ---- for them

// GLINT_E_NOMEM has been reported where one returns false.
bool glint_model_start(struct glint_model *m, struct glint_error *err);
// *out: the scene, or NULL after a fault.
glint_status glint_model_finish(struct glint_model *m, struct glint_scene **out);
bool glint_model_nomem(struct glint_model *m);

// Room for so many items of each kind.
bool glint_model_room(struct glint_model *m, uint32_t objects, uint32_t meshes, uint32_t materials);
// Each returns the index of the new item, GLINT_NONE without memory. An empty name reads "default";
// bytes that are no UTF-8 read '?'.
uint32_t glint_model_material(struct glint_model *m, const char *name);
uint32_t glint_model_object(struct glint_model *m, const char *name);
// Places the mesh, whose arrays the caller then fills.
struct glint_mesh *glint_model_mesh(struct glint_model *m, uint32_t object, uint32_t material,
                                    const char *name);
// Makes the mesh's normals unit; what has no direction gets that of a face it belongs to.
void glint_model_clean_normals(struct glint_mesh *mesh);
// A colour as files have it, encoded for a screen, to linear.
float glint_model_linear(float value);
// An id for an image.
char *glint_model_image_id(struct glint_model *m, const char *name);

// Doubles a malloc'd array that is full.
bool glint_model_grow(struct glint_model *m, void **array, uint32_t count, uint32_t *capacity,
                      size_t size);

#endif
