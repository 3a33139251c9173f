#include "scene/gltf.h"
#include "tests/unit/glb_maker.h"
#include "tests/unit/gltf_expect.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// --- nodes

static void transforms_of_parents_come_first(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad(
        GLB_QUAD_MESH
        ",'scenes':[{'nodes':[0]}],'nodes':[{'name':'a','translation':[10,0,0],"
        "'rotation':[0,0,0.7071067811865476,0.7071067811865476],'children':[1]},{'name':'b',"
        "'translation':[1,2,3],'scale':[2,2,-2],'mesh':0}]");
    // turned by 90 degrees about z: x to y, y to -x; then moved
    static const float expected[16] = {0, 2, 0, 0, -2, 0, 0, 0, 0, 0, -2, 0, 8, 1, 3, 1};
    gltf_floats_equal(s->instance[0].transform, expected, 16, 1e-6f);
    assert_string_equal(s->object[0].name, "b");
    glint_scene_destroy(&s);
}

static void matrices_are_column_major(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad(
        GLB_QUAD_MESH ",'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0,'matrix':[1,0,0,0, 0,1,0,0, "
                      "0,0,1,0, 4,5,6,1]}]");
    static const float expected[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4, 5, 6, 1};
    gltf_floats_equal(s->instance[0].transform, expected, 16, 0);
    glint_scene_destroy(&s);
}

static void a_node_scaled_to_nothing_is_left_out(void **state)
{
    (void)state;
    struct glint_scene *s =
        gltf_quad(GLB_QUAD_MESH
                  ",'scenes':[{'nodes':[0,1]}],'nodes':[{'name':'gone','mesh':0,'scale':[0,1,1]}"
                  ",{'name':'here','mesh':0,'scale':[1e-6,1e-6,1e-6]}]");
    assert_int_equal(s->objects, 1);
    assert_string_equal(s->object[0].name, "here");
    gltf_expect_warning(s, "node \"gone\" is left out");
    glint_scene_destroy(&s);
}

static void objects_are_named_by_node_or_path(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad(
        GLB_QUAD_MESH
        ",'scenes':[{'nodes':[0,3,5,6]}],'nodes':[{'name':'left','children':[1,2]},"
        "{'name':'leg','mesh':0},{'name':'top:seat','mesh':0},{'name':'right','children':[4]},"
        "{'name':'leg','mesh':0},{'mesh':0},{'mesh':0,'name':'solo'}]");
    static const char *const names[] = {"left/leg", "top:seat", "right/leg", "square", "solo"};
    static const char *const ids[] = {"left_leg", "top_seat", "right_leg", "square", "solo"};
    assert_int_equal(s->objects, 5);
    for (int i = 0; i < 5; i++) {
        assert_string_equal(s->object[i].name, names[i]);
        assert_string_equal(s->object[i].id, ids[i]);
        assert_string_equal(s->object[i].asset, i == 1 ? "top" : "");
        assert_int_equal(s->instance[i].object, i);
        assert_int_equal(s->instance[i].mesh, 0); // one mesh, many instances
    }
    glint_scene_destroy(&s);
}

static void ids_are_unique_where_names_are_not(void **state)
{
    (void)state;
    struct glint_scene *s =
        gltf_quad("'materials':[{'name':'a b'},{'name':'a/b'},{'name':'a_b_2'},{}]," GLB_QUAD_MESH
                  "," ONE_NODE);
    static const char *const ids[] = {"a_b", "a_b_2", "a_b_2_2", "material_3", "default"};
    static const char *const names[] = {"a b", "a/b", "a_b_2", "material_3", "default"};
    assert_int_equal(s->materials, 5);
    for (int i = 0; i < 5; i++) {
        assert_string_equal(s->material[i].id, ids[i]);
        assert_string_equal(s->material[i].name, names[i]);
    }
    assert_int_equal(s->instance[0].material, 4);
    glint_scene_destroy(&s);
}

static void the_asset_of_extras_holds_for_all_below(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad(
        GLB_QUAD_MESH
        ",'scenes':[{'nodes':[0]}],'nodes':[{'extras':{'asset':'chair'},'children':[1,2]},"
        "{'name':'x:y','mesh':0},{'name':'z','mesh':0,'extras':{'asset':'cushion'}}]");
    assert_string_equal(s->object[0].asset, "chair");
    assert_string_equal(s->object[1].asset, "cushion");
    glint_scene_destroy(&s);
}

