// pose.h - where everything is during one shutter interval: transforms and deformed vertices at
// equidistant keys, from nodes, animations, skins and morph targets (glTF 2.0, 3.7 and 3.11).
//
// Threads: create by a loader; immutable afterwards.
#ifndef GLINT_SCENE_POSE_H
#define GLINT_SCENE_POSE_H

#include "protocol/scene.h"

#define GLINT_POSE_MAX_KEYS 9u

// Which moments. Equal requests of one scene give equal poses, bit for bit.
struct glint_pose_request {
    uint32_t animation;   // index, GLINT_NONE: everything at rest
    double open, close;   // seconds, open <= close
    double before, after; // seconds of the frame earlier and the frame later, for motion vectors
    bool flow;            // fill the members for `before` and `after`
};

// An instance that an animation touches. Arrays of one that does not deform are NULL.
struct glint_pose_instance {
    bool moves;       // its transform differs between keys
    bool deforms;     // its vertices differ from the mesh's (at one key or over them)
    float *transform; // [keys][16] to the world, column-major; never singular
    float *position;  // [keys][vertices][3] in the space of `transform`
    float *normal;    // [keys][vertices][3] unit, or NULL where the mesh has none
    float *tangent;   // [keys][vertices][4], or NULL where the mesh has none
    // With request.flow: transform [2][16] and position [2][vertices][3], before and after.
    float *flow_transform, *flow_position;
};

struct glint_pose_placement {
    bool moves;
    float *transform;      // [keys][16] to the world
    float *flow_transform; // [2][16], with request.flow
};

struct glint_pose {
    struct glint_arena arena;
    struct glint_pose_request request;
    uint32_t keys; // 1: nothing moves in the interval; else 2, 3, 5 or 9 (see glint_pose_create)
    struct glint_pose_instance *instance; // [scene->instances]
    struct glint_pose_placement *light;   // [scene->lights]
    struct glint_pose_placement *camera;  // [scene->cameras]
    uint64_t bytes;                       // of the arena's arrays
    uint32_t collapsed; // instances or placements whose transform was singular: held as they were
};

// Evaluates. keys is the least of 1, 2, 3, 5, 9 with which linear interpolation between keys stays
// within 1/1000 of every instance's own size (rotations swing, cubic channels bend, skins bend), or
// 9. A scene without nodes gives one key whose transforms are those of the scene.
//   GLINT_E_NOMEM
glint_status glint_pose_create(struct glint_pose **out, const struct glint_scene *scene,
                               const struct glint_pose_request *request, struct glint_error *err);
void glint_pose_destroy(struct glint_pose **pose);

// True when the pose of the request can differ from that at rest, or move: what of the scene an
// animation touches. Without nodes: false.
bool glint_pose_wanted(const struct glint_scene *scene, const struct glint_pose_request *request);

// Index of the animation that a job names by id or name; "" and "none": GLINT_NONE; NULL: the first
// of the scene, or GLINT_NONE. False: there is none of that name.
bool glint_pose_animation(const struct glint_scene *scene, const char *name, uint32_t *out);

#endif
