// Skins and morph targets of poses, against positions worked out by hand.
#include "pose_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define H 0.70710678f
#define NEAR 1e-6

static const float second[2] = {0, 1};
static const float half_turn[8] = {0, 0, 0, 1, 0, 0, 1, 0};
static const float quarter_turn[8] = {0, 0, 0, 1, 0, 0, H, H};

// An arm along x: the shoulder at 0, the elbow at 2, the hand at 4.
static const float arm_position[12] = {1, 0, 0, 2, 0, 0, 4, 0, 0, 4, 0, 1};
static const float arm_normal[12] = {0, 1, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0};
static const float arm_tangent[16] = {1, 0, 0, -1, 1, 0, 0, 1, 1, 0, 0, 1, 0, 1, 0, 1};
static const uint16_t arm_joint[16] = {0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
static const float arm_weight[16] = {1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
static const float arm_bind[32] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0,  0, 0, 1,
                                   1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -2, 0, 0, 1};
static uint32_t arm_bones[2] = {0, 1};

static void make_arm(struct pose_scene *s)
{
    pose_scene_init(s);
    pose_scene_node(s, GLINT_NONE);
    pose_scene_node(s, 0);
    s->node[1].translation[0] = 2;
    struct glint_mesh *m = &s->mesh[0];
    m->vertices = 4;
    m->position = arm_position;
    m->normal = arm_normal;
    m->tangent = arm_tangent;
    m->joint = arm_joint;
    m->weight = arm_weight;
    s->skin[0] =
        (struct glint_skin){.id = "arm", .joints = 2, .joint = arm_bones, .inverse_bind = arm_bind};
    s->scene.skins = 1;
    pose_scene_instance(s, GLINT_NONE);
    s->instance[0].skin = 0;
}

// A vertex of instance 0 in the world.
static void expect_vertex(const struct glint_pose *p, uint32_t key, uint32_t vertex, double x,
                          double y, double z)
{
    const struct glint_pose_instance *in = &p->instance[0];
    const float *v = in->position + 3 * (4 * (in->bends ? key : 0) + vertex);
    expect_point(in->transform, v[0], v[1], v[2], x, y, z, NEAR);
}

static void expect_vector(const float *v, double x, double y, double z)
{
    const double want[3] = {x, y, z};
    for (int i = 0; i < 3; i++)
        if (!(fabs(v[i] - want[i]) < NEAR))
            fail_msg("component %d is %.9g, not %.9g", i, v[i], want[i]);
}

static void an_arm_bends_at_its_elbow(void **state)
{
    (void)state;
    struct pose_scene s;
    make_arm(&s);
    pose_scene_channel(&s, 1, GLINT_PATH_ROTATION, GLINT_INTERPOLATION_LINEAR, 2, second,
                       quarter_turn);
    struct glint_pose *p = pose_of(&s, 1, 1);
    assert_true(p->instance[0].deforms && !p->instance[0].bends && !p->instance[0].moves);
    expect_vertex(p, 0, 0, 1, 0, 0);
    expect_vertex(p, 0, 1, 2, 0, 0);
    expect_vertex(p, 0, 2, 2, 2, 0);
    expect_vertex(p, 0, 3, 2, 2, 1);
    expect_vector(p->instance[0].normal, 0, 1, 0);
    expect_vector(p->instance[0].normal + 3, -H, H, 0); // the mean of both bones, made unit
    expect_vector(p->instance[0].normal + 6, -1, 0, 0);
    expect_vector(p->instance[0].normal + 9, 0, 1, 0);
    expect_vector(p->instance[0].tangent, 1, 0, 0);
    expect_vector(p->instance[0].tangent + 8, 0, 1, 0);
    assert_true(p->instance[0].tangent[3] == -1 && p->instance[0].tangent[15] == 1);
    glint_pose_release(&p);
}

static void the_whole_arm_follows_its_shoulder_and_then_its_instance(void **state)
{
    (void)state;
    struct pose_scene s;
    make_arm(&s);
    s.instance[0].node = pose_scene_node(&s, GLINT_NONE);
    s.node[2].translation[0] = 100; // does not move it
    s.instance[0].transform[14] = 7;
    pose_scene_channel(&s, 0, GLINT_PATH_ROTATION, GLINT_INTERPOLATION_LINEAR, 2, second,
                       half_turn);
    struct glint_pose *p = pose_of(&s, 0.5, 0.5);
    expect_vertex(p, 0, 0, 0, 1, 7);
    expect_vertex(p, 0, 1, 0, 2, 7);
    expect_vertex(p, 0, 2, 0, 4, 7);
    expect_vertex(p, 0, 3, 0, 4, 8);
    glint_pose_release(&p);
    p = pose_of(&s, 0, 1);
    assert_int_equal(p->keys, 9);
    assert_true(p->instance[0].bends && !p->instance[0].moves);
    for (uint32_t k = 0; k < 9; k++)
        expect_vertex(p, k, 2, 4 * cos(M_PI * k / 8), 4 * sin(M_PI * k / 8), 7);
    glint_pose_release(&p);
}

static void weights_that_all_go_to_one_joint_are_a_rigid_motion(void **state)
{
    (void)state;
    static const uint16_t mixed[16] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
    static const float quarter[16] = {0.25f, 0.25f, 0.25f, 0.25f, 0.5f, 0.25f, 0.125f, 0.125f,
                                      1,     0,     0,     0,     0.5f, 0.5f,  0,      0};
    struct pose_scene s;
    make_arm(&s);
    s.mesh[0].joint = mixed;
    s.mesh[0].weight = quarter;
    s.node[0].rotation[0] = s.node[0].rotation[3] = H;
    pose_scene_channel(&s, 1, GLINT_PATH_ROTATION, GLINT_INTERPOLATION_LINEAR, 2, second,
                       half_turn);
    struct glint_pose *p = pose_of(&s, 0.3, 0.3);
    const double c = cos(0.3 * M_PI), d = sin(0.3 * M_PI);
    for (uint32_t i = 0; i < 4; i++) {
        const double x = arm_position[3 * i] - 2, z = arm_position[3 * i + 2];
        expect_vertex(p, 0, i, 2 + c * x, -z, d * x); // turned about z, then y goes to z, z to -y
    }
    glint_pose_release(&p);
}

static void normals_go_by_the_inverse_transpose(void **state)
{
    (void)state;
    struct pose_scene s;
    make_arm(&s);
    static const float slanted[12] = {H, H, 0, H, H, 0, H, H, 0, H, H, 0};
    s.mesh[0].normal = slanted;
    s.node[0].scale[0] = 3;
    struct glint_pose *p = pose_of(&s, 0, 0);
    expect_vector(p->instance[0].normal, 1 / sqrt(10), 3 / sqrt(10), 0);
    glint_pose_release(&p);
}

static void a_mirrored_skeleton_makes_a_mirrored_transform(void **state)
{
    (void)state;
    struct pose_scene s;
    make_arm(&s);
    s.node[0].scale[1] = -1;
    s.node[0].translation[1] = 3;
    struct glint_pose *p = pose_of(&s, 0, 0);
    const double *m = p->instance[0].transform;
    assert_true(m[0] * m[5] * m[10] == -1);
    expect_vertex(p, 0, 3, 4, 3, 1);
    // The normal as a renderer takes it on: +y of the mesh looks along -y.
    const float *n = p->instance[0].normal;
    expect_vector((float[3]){n[0] / (float)m[0], n[1], n[2]}, 0, -1, 0);
    glint_pose_release(&p);
}

static void far_from_the_origin_vertices_keep_their_digits(void **state)
{
    (void)state;
    struct pose_scene s;
    make_arm(&s);
    s.node[0].translation[0] = 1e7f;
    s.node[0].scale[0] = s.node[0].scale[1] = s.node[0].scale[2] = 1e-3f;
    struct glint_pose *p = pose_of(&s, 0, 0);
    expect_vertex(p, 0, 2, 1e7 + 4e-3, 0, 0);
    const float *v = p->instance[0].position;
    assert_true(fabs((v[6] - v[0]) - 3e-3) < 1e-9);
    glint_pose_release(&p);
}

static void a_joint_that_the_skin_has_not_is_refused(void **state)
{
    (void)state;
    struct pose_scene s;
    make_arm(&s);
    s.skin[0].joints = 1;
    struct glint_pose *p;
    struct glint_error err = {0};
    const struct glint_pose_request rest = glint_pose_rest();
    assert_int_equal(glint_pose_create(&p, &s.scene, &rest, &err), GLINT_E_RANGE);
    assert_null(p);
    glint_error_finish(&err);
}

// The arm over and over.
#define MANY 400
static float many_position[3 * MANY], many_normal[3 * MANY], many_tangent[4 * MANY],
    many_weight[4 * MANY];
static uint16_t many_joint[4 * MANY];

static void make_many(struct pose_scene *s)
{
    make_arm(s);
    for (int i = 0; i < MANY; i += 4) {
        memcpy(many_position + 3 * i, arm_position, sizeof arm_position);
        memcpy(many_normal + 3 * i, arm_normal, sizeof arm_normal);
        memcpy(many_tangent + 4 * i, arm_tangent, sizeof arm_tangent);
        memcpy(many_weight + 4 * i, arm_weight, sizeof arm_weight);
        memcpy(many_joint + 4 * i, arm_joint, sizeof arm_joint);
    }
    s->mesh[0].vertices = MANY;
    s->mesh[0].position = many_position;
    s->mesh[0].normal = many_normal;
    s->mesh[0].tangent = many_tangent;
    s->mesh[0].weight = many_weight;
    s->mesh[0].joint = many_joint;
}

static void a_pose_larger_than_allowed_has_fewer_keys_or_is_refused(void **state)
{
    (void)state;
    struct pose_scene s;
    make_many(&s);
    pose_scene_channel(&s, 0, GLINT_PATH_ROTATION, GLINT_INTERPOLATION_LINEAR, 2, second,
                       half_turn);
    // A transform, and for each vertex 40 bytes a key, and 24 of flow.
    struct glint_pose_request request = {.close = 1, .max_bytes = 128 + MANY * (24 + 9 * 40)};
    const uint32_t want[4] = {9, 5, 3, 1};
    struct glint_pose *p;
    for (int i = 0; i < 4; i++) {
        assert_int_equal(glint_pose_create(&p, &s.scene, &request, NULL), GLINT_OK);
        assert_int_equal(p->keys, want[i]);
        assert_int_equal(p->instance[0].bends, want[i] > 1);
        request.max_bytes = 128 + MANY * (24 + 40 * want[i]) - 1;
        glint_pose_release(&p);
    }
    struct glint_error err = {0};
    assert_int_equal(glint_pose_create(&p, &s.scene, &request, &err), GLINT_E_CAPACITY);
    glint_error_finish(&err);
    s.scene.instances = 0; // two nodes at 17 moments, and at rest
    request.max_bytes = 128 * (2 * 17 + 2);
    assert_int_equal(glint_pose_create(&p, &s.scene, &request, NULL), GLINT_OK);
    glint_pose_release(&p);
    request.max_bytes--;
    assert_int_equal(glint_pose_create(&p, &s.scene, &request, &err), GLINT_E_CAPACITY);
    glint_error_finish(&err);
}

// Two targets of the arm: up, and out with another normal.
static const float targets[24] = {0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0,
                                  0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0, 4};
static const float target_normals[24] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                                         1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0};
static const float at_rest[2] = {0.5f, 0}, of_instance[2] = {0, 0.25f};

