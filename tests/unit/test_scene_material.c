// Materials, their textures, cameras, lights and media: every member, its default, its bounds.
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

static const char pixel[4] = {1, 2, 3, 4};

// The text with the hash of a pixel for each %s.
static char *with_pixel(const char *format)
{
    const struct glint_asset asset = name_asset(pixel, sizeof pixel);
    char *text = NULL;
    assert_true(asprintf(&text, format, asset.sha256) > 0);
    return text;
}

#define IMAGE "'images':{'i':{'asset':'%s','width':1,'height':1,'format':'rgba8'}}"

static void a_material_of_which_nothing_is_said_is_white_paper(void **state)
{
    (void)state;
    struct glint_scene *s = parse("{'materials':{'m':{}}}");
    struct glint_material want;
    glint_material_init(&want);
    want.id = want.name = s->material[0].id;
    assert_true(want.specular == 1 && want.collimation == 1 && want.attenuation_distance == 0);
    assert_true(want.clearcoat == 0 && want.priority == 0 && want.alpha_mode == GLINT_ALPHA_OPAQUE);
    for (size_t k = 0; k < GLINT_TEXTURE_SLOTS; k++)
        assert_int_equal(glint_texture_of(&s->material[0], k)->image, GLINT_NONE);
    assert_true(s->material[0].specular_color[2] == 1 && s->material[0].attenuation_color[1] == 1);
    assert_true(s->material[0].clearcoat_normal_scale == 1 && s->material[0].opacity == 1);
    glint_scene_destroy(&s);
}

static void every_member_of_a_material_arrives_in_its_place(void **state)
{
    (void)state;
    struct glint_scene *s = parse(
        "{'materials':{'m':{'alpha_mode':'blend','opacity':0.25,'specular':0.5,'specular_color':[2,"
        "0.5,0],'clearcoat':0.75,'clearcoat_roughness':0.125,'clearcoat_normal_scale':-2,"
        "'attenuation_color':[0.5,0.25,1],'attenuation_distance':3,'collimation':0.0625,"
        "'priority':255}}}");
    const struct glint_material *m = &s->material[0];
    assert_true(m->alpha_mode == GLINT_ALPHA_BLEND && m->opacity == 0.25f && m->specular == 0.5f);
    assert_true(m->specular_color[0] == 2 && m->specular_color[2] == 0 && m->clearcoat == 0.75f);
    assert_true(m->clearcoat_roughness == 0.125f && m->clearcoat_normal_scale == -2);
    assert_true(m->attenuation_color[1] == 0.25f && m->attenuation_distance == 3);
    assert_true(m->collimation == 0.0625f && m->priority == 255);
    glint_scene_destroy(&s);
}

static void every_material_member_out_of_its_bounds_is_named(void **state)
{
    (void)state;
    refuse("{'materials':{'m':{'alpha_mode':'add','specular':1.5,'specular_color':[1,-1,2e6],"
           "'clearcoat':-0.1,'clearcoat_roughness':2,'clearcoat_normal_scale':1e7,"
           "'attenuation_color':[1,1,1.5],'attenuation_distance':-1,'collimation':1.01,"
           "'priority':256,'specular_texture':{}}}}",
           "/materials/m/alpha_mode=opaque, mask, blend|/materials/m/specular|"
           "/materials/m/specular_color/1|/materials/m/specular_color/2|/materials/m/clearcoat|"
           "/materials/m/clearcoat_roughness|/materials/m/clearcoat_normal_scale|"
           "/materials/m/attenuation_color/2|/materials/m/attenuation_distance|"
           "/materials/m/collimation|/materials/m/priority|/materials/m/specular_texture/image");
    refuse(
        "{'materials':{'m':{'priority':1.5,'attenuation_distance':'far','clearcoat':null}}}",
        "/materials/m/priority=integer|/materials/m/attenuation_distance|/materials/m/clearcoat");
}

static void every_texture_of_a_material_has_a_member_of_its_own(void **state)
{
    (void)state;
    const struct glint_asset asset = name_asset(pixel, sizeof pixel);
    for (size_t k = 0; k < GLINT_TEXTURE_SLOTS; k++) {
        char *text = NULL;
        assert_true(asprintf(&text, "{" IMAGE ",'materials':{'m':{'%s':{'image':'i'}}}}",
                             asset.sha256, glint_texture_slots[k].name) > 0);
        struct glint_scene *s = parse_with(text, &asset, 1);
        for (size_t other = 0; other < GLINT_TEXTURE_SLOTS; other++)
            assert_int_equal(glint_texture_of(&s->material[0], other)->image,
                             other == k ? 0 : GLINT_NONE);
        glint_scene_destroy(&s);
        free(text);
    }
    struct glint_material m;
    assert_ptr_equal(glint_texture_of(&m, 2), &m.normal_texture);
    assert_ptr_equal(glint_texture_of(&m, 9), &m.clearcoat_normal_texture);
}

