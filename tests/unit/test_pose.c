// Nodes, channels and keys of poses, against what can be worked out on paper.
#include "pose_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define H 0.70710678f
#define NEAR 1e-6

static const float second[2] = {0, 1};
static const float along_x[6] = {0, 0, 0, 4, 0, 0};

// A turning node: the identity, then half or a quarter of a turn about z.
static const float half_turn[8] = {0, 0, 0, 1, 0, 0, 1, 0};
static const float quarter_turn[8] = {0, 0, 0, 1, 0, 0, H, H};

static const double *transform(const struct glint_pose *p, uint32_t key)
{
    return p->instance[0].transform + (p->instance[0].moves ? 16 * key : 0);
}

static struct pose_scene one_box(enum glint_channel_path path,
                                 enum glint_interpolation interpolation, uint32_t keys,
                                 const float *time, const float *value)
{
    struct pose_scene s;
    pose_scene_init(&s);
    pose_scene_instance(&s, pose_scene_node(&s, GLINT_NONE));
    pose_scene_channel(&s, 0, path, interpolation, keys, time, value);
    return s;
}

// The scene moved: its pointers go into itself.
#define ONE_BOX(name, ...)                         \
    struct pose_scene name = one_box(__VA_ARGS__); \
    name.scene.node = name.node;                   \
    name.scene.mesh = name.mesh;                   \
    name.scene.instance = name.instance;           \
    name.scene.light = name.light;                 \
    name.scene.camera = name.camera;               \
    name.scene.animation = name.animation;         \
    name.animation[0].channel = name.channel

static void expect_at(const struct pose_scene *s, double time, double x, double y, double z)
{
    struct glint_pose *p = pose_of(s, time, time);
    assert_int_equal(p->keys, 1);
    expect_point(transform(p, 0), 0, 0, 0, x, y, z, NEAR);
    glint_pose_release(&p);
}

static void expect_turned(const struct pose_scene *s, double time, double degrees)
{
    struct glint_pose *p = pose_of(s, time, time);
    const double a = degrees * M_PI / 180;
    expect_point(transform(p, 0), 1, 0, 0, cos(a), sin(a), 0, NEAR);
    glint_pose_release(&p);
}

static void a_translation_is_linear_and_clamped_to_its_keys(void **state)
{
    (void)state;
    static const float time[3] = {1, 2, 4}, value[9] = {1, 0, 0, 3, 0, 0, 3, 8, 0};
    ONE_BOX(s, GLINT_PATH_TRANSLATION, GLINT_INTERPOLATION_LINEAR, 3, time, value);
    expect_at(&s, 0, 1, 0, 0);
    expect_at(&s, 1, 1, 0, 0);
    expect_at(&s, 1.25, 1.5, 0, 0);
    expect_at(&s, 2, 3, 0, 0);
    expect_at(&s, 3, 3, 4, 0);
    expect_at(&s, 4, 3, 8, 0);
    expect_at(&s, 1e9, 3, 8, 0);
}

static void a_step_happens_at_its_key_and_holds(void **state)
{
    (void)state;
    static const float time[3] = {0, 1.0f / 24, 2.0f / 24}, value[9] = {1, 0, 0, 2, 0, 0, 3, 0, 0};
    ONE_BOX(s, GLINT_PATH_TRANSLATION, GLINT_INTERPOLATION_STEP, 3, time, value);
    expect_at(&s, 0, 1, 0, 0);
    expect_at(&s, 0.9 / 24, 1, 0, 0);
    expect_at(&s, 1.0 / 24, 2, 0, 0); // the double of that frame is less than the key's float
    expect_at(&s, 1.9 / 24, 2, 0, 0);
    expect_at(&s, 2.0 / 24, 3, 0, 0);
    expect_at(&s, 1, 3, 0, 0);
}

