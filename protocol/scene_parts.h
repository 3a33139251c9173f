// scene_parts.h - what the files that read, complete and write scenes share; the job parser takes
// the camera from here. Not for others.
#ifndef GLINT_PROTOCOL_SCENE_PARTS_H
#define GLINT_PROTOCOL_SCENE_PARTS_H

#include "fields.h"
#include "scene.h"

// Plain members, one table for reading and writing each (scene_fields.c).
extern const struct glint_field glint_material_fields[], glint_texture_fields[],
    glint_image_fields[], glint_object_fields[], glint_instance_fields[], glint_light_fields[],
    glint_camera_fields[], glint_environment_fields[];

// The four textures of a material: member and place.
struct glint_texture_slot {
    const char *name;
    size_t offset;
};
extern const struct glint_texture_slot glint_texture_slots[4];
struct glint_texture *glint_texture_of(struct glint_material *m, size_t slot);

// A camera as the native scene and the job write it (scene_write.c).
void glint_camera_write(struct glint_text *t, const struct glint_camera *camera);

// ---- ids (scene_ids.c)

// The ids of one collection, sorted.
struct glint_ids {
    struct glint_id {
        const char *id;
        uint32_t index;
    } * entry;
    uint32_t count;
};
bool glint_ids_index(struct glint_ids *out, const cJSON *collection, struct glint_arena *arena);
uint32_t glint_ids_find(const struct glint_ids *ids, const char *id); // GLINT_NONE: not there

// ---- the reader

struct glint_scene_reader {
    struct glint_scene *scene;
    struct glint_error *err;
    struct glint_arena scratch;       // ids and sorted assets, gone after the parse
    const struct glint_asset **asset; // sorted by hash
    size_t assets;
    struct glint_ids images, materials, meshes, objects;
    float *reach;                // largest |coordinate| of each mesh
    uint64_t primitive_vertices; // made so far
};

// Appends GLINT_E_NOMEM; false.
bool glint_scene_no_memory(struct glint_scene_reader *r);

// Index of the member that names an item of a collection, GLINT_NONE if it is absent or at fault.
uint32_t glint_scene_reference(const struct glint_json *at, const struct glint_ids *ids,
                               const char *what);

// The asset that a member names, of exactly `bytes`; NULL is a fault. Copied where it is not
// aligned to 4 bytes. hash[65] receives the name.
const void *glint_scene_asset(struct glint_scene_reader *r, const struct glint_json *at,
                              uint64_t bytes, char *hash);

// Each reads one item; faults go to the reader's error.
void glint_image_read(struct glint_scene_reader *r, const struct glint_json *at,
                      struct glint_image *out);
void glint_material_read(struct glint_scene_reader *r, const struct glint_json *at,
                         struct glint_material *out);
void glint_mesh_read(struct glint_scene_reader *r, const struct glint_json *at,
                     struct glint_mesh *out, float *reach);
void glint_light_read(struct glint_scene_reader *r, const struct glint_json *at,
                      struct glint_light *out);
void glint_environment_read(struct glint_scene_reader *r, const struct glint_json *at,
                            struct glint_environment *out);

// `id` becomes the name where none is given.
bool glint_camera_read(const struct glint_json *at, const char *id, struct glint_arena *arena,
                       struct glint_camera *out);

// ---- transforms (scene_transform.c)

extern const float glint_identity[16];

// 16 numbers or an object of translation, rotation, scale; absent: unchanged.
bool glint_transform_read(const struct glint_json *at, float out[16]);
// Makes the axes unit and orthogonal (z kept, then y), unless they are within rounding.
void glint_transform_rigid(float m[16]);
// Largest |coordinate| that points of |coordinate| <= reach can have in the world.
double glint_transform_reach(const float m[16], float reach);

// ---- meshes

enum { GLINT_MESH_NORMAL = 1, GLINT_MESH_UV = 2, GLINT_MESH_TANGENT = 4 };
extern const char *const glint_mesh_attribute_names[4]; // in the order of the bits, NULL-terminated

// Where the arrays of a mesh asset begin.
struct glint_mesh_layout {
    uint64_t normal, uv, tangent, index, bytes;
};
struct glint_mesh_layout glint_mesh_layout(uint32_t vertices, uint32_t triangles,
                                           unsigned attributes);

// Checks positions, indices, normals, uvs and tangents of a mesh whose arrays are in place; makes
// normals unit (in a copy). *reach: largest |coordinate|.
bool glint_mesh_check(struct glint_scene_reader *r, const struct glint_json *at,
                      struct glint_mesh *mesh, float *reach);

// ---- assets (scene_asset.c)

unsigned glint_mesh_attributes(const struct glint_mesh *m); // the bits that it has

// Assets made by packing; what has the same bytes is kept once.
struct glint_packing {
    struct glint_asset *asset; // malloc'd, bytes too
    size_t count, capacity;
};
// The name of the packed bytes; false without memory.
bool glint_pack_mesh(struct glint_packing *p, const struct glint_mesh *m, char sha256[65]);
bool glint_pack_image(struct glint_packing *p, const struct glint_image *image, char sha256[65]);

// ---- primitives (scene_primitives.c)

enum glint_primitive_kind { GLINT_SPHERE, GLINT_QUAD, GLINT_BOX, GLINT_DISK };

struct glint_primitive {
    enum glint_primitive_kind kind;
    float radius;
    uint32_t segments; // 3..1024
    float size[3];
};

extern const char *const glint_primitive_names[5]; // NULL-terminated

void glint_primitive_size(const struct glint_primitive *p, uint32_t *vertices, uint32_t *triangles);
// Positions, normals, uvs and indices in the arena; false without memory.
bool glint_primitive_make(const struct glint_primitive *p, struct glint_arena *arena,
                          struct glint_mesh *out);

#endif
