// glTF files: morph targets, copies of nodes, colours of vertices.
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

static const float identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

// --- morph targets

#define MORPHED(MORE) \
    "'meshes':[{'name':'face','primitives':[{" GLB_QUAD_PRIMITIVE "," TARGETS "}]" MORE "}]"

static void targets_displace_and_weights_say_how_much(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_moving(
        MORPHED(",'weights':[0.25,0.5]") ",'scenes':[{'nodes':[0,1]}],'nodes':[{'name':'rest',"
                                         "'mesh':0},{'name':'own','mesh':0,'weights':[1,-2]}]");
    const struct glint_mesh *m = &s->mesh[0];
    assert_int_equal(s->meshes, 1);
    assert_int_equal(m->targets, 2);
    gltf_floats_equal(m->target_position, &gltf_moving_data.displace[0][0][0], 24, 0);
    for (int i = 0; i < 12; i++) // the first target leaves normals alone
        assert_true(m->target_normal[i] == 0);
    gltf_floats_equal(m->target_normal + 12, &gltf_moving_data.displace[0][0][0], 12, 0);
    assert_null(m->target_tangent);
    gltf_floats_equal(m->target_weight, (const float[]){0.25f, 0.5f}, 2, 0);
    assert_null(s->instance[0].weight);
    gltf_floats_equal(s->instance[1].weight, (const float[]){1, -2}, 2, 0);
    assert_int_equal(s->warnings, 0);
    glint_scene_destroy(&s);
}

static void meshes_that_morph_are_not_taken_for_equal(void **state)
{
    (void)state;
    struct glint_scene *s =
        gltf_moving("'meshes':[{'primitives':[{'attributes':{'POSITION':0},'targets':[{'POSITION':"
                    "13}]},{'attributes':{'POSITION':0},'targets':[{'POSITION':14}]}],'weights':["
                    "0.5]},{'primitives':[{'attributes':{'POSITION':0},'targets':[{'POSITION':13}]}"
                    "]}],'scenes':[{'nodes':[0,1]}],'nodes':[{'mesh':0},{'mesh':1}]");
    assert_int_equal(s->meshes, 3);
    assert_true(s->mesh[1].target_position[7] == 2 && s->mesh[1].target_weight[0] == 0.5f);
    assert_null(s->mesh[2].target_weight);
    glint_scene_destroy(&s);
}

static void a_channel_of_weights_gives_the_mesh_its_node(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_moving(
        MORPHED("") ",'scenes':[{'nodes':[0]}],'nodes':[{'name':'n','mesh':0,'translation':[1,0,0],"
                    "'children':[1]},{'name':'below','mesh':0}],"
                    "'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'weights'}}"
                    "],'samplers':[{'input':4,'output':8}]}]");
    const struct glint_animation_channel *c = &s->animation[0].channel[0];
    assert_true(c->path == GLINT_PATH_WEIGHTS && c->width == 2 && c->keys == 3 && c->node == 0);
    gltf_floats_equal(c->value, &gltf_moving_data.weigh[0][0], 6, 0);
    assert_true(s->instance[0].node == 0 && s->instance[1].node == GLINT_NONE); // weights move none
    gltf_floats_equal(s->instance[0].transform, identity, 16, 0);
    assert_true(s->instance[1].transform[12] == 1);
    glint_scene_destroy(&s);
}

