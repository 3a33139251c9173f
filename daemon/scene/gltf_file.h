// gltf_file.h - an opened glTF file, and the steps that turn it into a scene. For gltf_*.c only.
#ifndef GLINT_SCENE_GLTF_FILE_H
#define GLINT_SCENE_GLTF_FILE_H

#include "protocol/json.h"
#include "protocol/scene.h"
#include "scene/files.h"
#include "scene/matrix.h"

// --- names

struct glint_gltf_name {
    const char *text; // NULL: free
    uint32_t value;
};

// A set of strings, each with a number that starts at 0. Zero-initialise before use.
struct glint_gltf_names {
    struct glint_gltf_name *slot;
    uint32_t used, capacity;
};

// The number that belongs to `text`, which is copied into `arena` when it is new; NULL without
// memory. Good until the next call.
uint32_t *glint_gltf_names_at(struct glint_gltf_names *names, struct glint_arena *arena,
                              const char *text);
// An id that the set has not given before: `text` with all but [A-Za-z0-9._-] replaced by '_', cut
// at 64 bytes, and "_2", "_3"... where it is taken. In `arena`; NULL without memory.
char *glint_gltf_names_id(struct glint_gltf_names *names, struct glint_arena *arena,
                          const char *text);
void glint_gltf_names_finish(struct glint_gltf_names *names);

// --- the file

enum glint_gltf_kind {
    GLTF_ACCESSORS,
    GLTF_ANIMATIONS,
    GLTF_BUFFERS,
    GLTF_VIEWS,
    GLTF_CAMERAS,
    GLTF_IMAGES,
    GLTF_MATERIALS,
    GLTF_MESHES,
    GLTF_NODES,
    GLTF_SAMPLERS,
    GLTF_SCENES,
    GLTF_SKINS,
    GLTF_TEXTURES,
    GLTF_KINDS
};

// One of the arrays at the top of the file.
struct glint_gltf_list {
    struct glint_json at;
    const cJSON **item;
    uint32_t count;
};

struct glint_gltf_span {
    const uint8_t *bytes;
    size_t size;
};

struct glint_gltf_view {
    struct glint_gltf_span data; // bytes NULL: its buffer has none
    uint32_t stride;             // 0: not given
};

// A node that the scene reaches.
struct glint_gltf_node {
    uint32_t parent; // GLINT_NONE: a root
    uint32_t depth;
    bool reached;
    bool matrix;   // given as one; else translation, rotation and scale make `local`
    bool animated; // some channel turns, moves or scales it
    bool weighs;   // some channel morphs what it shows
    bool joint;
    bool moves;          // it or a node above it is animated
    uint32_t frame;      // node of the scene, or GLINT_NONE: what it holds lies in the world
    uint32_t channel[4]; // number of the last animation + 1 that has a channel of each path
    double translation[3], rotation[4], scale[3];
    double local[16], world[16]; // column-major
    double rest[16];             // of a frame: world, but never singular
    bool shrunk;                 // so small that it is not seen, it or a node above it
    const char *name;            // as authored, may be ""
    const char *asset; // extras.asset of the node or of the nearest node above it, or NULL
};

enum glint_gltf_ids {
    GLTF_ID_IMAGE,
    GLTF_ID_MATERIAL,
    GLTF_ID_MESH,
    GLTF_ID_OBJECT,
    GLTF_ID_INSTANCE,
    GLTF_ID_LIGHT,
    GLTF_ID_CAMERA,
    GLTF_ID_NODE,
    GLTF_ID_SKIN,
    GLTF_ID_ANIMATION,
    GLTF_ID_KINDS
};

struct glint_gltf {
    struct glint_error *err;
    struct glint_files *files;        // that came along, or NULL
    struct glint_scene *scene;        // being built
    struct glint_arena scratch;       // lives as long as this
    struct glint_gltf_span json, bin; // of the file; bin.bytes is NULL where there is none
    bool glb;                         // not JSON alone
    size_t trailing;                  // bytes after a GLB
    const char *newer;                // version that the file asks for at least, if that is not 2.0
    cJSON *tree;
    struct glint_json root;
    struct glint_gltf_list list[GLTF_KINDS];
    struct glint_gltf_span *buffer;
    uint8_t **decoded; // data URIs of the buffers, to be freed; NULL entries
    struct glint_gltf_view *view;
    struct glint_gltf_node *node;
    uint32_t *order; // reached nodes, parents before children, in the order of the file
    uint32_t reached;
    struct glint_texture *texture; // of each glTF texture, once read
    bool *texture_read;
    uint32_t *image; // scene image of each glTF image, once decoded
    bool *image_read;
    uint32_t *skin;            // scene skin of each glTF skin, GLINT_NONE: not in use
    const float **floats;      // of each accessor that animations read
    float *reach;              // largest |coordinate| of each scene mesh
    uint32_t *joints;          // that vertices of each scene mesh ask for
    uint64_t displaced;        // vertices of all morph targets
    uint32_t default_material; // GLINT_NONE until a primitive needs it
    struct glint_gltf_names ids[GLTF_ID_KINDS];
    struct glint_gltf_names noted;
    uint32_t notes;
};