static void a_step_at_the_end_of_the_shutter_belongs_to_the_next_frame(void **state)
{
    (void)state;
    static const float time[3] = {0, 1.0f / 24, 2.0f / 24}, value[9] = {1, 0, 0, 2, 0, 0, 3, 0, 0};
    ONE_BOX(s, GLINT_PATH_TRANSLATION, GLINT_INTERPOLATION_STEP, 3, time, value);
    struct glint_pose *p = pose_of(&s, 1.0 / 24, 2.0 / 24);
    assert_int_equal(p->keys, 1);
    assert_false(p->instance[0].moves);
    expect_point(transform(p, 0), 0, 0, 0, 2, 0, 0, NEAR);
    glint_pose_release(&p);
}

static void a_rotation_goes_the_short_way_at_an_even_pace(void **state)
{
    (void)state;
    // 120 degrees about z, the second key with its sign turned: the same rotation.
    const float q[8] = {0, 0, 0, 1, 0, 0, -sinf((float)M_PI / 3), -cosf((float)M_PI / 3)};
    ONE_BOX(s, GLINT_PATH_ROTATION, GLINT_INTERPOLATION_LINEAR, 2, second, q);
    for (int i = 0; i <= 8; i++)
        expect_turned(&s, i / 8.0, 120 * i / 8.0);
}

static void keys_nearly_alike_are_interpolated_without_loss(void **state)
{
    (void)state;
    const double small = 1e-3; // radians
    const float q[8] = {0, 0, 0, 1, 0, 0, (float)sin(small / 2), (float)cos(small / 2)};
    ONE_BOX(s, GLINT_PATH_ROTATION, GLINT_INTERPOLATION_LINEAR, 2, second, q);
    struct glint_pose *p = pose_of(&s, 0.25, 0.25);
    assert_true(fabs(transform(p, 0)[1] - sin(small / 4)) < 1e-10);
    glint_pose_release(&p);
    const float equal[8] = {H, 0, 0, H, -H, 0, 0, -H};
    s.channel[0].value = equal;
    p = pose_of(&s, 0.5, 0.5);
    expect_point(transform(p, 0), 0, 1, 0, 0, 0, 1, NEAR);
    glint_pose_release(&p);
}

static void a_cubic_spline_is_hermites_with_tangents_per_second(void **state)
{
    (void)state;
    static const float time[2] = {1, 3};
    // x is t^3 - 2 t of the true time: a cubic, which the spline must give back. y: tangents only.
    static const float value[18] = {9, 9, 9, -1, 0, 0, 1, 2, 0, 25, -3, 0, 21, 0, 0, 9, 9, 9};
    ONE_BOX(s, GLINT_PATH_TRANSLATION, GLINT_INTERPOLATION_CUBICSPLINE, 2, time, value);
    for (int i = 0; i <= 8; i++) {
        const double t = 1 + i / 4.0, f = i / 8.0;
        const double y = 2 * (f * f * f - 2 * f * f + f) * 2 + 2 * (f * f * f - f * f) * -3;
        expect_at(&s, t, t * t * t - 2 * t, y, 0);
    }
    expect_at(&s, 0, -1, 0, 0);
    expect_at(&s, 4, 21, 0, 0);
}

static void a_cubic_rotation_is_made_unit(void **state)
{
    (void)state;
    static const float value[24] = {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0,
                                    0, 0, 0, 0, 0, 0, H, H, 0, 0, 0, 0};
    ONE_BOX(s, GLINT_PATH_ROTATION, GLINT_INTERPOLATION_CUBICSPLINE, 2, second, value);
    struct glint_pose *p = pose_of(&s, 0.5, 0.5);
    const double *m = transform(p, 0);
    assert_true(fabs(hypot(m[0], m[1]) - 1) < 1e-12);
    glint_pose_release(&p);
    expect_turned(&s, 0.5, 45); // half-way, by symmetry
}