// The second target: sparse displacements of bytes, of vertex 2 alone, by 2/127 along y.
static void displacements_may_be_sparse_and_quantised(void **state)
{
    (void)state;
    static const struct {
        float position[9];
        int8_t dense[3][4], value[4];
        uint8_t index[4];
    } bin = {{0, 0, 0, 1, 0, 0, 0, 1, 0},
             {{127, 0, 0, 0}, {0, -127, 0, 0}, {0, 0, 0, 0}},
             {0, 2, 0, 0},
             {2, 0, 0, 0}};
    struct glint_scene *s = gltf_data(
        "{'asset':{'version':'2.0'},'extensionsRequired':['KHR_mesh_quantization'],'buffers':[{"
        "'byteLength':56}],'bufferViews':[{'buffer':0,'byteLength':36},{'buffer':0,'byteOffset':36,"
        "'byteLength':12,'byteStride':4},{'buffer':0,'byteOffset':48,'byteLength':4},{'buffer':0,"
        "'byteOffset':52,'byteLength':1}],'accessors':[{'bufferView':0,'componentType':5126,"
        "'count':3,'type':'VEC3'},{'bufferView':1,'componentType':5120,'normalized':true,'count':3,"
        "'type':'VEC3'},{'componentType':5120,'normalized':true,'count':3,'type':'VEC3','sparse':{"
        "'count':1,'indices':{'bufferView':3,'componentType':5121},'values':{'bufferView':2}}}],"
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'targets':[{'POSITION':1},"
        "{'POSITION':2}]}]}]," ONE_NODE "}",
        &bin, sizeof bin);
    static const float expected[18] = {1, 0, 0, 0, -1, 0, 0, 0,          0,
                                       0, 0, 0, 0, 0,  0, 0, 2 / 127.0f, 0};
    gltf_floats_equal(s->mesh[0].target_position, expected, 18, 0);
    glint_scene_destroy(&s);
}

static void faults_of_morph_targets_are_named(void **state)
{
    (void)state;
    static const struct {
        const char *rest, *pointer, *word;
    } bad[] = {
        {MORPHED(",'weights':[1]") "," ONE_NODE, "/meshes/0/weights", "2"},
        {MORPHED("") ",'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0,'weights':[1,2,3]}]",
         "/nodes/0/weights", "2"},
        {SQUARE ",'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0,'weights':[1]}]", "/nodes/0/weights",
         "no morph targets"},
        {"'meshes':[{'primitives':[{'attributes':{'POSITION':0},'targets':[{'POSITION':5}]}]}]"
         "," ONE_NODE,
         "/meshes/0/primitives/0/targets/0/POSITION", "3 elements"},
        {"'meshes':[{'primitives':[{'attributes':{'POSITION':0},'targets':[{'POSITION':12}]}]}]"
         "," ONE_NODE,
         "/meshes/0/primitives/0/targets/0/POSITION", "type"},
        {"'meshes':[{'primitives':[{'attributes':{'POSITION':0},'targets':[{}]},{'attributes':{"
         "'POSITION':0}}]}]," ONE_NODE,
         "/meshes/0/primitives/1/targets", "0 morph targets; the first primitive has 1"},
        {"'meshes':[{'primitives':[{'attributes':{'POSITION':0},'targets':[7]}]}]," ONE_NODE,
         "/meshes/0/primitives/0/targets/0", "object"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        gltf_refuse_moving(bad[i].rest, NULL, bad[i].pointer, bad[i].word);
    struct gltf_moving data = gltf_moving_data;
    data.displace[1][3][0] = NAN;
    gltf_refuse_moving(MORPHED("") "," ONE_NODE, &data, "/accessors/14", "element 3");
}

static void colours_and_coordinates_of_targets_stay_with_a_warning(void **state)
{
    (void)state;
    struct glint_scene *s =
        gltf_moving("'meshes':[{'name':'m','primitives':[{'attributes':{'POSITION':0},'targets':[{"
                    "'POSITION':13,'COLOR_0':15,'TEXCOORD_0':2}]}]}]," ONE_NODE);
    gltf_expect_warning(s, "morph targets of mesh \"m\" move COLOR_0");
    gltf_expect_warning(s, "morph targets of mesh \"m\" move TEXCOORD_0");
    glint_scene_destroy(&s);
}

// --- copies

#define COPIES(ATTRIBUTES, NODE)                                                         \
    SQUARE ",'extensionsRequired':['EXT_mesh_gpu_instancing'],'scenes':[{'nodes':[0]}]," \
           "'nodes':[{'name':'tree','mesh':0,'extensions':{'EXT_mesh_gpu_instancing':{"  \
           "'attributes':{" ATTRIBUTES "}}}" NODE "}]"

static void copies_of_a_node_are_instances_of_one_object(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_moving(COPIES("'TRANSLATION':5,'ROTATION':9", ",'scale':[2,2,2]"));
    assert_int_equal(s->objects, 1);
    assert_string_equal(s->object[0].name, "tree");
    assert_int_equal(s->instances, 3);
    // node scale 2; the second copy turned by 180 degrees about z, the third's quaternion is
    // (1, 0, 0, -1) made unit: -90 degrees about x, y to -z
    static const float expected[3][16] = {
        {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1},
        {-2, 0, 0, 0, 0, -2, 0, 0, 0, 0, 2, 0, 2, 4, 6, 1},
        {2, 0, 0, 0, 0, 0, -2, 0, 0, 2, 0, 0, 8, 10, 12, 1},
    };
    static const char *const ids[] = {"tree.0", "tree.1", "tree.2"};
    for (int i = 0; i < 3; i++) {
        assert_string_equal(s->instance[i].id, ids[i]);
        assert_true(s->instance[i].object == 0 && s->instance[i].mesh == 0);
        gltf_floats_equal(s->instance[i].transform, expected[i], 16, 1e-6f);
    }
    glint_scene_destroy(&s);
}

static void copies_below_what_moves_keep_their_place_in_it(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_moving(
        COPIES("'TRANSLATION':5",
               ",'translation':[9,9,9]") ",'animations':[{'channels':[{"
                                         "'sampler':0,'target':{'node':0,'path':'rotation'}}],'"
                                         "samplers':[{'input':4,'output':6}]}"
                                         "]");
    assert_int_equal(s->instances, 3);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(s->instance[i].node, 0);
        gltf_floats_equal(s->instance[i].transform + 12, gltf_moving_data.move[i], 3, 0);
    }
    glint_scene_destroy(&s);
}

static void faults_of_copies_are_named(void **state)
{
    (void)state;
#define COPIES_AT "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes"
    gltf_refuse_moving(COPIES("'TRANSLATION':6", ""), NULL, COPIES_AT "/TRANSLATION", "type");
    gltf_refuse_moving(COPIES("'ROTATION':11", ""), NULL, COPIES_AT "/ROTATION", "type");
    gltf_refuse_moving(COPIES("'TRANSLATION':5,'SCALE':0", ""), NULL, COPIES_AT "/SCALE",
                       "4 elements");
    gltf_refuse_moving(COPIES("'TRANSLATION':77", ""), NULL, COPIES_AT "/TRANSLATION",
                       "16 accessors");
    struct gltf_moving data = gltf_moving_data;
    data.move[2][0] = NAN;
    gltf_refuse_moving(COPIES("'TRANSLATION':5", ""), &data, "/accessors/5", "element 2");
    memset(data.turn[0], 0, sizeof data.turn[0]);
    gltf_refuse_moving(COPIES("'ROTATION':6", ""), &data, "/accessors/6", "element 0 is no");
}

static void copies_out_of_nothing_are_refused(void **state)
{
    (void)state;
    static const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    size_t size;
    uint8_t *glb = glb_make(
        "{'asset':{'version':'2.0'},'buffers':[{'byteLength':36}],'bufferViews':[{'buffer':0,"
        "'byteLength':36}],'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':"
        "'VEC3'},{'componentType':5126,'count':4000000,'type':'VEC3'}],'meshes':[{'primitives':[{"
        "'attributes':{'POSITION':0}}]}],'nodes':[{'mesh':0,'extensions':{"
        "'EXT_mesh_gpu_instancing':{'attributes':{'TRANSLATION':1}}}}]}",
        triangle, sizeof triangle, &size);
    gltf_refused(glb, size, GLINT_E_RANGE, COPIES_AT "/TRANSLATION", "no buffer view");
}

// --- vertices

static void colours_become_linear_fractions_with_opacity(void **state)
{
    (void)state;
    struct glint_scene *s =
        gltf_moving("'meshes':[{'primitives':[{'attributes':{'POSITION':0,'COLOR_0':15,"
                    "'TEXCOORD_0':2,'TEXCOORD_1':2},'indices':3},{'attributes':{'POSITION':0,"
                    "'COLOR_0':14}}]}]," ONE_NODE);
    static const float bytes[16] = {1, 0, 0.2f, 0.4f, 0, 1, 0, 1, 0, 0, 1, 1, 1, 1, 1, 0};
    gltf_floats_equal(s->mesh[0].color, bytes, 16, 1e-7f);
    gltf_floats_equal(s->mesh[0].uv1, gltf_moving_data.quad.uv, 8, 0);
    // three components, above 1: clamped, opaque
    static const float three[16] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1};
    gltf_floats_equal(s->mesh[1].color, three, 16, 0);
    assert_null(s->mesh[1].uv1);
    glint_scene_destroy(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(targets_displace_and_weights_say_how_much),
        cmocka_unit_test(meshes_that_morph_are_not_taken_for_equal),
        cmocka_unit_test(a_channel_of_weights_gives_the_mesh_its_node),
        cmocka_unit_test(displacements_may_be_sparse_and_quantised),
        cmocka_unit_test(faults_of_morph_targets_are_named),
        cmocka_unit_test(colours_and_coordinates_of_targets_stay_with_a_warning),
        cmocka_unit_test(copies_of_a_node_are_instances_of_one_object),
        cmocka_unit_test(copies_below_what_moves_keep_their_place_in_it),
        cmocka_unit_test(faults_of_copies_are_named),
        cmocka_unit_test(copies_out_of_nothing_are_refused),
        cmocka_unit_test(colours_become_linear_fractions_with_opacity),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
