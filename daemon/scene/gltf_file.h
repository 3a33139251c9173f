// gltf_file.h - an opened glTF file, and the steps that turn it into a scene. For gltf_*.c only.
#ifndef GLINT_SCENE_GLTF_FILE_H
#define GLINT_SCENE_GLTF_FILE_H

#include "protocol/json.h"
#include "protocol/scene.h"

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
    double world[16];  // column-major
    const char *name;  // as authored, may be ""
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
    GLTF_ID_KINDS
};

struct glint_gltf {
    struct glint_error *err;
    struct glint_scene *scene;        // being built
    struct glint_arena scratch;       // lives as long as this
    struct glint_gltf_span json, bin; // of the file; bin.bytes is NULL where there is none
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
    bool *sampler_read;
    float *reach;              // largest |coordinate| of each scene mesh
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
void glint_gltf_read_buffers(struct glint_gltf *g);

// --- gltf_notes.c
// A warning for the user. At most 8 of a group are given in full, the rest are counted.
void glint_gltf_note(struct glint_gltf *g, const char *group, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
// A note for each extension of `object` that is not in the NULL-terminated list.
void glint_gltf_ignored(struct glint_gltf *g, const struct glint_json *object, const char *what,
                        const char *name, const char *const *known);
// What no other step looks at: animations, skins, scenes left out.
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

// --- gltf_materials.c, gltf_textures.c
void glint_gltf_read_materials(struct glint_gltf *g);
// The scene's material of a glTF material, the default one for GLINT_NONE.
uint32_t glint_gltf_material(struct glint_gltf *g, uint32_t material);
// The texture that a textureInfo object asks for; image GLINT_NONE when there is none.
struct glint_texture glint_gltf_texture(struct glint_gltf *g, const struct glint_json *info,
                                        const char *material);

// --- gltf_meshes.c, gltf_geometry.c, gltf_assimp.c
enum glint_gltf_part { GLTF_POSITION, GLTF_NORMAL, GLTF_UV, GLTF_TANGENT, GLTF_INDEX, GLTF_PARTS };

// A triangle primitive of some mesh; equal ones are one.
struct glint_gltf_geometry {
    struct glint_gltf_accessor part[GLTF_PARTS]; // count 0: absent
    uint32_t mode;                               // 4 triangles, 5 strip, 6 fan
    const char *name;                            // of the mesh, for people
};
// Meshes, objects and instances.
void glint_gltf_read_meshes(struct glint_gltf *g);
// Fills the arrays of scene->mesh[0..count), one for each geometry.
void glint_gltf_read_geometry(struct glint_gltf *g, const struct glint_gltf_geometry *geometry,
                              uint32_t count);
// Has Assimp assemble the geometries first..first+count.
void glint_gltf_assemble(struct glint_gltf *g, const struct glint_gltf_geometry *geometry,
                         uint32_t first, uint32_t count);
// Makes normals unit, tangents and texture coordinates finite; a fault where a position is not.
// Fills g->reach.
void glint_gltf_clean_mesh(struct glint_gltf *g, uint32_t mesh,
                           const struct glint_gltf_geometry *geometry);

// --- gltf_lights.c, gltf_cameras.c
void glint_gltf_read_lights(struct glint_gltf *g);
void glint_gltf_read_cameras(struct glint_gltf *g);

// --- gltf_matrix.c: column-major, double
void glint_gltf_multiply(double out[16], const double a[16], const double b[16]);
void glint_gltf_compose(double out[16], const double t[3], const double q[4], const double s[3]);
// False when the transform cannot be used as one: not finite in single precision, or singular.
bool glint_gltf_to_float(float out[16], const double m[16]);
// Largest |coordinate| in the world of points whose own are at most `reach`.
double glint_gltf_reach(const float m[16], float reach);
// Only its rotation (-z and y kept, as far as they can be) and translation; false when it has no
// direction or does not fit.
bool glint_gltf_rigid(float out[16], const double m[16]);

#endif
