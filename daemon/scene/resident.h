// resident.h - a scene revision as the renderer wants it: geometry in Embree, shading records,
// lights, textures and tables in shared buffers. Immutable; counted.
//
// Threads: create by a loader; retain/release and the queries by any thread.
#ifndef GLINT_SCENE_RESIDENT_H
#define GLINT_SCENE_RESIDENT_H

#include "device/device.h"
#include "protocol/scene.h"
#include "scene/facts.h"

typedef struct glint_resident glint_resident;

// Builds from `scene`, which must have been completed (camera, environment). Takes `scene` on
// success; the assets that it borrows must live until `free_assets(assets)` is called, when the
// last reference goes (may be NULL).
glint_status glint_resident_create(glint_resident **out, glint_devices *devices,
                                   struct glint_scene *scene, void (*free_assets)(void *),
                                   void *assets, struct glint_error *err);
glint_resident *glint_resident_retain(glint_resident *resident);
void glint_resident_release(glint_resident **resident);

const struct glint_scene *glint_resident_scene(const glint_resident *resident);

// The revision that frames name in their header: 64 hex digits, set once by whoever publishes it,
// "" before.
void glint_resident_set_revision(glint_resident *resident, const char *revision);
const char *glint_resident_revision(const glint_resident *resident);

struct glint_resident_stats {
    uint64_t triangles, instanced_triangles; // stored, and as seen with instances expanded
    uint64_t geometry_bytes, bvh_bytes, record_bytes, texture_bytes, light_bytes;
    double geometry_seconds, bvh_seconds, texture_seconds, light_seconds;
    uint32_t lights;  // emitters of all kinds
    uint32_t dropped; // degenerate triangles left out
};
void glint_resident_stats(const glint_resident *resident, struct glint_resident_stats *out);

// What the scene contains, as far as the effects table asks.
const struct glint_scene_facts *glint_resident_facts(const glint_resident *resident);

// Numbers for the frame constants.
struct glint_scene_lighting {
    uint32_t lights;      // entries of the light table
    float environment[3]; // radiance, or factor of the image
    uint32_t env_width, env_height, env_cell_width, env_cell_height;
    float env_rotation; // radians
    float env_choice;   // share of light samples that go to the environment image
};
const struct glint_scene_lighting *glint_resident_lighting(const glint_resident *resident);

// The scene's own centre: positions in records and rays are relative to it.
void glint_resident_centre(const glint_resident *resident, double centre[3]);

// Buffers by purpose, never NULL (tables that a scene does not need hold one dummy entry).
enum glint_table {
    GLINT_TABLE_TRIANGLES,
    GLINT_TABLE_TANGENTS,
    GLINT_TABLE_INSTANCES,
    GLINT_TABLE_MATERIALS,
    GLINT_TABLE_TEXTURES,
    GLINT_TABLE_POOL0,
    GLINT_TABLE_POOL1,
    GLINT_TABLE_POOL2,
    GLINT_TABLE_POOL3,
    GLINT_TABLE_DECODE,
    GLINT_TABLE_LIGHTS,
    GLINT_TABLE_ALIAS,
    GLINT_TABLE_ENV_TEXELS,
    GLINT_TABLE_ENV_CELLS,
    GLINT_TABLES
};
glint_buffer *glint_resident_table(const glint_resident *resident, enum glint_table table);

// The traversal structure; the robust one is built when it is first asked for.
struct glint_geometry;
glint_status glint_resident_geometry(glint_resident *resident, bool robust,
                                     const struct glint_geometry **out, struct glint_error *err);

// Matte keys of the slot tables: 1 is the background, 2.. are the scene's (object, material, asset)
// triples, hidden ones too; then the names that no instance uses, in keys that nothing has. Returns
// the number of keys, the two first included.
struct glint_matte_key {
    const char *name[3]; // object, material, asset ("" or NULL for none)
    uint32_t id[3];      // Cryptomatte IDs; 0 for no name
};
uint32_t glint_resident_mattes(const glint_resident *resident, const struct glint_matte_key **keys);

#endif
