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

#include <stdbool.h>
#include <stdint.h>

#define GLINT_NONE UINT32_MAX // an absent reference

// Bounds within which products of what a scene holds stay finite in single precision.
#define GLINT_MAX_COORDINATE 1e12f // metres, in the object and in the world
#define GLINT_MAX_RADIANCE 1e20f   // also of intensities
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

struct glint_texture {
    uint32_t image; // GLINT_NONE: no texture
    enum glint_wrap wrap_u, wrap_v;
};

enum glint_alpha_mode { GLINT_ALPHA_OPAQUE, GLINT_ALPHA_MASK };

// Metallic-roughness material of glTF 2.0 with transmission, ior and emission strength.
struct glint_material {
    char *id, *name;
    float base_color[3]; // 0..1
    float opacity;       // 0..1, alpha of the base colour; only used by GLINT_ALPHA_MASK
    enum glint_alpha_mode alpha_mode;
    float alpha_cutoff; // opacity below it is a hole
    float metallic;     // 0..1
    float roughness;    // 0..1, alpha_g = roughness^2; below 1e-3 in alpha_g the lobe is a delta
    float ior;          // 1..10 (1: no dielectric interface), relative to vacuum
    float transmission; // 0..1 share of the non-metallic base that transmits instead of diffusing
    bool thin;          // transmits without bending: an infinitely thin wall
    bool double_sided;  // emits on both sides
    float emission[3];  // radiance, >= 0
    float normal_scale; // of the normal map's x and y
    struct glint_texture base_color_texture;         // rgb sRGB, a opacity
    struct glint_texture metallic_roughness_texture; // g roughness, b metallic, linear
    struct glint_texture normal_texture;             // tangent space, linear
    struct glint_texture emission_texture;           // sRGB
};

struct glint_mesh {
    char *id;
    uint32_t vertices, triangles; // each 1..2^31-1 where present
    const float *position;        // [vertices][3], finite
    const float *normal;          // [vertices][3] unit, or NULL: flat
    const float *uv;              // [vertices][2], or NULL
    const float *tangent;         // [vertices][4], w = sign of the bitangent, or NULL
    const uint32_t *index;        // [triangles][3], each < vertices
    char asset[65];               // "" when inline or a primitive
};

// What an object matte selects.
struct glint_object {
    char *id;
    char *name;  // Cryptomatte object name
    char *asset; // Cryptomatte asset name, "" for none
};

struct glint_instance {
    char *id;
    uint32_t object, mesh, material;
    float transform[16]; // column-major object to world, affine, not singular
    bool visible;
};

enum glint_light_kind { GLINT_LIGHT_POINT, GLINT_LIGHT_SPOT, GLINT_LIGHT_SUN, GLINT_LIGHT_AREA };

struct glint_light {
    char *id, *name;
    enum glint_light_kind kind;
    float color[3];               // >= 0
    float intensity;              // point, spot: W/sr; sun: W/m^2; area: radiance
    float transform[16];          // position and direction (-z)
    float inner_cone, outer_cone; // spot, radians, 0 <= inner < outer <= pi/2
    float size[2];                // area, metres along local x and y; emits along -z
};

struct glint_camera {
    char *id, *name;
    float transform[16];  // camera to world; looks along -z, +y up
    float yfov;           // radians, 0 < yfov < pi
    float lens_radius;    // metres, 0: pinhole
    float focus_distance; // metres along the view axis, > 0 where lens_radius > 0
};

struct glint_environment {
    float radiance[3]; // constant, or factor of the image
    uint32_t image;    // equirectangular (u = 0.5 is -z, v = 0 is +y), GLINT_NONE for constant
    float rotation;    // radians about +y
};

struct glint_scene {
    struct glint_arena arena; // owns every string and inline array
    uint32_t images, materials, meshes, objects, instances, lights, cameras;
    struct glint_image *image;
    struct glint_material *material;
    struct glint_mesh *mesh;
    struct glint_object *object;
    struct glint_instance *instance;
    struct glint_light *light;
    struct glint_camera *camera;
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

void glint_scene_destroy(struct glint_scene **scene);

// Adds a warning (printf). Only while the scene is being built.
void glint_scene_warn(struct glint_scene *scene, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

// Adds the camera and environment that a scene must have, with a warning each.
glint_status glint_scene_complete(struct glint_scene *scene, struct glint_error *err);

// The canonical native JSON: keys in a fixed order, shortest round-trip numbers; meshes and images
// by asset hash. Those that have no asset yet are packed into new assets, appended to *asset
// (malloc'd array and bytes, the caller's; NULL and 0 to begin with). Parsing the text gives an
// equal scene. GLINT_E_NOMEM only; *asset is as it was then, *text NULL.
glint_status glint_scene_write(const struct glint_scene *scene, char **text, size_t *length,
                               struct glint_asset **asset, size_t *assets, struct glint_error *err);

#endif
