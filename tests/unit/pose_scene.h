// pose_scene.h - small scenes made by hand, for the tests of poses.
#ifndef POSE_SCENE_H
#define POSE_SCENE_H

#include "scene/pose.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

// Room for a few of everything; `scene` counts what is used.
struct pose_scene {
    struct glint_scene scene;
    struct glint_node node[8];
    struct glint_mesh mesh[2];
    struct glint_instance instance[4];
    struct glint_light light[2];
    struct glint_camera camera[2];
    struct glint_skin skin[1];
    struct glint_animation animation[1];
    struct glint_animation_channel channel[8];
};

void pose_scene_init(struct pose_scene *s); // one animation without channels, a mesh: the unit box
uint32_t pose_scene_node(struct pose_scene *s, uint32_t parent);   // at rest: the identity
uint32_t pose_scene_instance(struct pose_scene *s, uint32_t node); // of mesh 0
uint32_t pose_scene_light(struct pose_scene *s, enum glint_light_kind kind, uint32_t node);
uint32_t pose_scene_camera(struct pose_scene *s, uint32_t node);
// `time` [keys] and `value` are borrowed.
void pose_scene_channel(struct pose_scene *s, uint32_t node, enum glint_channel_path path,
                        enum glint_interpolation interpolation, uint32_t keys, const float *time,
                        const float *value);

struct glint_pose *pose_of(const struct pose_scene *s, double open, double close);
struct glint_pose *pose_flowing(const struct pose_scene *s, double before, double now,
                                double after);
void expect_point(const double m[16], double x, double y, double z, double want_x, double want_y,
                  double want_z, double tolerance);

#endif