static void a_rotation_without_direction_keeps_the_one_before_and_is_counted(void **state)
{
    (void)state;
    // Half-way between q and -q the spline is zero.
    static const float value[24] = {0, 0, 0, 0, H,  0, 0, H,  0, 0, 0, 0,
                                    0, 0, 0, 0, -H, 0, 0, -H, 0, 0, 0, 0};
    ONE_BOX(s, GLINT_PATH_ROTATION, GLINT_INTERPOLATION_CUBICSPLINE, 2, second, value);
    struct glint_pose *p = pose_of(&s, 0.5, 0.5);
    assert_int_equal(p->collapsed, 1);
    expect_point(transform(p, 0), 0, 1, 0, 0, 0, 1, NEAR);
    glint_pose_release(&p);
    static const float zeros[8] = {0};
    s.channel[0].interpolation = GLINT_INTERPOLATION_LINEAR;
    s.channel[0].value = zeros;
    p = pose_of(&s, 0.5, 0.5);
    assert_int_equal(p->collapsed, 1);
    expect_point(transform(p, 0), 0, 1, 0, 0, 1, 0, NEAR);
    glint_pose_release(&p);
}

static void parents_may_come_after_their_children(void **state)
{
    (void)state;
    struct pose_scene s;
    pose_scene_init(&s);
    pose_scene_node(&s, 2); // hand
    pose_scene_node(&s, GLINT_NONE);
    pose_scene_node(&s, 1); // arm
    for (int i = 0; i < 3; i++)
        s.node[i].translation[0] = 2;
    s.node[1].scale[0] = s.node[1].scale[1] = s.node[1].scale[2] = 3;
    pose_scene_instance(&s, 0);
    s.instance[0].transform[13] = 1;
    pose_scene_channel(&s, 2, GLINT_PATH_ROTATION, GLINT_INTERPOLATION_LINEAR, 2, second,
                       quarter_turn);
    struct glint_pose *p = pose_of(&s, 1, 1);
    // hand: (0,1) + (2,0) = (2,1), turned (-1,2), + (2,0) = (1,2), times 3, + (2,0)
    expect_point(transform(p, 0), 0, 0, 0, 5, 6, 0, NEAR);
    glint_pose_release(&p);
}

static void a_node_given_as_a_matrix_is_taken_as_it_is(void **state)
{
    (void)state;
    struct pose_scene s;
    pose_scene_init(&s);
    pose_scene_instance(&s, pose_scene_node(&s, pose_scene_node(&s, GLINT_NONE)));
    s.instance[0].node = 1;
    const float shear[16] = {1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1};
    memcpy(s.node[1].transform, shear, sizeof shear);
    s.node[1].matrix = true;
    struct glint_pose *p = pose_of(&s, 0, 1);
    assert_int_equal(p->keys, 1);
    expect_point(transform(p, 0), 0, 2, 0, 7, 2, 0, 0);
    glint_pose_release(&p);
}

static void a_chain_of_a_hundred_thousand_nodes_needs_no_stack(void **state)
{
    (void)state;
    enum { DEPTH = 100000 };
    struct pose_scene s;
    pose_scene_init(&s);
    struct glint_node *node = calloc(DEPTH, sizeof *node);
    for (uint32_t i = 0; i < DEPTH; i++) { // the root is in the middle, the leaf is node 0
        glint_node_init(&node[i]);
        node[i].parent = i + 1 < DEPTH ? i + 1 : GLINT_NONE;
        node[i].translation[1] = 1;
    }
    s.scene.node = node;
    s.scene.nodes = DEPTH;
    pose_scene_instance(&s, 0);
    pose_scene_channel(&s, DEPTH - 1, GLINT_PATH_TRANSLATION, GLINT_INTERPOLATION_LINEAR, 2, second,
                       along_x);
    struct glint_pose *p = pose_of(&s, 0.25, 0.25);
    expect_point(transform(p, 0), 0, 0, 0, 1, DEPTH - 1, 0, NEAR);
    glint_pose_release(&p);
    free(node);
}

