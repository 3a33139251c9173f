// shape.h - what revisions share of one mesh: which of its triangles are kept, how large it is, and
// the bodies that it is placed by. Counted.
//
// Threads: immutable but for the bodies, which any thread may ask for.
#ifndef GLINT_SCENE_SHAPE_H
#define GLINT_SCENE_SHAPE_H

#include "protocol/scene.h"
#include "scene/geometry.h"

#include <pthread.h>
#include <stdatomic.h>

struct glint_shape {
    atomic_uint references;
    uint32_t *index; // [triangles][3], those kept; NULL: all are, as the mesh has them
    uint32_t triangles, dropped;
    float low[3], high[3];  // of the vertices, at all keys
    pthread_mutex_t mutex;  // guards the bodies
    glint_body *body[2][2]; // [robust][holes], of one tracer
};

// position: [keys][mesh->vertices][3]. Triangles that are no surfaces at any key are left out.
glint_status glint_shape_create(struct glint_shape **out, const struct glint_mesh *mesh,
                                const float *position, uint32_t keys, struct glint_error *err);
struct glint_shape *glint_shape_retain(struct glint_shape *shape);
void glint_shape_release(struct glint_shape **shape);

// Vertices of a body are relative to this, so that a mesh far from its own origin loses nothing.
void glint_shape_origin(const struct glint_shape *shape, float origin[3]);

// The body of `mesh`, whose triangles and vertices must be those of the shape; borrowed. built: set
// when it was not there before.
glint_status glint_shape_body(struct glint_shape *shape, glint_tracer *tracer,
                              const struct glint_geometry_mesh *mesh,
                              const struct glint_geometry_build *build, glint_body **out,
                              bool *built, struct glint_error *err);
uint64_t glint_shape_bytes(struct glint_shape *shape);

#endif
