// pose_work.h - the inside of the evaluation of a pose, shared by the files that do it.
//
// Matrices are column-major 4x4 in double. Moments are those of the shutter, at equal distances
// from open to close, and after them the two of flow.
#ifndef GLINT_SCENE_POSE_WORK_H
#define GLINT_SCENE_POSE_WORK_H

#include "scene/matrix.h"
#include "scene/pose.h"

#define GLINT_POSE_MOMENTS 17u // of the shutter: the keys and what lies half-way between them
#define GLINT_POSE_ALL (GLINT_POSE_MOMENTS + 2u)

typedef double glint_pose_matrix[16];

// pose_matrix.c
void glint_pose_multiply_float(double out[16], const double a[16], const float b[16]);
void glint_pose_point(double out[3], const double m[16], const double p[3]);
// Neither singular, by the measure of the parser of scenes, nor out of bounds for a thing that
// reaches as far as `reach` from its origin.
bool glint_pose_drawable(const double m[16], double reach);
// The rotation and translation of m: z is kept, y as far as it can be. False if m is not finite or
// gives no direction.
bool glint_pose_rigid(double out[16], const double m[16]);
// Makes every matrix drawable that is not, from the nearest that is. Returns how many were not; all
// of them: none could be made so.
uint32_t glint_pose_repair(glint_pose_matrix *m, uint32_t count, double reach);

// pose_channel.c
// One moment; what jumps there is taken as it is just before, or from then on.
struct glint_pose_moment {
    double time;
    bool before;
};
// The value, [width]. Rotations are unit; false: the one there has no direction, and out is that of
// the key before it, else `rest`.
bool glint_pose_channel(const struct glint_animation_channel *c, struct glint_pose_moment at,
                        const float *rest, double *out);

// pose_keys.c
// How far points stray from straight lines between 2, 3, 5, 9 keys.
struct glint_pose_stray {
    double worst[4];
};
void glint_pose_stray_point(struct glint_pose_stray *s, double (*track)[3]); // [MOMENTS]
void glint_pose_stray_number(struct glint_pose_stray *s, const double *track);
// Least number of keys with which no point strays further than 1/1000 of `size`.
uint32_t glint_pose_stray_keys(const struct glint_pose_stray *s, double size);
// That of a thing with this box, carried by the matrices, at least `least`; of a camera or light
// without extent.
uint32_t glint_pose_box_keys(const glint_pose_matrix *m, const double lo[3], const double hi[3],
                             uint32_t least);
uint32_t glint_pose_frame_keys(const glint_pose_matrix *m);

// What nodes do. Zero-initialised before prepare; everything is in the arena.
struct glint_pose_nodes {
    const struct glint_scene *scene;
    const struct glint_animation *animation;          // NULL: at rest
    const struct glint_animation_channel *(*path)[4]; // [nodes], by enum glint_channel_path
    uint32_t *order;                                  // parents first
    uint32_t *slot;                                   // [nodes] among the touched, or GLINT_NONE
    uint32_t touched;
    struct glint_pose_moment moment[GLINT_POSE_ALL];
    uint32_t shutter, moments; // of the shutter, 1 or GLINT_POSE_MOMENTS; with those of flow
    glint_pose_matrix *still;  // [nodes] to the world, of those that are not touched
    glint_pose_matrix *moving; // [touched][moments]
    uint32_t vanished;         // nodes whose rotation had no direction
};

// pose_nodes.c
// Who is touched. GLINT_E_NOMEM
glint_status glint_pose_nodes_prepare(struct glint_pose_nodes *n, struct glint_arena *arena,
                                      const struct glint_scene *scene,
                                      const struct glint_pose_request *request,
                                      struct glint_error *err);
double glint_pose_nodes_bytes(const struct glint_pose_nodes *n); // that place will take
// Where they are. GLINT_E_NOMEM
glint_status glint_pose_nodes_place(struct glint_pose_nodes *n, struct glint_arena *arena,
                                    struct glint_error *err);
const double *glint_pose_world(const struct glint_pose_nodes *n, uint32_t node, uint32_t moment);
bool glint_pose_touches(const struct glint_pose_nodes *n, uint32_t node); // GLINT_NONE: false