static void make_morph(struct pose_scene *s)
{
    make_arm(s);
    s->mesh[0].joint = NULL;
    s->mesh[0].weight = NULL;
    s->mesh[0].targets = 2;
    s->mesh[0].target_position = targets;
    s->mesh[0].target_normal = target_normals;
    s->instance[0].skin = GLINT_NONE;
    s->instance[0].node = 0;
}

static void expect_morphed(const struct pose_scene *s, double time, double a, double b)
{
    struct glint_pose *p = pose_of(s, time, time);
    for (uint32_t i = 0; i < 3; i++)
        expect_vertex(p, 0, i, arm_position[3 * i], a, 2 * b);
    expect_vertex(p, 0, 3, 4, a, 1 + 4 * b);
    expect_vector(p->instance[0].normal, b / hypot(1, b), 1 / hypot(1, b), 0);
    glint_pose_release(&p);
}

static void weights_come_from_the_channel_else_the_instance_else_the_mesh(void **state)
{
    (void)state;
    static const float weights[4] = {0, 1, 2, 0};
    struct pose_scene s;
    make_morph(&s);
    struct glint_pose *p = pose_of(&s, 0, 1);
    assert_false(p->instance[0].deforms); // no weights: 0
    assert_null(p->instance[0].position);
    glint_pose_release(&p);
    assert_true(glint_pose_needed(&s.scene));
    s.mesh[0].target_weight = at_rest;
    expect_morphed(&s, 0, 0.5, 0);
    s.instance[0].weight = of_instance;
    expect_morphed(&s, 0, 0, 0.25);
    pose_scene_channel(&s, 0, GLINT_PATH_WEIGHTS, GLINT_INTERPOLATION_LINEAR, 2, second, weights);
    for (int i = 0; i <= 4; i++)
        expect_morphed(&s, i / 4.0, i / 2.0, 1 - i / 4.0);
    p = pose_of(&s, 0, 1);
    assert_int_equal(p->keys, 2); // linear in the weights
    assert_true(p->instance[0].bends && !p->instance[0].moves);
    expect_vertex(p, 1, 3, 4, 2, 1);
    glint_pose_release(&p);
    const struct glint_pose_request request = {.close = 1};
    assert_true(glint_pose_wanted(&s.scene, &request));
}

