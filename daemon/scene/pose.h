// pose.h - where everything is during one shutter interval: transforms and deformed vertices at
// equidistant keys, from nodes, animations, skins and morph targets (glTF 2.0, 3.7 and 3.11).
//
// Between keys everything is linear. A STEP inside the interval is therefore spread over one
// segment; one at `close` belongs to the next frame and is not seen.
//
// Threads: create by a loader; immutable afterwards and counted, retain and release by any thread.
#ifndef GLINT_SCENE_POSE_H
#define GLINT_SCENE_POSE_H

#include "protocol/scene.h"

#include <stdatomic.h>

#define GLINT_POSE_MAX_KEYS 9u

// Which moments. Equal requests of one scene give equal poses, bit for bit.
struct glint_pose_request {
    uint32_t animation;   // index, GLINT_NONE: everything at rest
    double open, close;   // seconds, finite, open <= close
    double before, after; // seconds of the frame earlier and the frame later, for motion vectors
    bool flow;            // fill the members for `before` and `after`
    uint64_t max_bytes;   // of the arrays, and of what nodes take meanwhile; 0: half of the memory
};

// Instances that deform alike (one mesh, skin and weights) share their arrays: equal pointers.
// Those of an instance that does not deform are NULL, and the mesh's hold.
struct glint_pose_instance {
    bool moves;        // its transform differs between keys
    bool deforms;      // its vertices are not the mesh's
    bool bends;        // its vertices differ between keys
    bool hidden;       // has no extent at any key: not to be drawn
    double *transform; // [moves ? keys : 1][16] to the world, column-major, never singular. NULL:
                       // instance->transform, of an instance without node and skin
    float *position;   // [bends ? keys : 1][vertices][3] in the space of `transform`
    float *normal;     // [bends ? keys : 1][vertices][3] unit, or NULL where the mesh has none
    float *tangent;    // [bends ? keys : 1][vertices][4], or NULL where the mesh has none
    // With request.flow, [2]: before and after. NULL: as `transform` or `position` at the first
    // key, of an instance that is then where it is in the interval.
    double *flow_transform; // [2][16]
    float *flow_position;   // [2][vertices][3]
};

// A light or a camera. All but area lights are rotations and translations: scale is left out.
struct glint_pose_placement {
    bool moves;
    bool hidden;       // an area light without extent at any key
    double *transform; // [moves ? keys : 1][16] to the world; NULL: the item's own, without node
    double *flow_transform; // [2][16] with request.flow; NULL: as `transform` at the first key
};

struct glint_pose {
    atomic_uint references;
    struct glint_arena arena;
    struct glint_pose_request request;
    uint32_t keys; // 1: nothing moves in the interval; else 2, 3, 5 or 9 (see glint_pose_create)
    uint32_t instances, lights, cameras; // as in the scene
    struct glint_pose_instance *instance;
    struct glint_pose_placement *light, *camera;
    uint64_t bytes;     // of the arena
    uint32_t collapsed; // transforms without extent or out of bounds, and rotations that vanish:
                        // replaced by the nearest that can be drawn, or hidden
};

// Evaluates. keys is the least of 1, 2, 3, 5, 9 with which linear interpolation between keys stays
// within 1/1000 of every visible instance's own size (of a camera's and a light's path and
// directions), measured at 17 moments; 9 where none does, and fewer where max_bytes allows no more.
// Invisible instances are not evaluated: they are `hidden`.
//   GLINT_E_CAPACITY  one key alone, with those of flow, or the nodes exceed max_bytes
//   GLINT_E_NOMEM
glint_status glint_pose_create(struct glint_pose **out, const struct glint_scene *scene,
                               const struct glint_pose_request *request, struct glint_error *err);
struct glint_pose *glint_pose_retain(const struct glint_pose *pose);
void glint_pose_release(struct glint_pose **pose); // NULL inside is fine

// The request of a scene at rest; and whether its pose says more than the scene does: it has nodes,
// skins or morph targets. Where it does not, NULL is as good.
struct glint_pose_request glint_pose_rest(void);
bool glint_pose_needed(const struct glint_scene *scene);

// Transform to the world at a key, 0..keys-1, that of the first key where it does not move. `pose`
// may be NULL: as the scene has it.
void glint_pose_instance_at(const struct glint_pose *pose, const struct glint_scene *scene,
                            uint32_t instance, uint32_t key, double out[16]);
void glint_pose_light_at(const struct glint_pose *pose, const struct glint_scene *scene,
                         uint32_t light, uint32_t key, double out[16]);
void glint_pose_camera_at(const struct glint_pose *pose, const struct glint_scene *scene,
                          uint32_t camera, uint32_t key, double out[16]);

// True when the pose of the request can differ from that at rest, or move: the animation touches
// something that is seen, emits or looks. Without animations: false.
bool glint_pose_wanted(const struct glint_scene *scene, const struct glint_pose_request *request);

// Index of the animation that a job names by id or name; "" and "none": GLINT_NONE; NULL: the first
// of the scene, or GLINT_NONE. False: there is none of that name.
bool glint_pose_animation(const struct glint_scene *scene, const char *name, uint32_t *out);

#endif
