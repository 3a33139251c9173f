// resident.h - a scene revision as the renderer wants it: geometry in Embree, shading records,
// lights, textures and tables in shared buffers. Immutable; counted.
//
// Threads: create by a loader; retain/release and the queries by any thread.
#ifndef GLINT_SCENE_RESIDENT_H
#define GLINT_SCENE_RESIDENT_H

#include "device/device.h"
#include "protocol/scene.h"

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

struct glint_resident_stats {
    uint64_t triangles, instanced_triangles; // stored, and as seen with instances expanded
    uint64_t geometry_bytes, bvh_bytes, record_bytes, texture_bytes, light_bytes;
    double geometry_seconds, bvh_seconds, texture_seconds, light_seconds;
    uint32_t lights;   // emitters of all kinds
    uint32_t dropped;  // degenerate triangles left out
};
void glint_resident_stats(const glint_resident *resident, struct glint_resident_stats *out);

// Names of the effects that this scene calls for by itself, NULL-terminated, static strings.
size_t glint_resident_effects(const glint_resident *resident, const char **out, size_t capacity);

#endif
