// geometry.h - triangles and instances behind a closest-hit and an occlusion query.
// The only place that names rtc*.
//
// Rows are the scene's instance rows: a hit reports its row as `geometry` for a mesh of its own and
// as `instance` for a placed template.
//
// Threads: built by one loader; tracing by any number of workers at once.
#ifndef GLINT_SCENE_GEOMETRY_H
#define GLINT_SCENE_GEOMETRY_H

#include "protocol/status.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct glint_geometry glint_geometry;

// Vertices are [vertices][3] finite floats, indices [triangles][3] < vertices; copied.
struct glint_geometry_mesh {
    const float *position;
    uint32_t vertices;
    const uint32_t *index;
    uint32_t triangles;
    bool cutout; // ask `hole` about every hit
};

// Whether a ray passes the surface at (u, v) of a primitive: called from tracing threads. chance:
// 32 random bits, the same whenever that ray meets that primitive.
typedef bool glint_geometry_hole(const void *user, uint32_t row, uint32_t primitive, float u,
                                 float v, uint32_t chance);

// robust: watertight traversal, 1.2x the time.
glint_status glint_geometry_create(glint_geometry **out, bool robust, glint_geometry_hole *hole,
                                   const void *user, struct glint_error *err);
void glint_geometry_destroy(glint_geometry **geometry);

glint_status glint_geometry_add_mesh(glint_geometry *g, uint32_t row,
                                     const struct glint_geometry_mesh *mesh,
                                     struct glint_error *err);
// A template is a mesh without a place; *index counts from 0.
glint_status glint_geometry_add_template(glint_geometry *g, const struct glint_geometry_mesh *mesh,
                                         uint32_t *index, struct glint_error *err);
// transform: column-major, affine.
glint_status glint_geometry_place(glint_geometry *g, uint32_t row, uint32_t template_index,
                                  const float transform[16], struct glint_error *err);
// Builds. Nothing may be added afterwards.
glint_status glint_geometry_commit(glint_geometry *g, struct glint_error *err);

// Memory that the builder and its structures hold.
uint64_t glint_geometry_bytes(const glint_geometry *g);

// The RTCScene, for benches that trace it without us.
void *glint_geometry_native(const glint_geometry *g);

// Traces rows [0, n) of a wave's columns (kernels/gk_wave.h) in place: closest hits, or for shadow
// rays occlusion (distance becomes -inf). Rows with a negative distance are left alone.
void glint_geometry_trace_wave(const glint_geometry *g, float *wave, uint32_t stride, uint32_t n);
void glint_geometry_shadow_wave(const glint_geometry *g, float *wave, uint32_t stride, uint32_t n);

#endif