static void each_primitive_is_an_instance_of_one_object(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad(
        "'materials':[{'name':'red'},{'name':'blue'}],'meshes':[{'name':'two','primitives':["
        "{'material':0," GLB_QUAD_PRIMITIVE "},{'material':1," GLB_QUAD_PRIMITIVE "},"
        "{'material':1,'attributes':{'POSITION':0}}]}]," ONE_NODE);
    assert_int_equal(s->objects, 1);
    assert_int_equal(s->instances, 3);
    assert_int_equal(s->meshes, 2); // equal accessors are one mesh
    static const char *const ids[] = {"n.0", "n.1", "n.2"};
    for (int i = 0; i < 3; i++) {
        assert_string_equal(s->instance[i].id, ids[i]);
        assert_int_equal(s->instance[i].object, 0);
        assert_int_equal(s->instance[i].material, i > 0);
        assert_int_equal(s->instance[i].mesh, i > 1);
    }
    glint_scene_destroy(&s);
}

static void what_is_no_tree_is_refused(void **state)
{
    (void)state;
    gltf_refuse_quad("'scenes':[{'nodes':[0]}],'nodes':[{'children':[1]},{'children':[0]}]",
                     "/nodes/0", "inside of itself");
    gltf_refuse_quad("'scenes':[{'nodes':[0,1]}],'nodes':[{'children':[1]},{}]", "/nodes/1",
                     "two places");
    gltf_refuse_quad("'scenes':[{'nodes':[0,0]}],'nodes':[{},{}]", "/nodes/0", "two places");
    gltf_refuse_quad("'scenes':[{'nodes':[0,0,0]}],'nodes':[{},{}]", "/scenes/0/nodes", "tree");
    gltf_refuse_quad("'scenes':[{'nodes':[5]}],'nodes':[{}]", "/scenes/0/nodes/0", "1 nodes");
    gltf_refuse_quad("'scenes':[{'nodes':[0]}],'nodes':[{'rotation':[0,0,0,0]}]",
                     "/nodes/0/rotation", "no rotation");
    gltf_refuse_quad(
        "'scenes':[{'nodes':[0]}],'nodes':[{'matrix':[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]}]",
        "/nodes/0/matrix", "last row");
}

static void a_chain_of_nodes_may_be_512_deep(void **state)
{
    (void)state;
    for (int deep = 513; deep <= 514; deep++) { // the root has depth 0
        char *rest = malloc(64 * 600);
        int n = sprintf(rest, "'scenes':[{'nodes':[0]}],'nodes':[");
        for (int i = 1; i < deep; i++)
            n += sprintf(rest + n, "{'children':[%d]},", i);
        sprintf(rest + n, "{}]");
        if (deep == 513) {
            struct glint_scene *s = gltf_quad(rest);
            glint_scene_destroy(&s);
        } else {
            gltf_refuse_quad(rest, "/nodes/513", "512 deep");
        }
        free(rest);
    }
}

static void without_a_scene_every_root_is_shown(void **state)
{
    (void)state;
    struct glint_scene *s =
        gltf_quad(GLB_QUAD_MESH ",'nodes':[{'mesh':0},{'children':[0]},{'mesh':0}]");
    assert_int_equal(s->instances, 2);
    glint_scene_destroy(&s);
}

// --- lights and cameras

static void lights_keep_their_units_and_place(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad(
        "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point','intensity':100,'color':"
        "[1,0.5,0.25]},{'type':'spot','name':'beam','intensity':50,'spot':{'innerConeAngle':0.25,"
        "'outerConeAngle':0.5}},{'type':'directional','intensity':3}]}},'scenes':[{'nodes':[0,1,2]}"
        "],"
        "'nodes':[{'name':'bulb','translation':[1,2,3],'scale':[5,5,5],'extensions':{"
        "'KHR_lights_punctual':{'light':0}}},{'extensions':{'KHR_lights_punctual':{'light':1}}},"
        "{'name':'sun','rotation':[-0.7071067811865476,0,0,0.7071067811865476],'extensions':{"
        "'KHR_lights_punctual':{'light':2}}}]");
    assert_int_equal(s->lights, 3);
    const struct glint_light *l = s->light;
    assert_string_equal(l[0].name, "bulb");
    assert_string_equal(l[1].name, "beam");
    assert_true(l[0].kind == GLINT_LIGHT_POINT && l[0].intensity == 100);
    gltf_floats_equal(l[0].color, (const float[]){1, 0.5f, 0.25f}, 3, 0);
    static const float moved[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1};
    gltf_floats_equal(l[0].transform, moved, 16, 1e-6f); // without the scale
    assert_true(l[1].kind == GLINT_LIGHT_SPOT && l[1].inner_cone == 0.25f &&
                l[1].outer_cone == 0.5f);
    assert_true(l[2].kind == GLINT_LIGHT_SUN && l[2].intensity == 3);
    gltf_floats_equal(l[2].transform + 8, (const float[]){0, 1, 0}, 3,
                      1e-6f); // shines along -z: down
    glint_scene_destroy(&s);
}

