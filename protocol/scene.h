// scene.h - a scene as data: what the native JSON says, checked, with every reference resolved.
//
// One form for all inputs: an imported GLB becomes the same structure and can be written as the
// same JSON. Collections are keyed by unique ids in the JSON and are arrays here, in the order of
// the document; references are indices into them. Meshes and images given inline or made from
// primitives are arrays in the arena; those named by asset borrow the asset's bytes.
//
// Units: metres, radians, radiance in W/(sr m^2), linear Rec. 709; +y up, cameras and spot lights
// look along -z (glTF). 1 cd is taken as 1 W/sr.
//
// Thread-safety: built by one thread, immutable afterwards.
#ifndef GLINT_PROTOCOL_SCENE_H
#define GLINT_PROTOCOL_SCENE_H

#include "arena.h"
#include "status.h"

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>

#define GLINT_NONE UINT32_MAX // an absent reference

// Bounds within which products of what a scene holds stay finite in single precision.
#define GLINT_MAX_COORDINATE 1e12f // metres, in the object and in the world
#define GLINT_MAX_RADIANCE 1e20f   // also of intensities
#define GLINT_MAX_WEIGHT 1e6f      // of a morph target
#define GLINT_MAX_SECONDS 1e9f     // of an animation
#define GLINT_MAX_IMAGE_SIDE 16384u
#define GLINT_MAX_MESH_COUNT 0x7fffffffu // vertices, triangles

// Bytes named by the SHA-256 of their content.
struct glint_asset {
    char sha256[65]; // lower-case hex
    const uint8_t *bytes;
    size_t size;
};

// The name of the bytes; false if the library has no memory.
bool glint_asset_name(const void *bytes, size_t size, char sha256[65]);

enum glint_image_format {
    GLINT_IMAGE_RGBA8,   // sRGB or linear as its use says; alpha linear
    GLINT_IMAGE_RGBA16F, // linear half floats
};

// Rows from top to bottom, no padding.
struct glint_image {
    char *id;
    uint32_t width, height; // pixels, 1..16384
    enum glint_image_format format;
    const void *pixels;
    char asset[65]; // "" when inline
};

enum glint_wrap { GLINT_WRAP_REPEAT, GLINT_WRAP_CLAMP, GLINT_WRAP_MIRROR };

enum glint_filtering { GLINT_FILTERING_LINEAR, GLINT_FILTERING_NEAREST };

// One use of an image. Its coordinates are translate(offset) rotate(rotation) scale(scale) applied
// to those of the mesh, as KHR_texture_transform has it.
struct glint_texture {
    uint32_t image; // GLINT_NONE: no texture
    enum glint_wrap wrap_u, wrap_v;
    enum glint_filtering filter;
    uint32_t uv_set;                     // 0, 1: which coordinates of the mesh
    float offset[2], scale[2], rotation; // default 0, 1, 0 radians
};

// Opaque ignores opacity, mask makes holes where it is below the cutoff, blend shows what lies
// behind through the share 1 - opacity of the surface.
enum glint_alpha_mode { GLINT_ALPHA_OPAQUE, GLINT_ALPHA_MASK, GLINT_ALPHA_BLEND };