static uint32_t keys_of(const struct pose_scene *s, double open, double close)
{
    struct glint_pose *p = pose_of(s, open, close);
    const uint32_t keys = p->keys;
    assert_int_equal(p->instance[0].moves, keys > 1);
    glint_pose_release(&p);
    return keys;
}

// A box of half side 1 about its axis: its edges, at 2^0.5, sag by 2^0.5 (1 - cos(a/2)) between keys
// a apart; its diagonal is 12^0.5. So a/2 may be acos(1 - 1e-3 6^0.5), 4.01 degrees.
static void keys_are_as_many_as_keep_the_motion_straight(void **state)
{
    (void)state;
    ONE_BOX(s, GLINT_PATH_TRANSLATION, GLINT_INTERPOLATION_LINEAR, 2, second, along_x);
    assert_int_equal(keys_of(&s, 0, 1), 2);
    assert_int_equal(keys_of(&s, 0.5, 0.5), 1);
    assert_int_equal(keys_of(&s, 1, 2), 1); // past its last key
    s.channel[0] = (struct glint_animation_channel){
        .path = GLINT_PATH_ROTATION, .keys = 2, .width = 4, .time = second, .value = half_turn};
    assert_int_equal(keys_of(&s, 0, 1), 9);
    assert_int_equal(keys_of(&s, 0, 64.0 / 180), 9);
    assert_int_equal(keys_of(&s, 0, 31.9 / 180), 5);
    assert_int_equal(keys_of(&s, 0, 32.3 / 180), 9);
    assert_int_equal(keys_of(&s, 0, 15.9 / 180), 3);
    assert_int_equal(keys_of(&s, 0, 16.3 / 180), 5);
    assert_int_equal(keys_of(&s, 0, 7.9 / 180), 2);
    assert_int_equal(keys_of(&s, 0, 8.2 / 180), 3);
}

static void keys_are_at_equal_distances_and_exact(void **state)
{
    (void)state;
    ONE_BOX(s, GLINT_PATH_ROTATION, GLINT_INTERPOLATION_LINEAR, 2, second, half_turn);
    struct glint_pose *p = pose_of(&s, 0, 1);
    assert_int_equal(p->keys, 9);
    for (uint32_t k = 0; k < 9; k++) {
        const double a = M_PI * k / 8;
        expect_point(transform(p, k), 1, 0, 0, cos(a), sin(a), 0, NEAR);
    }
    glint_pose_release(&p);
}

static void what_does_not_move_has_one_transform_among_those_that_do(void **state)
{
    (void)state;
    ONE_BOX(s, GLINT_PATH_ROTATION, GLINT_INTERPOLATION_LINEAR, 2, second, half_turn);
    pose_scene_instance(&s, pose_scene_node(&s, GLINT_NONE));
    pose_scene_instance(&s, GLINT_NONE);
    s.instance[2].transform[12] = 7;
    struct glint_pose *p = pose_of(&s, 0, 1);
    assert_true(p->instance[0].moves && !p->instance[1].moves && !p->instance[2].moves);
    assert_non_null(p->instance[1].transform);
    assert_null(p->instance[2].transform);
    double m[16];
    for (uint32_t key = 0; key < p->keys; key++) {
        glint_pose_instance_at(p, &s.scene, 1, key, m);
        expect_point(m, 1, 2, 3, 1, 2, 3, 0);
        glint_pose_instance_at(p, &s.scene, 2, key, m);
        expect_point(m, 1, 2, 3, 8, 2, 3, 0);
    }
    glint_pose_instance_at(p, &s.scene, 0, 8, m);
    expect_point(m, 1, 2, 3, -1, -2, 3, NEAR);
    glint_pose_instance_at(NULL, &s.scene, 2, 0, m);
    expect_point(m, 1, 2, 3, 8, 2, 3, 0);
    glint_pose_release(&p);
}

