#include "scene_text.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TRIANGLE "'meshes':{'t':{'positions':[0,0,0, 1,0,0, 0,1,0]}},'materials':{'m':{}}"

static void an_item_gets_what_is_said_and_defaults_for_the_rest(void **state)
{
    (void)state;
    struct glint_scene *s = parse("{'materials':{'red':{'base_color':[1,0,0.5],'roughness':0.25,'"
                                  "alpha_mode':'mask','thin':true},"
                                  "'b':{'name':'B'}},'meshes':{'t':{'positions':[0,0,0, 1,0,0, "
                                  "0,1,0, 0,0,1],'indices':[0,1,2, 0,2,3]}},"
                                  "'objects':{'o':{'name':'Obj','asset':'A'}},"
                                  "'instances':{'i':{'mesh':'t','material':'b','object':'o','"
                                  "visible':false},'j':{'mesh':'t','material':'red'},"
                                  "'o':{'mesh':'t','material':'red'}},"
                                  "'lights':{'l':{'type':'area','size':[2,3]}},'cameras':{'c':{'"
                                  "yfov':1,'lens_radius':0.1,'focus_distance':4}},"
                                  "'environment':{'radiance':[1,2,3],'rotation':0.5}}");
    assert_true(s->materials == 2 && s->objects == 2 && s->instances == 3 && s->warnings == 0);
    assert_string_equal(s->material[0].name, "red");
    assert_true(s->material[0].base_color[2] == 0.5f &&
                s->material[0].alpha_mode == GLINT_ALPHA_MASK);
    assert_true(s->material[0].thin && s->material[0].double_sided && s->material[0].ior == 1.5f);
    assert_int_equal(s->material[0].normal_texture.image, GLINT_NONE);
    assert_string_equal(s->material[1].name, "B");
    assert_true(s->material[1].roughness == 1 && s->material[1].metallic == 0);
    assert_int_equal(s->mesh[0].triangles, 2);
    assert_int_equal(s->mesh[0].index[5], 3);
    assert_true(!s->instance[0].visible && s->instance[1].visible);
    assert_int_equal(s->instance[0].object, 0);
    assert_string_equal(s->object[s->instance[1].object].name, "j");
    assert_string_equal(s->object[s->instance[1].object].asset, "");
    assert_int_equal(s->instance[2].object, 0); // an object of its id is there
    assert_true(s->light[0].kind == GLINT_LIGHT_AREA && s->light[0].size[1] == 3);
    assert_true(s->camera[0].focus_distance == 4 && s->camera[0].transform[10] == 1);
    assert_true(s->environment.radiance[2] == 3 && s->environment.image == GLINT_NONE);
    glint_scene_destroy(&s);
    assert_null(s);
    glint_scene_destroy(&s);
}

static void every_fault_is_named(void **state)
{
    (void)state;
    refuse("{'materials':{'m':{'metallic':2,'colour':1,'emission':[-1,0,0]}},'lamps':{},"
           "'instances':{'i':{'mesh':'t','material':'m'}}}",
           "/materials/m/metallic|/materials/m/colour|/materials/m/emission/0|/lamps|/instances/i/"
           "mesh");
    refuse("[]", "");
    refuse("{'materials':[],'meshes':{'':{'primitive':'quad'}}}", "/materials|/meshes/");
    refuse("{'materials':{'m':7}}", "/materials/m");
    refuse("{'materials':{'m':{'normal_map':{'image':'x'}},'n':{'normal_map':{}}}}",
           "/materials/m/normal_map/image|/materials/n/normal_map/image");
    refuse("{'lights':{'a':{},'b':{'type':'spot','inner_cone':1,'outer_cone':0.5},'c':{'type':'"
           "lamp'}}}",
           "/lights/a/type|/lights/b/inner_cone|/lights/c/type");
    refuse("{'cameras':{'a':{},'b':{'yfov':3.2},'c':{'yfov':0}}}",
           "/cameras/a/yfov|/cameras/b/yfov|/cameras/c/yfov");
    refuse("{'environment':{'image':'x','radiance':[1,1]}}",
           "/environment/image|/environment/radiance");
    refuse("{'images':{'i':{'data':'data:image/png;base64,AA'}}}", "/images/i/data");
    refuse("{" TRIANGLE ",'instances':{'i':{},'j':{'mesh':'t','material':3,'object':'nobody'}}}",
           "/instances/i/mesh|/instances/i/material|/instances/j/material|/instances/j/object");
}