static void bad_lights_are_refused_with_their_place(void **state)
{
    (void)state;
#define LIGHT(JSON)                                                                        \
    "'extensions':{'KHR_lights_punctual':{'lights':[" JSON "]}},'scenes':[{'nodes':[0]}]," \
    "'nodes':[{'extensions':{'KHR_lights_punctual':{'light':0}}}]"
#define AT "/extensions/KHR_lights_punctual/lights/0"
    gltf_refuse_quad(LIGHT("{'type':'laser'}"), AT "/type", "laser");
    gltf_refuse_quad(LIGHT("{'type':'spot'}"), AT "/spot", "required");
    gltf_refuse_quad(LIGHT("{'type':'spot','spot':{'innerConeAngle':0.5,'outerConeAngle':0.5}}"),
                     AT "/spot", "inside");
    gltf_refuse_quad(LIGHT("{'type':'point','intensity':-1}"), AT "/intensity", "-1");
    gltf_refuse_quad(LIGHT(""), "/nodes/0/extensions/KHR_lights_punctual/light", "0 lights");
}

static void cameras_keep_yfov_and_lose_scale(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad(
        "'cameras':[{'name':'lens','type':'perspective','perspective':{'yfov':0.7,'aspectRatio':2,"
        "'znear':0.1}},{'type':'orthographic','orthographic':{'xmag':1,'ymag':2.5,'znear':0,'zfar':"
        "1}"
        "}],"
        "'scenes':[{'nodes':[0,1,2]}],'nodes':[{'camera':0,'translation':[0,0,5],'scale':[2,2,2]},"
        "{'name':'flat','camera':1},{'name':'cam','camera':0,'scale':[-1,1,1]}]");
    assert_int_equal(s->cameras, 3);
    assert_string_equal(s->camera[0].name, "lens");
    assert_string_equal(s->camera[1].name, "flat");
    assert_string_equal(s->camera[2].name, "cam");
    assert_true(s->camera[1].projection == GLINT_ORTHOGRAPHIC && s->camera[1].ymag == 2.5f);
    assert_true(s->camera[0].yfov == 0.7f && s->camera[0].focus_distance > 0);
    static const float back[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1};
    gltf_floats_equal(s->camera[0].transform, back, 16, 1e-6f);
    gltf_floats_equal(s->camera[2].transform, (const float[]){1, 0, 0}, 3, 1e-6f); // not mirrored
    glint_scene_destroy(&s);
    gltf_refuse_quad(
        "'cameras':[{'type':'perspective','perspective':{'yfov':0}}],'scenes':[{'nodes':[0]}],"
        "'nodes':[{'camera':0}]",
        "/cameras/0/perspective/yfov", "0");
    gltf_refuse_quad(
        "'cameras':[{'type':'perspective'}],'scenes':[{'nodes':[0]}],'nodes':[{'camera':0}]",
        "/cameras/0/perspective", "required");
    gltf_refuse_quad("'cameras':[{'type':'orthographic','orthographic':{'ymag':0}}],'scenes':[{"
                     "'nodes':[0]}],'nodes':[{'camera':0}]",
                     "/cameras/0/orthographic/ymag", "nothing");
}

// --- who lights the scene

#define LAMP(STRENGTH, MORE)                                                                   \
    "'materials':[{'emissiveFactor':[1,1,1],'extensions':{'KHR_materials_emissive_strength':{" \
    "'emissiveStrength':" STRENGTH                                                             \
    "}}}],'meshes':[{'primitives':[{'material':0," GLB_QUAD_PRIMITIVE                          \
    "}]}],'cameras':[{'type':'perspective','perspective':{'yfov':1}}],"                        \
    "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point'}]}},'scenes':[{'nodes':["  \
    "0,1]}],'nodes':[{'mesh':0},{" MORE "}]"