// --- gltf_container.c
// Finds the JSON and the binary chunk. GLINT_E_SYNTAX names what is wrong with the container.
glint_status glint_gltf_split(struct glint_gltf *g, const uint8_t *bytes, size_t size);

// --- gltf_file.c
struct glint_json glint_gltf_item(const struct glint_gltf *g, enum glint_gltf_kind kind,
                                  uint32_t index);
// Reads a member that is an index into a list. GLINT_NONE when it is absent or at fault.
uint32_t glint_gltf_index(const struct glint_gltf *g, const struct glint_json *object,
                          const char *key, enum glint_gltf_kind kind);
// The member, which is absent or an object; anything else is a fault and reads as absent.
struct glint_json glint_gltf_object(const struct glint_json *object, const char *key);
// The extension's object of the same kind.
bool glint_gltf_extension(const struct glint_json *object, const char *name,
                          struct glint_json hold[2]);
// "name" of the object, "" when it has none. In the scene's arena.
const char *glint_gltf_name(struct glint_gltf *g, const struct glint_json *object);
// Parses the JSON, checks version and required extensions, resolves buffers and views.
glint_status glint_gltf_open(struct glint_gltf *g);
void glint_gltf_close(struct glint_gltf *g);
// Remembers that memory ran out; returns false.
bool glint_gltf_nomem(struct glint_gltf *g);

// --- gltf_buffers.c
// A fault for each file that a buffer or an image names and that did not come along.
void glint_gltf_check_files(struct glint_gltf *g);
void glint_gltf_read_buffers(struct glint_gltf *g);