// A mesh as a skin and weights deform it; shared by the instances that have it so.
struct glint_pose_shape {
    uint32_t mesh, skin;
    const float *rest;                             // weights, or NULL: 0
    const struct glint_animation_channel *channel; // of the weights, or NULL
    bool skinned, morphed;                         // what of the two is to be done
    bool bends, flows;                             // differs between keys; at the moments of flow
    uint32_t keys;                                 // that it needs
    double *weight;                                // [moments][targets]
    double frame[16]; // of its vertices: position = frame^-1 skin(mesh)
    double back[16];  // frame^-1
    float *position, *normal, *tangent, *flow_position;
};

// pose_shape.c
// What it will take: fills all but the arrays; lo and hi bound the mesh. GLINT_E_NOMEM,
// GLINT_E_RANGE (a joint is missing)
glint_status glint_pose_shape_measure(struct glint_pose_shape *shape, struct glint_arena *arena,
                                      const struct glint_pose_nodes *n, const double lo[3],
                                      const double hi[3], struct glint_error *err);
double glint_pose_shape_bytes(const struct glint_pose_shape *shape, const struct glint_scene *scene,
                              uint32_t keys);
// GLINT_E_NOMEM
glint_status glint_pose_shape_fill(struct glint_pose_shape *shape, struct glint_arena *arena,
                                   const struct glint_pose_nodes *n, uint32_t keys,
                                   struct glint_error *err);

// pose_deform.c. Positions stay within GLINT_MAX_COORDINATE, whatever overflows.
struct glint_pose_deformed {
    float *position, *normal, *tangent; // [vertices]; the last two may be NULL
};
// Adds the weighted targets, weight [targets].
void glint_pose_morph(const struct glint_mesh *mesh, const double *weight,
                      const struct glint_pose_deformed *out);
// Blends the joints' matrices, [joints][16] aligned to 16 bytes, over the vertices of `from`.
void glint_pose_skin(const struct glint_mesh *mesh, const float *matrix,
                     const struct glint_pose_deformed *from, const struct glint_pose_deformed *out);

struct glint_pose_box {
    double lo[3], hi[3];
    bool known;
};

// One evaluation. Zero-initialised; scratch is its owner's to finish.
struct glint_pose_work {
    const struct glint_scene *scene;
    struct glint_pose *pose;
    struct glint_arena scratch;
    struct glint_pose_nodes nodes;
    struct glint_pose_box *box;     // [meshes], made when first asked for
    uint32_t *shape_of;             // [instances], or GLINT_NONE
    struct glint_pose_shape *shape; // each once
    uint32_t shapes, *bucket, buckets;
    uint32_t keys;                 // that are needed
    double still_bytes, key_bytes; // of transforms: whatever the keys, and for each of them
};

// pose_track.c
// What a transform does over the moments.
struct glint_pose_track {
    glint_pose_matrix m[GLINT_POSE_ALL];
    bool moves, flows; // between the moments of the shutter; at those of flow
};
void glint_pose_track_compare(struct glint_pose_track *t, const struct glint_pose_nodes *n);
// Counts the bytes that store will take.
void glint_pose_track_count(const struct glint_pose_track *t, struct glint_pose_work *w);
// The transforms at the keys, and of flow, which may stay NULL. False without memory.
bool glint_pose_track_store(const struct glint_pose_track *t, struct glint_pose_work *w,
                            double **transform, double **flow);

// pose_instances.c
// Measure finds the keys needed and the bytes; fill makes the arrays, with pose->keys known.
// GLINT_E_NOMEM, GLINT_E_RANGE
glint_status glint_pose_instances_measure(struct glint_pose_work *w, struct glint_error *err);
glint_status glint_pose_instances_fill(struct glint_pose_work *w, struct glint_error *err);

// pose_placements.c
void glint_pose_placements_measure(struct glint_pose_work *w);
glint_status glint_pose_placements_fill(struct glint_pose_work *w, struct glint_error *err);

// Key k of `keys` is this moment.
static inline uint32_t glint_pose_moment_of(uint32_t key, uint32_t keys)
{
    return keys > 1 ? key * (GLINT_POSE_MOMENTS - 1) / (keys - 1) : 0;
}

#endif