static void flow_is_where_things_are_a_frame_away(void **state)
{
    (void)state;
    ONE_BOX(s, GLINT_PATH_TRANSLATION, GLINT_INTERPOLATION_LINEAR, 2, second, along_x);
    pose_scene_instance(&s, pose_scene_node(&s, GLINT_NONE));
    struct glint_pose *p = pose_flowing(&s, 0.25, 0.5, 0.75);
    assert_int_equal(p->keys, 1);
    expect_point(transform(p, 0), 0, 0, 0, 2, 0, 0, NEAR);
    expect_point(p->instance[0].flow_transform, 0, 0, 0, 1, 0, 0, NEAR);
    expect_point(p->instance[0].flow_transform + 16, 0, 0, 0, 3, 0, 0, NEAR);
    assert_null(p->instance[1].flow_transform);
    assert_null(p->instance[0].flow_position);
    glint_pose_release(&p);
}

static void cameras_and_lights_ride_on_nodes_without_scale(void **state)
{
    (void)state;
    ONE_BOX(s, GLINT_PATH_TRANSLATION, GLINT_INTERPOLATION_LINEAR, 2, second, along_x);
    s.node[0].scale[0] = s.node[0].scale[2] = 5;
    s.node[0].scale[1] = -2;
    pose_scene_camera(&s, 0);
    pose_scene_camera(&s, GLINT_NONE);
    pose_scene_light(&s, GLINT_LIGHT_SPOT, 0);
    pose_scene_light(&s, GLINT_LIGHT_AREA, 0);
    struct glint_pose *p = pose_of(&s, 0, 1);
    double m[16];
    glint_pose_camera_at(p, &s.scene, 0, 1, m);
    expect_point(m, 0, 0, -1, 4, 0, -1, NEAR);
    expect_point(m, 0, 1, 0, 4, -1, 0, NEAR);
    expect_point(m, 1, 0, 0, 3, 0, 0, NEAR); // not mirrored
    assert_null(p->camera[1].transform);
    glint_pose_light_at(p, &s.scene, 0, 1, m);
    expect_point(m, 0, 0, -1, 4, 0, -1, NEAR);
    glint_pose_light_at(p, &s.scene, 1, 1, m);
    expect_point(m, 1, 1, 0, 9, -2, 0, NEAR);
    glint_pose_release(&p);
}

static void a_turning_camera_keeps_its_directions_to_a_thousandth(void **state)
{
    (void)state;
    ONE_BOX(s, GLINT_PATH_ROTATION, GLINT_INTERPOLATION_LINEAR, 2, second, half_turn);
    s.scene.instances = 0;
    pose_scene_camera(&s, 0);
    // Chords of a unit circle sag by 1 - cos(a/2): 2 acos(0.999) is 5.13 degrees.
    struct glint_pose *p = pose_of(&s, 0, 5.1 / 180);
    assert_int_equal(p->keys, 2);
    glint_pose_release(&p);
    p = pose_of(&s, 0, 5.2 / 180);
    assert_int_equal(p->keys, 3);
    assert_true(p->camera[0].moves);
    glint_pose_release(&p);
}

static void what_has_no_extent_is_hidden(void **state)
{
    (void)state;
    static const float flat[3] = {1, 0, 1};
    ONE_BOX(s, GLINT_PATH_SCALE, GLINT_INTERPOLATION_STEP, 1, second, flat);
    pose_scene_light(&s, GLINT_LIGHT_AREA, 0);
    pose_scene_instance(&s, GLINT_NONE);
    s.instance[1].visible = false;
    struct glint_pose *p = pose_of(&s, 0, 1);
    assert_true(p->instance[0].hidden && p->instance[1].hidden && p->light[0].hidden);
    assert_int_equal(p->collapsed, 2); // the invisible one is not looked at
    glint_pose_release(&p);
}

static double determinant(const double *m)
{
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[4] * (m[1] * m[10] - m[2] * m[9]) +
           m[8] * (m[1] * m[6] - m[2] * m[5]);
}