// A label does not light what it is on; an interior whose lamp glows wants no sky.
static void surfaces_light_a_file_that_has_a_camera_and_radiance_above_1(void **state)
{
    (void)state;
    static const struct {
        const char *rest, *word;
        bool environment;
    } lit[] = {
        {LAMP("20", "'camera':0"), NULL, false},
        {LAMP("1", "'camera':0"), "has no lights", true},
        {LAMP("20", ""), "neither lights nor cameras", true},
        {LAMP("1", "'extensions':{'KHR_lights_punctual':{'light':0}}"), NULL, false},
        {LAMP("0", "'camera':0"), "nothing in the scene emits", true},
    };
    for (size_t i = 0; i < sizeof lit / sizeof *lit; i++) {
        struct glint_scene *s = gltf_quad(lit[i].rest);
        assert_int_equal(glint_scene_complete_file(s, NULL), GLINT_OK);
        assert_true(s->has_environment == lit[i].environment);
        if (lit[i].word)
            gltf_expect_warning(s, lit[i].word);
        else
            assert_false(gltf_warns(s, "environment"));
        glint_scene_destroy(&s);
    }
}

// --- what is ignored

static void what_is_ignored_is_named(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad(
        "'textures':[{}],'materials':[{'name':'paint','emissiveTexture':{'index':0},"
        "'extensions':{'KHR_materials_sheen':{}}}],"
        "'meshes':[{'name':'body','primitives':[{'attributes':{'POSITION':0,'COLOR_1':1},"
        "'extensions':{'KHR_materials_variants':{}}}]}],"
        "'animations':[{'name':'walk','channels':[],'samplers':[]}],'extensions':{'KHR_audio':{}},"
        "'scenes':[{'nodes':[0]},{}],"
        "'nodes':[{'name':'man','mesh':0,'extensions':{'MSFT_lod':{}}}]");
    static const char *const expected[] = {
        "texture 0 has no image",
        "KHR_materials_sheen on material \"paint\" is ignored",
        "vertex colours 1 of mesh \"body\"",
        "KHR_materials_variants on mesh \"body\" is ignored",
        "animation \"walk\" moves nothing",
        "KHR_audio",
        "2 scenes",
        "MSFT_lod on node \"man\" is ignored",
    };
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++)
        gltf_expect_warning(s, expected[i]);
    assert_int_equal(s->warnings, sizeof expected / sizeof *expected);
    glint_scene_destroy(&s);
}

static void warnings_of_a_kind_are_capped_and_counted(void **state)
{
    (void)state;
    char rest[4096];
    int n = sprintf(rest, "'materials':[");
    for (int i = 0; i < 20; i++)
        n += sprintf(rest + n, "%s{'name':'m%d','extensions':{'KHR_materials_sheen':{}}}",
                     i ? "," : "", i);
    sprintf(rest + n, "]");
    struct glint_scene *s = gltf_quad(rest);
    assert_int_equal(s->warnings, 9);
    gltf_expect_warning(s, "material \"m7\"");
    assert_false(gltf_warns(s, "material \"m8\""));
    gltf_expect_warning(s, "KHR_materials_sheen on a material: 12 more");
    glint_scene_destroy(&s);
}

static void required_extensions_that_are_not_read_are_refused_by_name(void **state)
{
    (void)state;
    static const char *const names[] = {"KHR_draco_mesh_compression", "EXT_meshopt_compression",
                                        "EXT_texture_webp", "KHR_texture_basisu",
                                        "KHR_materials_pbrSpecularGlossiness"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char rest[128];
        snprintf(rest, sizeof rest, "'extensionsRequired':['KHR_lights_punctual','%s']", names[i]);
        gltf_refuse_quad(rest, "/extensionsRequired/1", names[i]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(transforms_of_parents_come_first),
        cmocka_unit_test(matrices_are_column_major),
        cmocka_unit_test(a_node_scaled_to_nothing_is_left_out),
        cmocka_unit_test(objects_are_named_by_node_or_path),
        cmocka_unit_test(ids_are_unique_where_names_are_not),
        cmocka_unit_test(the_asset_of_extras_holds_for_all_below),
        cmocka_unit_test(each_primitive_is_an_instance_of_one_object),
        cmocka_unit_test(what_is_no_tree_is_refused),
        cmocka_unit_test(a_chain_of_nodes_may_be_512_deep),
        cmocka_unit_test(without_a_scene_every_root_is_shown),
        cmocka_unit_test(lights_keep_their_units_and_place),
        cmocka_unit_test(bad_lights_are_refused_with_their_place),
        cmocka_unit_test(cameras_keep_yfov_and_lose_scale),
        cmocka_unit_test(surfaces_light_a_file_that_has_a_camera_and_radiance_above_1),
        cmocka_unit_test(what_is_ignored_is_named),
        cmocka_unit_test(warnings_of_a_kind_are_capped_and_counted),
        cmocka_unit_test(required_extensions_that_are_not_read_are_refused_by_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
