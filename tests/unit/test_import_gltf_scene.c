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

// --- materials

static void factors_and_extensions_reach_the_material(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad(
        "'materials':[{'name':'all','doubleSided':true,'alphaMode':'MASK','alphaCutoff':0.25,"
        "'pbrMetallicRoughness':{'baseColorFactor':[0.1,0.2,0.3,0.4],'metallicFactor':0.6,"
        "'roughnessFactor':0.7},'emissiveFactor':[1,0.5,0.25],'extensions':{"
        "'KHR_materials_emissive_strength':{'emissiveStrength':8},'KHR_materials_ior':{'ior':1.33},"
        "'KHR_materials_transmission':{'transmissionFactor':0.9},'KHR_materials_volume':{"
        "'thicknessFactor':0.5}}},"
        "{'extensions':{'KHR_materials_transmission':{'transmissionFactor':1}}},{}]");
    const struct glint_material *m = &s->material[0];
    gltf_floats_equal(m->base_color, (const float[]){0.1f, 0.2f, 0.3f}, 3, 0);
    gltf_floats_equal(m->emission, (const float[]){8, 4, 2}, 3, 0);
    gltf_floats_equal((const float[]){m->opacity, m->alpha_cutoff, m->metallic, m->roughness,
                                      m->ior, m->transmission},
                      (const float[]){0.4f, 0.25f, 0.6f, 0.7f, 1.33f, 0.9f}, 6, 0);
    assert_true(m->alpha_mode == GLINT_ALPHA_MASK && m->double_sided && !m->thin);
    assert_true(s->material[1].thin); // no volume: a thin wall
    m = &s->material[2];              // the defaults of glTF, which are not those of native scenes
    assert_true(m->metallic == 1 && m->roughness == 1 && m->ior == 1.5f && !m->double_sided &&
                m->alpha_mode == GLINT_ALPHA_OPAQUE && !m->thin && m->opacity == 1);
    assert_int_equal(m->base_color_texture.image, GLINT_NONE);
    glint_scene_destroy(&s);
}

static void factors_out_of_range_are_all_named(void **state)
{
    (void)state;
    size_t size;
    uint8_t *glb =
        glb_quad("'materials':[{'pbrMetallicRoughness':{'metallicFactor':2,"
                 "'roughnessFactor':-1},'extensions':{'KHR_materials_ior':{'ior':0.5}}}]",
                 &size);
    struct glint_error err = {0};
    struct glint_scene *s;
    assert_int_equal(glint_gltf_import(&s, glb, size, &err), GLINT_E_RANGE);
    assert_int_equal(err.count, 3);
    assert_string_equal(err.fault[0].pointer, "/materials/0/pbrMetallicRoughness/metallicFactor");
    assert_string_equal(err.fault[1].pointer, "/materials/0/pbrMetallicRoughness/roughnessFactor");
    assert_string_equal(err.fault[2].pointer, "/materials/0/extensions/KHR_materials_ior/ior");
    glint_error_finish(&err);
    free(glb);
}

// A PNG of 1x1: red.
#define RED_PNG                                                                          \
    "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4" \
    "z8AAAAMBAQDJ/pLvAAAAAElFTkSuQmCC"

static void textures_bring_image_and_wrapping(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad(
        "'images':[{'name':'unused','uri':'data:,nothing'},{'name':'red','uri':'" RED_PNG "'}],"
        "'samplers':[{'wrapS':33071,'wrapT':33648}],'textures':[{'source':1,'sampler':0},{'source':"
        "1}],"
        "'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0}},'normalTexture':"
        "{'index':1,'scale':0.5},'occlusionTexture':{'index':0}}]");
    assert_int_equal(s->images, 1); // one image, used twice; what nobody uses is not decoded
    assert_string_equal(s->image[0].id, "red");
    assert_memory_equal(s->image[0].pixels, "\xff\0\0\xff", 4);
    const struct glint_material *m = &s->material[0];
    assert_int_equal(m->base_color_texture.image, 0);
    assert_int_equal(m->base_color_texture.wrap_u, GLINT_WRAP_CLAMP);
    assert_int_equal(m->base_color_texture.wrap_v, GLINT_WRAP_MIRROR);
    assert_int_equal(m->normal_texture.image, 0);
    assert_int_equal(m->normal_texture.wrap_u, GLINT_WRAP_REPEAT);
    assert_true(m->normal_scale == 0.5f);
    assert_int_equal(s->warnings, 0);
    glint_scene_destroy(&s);
}