static void weights_that_bend_take_more_keys(void **state)
{
    (void)state;
    static const float cubic[12] = {0, 0, 0, 0, 8, 0, -8, 0, 0, 0, 0, 0}; // a bump of height 2
    struct pose_scene s;
    make_morph(&s);
    pose_scene_channel(&s, 0, GLINT_PATH_WEIGHTS, GLINT_INTERPOLATION_CUBICSPLINE, 2, second,
                       cubic);
    struct glint_pose *p = pose_of(&s, 0, 1);
    assert_int_equal(p->keys, 9);
    expect_vertex(p, 4, 0, 1, 2, 0);
    glint_pose_release(&p);
}

static void targets_are_added_before_the_skin(void **state)
{
    (void)state;
    struct pose_scene s;
    make_morph(&s);
    s.mesh[0].joint = arm_joint;
    s.mesh[0].weight = arm_weight;
    s.mesh[0].target_weight = at_rest;
    s.instance[0].skin = 0;
    s.node[1].rotation[2] = s.node[1].rotation[3] = H;
    struct glint_pose *p = pose_of(&s, 0, 0);
    expect_vertex(p, 0, 0, 1, 0.5, 0);
    expect_vertex(p, 0, 2, 1.5, 2, 0); // (2, 0.5) turned and set on the elbow
    glint_pose_release(&p);
}