// Metallic-roughness material of glTF 2.0 with its ratified extensions transmission, volume, ior,
// specular, clearcoat and emissive strength; priority and collimation are ours.
struct glint_material {
    char *id, *name;
    float base_color[3]; // 0..1
    float opacity;       // 0..1, alpha of the base colour; not used by GLINT_ALPHA_OPAQUE
    enum glint_alpha_mode alpha_mode;
    float alpha_cutoff; // opacity below it is a hole
    float metallic;     // 0..1
    float roughness;    // 0..1, alpha_g = roughness^2; below 1e-3 in alpha_g the lobe is a delta
    float ior;          // 1..10 (1: no dielectric interface), relative to vacuum
    float transmission; // 0..1 share of the non-metallic base that transmits instead of diffusing
    bool thin;          // transmits without bending: an infinitely thin wall
    bool double_sided;  // emits on both sides; else the camera does not see an opaque one's back
    float emission[3];  // radiance, >= 0
    float normal_scale; // of the normal map's x and y
    float specular;     // 0..1, factor of the dielectric's reflection (KHR_materials_specular)
    float specular_color[3];   // >= 0, of its reflection at normal incidence
    float clearcoat;           // 0..1 (KHR_materials_clearcoat)
    float clearcoat_roughness; // 0..1
    float clearcoat_normal_scale;
    float attenuation_color[3]; // 0..1, what is left of white light after attenuation_distance
    float attenuation_distance; // metres, 0: nothing is absorbed (KHR_materials_volume)
    float collimation;          // 0..1, 1: transmits as sharply as the surface is smooth; towards 0
                                // what is transmitted is scattered
    uint32_t priority; // of nested dielectrics, 1..255: where solids overlap the highest is there
                       // (Schmidt and Budge 2002); 0: each interface is one with empty space
    struct glint_texture base_color_texture;          // rgb sRGB, a opacity
    struct glint_texture metallic_roughness_texture;  // g roughness, b metallic, linear
    struct glint_texture normal_texture;              // tangent space, linear
    struct glint_texture emission_texture;            // sRGB
    struct glint_texture specular_texture;            // a specular
    struct glint_texture specular_color_texture;      // sRGB
    struct glint_texture transmission_texture;        // r transmission
    struct glint_texture clearcoat_texture;           // r clearcoat
    struct glint_texture clearcoat_roughness_texture; // g clearcoat roughness
    struct glint_texture clearcoat_normal_texture;    // tangent space, linear
};

struct glint_mesh {
    char *id;
    uint32_t vertices, triangles; // each 1..2^31-1 where present
    const float *position;        // [vertices][3], finite
    const float *normal;          // [vertices][3] unit, or NULL: flat
    const float *uv;              // [vertices][2], or NULL
    const float *tangent;         // [vertices][4], w = sign of the bitangent, or NULL
    const float *uv1;             // [vertices][2], second set, or NULL
    const float *color;           // [vertices][4] linear rgb and opacity, 0..1, or NULL
    const uint16_t *joint;        // [vertices][4] indices of a skin's joints, or NULL
    const float *weight;          // [vertices][4] >= 0, sum 1, where `joint` is present
    uint32_t targets;             // morph targets, 0..256
    const float *target_position; // [targets][vertices][3] displacements
    const float *target_normal;   // [targets][vertices][3], or NULL
    const float *target_tangent;  // [targets][vertices][3], or NULL
    const float *target_weight;   // [targets] at rest, or NULL: 0
    const uint32_t *index;        // [triangles][3], each < vertices
    char asset[65];               // "" when inline or a primitive
    // Found by the parser, which sets `checked`; 0 where a scene is built otherwise.
    bool checked;
    float low[3], high[3]; // the box of the positions
    float reach;           // largest |coordinate| of a position
    float target_reach;    // largest |coordinate| by which a target moves a vertex
    uint32_t joint_end;    // 1 + the largest index of a joint
};

// What an object matte selects.
struct glint_object {
    char *id;
    char *name;  // Cryptomatte object name
    char *asset; // Cryptomatte asset name, "" for none
};

// A frame of reference that may move. Node -> parent is its transform; a chain ends in the world.
// At rest neither a node's transform nor its product with those above it is singular.
struct glint_node {
    char *id, *name;
    uint32_t parent;                             // GLINT_NONE: the world. No cycles
    float transform[16];                         // column-major, affine; of the node at rest
    float translation[3], rotation[4], scale[3]; // the same; rotation is a unit quaternion x y z w
    bool matrix; // given as 16 numbers: it cannot be animated, the three members above are unset
};