// Samplers by filter; both textures of sampler 0 are in use, no texture of the last one is.
static void nearest_filtering_is_warned_of_once_for_each_sampler(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad(
        "'images':[{'uri':'" RED_PNG "'}],'samplers':[{'magFilter':9728,'minFilter':9728},"
        "{'magFilter':9729,'minFilter':9984},{'minFilter':9986},"
        "{'magFilter':9729,'minFilter':9985},{'magFilter':9729,'minFilter':9987},{'magFilter':9728}"
        ",{'magFilter':9728}],"
        "'textures':[{'source':0,'sampler':0},{'source':0,'sampler':0},{'source':0,'sampler':1},"
        "{'source':0,'sampler':2},{'source':0,'sampler':3},{'source':0,'sampler':4},"
        "{'source':0,'sampler':5},{'source':0,'sampler':6}],'materials':[{'pbrMetallicRoughness':"
        "{'baseColorTexture':{'index':0}},'emissiveTexture':{'index':1}},{'emissiveTexture':"
        "{'index':2}},{'emissiveTexture':{'index':3}},{'emissiveTexture':{'index':4}},"
        "{'emissiveTexture':{'index':5}},{'emissiveTexture':{'index':6}}]");
    gltf_expect_warning(s, "sampler 0 asks for nearest filtering (magFilter) (minFilter); "
                           "textures are filtered bilinearly");
    gltf_expect_warning(s, "sampler 1 asks for nearest filtering (minFilter);");
    gltf_expect_warning(s, "sampler 2 asks for nearest filtering (minFilter);");
    gltf_expect_warning(s, "sampler 5 asks for nearest filtering (magFilter);");
    assert_int_equal(s->warnings, 4); // not 3 and 4, which are linear, nor 6, which is not in use
    glint_scene_destroy(&s);
}

static void a_damaged_image_is_refused_by_its_number(void **state)
{
    (void)state;
    gltf_refuse_quad("'images':[{'bufferView':0}],'textures':[{'source':0}],'materials':[{"
                     "'emissiveTexture':{'index':0}}]",
                     "/images/0", "not PNG, JPEG or Radiance");
    gltf_refuse_quad(
        "'images':[{}],'textures':[{'source':0}],'materials':[{'emissiveTexture':{'index':0}}]",
        "/images/0", "no data");
    gltf_refuse_quad("'images':[{'uri':'../secret.png'}],'textures':[{'source':0}],'materials':[{"
                     "'emissiveTexture':{'index':0}}]",
                     "/images/0/uri", "outside of the file");
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
        "'znear':0.1}},{'type':'orthographic','orthographic':{'xmag':1,'ymag':1,'znear':0,'zfar':1}"
        "}],"
        "'scenes':[{'nodes':[0,1,2]}],'nodes':[{'camera':0,'translation':[0,0,5],'scale':[2,2,2]},"
        "{'name':'flat','camera':1},{'name':'cam','camera':0,'scale':[-1,1,1]}]");
    assert_int_equal(s->cameras, 2);
    assert_string_equal(s->camera[0].name, "lens");
    assert_string_equal(s->camera[1].name, "cam");
    assert_true(s->camera[0].yfov == 0.7f && s->camera[0].focus_distance > 0);
    static const float back[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1};
    gltf_floats_equal(s->camera[0].transform, back, 16, 1e-6f);
    gltf_floats_equal(s->camera[1].transform, (const float[]){1, 0, 0}, 3, 1e-6f); // not mirrored
    gltf_expect_warning(s, "camera \"flat\" is orthographic");
    glint_scene_destroy(&s);
    gltf_refuse_quad(
        "'cameras':[{'type':'perspective','perspective':{'yfov':0}}],'scenes':[{'nodes':[0]}],"
        "'nodes':[{'camera':0}]",
        "/cameras/0/perspective/yfov", "0");
    gltf_refuse_quad(
        "'cameras':[{'type':'perspective'}],'scenes':[{'nodes':[0]}],'nodes':[{'camera':0}]",
        "/cameras/0/perspective/yfov", "required");
}

