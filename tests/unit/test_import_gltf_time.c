#include "tests/unit/gltf_expect.h"
#include "tests/unit/gltf_moving.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SQUARE "'meshes':[{'name':'square','primitives':[{" GLB_QUAD_PRIMITIVE "}]}]"
#define UNIT 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1

static const float identity[16] = {UNIT};

// --- frames

// rig (moved) / arm (animated) / hand, with a square on each, and one beside them.
static void what_moves_keeps_its_frame_and_all_else_is_baked(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_moving(
        SQUARE ",'scenes':[{'nodes':[0,3]}],'nodes':["
               "{'name':'rig','translation':[0,0,5],'children':[1],'mesh':0},"
               "{'name':'arm','translation':[1,0,0],'scale':[2,2,2],'children':[2],'mesh':0},"
               "{'matrix':[1,0,0,0,0,1,0,0,0,0,1,0,7,0,0,1],'mesh':0},"
               "{'name':'still','translation':[3,0,0],'mesh':0}],"
               "'animations':[{'name':'wave','channels':[{'sampler':0,'target':{'node':1,'path':"
               "'rotation'}}],'samplers':[{'input':4,'output':6}]}]");
    assert_int_equal(s->nodes, 3);
    const struct glint_node *n = s->node;
    assert_string_equal(n[0].id, "rig");
    assert_string_equal(n[1].name, "arm");
    assert_string_equal(n[2].id, "node_2");
    assert_true(n[0].parent == GLINT_NONE && n[1].parent == 0 && n[2].parent == 1);
    assert_true(n[0].translation[2] == 5 && !n[0].matrix && n[2].matrix);
    static const float arm[16] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 0, 0, 1};
    gltf_floats_equal(n[1].transform, arm, 16, 0);
    assert_true(n[2].transform[12] == 7);
    assert_int_equal(s->instances, 4);
    const struct glint_instance *in = s->instance;
    assert_true(in[0].node == GLINT_NONE && in[0].transform[14] == 5); // above what moves
    assert_true(in[1].node == 1 && in[2].node == 2 && in[3].node == GLINT_NONE);
    gltf_floats_equal(in[1].transform, identity, 16, 0);
    gltf_floats_equal(in[2].transform, identity, 16, 0);
    assert_true(in[3].transform[12] == 3);
    assert_true(s->fps == 24);
    assert_int_equal(s->warnings, 0);
    glint_scene_destroy(&s);
}

static void without_animation_there_are_no_nodes(void **state)
{
    (void)state;
    struct glint_scene *s =
        gltf_moving(SQUARE ",'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0,'translation':[1,2,3]}]");
    assert_int_equal(s->nodes, 0);
    assert_true(s->instance[0].node == GLINT_NONE && s->instance[0].skin == GLINT_NONE);
    glint_scene_destroy(&s);
}

static void lights_and_cameras_ride_on_what_moves(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_moving(
        "'cameras':[{'type':'perspective','perspective':{'yfov':1}}],'extensions':{"
        "'KHR_lights_punctual':{'lights':[{'type':'point'}]}},'scenes':[{'nodes':[0,3]}],'nodes':["
        "{'children':[1,2]},{'camera':0,'translation':[1,0,0]},{'extensions':{"
        "'KHR_lights_punctual':{'light':0}}},{'camera':0,'translation':[0,4,0]}],"
        "'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
        "'samplers':[{'input':4,'output':5}]}]");
    assert_int_equal(s->nodes, 3);
    assert_true(s->camera[0].node == 1 && s->light[0].node == 2);
    gltf_floats_equal(s->camera[0].transform, identity, 16, 0);
    gltf_floats_equal(s->light[0].transform, identity, 16, 0);
    assert_true(s->camera[1].node == GLINT_NONE && s->camera[1].transform[13] == 4);
    glint_scene_destroy(&s);
}