// Joint j moves a vertex by joint_to_world(j) inverse_bind[j]; weights mix the joints.
struct glint_skin {
    char *id;
    uint32_t joints;           // 1..65535
    uint32_t *joint;           // [joints] nodes
    const float *inverse_bind; // [joints][16] column-major, affine
    char asset[65];            // "" when inline
};

enum glint_channel_path {
    GLINT_PATH_TRANSLATION,
    GLINT_PATH_ROTATION,
    GLINT_PATH_SCALE,
    GLINT_PATH_WEIGHTS
};
enum glint_interpolation {
    GLINT_INTERPOLATION_LINEAR, // rotations: spherical, the short way
    GLINT_INTERPOLATION_STEP,
    GLINT_INTERPOLATION_CUBICSPLINE
};

struct glint_animation_channel {
    char *id;
    uint32_t node;
    enum glint_channel_path path;
    enum glint_interpolation interpolation;
    uint32_t keys;      // 1..
    uint32_t width;     // numbers in a value: 3, 4, or the targets of the node's instances
    const float *time;  // [keys] seconds, 0..1e9, growing
    const float *value; // [keys][width]; cubic: [keys][3][width], in-tangent, value, out-tangent
    char asset[65];     // "" when inline
};

struct glint_animation {
    char *id, *name;
    uint32_t channels;
    struct glint_animation_channel *channel; // no two of one node and path
};

struct glint_instance {
    char *id;
    uint32_t object, mesh, material;
    uint32_t node; // GLINT_NONE: the world
    uint32_t skin; // GLINT_NONE: rigid; else `node` does not move it and transform comes after it
    float transform[16]; // column-major object to node, affine, not singular
    const float *weight; // [targets of the mesh], or NULL: those of the mesh
    bool visible;
};

enum glint_light_kind { GLINT_LIGHT_POINT, GLINT_LIGHT_SPOT, GLINT_LIGHT_SUN, GLINT_LIGHT_AREA };

struct glint_light {
    char *id, *name;
    enum glint_light_kind kind;
    float color[3];               // >= 0
    float intensity;              // point, spot: W/sr; sun: W/m^2; area: radiance
    uint32_t node;                // GLINT_NONE: the world
    float transform[16];          // to the node: position and direction (-z)
    float inner_cone, outer_cone; // spot, radians, 0 <= inner < outer <= pi/2
    float size[2];                // area, metres along local x and y; emits along -z
};

enum glint_projection { GLINT_PERSPECTIVE, GLINT_ORTHOGRAPHIC };

struct glint_camera {
    char *id, *name;
    enum glint_projection projection;
    uint32_t node;        // GLINT_NONE: the world; always so in a job
    float transform[16];  // camera to node; looks along -z, +y up
    float yfov;           // radians, 0 < yfov < pi; perspective
    float ymag;           // metres, half the height of what is seen, > 0; orthographic
    float lens_radius;    // metres, 0: pinhole
    float focus_distance; // metres along the view axis, > 0 where lens_radius > 0
};

struct glint_environment {
    float radiance[3]; // constant, or factor of the image
    uint32_t image;    // equirectangular (u = 0.5 is -z, v = 0 is +y), GLINT_NONE for constant
    float rotation;    // radians about +y
};

// A homogeneous medium that scatters by Henyey and Greenstein, in the open space of the scene, that
// is outside of every solid that transmits.
struct glint_medium {
    char *id;
    float density;   // extinction, 1/m, >= 0
    float albedo[3]; // 0..1, share of the extinction that scatters
    float g;         // -1..1, mean cosine
    bool bounded;    // else it has no end, and nothing shines through it from infinity
    float box[6];    // least and greatest corner, metres in the world
};