// --- what is ignored

static void what_is_ignored_is_named(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad(
        "'images':[{'uri':'" RED_PNG
        "'}],'textures':[{'source':0},{}],'materials':[{'name':'paint',"
        "'alphaMode':'BLEND','pbrMetallicRoughness':{'baseColorTexture':{'index':0,'texCoord':1,"
        "'extensions':{'KHR_texture_transform':{'scale':[2,2]}}}},'emissiveTexture':{'index':1},"
        "'extensions':{'KHR_materials_clearcoat':{},"
        "'KHR_materials_transmission':{'transmissionFactor':1,'transmissionTexture':{'index':0}},"
        "'KHR_materials_volume':{'attenuationDistance':1}}}],"
        "'meshes':[{'name':'body','primitives':[{'attributes':{'POSITION':0,'COLOR_0':1,'TEXCOORD_"
        "1':2"
        "},'targets':[{}],'extensions':{'KHR_materials_variants':{}}}]}],'skins':[{'name':'bones'}]"
        ","
        "'animations':[{'name':'walk'}],'extensions':{'KHR_audio':{}},'scenes':[{'nodes':[0]},{}],"
        "'nodes':[{'name':'man','mesh':0,'skin':0,'extensions':{'EXT_mesh_gpu_instancing':{}}}]");
    static const char *const expected[] = {
        "alphaMode BLEND of material \"paint\"",
        "KHR_texture_transform on texture of material \"paint\" is ignored",
        "material \"paint\" uses texture coordinates 1",
        "texture 1 has no image",
        "KHR_materials_clearcoat on material \"paint\" is ignored",
        "transmissionTexture of material \"paint\"",
        "attenuation of material \"paint\"",
        "vertex colours of mesh \"body\"",
        "texture coordinates 1 of mesh \"body\"",
        "morph targets of mesh \"body\"",
        "KHR_materials_variants on mesh \"body\" is ignored",
        "skin \"bones\" is ignored",
        "skin of node \"man\"",
        "animation \"walk\" is ignored",
        "KHR_audio",
        "2 scenes",
        "EXT_mesh_gpu_instancing on node \"man\" is ignored",
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
    gltf_refuse_quad("'extensionsRequired':['KHR_lights_punctual','KHR_draco_mesh_compression']",
                     "/extensionsRequired/1", "KHR_draco_mesh_compression");
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
        cmocka_unit_test(factors_and_extensions_reach_the_material),
        cmocka_unit_test(factors_out_of_range_are_all_named),
        cmocka_unit_test(textures_bring_image_and_wrapping),
        cmocka_unit_test(nearest_filtering_is_warned_of_once_for_each_sampler),
        cmocka_unit_test(a_damaged_image_is_refused_by_its_number),
        cmocka_unit_test(lights_keep_their_units_and_place),
        cmocka_unit_test(bad_lights_are_refused_with_their_place),
        cmocka_unit_test(cameras_keep_yfov_and_lose_scale),
        cmocka_unit_test(what_is_ignored_is_named),
        cmocka_unit_test(warnings_of_a_kind_are_capped_and_counted),
        cmocka_unit_test(required_extensions_that_are_not_read_are_refused_by_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