// Turned by 90 degrees about z, scaled by 2, 3 and -4, moved.
static void an_animated_matrix_is_taken_apart(void **state)
{
    (void)state;
#define MATRIX(M)                                                                             \
    SQUARE ",'scenes':[{'nodes':[0]}],'nodes':[{'name':'m','mesh':0,'matrix':[" M "]}],"      \
           "'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}" \
           "}],'samplers':[{'input':4,'output':5}]}]"
    struct glint_scene *s = gltf_moving(MATRIX("0,2,0,0,-3,0,0,0,0,0,-4,0,5,6,7,1"));
    const struct glint_node *n = &s->node[0];
    static const float whole[16] = {0, 2, 0, 0, -3, 0, 0, 0, 0, 0, -4, 0, 5, 6, 7, 1};
    assert_false(n->matrix);
    gltf_floats_equal(n->transform, whole, 16, 1e-6f);
    gltf_floats_equal(n->translation, whole + 12, 3, 0);
    // which axis is mirrored is a choice; the product of the scales is not
    assert_true(fabsf(n->scale[0] * n->scale[1] * n->scale[2] + 24) < 1e-5f);
    const float *q = n->rotation;
    assert_true(fabsf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1) < 1e-6f);
    gltf_expect_warning(s, "node \"m\" is animated and has a matrix");
    assert_false(gltf_warns(s, "shear"));
    glint_scene_destroy(&s);
    s = gltf_moving(MATRIX("1,0,0,0,0.5,1,0,0,0,0,1,0,0,0,0,1"));
    gltf_expect_warning(s, "its shear is lost");
    glint_scene_destroy(&s);
}

// --- channels

#define ONE_MOVES                                                                          \
    SQUARE ",'scenes':[{'nodes':[0]}],'nodes':[{'name':'n','mesh':0},{'name':'outside'}]," \
           "'animations':"

static void channels_keep_their_keys(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_moving(
        ONE_MOVES
        "[{'name':'go','channels':[{'sampler':0,'target':{'node':0,'path':'translation'}},"
        "{'sampler':1,'target':{'node':0,'path':'rotation'}},{'sampler':2,'target':{'node':0,"
        "'path':'scale'}}],'samplers':[{'input':4,'output':5},{'input':4,'output':9,"
        "'interpolation':'STEP'},{'input':4,'output':7,'interpolation':'CUBICSPLINE'}]},"
        "{'channels':[{'sampler':0,'target':{'node':0,'path':'rotation'}}],'samplers':[{'input':4,"
        "'output':6,'interpolation':'LINEAR'}]}]");
    assert_int_equal(s->animations, 2);
    const struct glint_animation *a = s->animation;
    assert_string_equal(a[0].id, "go");
    assert_string_equal(a[1].name, "animation_1");
    assert_true(a[0].channels == 3 && a[1].channels == 1);
    const struct glint_animation_channel *c = a[0].channel;
    static const char *const ids[] = {"n.translation", "n.rotation", "n.scale"};
    for (int i = 0; i < 3; i++) {
        assert_string_equal(c[i].id, ids[i]);
        assert_true(c[i].node == 0 && c[i].keys == 3 && (int)c[i].path == i);
        gltf_floats_equal(c[i].time, gltf_moving_data.time, 3, 0);
    }
    assert_true(c[0].interpolation == GLINT_INTERPOLATION_LINEAR &&
                c[1].interpolation == GLINT_INTERPOLATION_STEP &&
                c[2].interpolation == GLINT_INTERPOLATION_CUBICSPLINE);
    assert_true(c[0].width == 3 && c[1].width == 4 && c[2].width == 3);
    gltf_floats_equal(c[0].value, &gltf_moving_data.move[0][0], 9, 0);
    // -32768 is -1 too, and the last one is made unit
    const float half = sqrtf(0.5f);
    const float turn16[12] = {0, 0, 0, 1, 0, 0, 1, 0, half, 0, 0, -half};
    gltf_floats_equal(c[1].value, turn16, 12, 1e-7f);
    gltf_floats_equal(c[2].value, &gltf_moving_data.curve[0][0][0], 27, 0);
    gltf_floats_equal(a[1].channel[0].value, &gltf_moving_data.turn[0][0], 12, 0);
    assert_string_equal(a[1].channel[0].id, "n.rotation"); // unique in its animation alone
    glint_scene_destroy(&s);
}