static void what_shrinks_to_nothing_stays_drawable(void **state)
{
    (void)state;
    static const float to_nothing[6] = {1, 1, 1, 0, 0, 0}, to_a_disc[6] = {1, 1, 1, 1, 1, 0};
    ONE_BOX(s, GLINT_PATH_SCALE, GLINT_INTERPOLATION_LINEAR, 2, second, to_nothing);
    struct glint_pose *p = pose_of(&s, 0, 1);
    assert_int_equal(p->keys, 2);
    assert_int_equal(p->collapsed, 1);
    assert_true(determinant(transform(p, 1)) > 0 && determinant(transform(p, 1)) < 1e-8);
    expect_point(transform(p, 1), 1, 1, 1, 0, 0, 0, 1e-3);
    glint_pose_release(&p);
    s.channel[0].value = to_a_disc;
    p = pose_of(&s, 0, 1);
    assert_true(determinant(transform(p, 1)) > 0);
    expect_point(transform(p, 1), 1, 1, 1, 1, 1, 0, 1e-3);
    glint_pose_release(&p);
}

static void animations_are_found_by_id_then_name(void **state)
{
    (void)state;
    ONE_BOX(s, GLINT_PATH_TRANSLATION, GLINT_INTERPOLATION_LINEAR, 2, second, along_x);
    uint32_t at;
    assert_true(glint_pose_animation(&s.scene, NULL, &at) && at == 0);
    assert_true(glint_pose_animation(&s.scene, "walk", &at) && at == 0);
    assert_true(glint_pose_animation(&s.scene, "Walk", &at) && at == 0);
    assert_true(glint_pose_animation(&s.scene, "none", &at) && at == GLINT_NONE);
    assert_true(glint_pose_animation(&s.scene, "", &at) && at == GLINT_NONE);
    assert_false(glint_pose_animation(&s.scene, "run", &at));
    s.scene.animations = 0;
    assert_true(glint_pose_animation(&s.scene, NULL, &at) && at == GLINT_NONE);
}

static void a_pose_is_wanted_where_the_animation_shows(void **state)
{
    (void)state;
    const struct glint_pose_request request = {.animation = 0, .close = 1};
    const struct glint_pose_request rest = glint_pose_rest();
    ONE_BOX(s, GLINT_PATH_TRANSLATION, GLINT_INTERPOLATION_LINEAR, 2, second, along_x);
    assert_true(glint_pose_wanted(&s.scene, &request) && glint_pose_needed(&s.scene));
    assert_false(glint_pose_wanted(&s.scene, &rest));
    s.instance[0].visible = false;
    assert_false(glint_pose_wanted(&s.scene, &request));
    s.instance[0].visible = true;
    s.instance[0].node = pose_scene_node(&s, GLINT_NONE);
    assert_false(glint_pose_wanted(&s.scene, &request));
    s.node[1].parent = 0;
    assert_true(glint_pose_wanted(&s.scene, &request));
    s.instance[0].node = GLINT_NONE;
    assert_false(glint_pose_wanted(&s.scene, &request) || glint_pose_needed(&s.scene));
    pose_scene_light(&s, GLINT_LIGHT_POINT, 1);
    assert_true(glint_pose_wanted(&s.scene, &request) && glint_pose_needed(&s.scene));
}

static void equal_requests_give_equal_bits(void **state)
{
    (void)state;
    ONE_BOX(s, GLINT_PATH_ROTATION, GLINT_INTERPOLATION_LINEAR, 2, second, half_turn);
    struct glint_pose *a = pose_of(&s, 0.1, 0.9), *b = pose_of(&s, 0.1, 0.9);
    assert_int_equal(a->keys, b->keys);
    assert_true(a->bytes == b->bytes && a->bytes > 0);
    assert_memory_equal(transform(a, 0), transform(b, 0), a->keys * sizeof(double[16]));
    glint_pose_release(&a);
    struct glint_pose *c = glint_pose_retain(b);
    glint_pose_release(&b);
    assert_true(!a && !b && c->keys == 9);
    glint_pose_release(&c);
    glint_pose_release(&c);
}