// --- gltf_notes.c
// A warning for the user. At most 8 of a group are given in full, the rest are counted.
void glint_gltf_note(struct glint_gltf *g, const char *group, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
// A note for each extension of `object` that is not in the NULL-terminated list.
void glint_gltf_ignored(struct glint_gltf *g, const struct glint_json *object, const char *what,
                        const char *name, const char *const *known);
// What no other step looks at: extensions of the file.
void glint_gltf_note_the_rest(struct glint_gltf *g);
void glint_gltf_notes_end(struct glint_gltf *g);

// --- gltf_accessor.c
struct glint_gltf_accessor {
    uint32_t number;                  // in the file
    uint32_t count, components, type; // type: componentType
    bool normalized;
    uint32_t view;          // GLINT_NONE: zeros
    size_t offset;          // in the view
    size_t element, stride; // bytes
    uint32_t sparse;        // elements replaced
    uint32_t sparse_type;
    const uint8_t *sparse_index, *sparse_value;
};

enum { GLTF_I8 = 5120, GLTF_U8, GLTF_I16, GLTF_U16, GLTF_U32 = 5125, GLTF_F32 };

// Checks it against its view; false after a fault.
bool glint_gltf_accessor_read(struct glint_gltf *g, uint32_t index,
                              struct glint_gltf_accessor *out);
// All elements as floats: normalised integers as glTF 2.0 says, others by value. out: count x
// components.
bool glint_gltf_accessor_floats(struct glint_gltf *g, const struct glint_gltf_accessor *a,
                                float *out);
// Appends a GLINT_E_RANGE fault at the accessor; returns false.
bool glint_gltf_accessor_fault(struct glint_gltf *g, const struct glint_gltf_accessor *a,
                               const char *format, ...) __attribute__((format(printf, 3, 4)));
// All elements of a scalar unsigned accessor.
bool glint_gltf_accessor_indices(struct glint_gltf *g, const struct glint_gltf_accessor *a,
                                 uint32_t *out);

// --- gltf_nodes.c
// Fills node, order and reached: hierarchy, world transforms, names.
void glint_gltf_read_nodes(struct glint_gltf *g);
// "a/b/c", each without a name as "node_7".
char *glint_gltf_node_path(struct glint_gltf *g, uint32_t node);

// --- gltf_animations.c, gltf_skins.c, gltf_frames.c: run in this order
// Fills scene->animation; channels name nodes of the file until there are frames.
void glint_gltf_read_animations(struct glint_gltf *g);
// Fills scene->skin for those in use; joints are nodes of the file until there are frames.
void glint_gltf_read_skins(struct glint_gltf *g);
// Makes scene->node of what moves and of what that needs, and lets channels and joints point there.
void glint_gltf_make_frames(struct glint_gltf *g);
// Leaves out channels of weights that nothing shown has. After the instances.
void glint_gltf_drop_idle_channels(struct glint_gltf *g);
// Morph targets of the mesh that a node shows, as its first primitive has them.
uint32_t glint_gltf_targets(struct glint_gltf *g, const struct glint_json *node);
// Where something with a direction but without a size lies: in the world, *frame GLINT_NONE, or in
// the frame of a node that moves. False when it has no direction or does not fit.
bool glint_gltf_place(const struct glint_gltf *g, uint32_t node, float transform[16],
                      uint32_t *frame);

// --- gltf_materials.c, gltf_surfaces.c, gltf_textures.c
void glint_gltf_read_materials(struct glint_gltf *g);
// The scene's material of a glTF material, the default one for GLINT_NONE.
uint32_t glint_gltf_material(struct glint_gltf *g, uint32_t material);
// The texture that a textureInfo object asks for; image GLINT_NONE when there is none.
struct glint_texture glint_gltf_texture(struct glint_gltf *g, const struct glint_json *info,
                                        const char *material);
// The same of a member of the object.
struct glint_texture glint_gltf_texture_member(struct glint_gltf *g,
                                               const struct glint_json *object, const char *key,
                                               const char *material);
// The extensions of a material, whose base has been read.
void glint_gltf_read_surface(struct glint_gltf *g, const struct glint_json *at,
                             struct glint_material *m);

// --- gltf_primitives.c, gltf_meshes.c, gltf_geometry.c, gltf_attributes.c, gltf_assimp.c
enum glint_gltf_part {
    GLTF_POSITION,
    GLTF_NORMAL,
    GLTF_TANGENT,
    GLTF_INDEX,
    GLTF_ASSEMBLED, // those before it go through Assimp, the others are read as they are
    GLTF_UV = GLTF_ASSEMBLED,
    GLTF_UV1,
    GLTF_COLOR,
    GLTF_JOINTS,
    GLTF_WEIGHTS,
    GLTF_PARTS
};

// Displacements of one morph target. count 0: none.
struct glint_gltf_target {
    struct glint_gltf_accessor position, normal, tangent;
};

// A triangle primitive of some mesh; equal ones are one.
struct glint_gltf_geometry {
    struct glint_gltf_accessor part[GLTF_PARTS]; // count 0: absent
    uint32_t mode;                               // 4 triangles, 5 strip, 6 fan
    uint32_t targets;
    struct glint_gltf_target *target;
    const float *weight; // of the targets at rest, or NULL: 0
    const char *name;    // of the mesh, for people
};

struct glint_gltf_primitive {
    uint32_t geometry; // GLINT_NONE: left out
    uint32_t material; // of the file, or GLINT_NONE
};

// The primitives of the file's meshes. Zero-initialise all but g before use.
struct glint_gltf_primitives {
    struct glint_gltf *g;
    struct glint_gltf_geometry *geometry;
    uint32_t geometries, capacity;
    struct glint_gltf_names keys; // accessors of a geometry -> its index + 1
};

// Number `part` of the mesh, whose primitive it is.
struct glint_gltf_primitive glint_gltf_read_primitive(struct glint_gltf_primitives *p,
                                                      const struct glint_json *at, uint32_t mesh,
                                                      uint32_t part, const float *weight,
                                                      const char *name);
// Weights of `targets` morph targets, in the scene's arena; NULL when the object has none.
const float *glint_gltf_weights(struct glint_gltf *g, const struct glint_json *object,
                                uint32_t targets);

// EXT_mesh_gpu_instancing of a node: how many there are, 0 without it or after a fault.
uint32_t glint_gltf_copies(struct glint_gltf *g, const struct glint_json *node);
// Their transforms below the node: in g's scratch, NULL after a fault.
double (*glint_gltf_read_copies(struct glint_gltf *g, const struct glint_json *node))[16];

// Meshes, objects and instances.
void glint_gltf_read_meshes(struct glint_gltf *g);
// Fills the arrays of scene->mesh[0..count), one for each geometry.
void glint_gltf_read_geometry(struct glint_gltf *g, const struct glint_gltf_geometry *geometry,
                              uint32_t count);
// Has Assimp assemble the geometries first..first+count.
void glint_gltf_assemble(struct glint_gltf *g, const struct glint_gltf_geometry *geometry,
                         uint32_t first, uint32_t count);
// Reads what Assimp does not: coordinates, colours, joints, morph targets.
void glint_gltf_read_attributes(struct glint_gltf *g, uint32_t mesh,
                                const struct glint_gltf_geometry *geometry);
// Makes normals unit and tangents finite; a fault where a position is not.
// Fills g->reach.
void glint_gltf_clean_mesh(struct glint_gltf *g, uint32_t mesh,
                           const struct glint_gltf_geometry *geometry);

// --- gltf_lights.c, gltf_cameras.c
void glint_gltf_read_lights(struct glint_gltf *g);
void glint_gltf_read_cameras(struct glint_gltf *g);

// --- gltf_matrix.c: column-major, double
// The reverse, with a negative scale where m mirrors. Returns false when compose would not give m
// back: it is sheared or has an axis without length.
bool glint_gltf_decompose(const double m[16], double t[3], double q[4], double s[3]);
// False when a number does not fit.
bool glint_gltf_fit(float out[16], const double m[16]);
// False when the transform cannot be used as one: not finite in single precision, or singular.
bool glint_gltf_to_float(float out[16], const double m[16]);
// Largest |coordinate| in the world of points whose own are at most `reach`.
double glint_gltf_reach(const float m[16], float reach);
// Only its rotation (-z and y kept, as far as they can be) and translation; false when it has no
// direction or does not fit.
bool glint_gltf_rigid(float out[16], const double m[16]);

#endif
