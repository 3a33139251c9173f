// scene_parts.h - what the files that read, complete and write scenes share; the job parser takes
// the camera from here. Not for others.
#ifndef GLINT_PROTOCOL_SCENE_PARTS_H
#define GLINT_PROTOCOL_SCENE_PARTS_H

#include "fields.h"
#include "scene.h"

// Plain members, one table for reading and writing each (scene_fields.c).
extern const struct glint_field glint_material_fields[], glint_texture_fields[],
    glint_image_fields[], glint_object_fields[], glint_node_fields[], glint_skin_fields[],
    glint_instance_fields[], glint_animation_fields[], glint_channel_fields[], glint_light_fields[],
    glint_camera_fields[], glint_medium_fields[], glint_environment_fields[], glint_scene_fields[];

// The textures of a material: member and place.
#define GLINT_TEXTURE_SLOTS 10
struct glint_texture_slot {
    const char *name;
    size_t offset;
};
extern const struct glint_texture_slot glint_texture_slots[GLINT_TEXTURE_SLOTS];
struct glint_texture *glint_texture_of(struct glint_material *m, size_t slot);

#define GLINT_DEFAULT_YFOV 0.7f // radians, about 40 degrees
#define GLINT_DEFAULT_FPS 24

// A camera as the native scene and the job write it, without its node (scene_write.c).
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

// ---- names of assets (scene_hashes.c)

// Zero-initialise before use. Names are 64 lower-case hexadecimal digits.
struct glint_hashes {
    struct glint_hash_slot *slot; // owned
    size_t capacity, used;
};
// The first index that is added for a name stays. False without memory.
bool glint_hashes_add(struct glint_hashes *h, const char *sha256, uint32_t index);
uint32_t glint_hashes_find(const struct glint_hashes *h, const char *sha256); // GLINT_NONE: absent
void glint_hashes_finish(struct glint_hashes *h);

// ---- the reader

// An earlier scene whose meshes and images are known to be good, and the meshes of this one that
// are by now.
struct glint_scene_trust {
    const struct glint_scene *scene;    // NULL: nothing is
    struct glint_hashes meshes, images; // made when first asked
    uint32_t next_mesh, next_image;     // an edited text names most in the same order
    struct glint_hashes own_meshes;
};