struct glint_scene {
    struct glint_arena arena; // owns every string and inline array
    uint32_t images, materials, meshes, objects, instances, lights, cameras;
    uint32_t nodes, skins, animations, media; // media: at most 1
    struct glint_image *image;
    struct glint_material *material;
    struct glint_mesh *mesh;
    struct glint_object *object;
    struct glint_instance *instance;
    struct glint_light *light;
    struct glint_camera *camera;
    struct glint_node *node; // parents may come after their children
    struct glint_skin *skin;
    struct glint_animation *animation;
    struct glint_medium *medium;
    float fps; // frames per second that jobs count by, default 24
    bool has_environment;
    struct glint_environment environment;
    uint32_t warnings, warning_capacity;
    char **warning; // sentences for the user, each naming the item it speaks of
};

// Reads the native JSON. `asset` are the bytes that it may name by hash; they must outlive *out.
// Every fault is reported with its pointer; unknown keys are faults. A scene without a camera gets
// one that frames it, one without an emitter a constant environment of radiance 1: both warn.
//   GLINT_E_SYNTAX  not JSON
//   GLINT_E_RANGE   faults in *err
glint_status glint_scene_parse(struct glint_scene **out, const char *text, size_t length,
                               const struct glint_asset *asset, size_t assets,
                               struct glint_error *err);

// As above for an edited text. `checked` (may be NULL) is a scene parsed before: meshes and images
// whose asset, counts, attributes and format are those of one in it are known to be good, and their
// bytes, which must be the same, are not walked again. *out never points into *checked, which may
// be destroyed at once.
glint_status glint_scene_parse_from(struct glint_scene **out, const char *text, size_t length,
                                    const struct glint_asset *asset, size_t assets,
                                    const struct glint_scene *checked, struct glint_error *err);

// The two halves of glint_scene_parse(), for who changes something in between: the text within the
// limits of a scene, *out freed by cJSON_Delete(); then what it says.
glint_status glint_scene_parse_text(cJSON **out, const char *text, size_t length,
                                    struct glint_error *err);
glint_status glint_scene_parse_tree(struct glint_scene **out, const cJSON *tree,
                                    const struct glint_asset *asset, size_t assets,
                                    struct glint_error *err);

void glint_scene_destroy(struct glint_scene **scene);

// What an item is where nothing is said of it: the defaults of the native form. Ids, names and
// references to other items are the caller's, absent ones GLINT_NONE.
void glint_material_init(struct glint_material *material);
void glint_texture_init(struct glint_texture *texture); // no image
void glint_instance_init(struct glint_instance *instance);
void glint_light_init(struct glint_light *light);
void glint_camera_init(struct glint_camera *camera);
void glint_node_init(struct glint_node *node);

// Adds a warning (printf). Only while the scene is being built.
void glint_scene_warn(struct glint_scene *scene, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

// What the warnings of the next two functions say of what was added: an edit that replaces it knows
// them by that.
#define GLINT_CAMERA_ADDED "\"camera\" was added"
#define GLINT_ENVIRONMENT_ADDED "a constant environment of radiance 1 was added"

// Adds the camera and environment that a scene must have, with a warning each.
glint_status glint_scene_complete(struct glint_scene *scene, struct glint_error *err);

// The same for a scene out of a file of another format. Such files are made to be looked at in some
// light of the viewer's, and a surface that emits is a label or a lamp's picture. So the environment
// comes too where only surfaces emit, and the file has no camera or no surface has radiance above 1.
glint_status glint_scene_complete_file(struct glint_scene *scene, struct glint_error *err);

// The canonical native JSON: keys in a fixed order, shortest round-trip numbers; meshes and images
// by asset hash. Those that have no asset yet are packed into new assets, appended to *asset
// (malloc'd array and bytes, the caller's; NULL and 0 to begin with). Parsing the text gives an
// equal scene. GLINT_E_NOMEM only; *asset is as it was then, *text NULL.
glint_status glint_scene_write(const struct glint_scene *scene, char **text, size_t *length,
                               struct glint_asset **asset, size_t *assets, struct glint_error *err);

#endif