static void channels_without_a_place_here_are_named(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_moving(
        ONE_MOVES
        "[{'name':'a','channels':[{'sampler':0,'target':{'node':1,'path':'translation'}},"
        "{'sampler':0,'target':{'path':'pointer','extensions':{'KHR_animation_pointer':{}}}},"
        "{'sampler':0,'target':{'path':'scale'}},{'sampler':0,'target':{'node':0,'path':'scale'}}]"
        ",'samplers':[{'input':4,'output':5}]},"
        "{'name':'b','channels':[{'sampler':0,'target':{'node':1,'path':'scale'}}],"
        "'samplers':[{'input':4,'output':5}]}]");
    assert_int_equal(s->animations, 1);
    assert_int_equal(s->animation[0].channels, 1);
    gltf_expect_warning(s, "a channel of animation \"a\" moves node 1, which the scene does not");
    gltf_expect_warning(s, "a channel of animation \"a\" with KHR_animation_pointer");
    gltf_expect_warning(s, "animation \"b\" moves nothing");
    glint_scene_destroy(&s);
}

#define CHANNEL(TARGET, SAMPLER) \
    ONE_MOVES "[{'channels':[{'sampler':0,'target':{" TARGET "}}],'samplers':[{" SAMPLER "}]}]"
#define CHANNEL_AT "/animations/0/channels/0"
#define SAMPLER_AT "/animations/0/samplers/0"