static void what_no_triangle_can_be_made_of_is_refused(void **state)
{
    (void)state;
    refuse("{'meshes':{'a':{},'b':{'positions':[]},'c':{'positions':[0,0]},'d':{'positions':[0,0,0]"
           "}}}",
           "/meshes/a/positions|/meshes/b/positions|/meshes/c/positions|/meshes/d/positions");
    refuse("{'meshes':{'a':{'positions':[0,0,0, 1,0,0, 0,1,0],'indices':[0,1,3]},"
           "'b':{'positions':[0,0,0, 1,0,0, 0,1,0],'indices':[]},"
           "'c':{'positions':[0,0,0, 1,0,0, 0,1,0],'normals':[0,0,1]},"
           "'d':{'positions':[0,0,0, 1e999,0,0, 0,1e13,0],'uvs':['x',0, 0,0, 0,0]}}}",
           "/meshes/a/indices/2|/meshes/b/indices|/meshes/c/normals|/meshes/d/positions/3|"
           "/meshes/d/positions/7|/meshes/d/uvs/0");
    refuse("{'meshes':{'a':{'primitive':'cone'},'b':{'primitive':'sphere','segments':2},"
           "'c':{'primitive':'box','radius':1},'d':{'primitive':'quad','size':[1,0]}}}",
           "/meshes/a/primitive|/meshes/b/segments|/meshes/c/radius|/meshes/d/size/1");
    refuse("{'meshes':{'a':{'positions':[0,0,0, 1,0,0, 0,1,0],'tangents':[1,0,0,1, 1,0,0,0, "
           "1,0,0,1]}}}",
           "/meshes/a");
}

static void transforms_are_affine_and_have_an_inverse(void **state)
{
    (void)state;
    refuse("{" TRIANGLE ",'instances':{"
           "'a':{'mesh':'t','material':'m','transform':[1,0,0,0, 0,1,0,0, 0,0,0,0, 0,0,0,1]},"
           "'b':{'mesh':'t','material':'m','transform':[1,0,0,0, 0,1,0,0, 1,1,0,0, 0,0,0,1]},"
           "'c':{'mesh':'t','material':'m','transform':[1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1]},"
           "'d':{'mesh':'t','material':'m','transform':{'rotation':[0,0,0,0]}},"
           "'e':{'mesh':'t','material':'m','transform':{'scale':[1,0,1]}},"
           "'f':{'mesh':'t','material':'m','transform':[1,0,0]},"
           "'g':{'mesh':'t','material':'m','transform':{'rotate':[0,0,0,1]}},"
           "'h':{'mesh':'t','material':'m','transform':[0.1,0.2,0.3,0, 0.4,0.5,0.6,0, "
           "0.7,0.8,0.9,0, 0,0,0,1]}}}",
           "/instances/a/transform|/instances/b/transform|/instances/c/transform|"
           "/instances/d/transform/rotation|/instances/e/transform|/instances/f/transform|"
           "/instances/g/transform/rotate|/instances/h/transform");
    refuse("{" TRIANGLE
           ",'instances':{'a':{'mesh':'t','material':'m','transform':{'scale':[1e6,1,1],"
           "'translation':[9.999999e11,0,0]}}}}",
           "/instances/a");
}

static void parts_compose_as_translation_rotation_scale(void **state)
{
    (void)state;
    // Half a turn's root about z: x goes to y, y to -x; twice as long before, moved after.
    struct glint_scene *s =
        parse("{" TRIANGLE ",'instances':{'i':{'mesh':'t','material':'m','transform':"
              "{'translation':[5,6,7],'rotation':[0,0,3,3],'scale':[2,3,1e-5]}}}}");
    const float want[16] = {0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 1e-5f, 0, 5, 6, 7, 1};
    for (int k = 0; k < 16; k++)
        assert_true(fabsf(s->instance[0].transform[k] - want[k]) < 1e-6f);
    glint_scene_destroy(&s);
}

static void cameras_are_made_rigid_and_keep_their_view(void **state)
{
    (void)state;
    struct glint_scene *s =
        parse("{'cameras':{'c':{'yfov':1,'transform':[2,0,0,0, 0,3,1,0, 0,0,4,0, 7,8,9,1]},"
              "'d':{'yfov':1,'transform':[0,0,-1,0, 0,1,0,0, 1,0,0,0, 0,0,0,1]}}}");
    const float want[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1};
    for (int k = 0; k < 16; k++)
        assert_true(fabsf(s->camera[0].transform[k] - want[k]) < 1e-6f);
    assert_true(s->camera[1].transform[2] == -1 && s->camera[1].transform[8] == 1);
    glint_scene_destroy(&s);
}

// ---- normals

