#include "pose_scene.h"

#include <math.h>
#include <string.h>

static const float corners[8][3] = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1},
                                    {-1, -1, 1},  {1, -1, 1},  {-1, 1, 1},  {1, 1, 1}};
static const uint32_t triangles[2][3] = {{0, 1, 2}, {5, 6, 7}};

void pose_scene_init(struct pose_scene *s)
{
    memset(s, 0, sizeof *s);
    s->scene.node = s->node;
    s->scene.mesh = s->mesh;
    s->scene.instance = s->instance;
    s->scene.light = s->light;
    s->scene.camera = s->camera;
    s->scene.skin = s->skin;
    s->scene.animation = s->animation;
    s->animation[0] = (struct glint_animation){.id = "walk", .name = "Walk", .channel = s->channel};
    s->scene.animations = 1;
    s->mesh[0] = (struct glint_mesh){
        .id = "box", .vertices = 8, .triangles = 2, .position = corners[0], .index = triangles[0]};
    s->scene.meshes = 1;
}

uint32_t pose_scene_node(struct pose_scene *s, uint32_t parent)
{
    assert_true(s->scene.nodes < 8);
    struct glint_node *n = &s->node[s->scene.nodes];
    glint_node_init(n);
    n->parent = parent;
    return s->scene.nodes++;
}

uint32_t pose_scene_instance(struct pose_scene *s, uint32_t node)
{
    assert_true(s->scene.instances < 4);
    struct glint_instance *in = &s->instance[s->scene.instances];
    glint_instance_init(in);
    in->mesh = 0;
    in->node = node;
    in->skin = GLINT_NONE;
    return s->scene.instances++;
}

uint32_t pose_scene_light(struct pose_scene *s, enum glint_light_kind kind, uint32_t node)
{
    struct glint_light *l = &s->light[s->scene.lights];
    glint_light_init(l);
    l->kind = kind;
    l->node = node;
    return s->scene.lights++;
}

uint32_t pose_scene_camera(struct pose_scene *s, uint32_t node)
{
    struct glint_camera *c = &s->camera[s->scene.cameras];
    glint_camera_init(c);
    c->node = node;
    return s->scene.cameras++;
}

void pose_scene_channel(struct pose_scene *s, uint32_t node, enum glint_channel_path path,
                        enum glint_interpolation interpolation, uint32_t keys, const float *time,
                        const float *value)
{
    assert_true(s->animation[0].channels < 8);
    s->channel[s->animation[0].channels++] = (struct glint_animation_channel){
        .id = "c",
        .node = node,
        .path = path,
        .interpolation = interpolation,
        .keys = keys,
        .width = path == GLINT_PATH_WEIGHTS    ? s->mesh[0].targets
                 : path == GLINT_PATH_ROTATION ? 4
                                               : 3,
        .time = time,
        .value = value,
    };
}

static struct glint_pose *evaluate(const struct pose_scene *s,
                                   const struct glint_pose_request *request)
{
    struct glint_error err = {0};
    struct glint_pose *p;
    if (glint_pose_create(&p, &s->scene, request, &err))
        fail_msg("%s", err.fault[0].detail);
    return p;
}

struct glint_pose *pose_of(const struct pose_scene *s, double open, double close)
{
    return evaluate(s, &(struct glint_pose_request){.open = open, .close = close});
}

struct glint_pose *pose_flowing(const struct pose_scene *s, double before, double now, double after)
{
    return evaluate(s,
                    &(struct glint_pose_request){
                        .open = now, .close = now, .before = before, .after = after, .flow = true});
}

void expect_point(const double m[16], double x, double y, double z, double want_x, double want_y,
                  double want_z, double tolerance)
{
    const double p[3] = {x, y, z}, want[3] = {want_x, want_y, want_z};
    for (int i = 0; i < 3; i++) {
        const double got = m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i];
        if (!(fabs(got - want[i]) <= tolerance))
            fail_msg("coordinate %d is %.9g, not %.9g", i, got, want[i]);
    }
}