static void faults_of_channels_are_named(void **state)
{
    (void)state;
    static const struct {
        const char *rest, *pointer, *word;
    } bad[] = {
        {CHANNEL("'node':9,'path':'scale'", "'input':4,'output':5"), CHANNEL_AT "/target/node",
         "2 nodes"},
        {CHANNEL("'node':0,'path':'colour'", "'input':4,'output':5"), CHANNEL_AT "/target/path",
         "colour"},
        {CHANNEL("'node':0", "'input':4,'output':5"), CHANNEL_AT "/target/path", "required"},
        {CHANNEL("'node':0,'path':'weights'", "'input':4,'output':8"), CHANNEL_AT "/target",
         "no morph targets"},
        {CHANNEL("'node':0,'path':'scale'", "'input':4,'output':5,'interpolation':'BEZIER'"),
         SAMPLER_AT "/interpolation", "BEZIER"},
        {CHANNEL("'node':0,'path':'scale'", "'output':5"), SAMPLER_AT "/input", "required"},
        {CHANNEL("'node':0,'path':'scale'", "'input':4"), SAMPLER_AT "/output", "required"},
        {CHANNEL("'node':0,'path':'scale'", "'input':99,'output':5"), SAMPLER_AT "/input",
         "16 accessors"},
        {CHANNEL("'node':0,'path':'scale'", "'input':3,'output':5"), SAMPLER_AT "/input", "times"},
        {CHANNEL("'node':0,'path':'scale'", "'input':4,'output':6"), SAMPLER_AT "/output", "type"},
        {CHANNEL("'node':0,'path':'rotation'", "'input':4,'output':11"), SAMPLER_AT "/output",
         "type"},
        {CHANNEL("'node':0,'path':'scale'", "'input':4,'output':0"), SAMPLER_AT "/output",
         "4 elements; 3 keys need 3"},
        {CHANNEL("'node':0,'path':'scale'", "'input':4,'output':5,'interpolation':'CUBICSPLINE'"),
         SAMPLER_AT "/output", "3 keys need 9"},
        {ONE_MOVES "[{'channels':[{'sampler':1,'target':{'node':0,'path':'scale'}}],'samplers':[{"
                   "'input':4,'output':5}]}]",
         CHANNEL_AT "/sampler", "1 samplers"},
        {ONE_MOVES "[{'channels':[{'sampler':0,'target':{'node':0,'path':'scale'}},{'sampler':0,"
                   "'target':{'node':0,'path':'scale'}}],'samplers':[{'input':4,'output':5}]}]",
         "/animations/0/channels/1/target", "twice"},
        {ONE_MOVES "[{'samplers':[]}]", "/animations/0/channels", "required"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        gltf_refuse_moving(bad[i].rest, NULL, bad[i].pointer, bad[i].word);
}

static void times_grow_from_0_and_values_are_numbers(void **state)
{
    (void)state;
    static const char *const rest =
        CHANNEL("'node':0,'path':'translation'", "'input':4,'output':5");
    struct gltf_moving data = gltf_moving_data;
    data.time[2] = 0.5f;
    gltf_refuse_moving(rest, &data, "/accessors/4", "time 2 is 0.5, not after 0.5");
    data.time[2] = NAN;
    gltf_refuse_moving(rest, &data, "/accessors/4", "nan");
    data = gltf_moving_data;
    data.time[0] = -1;
    gltf_refuse_moving(rest, &data, "/accessors/4", "from -1 to 2");
    data = gltf_moving_data;
    data.move[1][2] = INFINITY;
    gltf_refuse_moving(rest, &data, "/accessors/5", "element 1 has the number inf");
    data = gltf_moving_data;
    memset(data.turn[1], 0, sizeof data.turn[1]);
    gltf_refuse_moving(CHANNEL("'node':0,'path':'rotation'", "'input':4,'output':6"), &data,
                       "/accessors/6", "key 1 is no rotation");
}

static void rotations_of_a_spline_are_nearly_unit(void **state)
{
    (void)state;
    // 3 keys of a spline need 9 quaternions: those of a hand-made accessor
    static const float bin[3 + 36] = {0, 1, 2,                               // times
                                      0, 0, 0, 0, 0, 0, 0, 1,    0, 0, 0, 0, //
                                      9, 0, 0, 0, 0, 0, 0, 1.01, 0, 9, 0, 0, //
                                      0, 0, 0, 0, 0, 1, 0, 0,    0, 0, 0, 0};
    static const char *const json =
        "{'asset':{'version':'2.0'},'buffers':[{'byteLength':156}],'bufferViews':[{'buffer':0,"
        "'byteLength':12},{'buffer':0,'byteOffset':12,'byteLength':144}],'accessors':[{"
        "'bufferView':0,'componentType':5126,'count':3,'type':'SCALAR'},{'bufferView':1,"
        "'componentType':5126,'count':9,'type':'VEC4'}],'nodes':[{}],'animations':[{'channels':[{"
        "'sampler':0,'target':{'node':0,'path':'rotation'}}],'samplers':[{'input':0,'output':1,"
        "'interpolation':'CUBICSPLINE'}]}]}";
    struct glint_scene *s = gltf_data(json, bin, sizeof bin);
    gltf_floats_equal(s->animation[0].channel[0].value, bin + 3, 36, 0);
    glint_scene_destroy(&s);
    float longer[39];
    size_t size;
    memcpy(longer, bin, sizeof bin);
    longer[3 + 12 + 7] = 1.05f;
    uint8_t *glb = glb_make(json, longer, sizeof longer, &size);
    gltf_refused(glb, size, GLINT_E_RANGE, "/accessors/1", "key 1 is no rotation");
}

// Scaled to nothing at rest, to be shown by an animation; what is below is scaled to nothing too.
static void what_moves_may_be_hidden_at_rest(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_moving(
        SQUARE ",'scenes':[{'nodes':[0]}],'nodes':[{'name':'seed','scale':[0,0,0],'children':[1]},"
               "{'name':'leaf','scale':[0,2,2],'mesh':0}],'animations':[{'channels':[{'sampler':0,"
               "'target':{'node':0,'path':'scale'}}],'samplers':[{'input':4,'output':5}]}]");
    assert_int_equal(s->instances, 1);
    assert_true(s->node[0].scale[0] == 1e-6f && s->node[1].scale[0] == 1 &&
                s->node[1].scale[1] == 2);
    assert_true(s->node[0].transform[5] == 1e-6f);
    gltf_expect_warning(s, "node \"seed\" has no size");
    gltf_expect_warning(s, "node \"leaf\" has no size");
    glint_scene_destroy(&s);
}

static void weights_of_what_is_not_shown_are_dropped(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_moving(
        "'meshes':[{'primitives':[{'mode':0,'attributes':{'POSITION':0},'targets':[{},{}]}]}],"
        "'scenes':[{'nodes':[0]}],'nodes':[{'name':'n','mesh':0}],'animations':[{'name':'a',"
        "'channels':[{'sampler':0,'target':{'node':0,'path':'weights'}}],'samplers':[{'input':4,"
        "'output':8}]}]");
    assert_int_equal(s->animations, 0);
    gltf_expect_warning(s, "weights of animation \"a\" are ignored: node \"n\" shows nothing");
    glint_scene_destroy(&s);
}

// --- skins

#define SKINNED_MESH                                                                 \
    "'meshes':[{'name':'body','primitives':[{'attributes':{'POSITION':0,'NORMAL':1," \
    "'JOINTS_0':11,'WEIGHTS_0':12},'indices':3}]}]"
// The square, moved out of the way, bound to hip / knee; with the inverse matrices or without.
#define SKINNED(SKIN)                                                                       \
    SKINNED_MESH ",'skins':[" SKIN "],'scenes':[{'nodes':[0,1]}],'nodes':[{'name':'skin',"  \
                 "'mesh':0,'skin':0,'translation':[50,0,0]},{'name':'hip','children':[2]}," \
                 "{'name':'knee','translation':[0,1,0]},{'name':'far'}]"

static void a_skinned_mesh_hangs_on_its_joints(void **state)
{
    (void)state;
    struct glint_scene *s =
        gltf_moving(SKINNED("{'name':'bones','joints':[1,2],'inverseBindMatrices':10}"));
    assert_int_equal(s->skins, 1);
    const struct glint_skin *k = &s->skin[0];
    assert_string_equal(k->id, "bones");
    assert_int_equal(k->joints, 2);
    assert_string_equal(s->node[k->joint[0]].name, "hip"); // nodes, though nothing moves them
    assert_string_equal(s->node[k->joint[1]].name, "knee");
    assert_int_equal(s->node[k->joint[1]].parent, k->joint[0]);
    gltf_floats_equal(k->inverse_bind, &gltf_moving_data.bind[0][0], 32, 0);
    const struct glint_instance *in = &s->instance[0];
    assert_true(in->skin == 0 && in->node == GLINT_NONE);
    gltf_floats_equal(in->transform, identity, 16, 0); // its own node does not move it
    glint_scene_destroy(&s);
    s = gltf_moving(SKINNED("{'joints':[1,2]}"));
    gltf_floats_equal(s->skin[0].inverse_bind, identity, 16, 0);
    gltf_floats_equal(s->skin[0].inverse_bind + 16, identity, 16, 0);
    assert_string_equal(s->skin[0].id, "skin_0");
    glint_scene_destroy(&s);
}

// Of a vertex with weights that are not of sum 1, and of one without any; joint 9 has no weight.
static void weights_have_the_sum_1(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_moving(SKINNED("{'joints':[1,2]}"));
    const struct glint_mesh *m = &s->mesh[0];
    static const float weight[16] = {1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    static const uint16_t joint[16] = {0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0};
    gltf_floats_equal(m->weight, weight, 16, 0);
    assert_memory_equal(m->joint, joint, sizeof joint);
    gltf_expect_warning(s, "1 vertices of mesh \"body\" follow no joint");
    glint_scene_destroy(&s);
}

static void faults_of_skins_are_named(void **state)
{
    (void)state;
    static const struct {
        const char *rest, *pointer, *word;
    } bad[] = {
        {SKINNED("{}"), "/skins/0/joints", "required"},
        {SKINNED("{'joints':[]}"), "/skins/0/joints", "0 joints"},
        {SKINNED("{'joints':[1,9]}"), "/skins/0/joints/1", "node 9"},
        {SKINNED("{'joints':[1,3]}"), "/skins/0/joints/1", "node 3 is not in the scene"},
        {SKINNED("{'joints':[1]}"), "/nodes/0/skin", "asks for joint 1; the skin has 1"},
        {SKINNED("{'joints':[1,2],'inverseBindMatrices':12}"), "/skins/0/inverseBindMatrices",
         "2 matrices"},
        {SKINNED("{'joints':[1,2,0],'inverseBindMatrices':10}"), "/skins/0/inverseBindMatrices",
         "3 matrices"},
        {"'meshes':[{'primitives':[{'attributes':{'POSITION':0,'JOINTS_0':11}}]}]," ONE_NODE,
         "/meshes/0/primitives/0/attributes", "together"},
        {"'meshes':[{'primitives':[{'attributes':{'POSITION':0,'JOINTS_0':12,'WEIGHTS_0':12}}]}]"
         "," ONE_NODE,
         "/meshes/0/primitives/0/attributes/JOINTS_0", "8 or 16"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        gltf_refuse_moving(bad[i].rest, NULL, bad[i].pointer, bad[i].word);
    struct gltf_moving data = gltf_moving_data;
    data.bind[1][3] = 1;
    static const char *const bound = SKINNED("{'joints':[1,2],'inverseBindMatrices':10}");
    gltf_refuse_moving(bound, &data, "/accessors/10", "last row of matrix 1");
    data.bind[1][3] = NAN;
    gltf_refuse_moving(bound, &data, "/accessors/10", "matrix 1 has the number nan");
}

static void a_million_joints_are_refused(void **state)
{
    (void)state;
    char *rest = malloc(3000000), *end = rest;
    end += sprintf(end, SKINNED_MESH ",'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0,'skin':0}],"
                                     "'skins':[{'joints':[0");
    for (int i = 1; i < 1000000; i++)
        end += sprintf(end, ",0");
    strcpy(end, "]}]");
    gltf_refuse_moving(rest, NULL, "/skins/0/joints", "1000000 joints");
    free(rest);
}

// A joint may be the skinned node's own, as joints go: no cycle of nodes comes of it.
static void a_skin_on_its_own_joint_is_read(void **state)
{
    (void)state;
    struct glint_scene *s =
        gltf_moving(SKINNED_MESH ",'skins':[{'joints':[0,0]}],'scenes':[{'nodes':[0]}],"
                                 "'nodes':[{'mesh':0,'skin':0}]");
    assert_int_equal(s->nodes, 1);
    assert_true(s->skin[0].joint[0] == 0 && s->instance[0].node == GLINT_NONE);
    glint_scene_destroy(&s);
}

static void a_skin_without_joints_in_the_mesh_binds_nothing(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_moving(SQUARE ",'skins':[{'joints':[0]}],'scenes':[{'nodes':[0]}"
                                               "],'nodes':[{'name':'n','mesh':0,'skin':0,"
                                               "'translation':[1,2,3]}]");
    assert_true(s->instance[0].skin == GLINT_NONE && s->instance[0].transform[13] == 2);
    gltf_expect_warning(s, "node \"n\" has a skin, but its mesh has no joints");
    glint_scene_destroy(&s);
    s = gltf_moving(SKINNED_MESH ",'skins':[{'joints':[0,0]}],'scenes':[{'nodes':[0]}],'nodes':[{"
                                 "'name':'n','mesh':0,'skin':0,'extensions':{"
                                 "'EXT_mesh_gpu_instancing':{'attributes':{'TRANSLATION':5}}}}]");
    assert_true(s->instances == 1 && s->instance[0].skin == 0);
    gltf_expect_warning(s, "EXT_mesh_gpu_instancing of node \"n\" is ignored");
    glint_scene_destroy(&s);
}

// --- the camera that is added

// Of a square that moves away from where it rests.
static void the_added_camera_sees_where_animations_take_things(void **state)
{
    (void)state;
    struct glint_scene *s =
        gltf_moving(CHANNEL("'node':0,'path':'translation'", "'input':4,'output':5"));
    assert_int_equal(glint_scene_complete_file(s, NULL), GLINT_OK);
    assert_int_equal(s->cameras, 1);
    const float *c = s->camera[0].transform;
    const float slope = tanf(0.5f * s->camera[0].yfov);
    for (int key = 0; key < 3; key++)
        for (int v = 0; v < 4; v++) {
            float view[3] = {0, 0, 0};
            for (int k = 0; k < 3; k++) {
                const float p =
                    gltf_moving_data.move[key][k] + gltf_moving_data.quad.position[3 * v + k];
                for (int axis = 0; axis < 3; axis++)
                    view[axis] += (p - c[12 + k]) * c[4 * axis + k];
            }
            assert_true(fabsf(view[0]) < -slope * view[2] && fabsf(view[1]) < -slope * view[2]);
        }
    glint_scene_destroy(&s);
}

// --- the native form

static void free_assets(struct glint_asset *asset, size_t assets)
{
    for (size_t i = 0; i < assets; i++)
        free((void *)asset[i].bytes);
    free(asset);
}

// All at once: the text that is written parses, and is written again as the same text.
static void what_is_imported_survives_the_native_form(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_moving(
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':1,'TEXCOORD_0':2,"
        "'TEXCOORD_1':2,'COLOR_0':15,'JOINTS_0':11,'WEIGHTS_0':12},'indices':3," TARGETS
        "}],'weights':[0.1,0.2]}],'skins':[{'joints':[1,2],'inverseBindMatrices':10}],"
        "'cameras':[{'type':'orthographic','orthographic':{'ymag':2}}],'scenes':[{'nodes':[0,1,3]}]"
        ",'nodes':[{'mesh':0,'skin':0},{'children':[2],'scale':[0,1,1]},{'camera':0,'matrix':[1,0,"
        "0,0,0,1,0,0,0,0,1,0,7,0,0,1]},{'mesh':0,'weights':[1,2],'extensions':{"
        "'EXT_mesh_gpu_instancing':{'attributes':{'TRANSLATION':5,'ROTATION':9}}}}],"
        "'animations':[{'channels':[{'sampler':0,'target':{'node':1,'path':'translation'}},"
        "{'sampler':1,'target':{'node':2,'path':'rotation'}},{'sampler':2,'target':{'node':3,"
        "'path':'scale'}},{'sampler':3,'target':{'node':3,'path':'weights'}}],'samplers':[{'input':"
        "4,'output':5},{'input':4,'output':9,'interpolation':'STEP'},{'input':4,'output':7,"
        "'interpolation':'CUBICSPLINE'},{'input':4,'output':8}]}]");
    struct glint_asset *asset = NULL, *more = NULL;
    struct glint_scene *again = NULL;
    struct glint_error err = {0};
    char *text, *second;
    size_t assets = 0, others = 0, length, longer;
    assert_int_equal(glint_scene_complete_file(s, NULL), GLINT_OK);
    assert_int_equal(glint_scene_write(s, &text, &length, &asset, &assets, NULL), GLINT_OK);
    if (glint_scene_parse(&again, text, length, asset, assets, &err))
        fail_msg("%s: %s", err.count ? err.fault[0].pointer : "", glint_error_text(&err));
    assert_int_equal(glint_scene_write(again, &second, &longer, &more, &others, NULL), GLINT_OK);
    assert_string_equal(text, second);
    assert_true(again->nodes == s->nodes && again->skins == 1 && again->animations == 1);
    assert_true(again->mesh[0].targets == 2 && again->mesh[0].joint && again->mesh[0].color);
    free(text);
    free(second);
    free_assets(asset, assets);
    free_assets(more, others);
    glint_scene_destroy(&again);
    glint_scene_destroy(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_moves_keeps_its_frame_and_all_else_is_baked),
        cmocka_unit_test(without_animation_there_are_no_nodes),
        cmocka_unit_test(lights_and_cameras_ride_on_what_moves),
        cmocka_unit_test(an_animated_matrix_is_taken_apart),
        cmocka_unit_test(channels_keep_their_keys),
        cmocka_unit_test(channels_without_a_place_here_are_named),
        cmocka_unit_test(faults_of_channels_are_named),
        cmocka_unit_test(times_grow_from_0_and_values_are_numbers),
        cmocka_unit_test(rotations_of_a_spline_are_nearly_unit),
        cmocka_unit_test(what_moves_may_be_hidden_at_rest),
        cmocka_unit_test(weights_of_what_is_not_shown_are_dropped),
        cmocka_unit_test(a_skinned_mesh_hangs_on_its_joints),
        cmocka_unit_test(weights_have_the_sum_1),
        cmocka_unit_test(faults_of_skins_are_named),
        cmocka_unit_test(a_million_joints_are_refused),
        cmocka_unit_test(a_skin_on_its_own_joint_is_read),
        cmocka_unit_test(a_skin_without_joints_in_the_mesh_binds_nothing),
        cmocka_unit_test(the_added_camera_sees_where_animations_take_things),
        cmocka_unit_test(what_is_imported_survives_the_native_form),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