static void normals_are_made_unit_and_zero_ones_follow_the_face(void **state)
{
    (void)state;
    struct glint_scene *s =
        parse("{'meshes':{'t':{'positions':[0,0,0, 0,2,0, 0,0,2, 9,9,9],'indices':[0,1,2],"
              "'normals':[3,0,4, 0,0,0, 0,1,0, 0,0,0]}},'cameras':{'c':{'yfov':1}}}");
    const float want[12] = {0.6f, 0, 0.8f, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    for (int k = 0; k < 12; k++)
        assert_true(fabsf(s->mesh[0].normal[k] - want[k]) < 1e-6f);
    glint_scene_destroy(&s);
}

// ---- assets

struct triangle_asset {
    float position[9], normal[9], uv[6];
    uint32_t index[3];
};

static struct triangle_asset make_triangle(void)
{
    return (struct triangle_asset){
        {0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 1, 0, 0, 1, 0, 0, 1}, {0, 0, 1, 0, 0, 1}, {0, 1, 2}};
}

static void hashes_are_sha256(void **state)
{
    (void)state;
    const struct glint_asset abc = name_asset("abc", 3);
    assert_string_equal(abc.sha256,
                        "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

static char *mesh_text(const char *hash, const char *rest)
{
    char *text = NULL;
    assert_true(asprintf(&text, "{'meshes':{'t':{'asset':'%s',%s}}}", hash, rest) > 0);
    return text;
}

#define WHOLE "'vertices':3,'triangles':1,'attributes':['normal','uv']"

static void a_mesh_asset_is_borrowed_in_place(void **state)
{
    (void)state;
    const struct triangle_asset t = make_triangle();
    const struct glint_asset asset = name_asset(&t, sizeof t);
    char *text = mesh_text(asset.sha256, WHOLE);
    struct glint_scene *s = parse_with(text, &asset, 1);
    assert_ptr_equal(s->mesh[0].position, t.position);
    assert_ptr_equal(s->mesh[0].normal, t.normal);
    assert_ptr_equal(s->mesh[0].uv, t.uv);
    assert_null(s->mesh[0].tangent);
    assert_ptr_equal(s->mesh[0].index, t.index);
    assert_string_equal(s->mesh[0].asset, asset.sha256);
    glint_scene_destroy(&s);
    char shifted[sizeof t + 1];
    memcpy(shifted + 1, &t, sizeof t);
    struct glint_asset odd = asset;
    odd.bytes = (const uint8_t *)(((uintptr_t)shifted & 1) ? shifted : shifted + 1);
    memmove((void *)odd.bytes, &t, sizeof t);
    s = parse_with(text, &odd, 1);
    assert_int_equal((uintptr_t)s->mesh[0].index % 4, 0);
    assert_int_equal(s->mesh[0].index[2], 2);
    glint_scene_destroy(&s);
    free(text);
}

static void an_asset_must_be_there_and_have_the_size_that_the_counts_say(void **state)
{
    (void)state;
    const struct triangle_asset t = make_triangle();
    const struct glint_asset asset = name_asset(&t, sizeof t);
    static const char *const wrong[] = {
        "'vertices':3,'triangles':1",
        "'vertices':2,'triangles':1,'attributes':['normal','uv']",
        "'vertices':2147483647,'triangles':2147483647,'attributes':['normal','uv','tangent']",
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        char *text = mesh_text(asset.sha256, wrong[i]);
        refuse_with(text, &asset, 1, "/meshes/t/asset");
        refuse_with(text, NULL, 0, "/meshes/t/asset");
        free(text);
    }
    char *text = mesh_text(asset.sha256, "'vertices':3,'triangles':0,'attributes':['uv','uv']");
    refuse_with(text, &asset, 1, "/meshes/t/triangles|/meshes/t/attributes/1");
    free(text);
    refuse("{'meshes':{'t':{'asset':'abc'," WHOLE "}}}", "/meshes/t/asset");
    refuse("{'meshes':{'t':{'asset':7}}}", "/meshes/t/vertices|/meshes/t/triangles");
}

static void what_an_asset_holds_is_checked(void **state)
{
    (void)state;
    struct triangle_asset bad[5];
    for (int i = 0; i < 5; i++)
        bad[i] = make_triangle();
    bad[0].position[4] = NAN;
    bad[1].position[8] = -INFINITY;
    bad[2].index[2] = 3;
    bad[3].normal[0] = NAN;
    bad[4].uv[5] = INFINITY;
    for (int i = 0; i < 5; i++) {
        const struct glint_asset asset = name_asset(&bad[i], sizeof bad[i]);
        char *text = mesh_text(asset.sha256, WHOLE);
        refuse_with(text, &asset, 1, "/meshes/t/asset");
        free(text);
    }
}

static void half_images_are_finite_and_not_negative(void **state)
{
    (void)state;
    static const uint16_t good[4] = {0x3c00, 0x8000, 0x7bff, 1}, infinite[4] = {0, 0x7c00, 0, 0},
                          negative[4] = {0, 0, 0, 0x8001}, nan[4] = {0xffff, 0, 0, 0};
    const uint16_t *const all[] = {good, infinite, negative, nan};
    for (int i = 0; i < 4; i++) {
        const struct glint_asset asset = name_asset(all[i], 8);
        char *text = NULL;
        assert_true(asprintf(&text,
                             "{'images':{'i':{'asset':'%s','width':1,'height':1,'format':"
                             "'rgba16f'}},'environment':{'image':'i'}}",
                             asset.sha256) > 0);
        if (i > 0) {
            refuse_with(text, &asset, 1, "/images/i/asset");
        } else {
            struct glint_scene *s = parse_with(text, &asset, 1);
            assert_ptr_equal(s->image[s->environment.image].pixels, good);
            glint_scene_destroy(&s);
        }
        free(text);
    }
}

// ---- completion

static void an_empty_scene_gets_camera_and_light_and_three_warnings(void **state)
{
    (void)state;
    struct glint_scene *s = parse("{}");
    assert_int_equal(s->warnings, 3);
    assert_int_equal(s->cameras, 1);
    assert_true(s->has_environment && s->environment.radiance[1] == 1);
    assert_int_equal(glint_scene_complete(s, NULL), GLINT_OK);
    assert_int_equal(s->warnings, 3);
    glint_scene_destroy(&s);
}

static void the_added_camera_sees_the_whole_box(void **state)
{
    (void)state;
    struct glint_scene *s = parse(
        "{'meshes':{'b':{'primitive':'box','size':[4,1,2]}},'materials':{'m':{}},'instances':{"
        "'i':{'mesh':'b','material':'m','transform':{'translation':[10,20,30]}},"
        "'hidden':{'mesh':'b','material':'m','visible':false,'transform':{'translation':[1000,0,0]}"
        "}}}");
    const float *c = s->camera[0].transform;
    const double reach = tan(0.5 * s->camera[0].yfov);
    double nearest = 1;
    for (int i = 0; i < 8; i++) {
        const double p[3] = {10 + (i & 1 ? 2 : -2), 20 + (i & 2 ? 0.5 : -0.5),
                             30 + (i & 4 ? 1 : -1)};
        double view[3] = {0, 0, 0};
        for (int a = 0; a < 3; a++)
            for (int k = 0; k < 3; k++)
                view[a] += c[4 * a + k] * (p[k] - c[12 + k]);
        assert_true(view[2] < 0);
        const double x = fabs(view[0] / view[2]) / reach, y = fabs(view[1] / view[2]) / reach;
        assert_true(x <= 1 && y <= 1);
        nearest = fmin(nearest, 1 - fmax(x, y));
    }
    assert_true(nearest < 0.5); // and is not lost in it
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
            double dot = 0;
            for (int k = 0; k < 3; k++)
                dot += (double)c[4 * a + k] * c[4 * b + k];
            assert_true(fabs(dot - (a == b)) < 1e-6);
        }
    glint_scene_destroy(&s);
}

static void an_environment_is_added_only_where_nothing_emits(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        bool added;
    } cases[] = {
        {"{'meshes':{'q':{'primitive':'quad'}},'materials':{'m':{'emission':[0,0,1]}},"
         "'instances':{'i':{'mesh':'q','material':'m'}}}",
         false},
        {"{'meshes':{'q':{'primitive':'quad'}},'materials':{'m':{'emission':[0,0,1]}},"
         "'instances':{'i':{'mesh':'q','material':'m','visible':false}}}",
         true},
        {"{'lights':{'l':{'type':'sun'}}}", false},
        {"{'meshes':{'q':{'primitive':'quad'}},'materials':{'m':{'emission':[0,0,1]}}}", true},
    };
    for (size_t i = 0; i < 4; i++) {
        struct glint_scene *s = parse(cases[i].text);
        assert_int_equal(s->has_environment, cases[i].added);
        glint_scene_destroy(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_item_gets_what_is_said_and_defaults_for_the_rest),
        cmocka_unit_test(every_fault_is_named),
        cmocka_unit_test(what_no_triangle_can_be_made_of_is_refused),
        cmocka_unit_test(transforms_are_affine_and_have_an_inverse),
        cmocka_unit_test(parts_compose_as_translation_rotation_scale),
        cmocka_unit_test(cameras_are_made_rigid_and_keep_their_view),
        cmocka_unit_test(normals_are_made_unit_and_zero_ones_follow_the_face),
        cmocka_unit_test(hashes_are_sha256),
        cmocka_unit_test(a_mesh_asset_is_borrowed_in_place),
        cmocka_unit_test(an_asset_must_be_there_and_have_the_size_that_the_counts_say),
        cmocka_unit_test(what_an_asset_holds_is_checked),
        cmocka_unit_test(half_images_are_finite_and_not_negative),
        cmocka_unit_test(an_empty_scene_gets_camera_and_light_and_three_warnings),
        cmocka_unit_test(the_added_camera_sees_the_whole_box),
        cmocka_unit_test(an_environment_is_added_only_where_nothing_emits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