static void a_texture_says_how_it_is_looked_up(void **state)
{
    (void)state;
    const struct glint_asset asset = name_asset(pixel, sizeof pixel);
    char *text = with_pixel("{" IMAGE ",'materials':{'m':{'base_color_texture':{'image':'i',"
                            "'filter':'nearest','uv_set':1,'offset':[0.5,-2],'scale':[3,0],"
                            "'rotation':1.5,'wrap_u':'clamp'},'normal_map':{'image':'i'}}}}");
    struct glint_scene *s = parse_with(text, &asset, 1);
    const struct glint_texture *t = &s->material[0].base_color_texture;
    assert_true(t->filter == GLINT_FILTERING_NEAREST && t->uv_set == 1 && t->offset[1] == -2);
    assert_true(t->scale[0] == 3 && t->scale[1] == 0 && t->rotation == 1.5f);
    assert_true(t->wrap_u == GLINT_WRAP_CLAMP && t->wrap_v == GLINT_WRAP_REPEAT);
    t = &s->material[0].normal_texture;
    assert_true(t->filter == GLINT_FILTERING_LINEAR && t->uv_set == 0 && t->offset[0] == 0);
    assert_true(t->scale[0] == 1 && t->scale[1] == 1 && t->rotation == 0);
    glint_scene_destroy(&s);
    free(text);
    text =
        with_pixel("{" IMAGE ",'materials':{'m':{'base_color_texture':{'image':'i','filter':"
                   "'cubic','uv_set':2,'offset':[0],'scale':[1,1e7],'rotation':1e7,'tile':1}}}}");
    refuse_with(text, &asset, 1,
                "/materials/m/base_color_texture/filter=linear, nearest|"
                "/materials/m/base_color_texture/uv_set|/materials/m/base_color_texture/offset|"
                "/materials/m/base_color_texture/scale/1|"
                "/materials/m/base_color_texture/rotation|/materials/m/base_color_texture/tile");
    free(text);
}

static void a_camera_needs_what_its_projection_needs(void **state)
{
    (void)state;
    struct glint_scene *s = parse("{'cameras':{'o':{'projection':'orthographic','ymag':3},"
                                  "'p':{'yfov':1}},'nodes':{'n':{}}}");
    assert_true(s->camera[0].projection == GLINT_ORTHOGRAPHIC && s->camera[0].ymag == 3);
    assert_true(s->camera[1].projection == GLINT_PERSPECTIVE && s->camera[1].ymag == 1);
    assert_int_equal(s->camera[0].node, GLINT_NONE);
    glint_scene_destroy(&s);
    refuse("{'cameras':{'a':{'projection':'orthographic'},'b':{'ymag':1},'c':{'projection':"
           "'orthographic','ymag':0},'d':{'projection':'fish','yfov':1,'node':'n'}}}",
           "/cameras/a/ymag=required|/cameras/b/yfov=required|/cameras/c/ymag|"
           "/cameras/d/projection|/cameras/d/node=no node");
}

static void lights_and_cameras_stand_on_nodes(void **state)
{
    (void)state;
    struct glint_scene *s =
        parse("{'nodes':{'a':{},'b':{'parent':'a'}},'lights':{'l':{'type':'point','node':'b'}},"
              "'cameras':{'c':{'yfov':1,'node':'a'}}}");
    assert_true(s->light[0].node == 1 && s->camera[0].node == 0);
    glint_scene_destroy(&s);
    refuse("{'lights':{'l':{'type':'point','node':7}}}", "/lights/l/node=string");
}

static void a_scene_has_one_medium_at_most(void **state)
{
    (void)state;
    struct glint_scene *s = parse("{'media':{'fog':{'density':0.5}}}");
    assert_true(s->media == 1 && s->medium[0].density == 0.5f && s->medium[0].g == 0);
    assert_true(s->medium[0].albedo[0] == 1 && !s->medium[0].bounded);
    glint_scene_destroy(&s);
    s = parse("{'media':{'fog':{'density':2,'albedo':[0.1,0.2,0.3],'g':-0.5,"
              "'box':[-1,-2,-3,1,2,3]}}}");
    assert_true(s->medium[0].bounded && s->medium[0].box[1] == -2 && s->medium[0].box[5] == 3);
    assert_true(s->medium[0].albedo[2] == 0.3f && s->medium[0].g == -0.5f);
    glint_scene_destroy(&s);
    s = parse("{'media':{'fog':{'density':2}},'environment':{}}");
    assert_non_null(strstr(s->warning[s->warnings - 1], "\"fog\" has no box"));
    glint_scene_destroy(&s);
    s = parse("{'media':{'fog':{'density':2,'box':[0,0,0,1,1,1]}},'environment':{}}");
    for (uint32_t k = 0; k < s->warnings; k++)
        assert_null(strstr(s->warning[k], "box"));
    glint_scene_destroy(&s);
    refuse("{'media':{'a':{'density':1},'b':{'density':1}}}", "/media/b=one medium");
    refuse("{'media':{'a':{'density':-1,'albedo':[0,0,2],'g':1.5,'box':[0,0,0,1,1]}}}",
           "/media/a/density|/media/a/albedo/2|/media/a/g|/media/a/box");
    refuse("{'media':{'a':{'box':[0,5,0,1,5,1],'colour':1}}}",
           "/media/a/density=required|/media/a/box=not below|/media/a/colour");
    refuse("{'media':[]}", "/media");
}

static void a_scene_counts_24_frames_a_second_unless_it_says_so(void **state)
{
    (void)state;
    struct glint_scene *s = parse("{}");
    assert_true(s->fps == 24);
    glint_scene_destroy(&s);
    s = parse("{'fps':0.01}");
    assert_true(s->fps == 0.01f);
    glint_scene_destroy(&s);
    refuse("{'fps':0}", "/fps");
    refuse("{'fps':1000.5}", "/fps");
    refuse("{'fps':'24'}", "/fps");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_material_of_which_nothing_is_said_is_white_paper),
        cmocka_unit_test(every_member_of_a_material_arrives_in_its_place),
        cmocka_unit_test(every_material_member_out_of_its_bounds_is_named),
        cmocka_unit_test(every_texture_of_a_material_has_a_member_of_its_own),
        cmocka_unit_test(a_texture_says_how_it_is_looked_up),
        cmocka_unit_test(a_camera_needs_what_its_projection_needs),
        cmocka_unit_test(lights_and_cameras_stand_on_nodes),
        cmocka_unit_test(a_scene_has_one_medium_at_most),
        cmocka_unit_test(a_scene_counts_24_frames_a_second_unless_it_says_so),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