static void flow_of_what_bends_is_its_vertices_a_frame_away(void **state)
{
    (void)state;
    static const float weights[4] = {0, 0, 4, 0};
    struct pose_scene s;
    make_morph(&s);
    pose_scene_channel(&s, 0, GLINT_PATH_WEIGHTS, GLINT_INTERPOLATION_LINEAR, 2, second, weights);
    struct glint_pose *p = pose_flowing(&s, 0, 0.25, 0.75);
    expect_vertex(p, 0, 0, 1, 1, 0);
    expect_vector(p->instance[0].flow_position, 1, 0, 0);
    expect_vector(p->instance[0].flow_position + 12, 1, 3, 0);
    assert_null(p->instance[0].flow_transform);
    glint_pose_release(&p);
    p = pose_flowing(&s, 2, 3, 4); // it stands still there
    assert_null(p->instance[0].flow_position);
    glint_pose_release(&p);
}

static void instances_that_deform_alike_share_their_vertices(void **state)
{
    (void)state;
    struct pose_scene s;
    make_arm(&s);
    pose_scene_instance(&s, GLINT_NONE);
    pose_scene_instance(&s, GLINT_NONE);
    s.instance[1].skin = s.instance[2].skin = 0;
    s.instance[1].transform[12] = 5;
    s.instance[2].visible = false;
    struct glint_pose *p = pose_of(&s, 0, 0);
    assert_ptr_equal(p->instance[0].position, p->instance[1].position);
    assert_true(p->instance[1].transform[12] == p->instance[0].transform[12] + 5);
    assert_true(p->instance[2].hidden && !p->instance[2].position);
    glint_pose_release(&p);
}