// Values at the bounds of what the parser lets in, and shutters about them.
static void nothing_that_is_parsed_makes_a_matrix_that_cannot_be_drawn(void **state)
{
    (void)state;
    srand(3);
    for (int round = 0; round < 2000; round++) {
        struct pose_scene s;
        pose_scene_init(&s);
        float value[4][24], time[2] = {0, 1};
        for (uint32_t n = 0; n < 4; n++) {
            pose_scene_node(&s, n ? n - 1 : GLINT_NONE);
            for (int i = 0; i < 24; i++) {
                static const float wild[8] = {0, -0.0f, 1e-38f, 1e12f, -1e12f, 1, -1, 3e-8f};
                value[n][i] = wild[rand() % 8];
            }
            pose_scene_channel(&s, n, rand() % 3, rand() % 3, 2, time, value[n]);
        }
        for (uint32_t n = 0; n < 4; n++)
            pose_scene_instance(&s, n);
        pose_scene_camera(&s, 3);
        pose_scene_light(&s, GLINT_LIGHT_AREA, 2);
        struct glint_pose *p = pose_of(&s, 0, rand() % 2);
        for (uint32_t i = 0; i < 4; i++)
            for (uint32_t k = 0; !p->instance[i].hidden && k < p->keys; k++) {
                double m[16];
                glint_pose_instance_at(p, &s.scene, i, k, m);
                for (int e = 0; e < 16; e++)
                    assert_true(fabs(m[e]) <= 1e12);
                assert_true(determinant(m) != 0);
            }
        for (int e = 0; e < 16; e++)
            assert_true(fabs(p->camera[0].transform[e]) <= 1e12);
        glint_pose_release(&p);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_translation_is_linear_and_clamped_to_its_keys),
        cmocka_unit_test(a_step_happens_at_its_key_and_holds),
        cmocka_unit_test(a_step_at_the_end_of_the_shutter_belongs_to_the_next_frame),
        cmocka_unit_test(a_rotation_goes_the_short_way_at_an_even_pace),
        cmocka_unit_test(keys_nearly_alike_are_interpolated_without_loss),
        cmocka_unit_test(a_cubic_spline_is_hermites_with_tangents_per_second),
        cmocka_unit_test(a_cubic_rotation_is_made_unit),
        cmocka_unit_test(a_rotation_without_direction_keeps_the_one_before_and_is_counted),
        cmocka_unit_test(parents_may_come_after_their_children),
        cmocka_unit_test(a_node_given_as_a_matrix_is_taken_as_it_is),
        cmocka_unit_test(a_chain_of_a_hundred_thousand_nodes_needs_no_stack),
        cmocka_unit_test(keys_are_as_many_as_keep_the_motion_straight),
        cmocka_unit_test(keys_are_at_equal_distances_and_exact),
        cmocka_unit_test(what_does_not_move_has_one_transform_among_those_that_do),
        cmocka_unit_test(flow_is_where_things_are_a_frame_away),
        cmocka_unit_test(cameras_and_lights_ride_on_nodes_without_scale),
        cmocka_unit_test(a_turning_camera_keeps_its_directions_to_a_thousandth),
        cmocka_unit_test(what_has_no_extent_is_hidden),
        cmocka_unit_test(what_shrinks_to_nothing_stays_drawable),
        cmocka_unit_test(animations_are_found_by_id_then_name),
        cmocka_unit_test(a_pose_is_wanted_where_the_animation_shows),
        cmocka_unit_test(equal_requests_give_equal_bits),
        cmocka_unit_test(nothing_that_is_parsed_makes_a_matrix_that_cannot_be_drawn),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