struct glint_scene_reader {
    struct glint_scene *scene;
    struct glint_error *err;
    struct glint_arena scratch; // ids, gone after the parse
    const struct glint_asset *asset;
    struct glint_hashes assets;
    uint64_t budget; // bytes of assets that may be walked yet
    struct glint_ids images, materials, meshes, objects, nodes, skins;
    struct glint_scene_trust trust;
    uint64_t primitive_vertices; // made so far
    // For channels: [nodes][4] 1 + the animation that had one last for the path; [nodes] targets of
    // the meshes on it, GLINT_NONE where they differ.
    uint32_t *animated, *targets;
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

// To be asked before the bytes of an asset are walked: some text must not cost hours by naming one
// large asset again and again. False with a fault.
bool glint_scene_charge(struct glint_scene_reader *r, const struct glint_json *at, uint64_t bytes);

// Each reads one item; faults go to the reader's error.
void glint_image_read(struct glint_scene_reader *r, const struct glint_json *at,
                      struct glint_image *out);
void glint_material_read(struct glint_scene_reader *r, const struct glint_json *at,
                         struct glint_material *out);
void glint_mesh_read(struct glint_scene_reader *r, const struct glint_json *at,
                     struct glint_mesh *out);
void glint_node_read(struct glint_scene_reader *r, const struct glint_json *at,
                     struct glint_node *out);
void glint_skin_read(struct glint_scene_reader *r, const struct glint_json *at,
                     struct glint_skin *out);
void glint_instance_read(struct glint_scene_reader *r, const struct glint_json *at,
                         struct glint_instance *out);
// Makes what channels need of nodes and instances; false without memory.
bool glint_animations_prepare(struct glint_scene_reader *r);
void glint_animation_read(struct glint_scene_reader *r, const struct glint_json *at,
                          struct glint_animation *out);
void glint_light_read(struct glint_scene_reader *r, const struct glint_json *at,
                      struct glint_light *out);
void glint_medium_read(struct glint_scene_reader *r, const struct glint_json *at,
                       struct glint_medium *out);
void glint_environment_read(struct glint_scene_reader *r, const struct glint_json *at,
                            struct glint_environment *out);

// `id` becomes the name where none is given. nodes NULL: a camera of a job, which has none.
bool glint_camera_read(const struct glint_json *at, const char *id, const struct glint_ids *nodes,
                       struct glint_arena *arena, struct glint_camera *out);

// Reads the items of a collection into an array with room for `extra` more. *count grows with each
// that was read; each begins with its id. NULL is a fault.
typedef void glint_read_item(struct glint_scene_reader *r, const struct glint_json *at, void *out);
void *glint_collection_read(struct glint_scene_reader *r, const struct glint_json *at,
                            size_t item_bytes, glint_read_item *read, uint32_t extra,
                            uint32_t *count);

// ---- transforms (scene_transform.c)

extern const float glint_identity[16];

// 16 numbers or an object of translation, rotation, scale; absent: unchanged.
bool glint_transform_read(const struct glint_json *at, float out[16]);
// The same into a node, which remembers how it was said.
bool glint_transform_read_node(const struct glint_json *at, struct glint_node *node);
void glint_transform_compose(const float translation[3], const float rotation[4],
                             const float scale[3], float m[16]);
bool glint_transform_affine(float m[16]); // and makes the last row exact
bool glint_transform_invertible(const double m[16]);
// Makes the axes unit and orthogonal (z kept, then y), unless they are within rounding.
void glint_transform_rigid(float m[16]);
// Largest |coordinate| that points of |coordinate| <= reach can have in the world.
double glint_transform_reach(const float m[16], float reach);
// How much m stretches a vector at most: its largest singular value, but for rounding.
double glint_transform_stretch(const float m[16]);
// out = a b; out is neither.
void glint_transform_product(double out[16], const double a[16], const float b[16]);
void glint_transform_chain(double out[16], const double a[16], const double b[16]);

// ---- nodes (scene_nodes.c)

struct glint_node_order {
    uint32_t *order; // [nodes], parents before children
    uint32_t *loop;  // one node of each circle of parents; what hangs there has no order
    uint32_t loops;
};
// In the arena. Linear. False without memory.
bool glint_nodes_order(const struct glint_scene *scene, struct glint_arena *arena,
                       struct glint_node_order *out);
// Node to world at rest, of each; NULL without memory.
double (*glint_nodes_world(const struct glint_scene *scene, struct glint_arena *arena))[16];

// ---- where everything is (scene_box.c)

// Around what is visible at rest and where each channel of an animation takes it by itself; skinned
// meshes at rest. *any: false for nothing. False without memory.
bool glint_scene_box(const struct glint_scene *scene, double low[3], double high[3], bool *any);

// ---- what moves (scene_reach.c)

// Faults where something may leave the world's bounds at any time of any animation, and where a
// transform at rest is singular. For a scene without faults.
void glint_scene_check_reach(struct glint_scene_reader *r, const struct glint_json *root);

// ---- meshes

enum {
    GLINT_MESH_NORMAL = 1,
    GLINT_MESH_UV = 2,
    GLINT_MESH_TANGENT = 4,
    GLINT_MESH_UV1 = 8,
    GLINT_MESH_COLOR = 16,
    GLINT_MESH_JOINTS = 32,
    GLINT_MESH_WEIGHTS = 64,
    GLINT_MESH_TARGET_NORMAL = 128,
    GLINT_MESH_TARGET_TANGENT = 256,
};
#define GLINT_MAX_TARGETS 256u
// In the order of the bits, NULL-terminated; targets' begin with GLINT_MESH_TARGET_NORMAL.
extern const char *const glint_mesh_attribute_names[8], *const glint_target_attribute_names[3];

unsigned glint_mesh_attributes(const struct glint_mesh *m); // the bits that it has

// Where the arrays of a mesh asset begin and how long they are, in the order of the asset
// (scene_mesh_layout.c). The counts are those of `m`.
#define GLINT_MESH_ARRAYS 12
struct glint_mesh_layout {
    uint64_t at[GLINT_MESH_ARRAYS], size[GLINT_MESH_ARRAYS], bytes;
};
struct glint_mesh_layout glint_mesh_layout(const struct glint_mesh *m, unsigned attributes);
const void *glint_mesh_array(const struct glint_mesh *m, size_t array);
void glint_mesh_set_array(struct glint_mesh *m, size_t array, const void *values);

// Positions and indices, which triangles there are, from arrays of numbers (scene_mesh_inline.c).
bool glint_mesh_read_inline(struct glint_scene_reader *r, const struct glint_json *at,
                            struct glint_mesh *m);
// "target_weights", once the number of targets is known.
bool glint_mesh_read_weights(struct glint_scene_reader *r, const struct glint_json *at,
                             const char *key, uint32_t targets, const float **out);

// The box of the positions, of which there are some.
void glint_mesh_box(const struct glint_mesh *m, float low[3], float high[3]);
// Checks a mesh whose arrays are in place and finds what the parser finds of it. In copies: normals
// and weights are made unit, colours are cut at 1.
bool glint_mesh_check(struct glint_scene_reader *r, const struct glint_json *at,
                      struct glint_mesh *mesh);

// ---- trust (scene_trust.c)

// Takes what an earlier check found of the same mesh. False: it must be checked. After a lack of
// memory: true, with the fault.
bool glint_trust_mesh(struct glint_scene_reader *r, struct glint_mesh *mesh);
// The mesh, which is the next of the scene, has been checked. False without memory.
bool glint_trust_own_mesh(struct glint_scene_reader *r, const struct glint_mesh *mesh);
bool glint_trust_image(struct glint_scene_reader *r, const struct glint_image *image);
void glint_trust_finish(struct glint_scene_trust *trust);

// ---- assets (scene_asset.c)

// Assets made by packing; what has the same bytes is kept once.
struct glint_packing {
    struct glint_asset *asset; // malloc'd, bytes too
    size_t count, capacity;
    struct glint_hashes there;
};
// Begins with assets that are there already; false without memory.
bool glint_packing_start(struct glint_packing *p, struct glint_asset *asset, size_t count);
// Each gives the name of the packed bytes; false without memory.
bool glint_pack_mesh(struct glint_packing *p, const struct glint_mesh *m, char sha256[65]);
bool glint_pack_image(struct glint_packing *p, const struct glint_image *image, char sha256[65]);
bool glint_pack_skin(struct glint_packing *p, const struct glint_skin *skin, char sha256[65]);
bool glint_pack_channel(struct glint_packing *p, const struct glint_animation_channel *channel,
                        char sha256[65]);

// Numbers in the values of a channel.
size_t glint_channel_values(const struct glint_animation_channel *channel);

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