static void a_joint_without_extent_leaves_normals_unit(void **state)
{
    (void)state;
    struct pose_scene s;
    make_arm(&s);
    s.node[1].scale[0] = s.node[1].scale[1] = s.node[1].scale[2] = 0;
    struct glint_pose *p = pose_of(&s, 0, 0);
    expect_vertex(p, 0, 2, 2, 0, 0);
    expect_vertex(p, 0, 3, 2, 0, 0);
    expect_vector(p->instance[0].normal + 9, 1, 0, 0); // as the mesh has it
    glint_pose_release(&p);
}

static void nothing_that_is_parsed_makes_a_vertex_that_is_no_number(void **state)
{
    (void)state;
    static const float wild[8] = {0, -0.0f, 1e-38f, 1e12f, -1e12f, 1, -1, 1e-20f};
    srand(5);
    for (int round = 0; round < 2000; round++) {
        struct pose_scene s;
        make_morph(&s);
        float position[12], target[24], bind[32], weights[4], value[2][24];
        for (int i = 0; i < 32; i++) {
            position[i % 12] = wild[rand() % 8];
            target[i % 24] = wild[rand() % 8];
            bind[i] = i % 4 == 3 ? i % 16 == 15 : wild[rand() % 8];
            weights[i % 4] = wild[rand() % 8];
            value[0][i % 24] = wild[rand() % 8];
            value[1][i % 24] = wild[rand() % 8];
        }
        s.mesh[0].position = position;
        s.mesh[0].target_position = target;
        s.mesh[0].joint = arm_joint;
        s.mesh[0].weight = arm_weight;
        s.skin[0].inverse_bind = bind;
        s.instance[0].skin = 0;
        for (uint32_t n = 0; n < 2; n++)
            pose_scene_channel(&s, n, rand() % 3, rand() % 3, 2, second, value[n]);
        pose_scene_channel(&s, 0, GLINT_PATH_WEIGHTS, GLINT_INTERPOLATION_LINEAR, 2, second,
                           weights);
        struct glint_pose *p = pose_of(&s, 0, rand() % 2);
        const struct glint_pose_instance *in = &p->instance[0];
        for (uint32_t i = 0; i < 12 * (in->bends ? p->keys : 1); i++) {
            assert_true(fabsf(in->position[i]) <= GLINT_MAX_COORDINATE);
            const float *n = in->normal + i / 3 * 3;
            assert_true(fabsf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1) < 1e-5f);
        }
        glint_pose_release(&p);
    }
}

static void equal_requests_give_equal_vertices(void **state)
{
    (void)state;
    struct pose_scene s;
    make_arm(&s);
    pose_scene_channel(&s, 1, GLINT_PATH_ROTATION, GLINT_INTERPOLATION_LINEAR, 2, second,
                       half_turn);
    struct glint_pose *a = pose_of(&s, 0, 1), *b = pose_of(&s, 0, 1);
    assert_int_equal(a->keys, b->keys);
    assert_memory_equal(a->instance[0].position, b->instance[0].position,
                        a->keys * 4 * sizeof(float[3]));
    assert_memory_equal(a->instance[0].normal, b->instance[0].normal,
                        a->keys * 4 * sizeof(float[3]));
    glint_pose_release(&a);
    glint_pose_release(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_arm_bends_at_its_elbow),
        cmocka_unit_test(the_whole_arm_follows_its_shoulder_and_then_its_instance),
        cmocka_unit_test(weights_that_all_go_to_one_joint_are_a_rigid_motion),
        cmocka_unit_test(normals_go_by_the_inverse_transpose),
        cmocka_unit_test(a_mirrored_skeleton_makes_a_mirrored_transform),
        cmocka_unit_test(far_from_the_origin_vertices_keep_their_digits),
        cmocka_unit_test(a_joint_that_the_skin_has_not_is_refused),
        cmocka_unit_test(a_pose_larger_than_allowed_has_fewer_keys_or_is_refused),
        cmocka_unit_test(weights_come_from_the_channel_else_the_instance_else_the_mesh),
        cmocka_unit_test(weights_that_bend_take_more_keys),
        cmocka_unit_test(targets_are_added_before_the_skin),
        cmocka_unit_test(flow_of_what_bends_is_its_vertices_a_frame_away),
        cmocka_unit_test(instances_that_deform_alike_share_their_vertices),
        cmocka_unit_test(a_joint_without_extent_leaves_normals_unit),
        cmocka_unit_test(nothing_that_is_parsed_makes_a_vertex_that_is_no_number),
        cmocka_unit_test(equal_requests_give_equal_vertices),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
