// geometry.h - triangles and instances behind a closest-hit and an occlusion query.
// The only place that names rtc*.
//
// A body is the structure over one mesh, a world the structure over meshes of its own and placed
// bodies; both are counted and shared between revisions. A geometry is a revision's view of a world:
// the world's triangles with that revision's holes.
//
// Rows are the scene's instance rows: a hit reports its row as `geometry` for a mesh of the world
// and as `instance` for a placed body.
//
// Threads: whatever is made on one tracer is made and released one after the other, by any thread;
// tracing by any number of workers at once.
#ifndef GLINT_SCENE_GEOMETRY_H
#define GLINT_SCENE_GEOMETRY_H

#include "protocol/status.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct glint_tracer glint_tracer;
typedef struct glint_body glint_body;
typedef struct glint_world glint_world;
typedef struct glint_geometry glint_geometry;

// A builder and its memory. Bodies are placed in worlds of their own tracer only.
glint_status glint_tracer_create(glint_tracer **out, struct glint_error *err);
glint_tracer *glint_tracer_retain(glint_tracer *tracer);
void glint_tracer_release(glint_tracer **tracer);

// Vertices are [keys][vertices][3] finite floats, indices [triangles][3] < vertices; copied. Between
// the keys, which are equally spaced over the times 0..1, a vertex goes straight.
struct glint_geometry_mesh {
    const float *position;
    uint32_t vertices;
    const uint32_t *index;
    uint32_t triangles;
    uint32_t keys;   // 1: still
    float origin[3]; // taken off every vertex
    bool holes;      // ask about every hit
};

// How long a structure is built, and how fast it is traced then.
enum glint_geometry_quality {
    GLINT_GEOMETRY_FINE,
    GLINT_GEOMETRY_BRISK, // built in a third of the time, traced a little slower
    GLINT_GEOMETRY_QUICK  // in an eighth, traced half as fast
};

// What a structure is built for.
struct glint_geometry_build {
    bool robust; // nothing slips between triangles at an edge, 1.2x the time
    enum glint_geometry_quality quality;
};

glint_status glint_body_create(glint_body **out, glint_tracer *tracer,
                               const struct glint_geometry_mesh *mesh,
                               const struct glint_geometry_build *build, struct glint_error *err);
void glint_body_release(glint_body **body);
uint64_t glint_body_bytes(const glint_body *body);

// Calls `fill`, which adds rows, then builds.
typedef glint_status glint_world_fill(glint_world *world, void *user, struct glint_error *err);
glint_status glint_world_create(glint_world **out, glint_tracer *tracer,
                                const struct glint_geometry_build *build, glint_world_fill *fill,
                                void *user, struct glint_error *err);
glint_world *glint_world_retain(glint_world *world);
void glint_world_release(glint_world **world);
// Without the bodies that are placed in it.
uint64_t glint_world_bytes(const glint_world *world);
// Of all that is made on its tracer.
uint64_t glint_world_tracer_bytes(const glint_world *world);

glint_status glint_world_add_mesh(glint_world *world, uint32_t row,
                                  const struct glint_geometry_mesh *mesh, struct glint_error *err);
// transform: [keys][16], column-major, affine; linear in between.
glint_status glint_world_place(glint_world *world, uint32_t row, glint_body *body,
                               const float *transform, uint32_t keys, struct glint_error *err);

// Rows that are one mesh in one place: of those that a ray meets there the first is hit, which is no
// matter of the structure's. ring: [rows], from each to the next of its place, and from the last to
// the first; a row alone to itself. NULL: all are alone. Taken.
void glint_world_tie(glint_world *world, uint32_t *ring);

// Whether a ray passes the surface at (u, v) of a primitive: called from tracing threads. chance:
// 32 random bits, the same whenever that ray meets that primitive.
typedef bool glint_geometry_hole(const void *user, uint32_t row, uint32_t primitive, float u,
                                 float v, uint32_t chance);
// NULL without memory.
glint_geometry *glint_geometry_create(glint_world *world, glint_geometry_hole *hole,
                                      const void *user);
void glint_geometry_destroy(glint_geometry **geometry);
glint_world *glint_geometry_world(const glint_geometry *geometry);

// The RTCScene, for benches that trace it without us.
void *glint_geometry_native(const glint_geometry *g);

// Traces rows [0, n) of a wave's columns (kernels/gk_wave.h) in place: closest hits, or for shadow
// rays occlusion (distance becomes -inf). Rows with a negative distance are left alone.
void glint_geometry_trace_wave(const glint_geometry *g, float *wave, uint32_t stride, uint32_t n);
void glint_geometry_shadow_wave(const glint_geometry *g, float *wave, uint32_t stride, uint32_t n);

// After them, of a robust world: of the rays that met nothing, hits on those that slipped between the
// triangles of a vertex.
void glint_geometry_close_wave(const glint_geometry *g, float *wave, uint32_t stride, uint32_t n);
void glint_geometry_close_shadows(const glint_geometry *g, float *wave, uint32_t stride,
                                  uint32_t n);

#endif
