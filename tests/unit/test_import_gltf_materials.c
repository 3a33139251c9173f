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
    assert_int_equal(glint_gltf_import(&s, glb, size, NULL, &err), GLINT_E_RANGE);
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
// Filters for what is smaller than its pixels choose among sizes that do not exist here.
static void nearest_magnification_is_kept_and_minification_is_nothing_to_speak_of(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad(
        "'images':[{'uri':'" RED_PNG "'}],'samplers':[{'magFilter':9728,'minFilter':9987},"
        "{'magFilter':9729,'minFilter':9984},{'minFilter':9728}],'textures':[{'source':0,"
        "'sampler':0},{'source':0,'sampler':1},{'source':0,'sampler':2}],'materials':[{"
        "'pbrMetallicRoughness':{'baseColorTexture':{'index':0},'metallicRoughnessTexture':"
        "{'index':1}},'emissiveTexture':{'index':2}}]");
    const struct glint_material *m = &s->material[0];
    assert_int_equal(m->base_color_texture.filter, GLINT_FILTERING_NEAREST);
    assert_int_equal(m->metallic_roughness_texture.filter, GLINT_FILTERING_LINEAR);
    assert_int_equal(m->emission_texture.filter, GLINT_FILTERING_LINEAR);
    assert_int_equal(s->warnings, 0);
    glint_scene_destroy(&s);
    gltf_refuse_quad("'images':[{'uri':'" RED_PNG "'}],'samplers':[{'magFilter':9987}],"
                     "'textures':[{'source':0,'sampler':0}],'materials':[{'emissiveTexture':"
                     "{'index':0}}]",
                     "/samplers/0/magFilter", "9987");
}

static void specular_and_clearcoat_bring_their_factors_and_textures(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad(
        "'extensionsRequired':['KHR_materials_specular','KHR_materials_clearcoat'],'images':["
        "{'uri':'" RED_PNG "'}],'textures':[{'source':0}],'materials':[{'extensions':{"
        "'KHR_materials_specular':{'specularFactor':0.25,'specularColorFactor':[0.5,1,2],"
        "'specularTexture':{'index':0,'texCoord':1},'specularColorTexture':{'index':0}},"
        "'KHR_materials_clearcoat':{'clearcoatFactor':0.75,'clearcoatRoughnessFactor':0.125,"
        "'clearcoatTexture':{'index':0},'clearcoatRoughnessTexture':{'index':0},"
        "'clearcoatNormalTexture':{'index':0,'scale':-0.5}}}},{}]");
    const struct glint_material *m = &s->material[0];
    gltf_floats_equal((const float[]){m->specular, m->clearcoat, m->clearcoat_roughness,
                                      m->clearcoat_normal_scale},
                      (const float[]){0.25f, 0.75f, 0.125f, -0.5f}, 4, 0);
    gltf_floats_equal(m->specular_color, (const float[]){0.5f, 1, 2}, 3, 0);
    assert_true(m->specular_texture.image == 0 && m->specular_texture.uv_set == 1 &&
                m->specular_color_texture.image == 0 && m->specular_color_texture.uv_set == 0 &&
                m->clearcoat_texture.image == 0 && m->clearcoat_roughness_texture.image == 0 &&
                m->clearcoat_normal_texture.image == 0);
    m = &s->material[1];
    assert_true(m->specular == 1 && m->specular_color[1] == 1 && m->clearcoat == 0 &&
                m->clearcoat_normal_texture.image == GLINT_NONE && !m->double_sided);
    assert_int_equal(s->warnings, 0);
    glint_scene_destroy(&s);
}

static void a_volume_absorbs_only_where_it_has_thickness(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad(
        "'images':[{'uri':'" RED_PNG "'}],'textures':[{'source':0}],'materials':["
        "{'name':'solid','extensions':{'KHR_materials_transmission':{'transmissionFactor':1,"
        "'transmissionTexture':{'index':0}},'KHR_materials_volume':{'thicknessFactor':1,"
        "'attenuationDistance':0.5,'attenuationColor':[0.25,0.5,1],'thicknessTexture':{'index':0}}"
        "}},{'extensions':{'KHR_materials_transmission':{'transmissionFactor':1},"
        "'KHR_materials_volume':{'attenuationDistance':0.5}}},"
        "{'extensions':{'KHR_materials_transmission':{'transmissionFactor':1},"
        "'KHR_materials_volume':{'thicknessFactor':1}}}]");
    const struct glint_material *m = s->material;
    assert_true(!m[0].thin && m[0].attenuation_distance == 0.5f);
    gltf_floats_equal(m[0].attenuation_color, (const float[]){0.25f, 0.5f, 1}, 3, 0);
    assert_int_equal(m[0].transmission_texture.image, 0);
    assert_true(m[1].thin && m[1].attenuation_distance == 0);
    assert_true(!m[2].thin && m[2].attenuation_distance == 0);
    gltf_expect_warning(s, "thicknessTexture of material \"solid\"");
    assert_int_equal(s->warnings, 1);
    glint_scene_destroy(&s);
    gltf_refuse_quad("'materials':[{'extensions':{'KHR_materials_volume':{'attenuationDistance':"
                     "0}}}]",
                     "/materials/0/extensions/KHR_materials_volume/attenuationDistance", "above 0");
}

// 0 stands for infinity, where all is reflected at normal incidence: the largest index reflects
// (9/11)^2 of that, which the specular colour makes up for.
static void an_index_of_refraction_of_0_reflects_the_specular_colour(void **state)
{
    (void)state;
    struct glint_scene *s =
        gltf_quad("'materials':[{'extensions':{'KHR_materials_ior':{'ior':0},"
                  "'KHR_materials_specular':{'specularColorFactor':[0.5,0.25,1]}}}]");
    const struct glint_material *m = &s->material[0];
    const float f0 = (m->ior - 1) * (m->ior - 1) / ((m->ior + 1) * (m->ior + 1));
    assert_true(m->ior == 10);
    for (int i = 0; i < 3; i++)
        assert_true(fabsf(f0 * m->specular_color[i] - (const float[]){0.5f, 0.25f, 1}[i]) < 1e-6f);
    glint_scene_destroy(&s);
}

static void an_unlit_material_emits_its_base_colour_and_reflects_nothing(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad(
        "'images':[{'uri':'" RED_PNG "'}],'textures':[{'source':0}],'materials':[{'name':'flat',"
        "'emissiveFactor':[1,1,1],'pbrMetallicRoughness':{'baseColorFactor':[0.5,0.25,1,0.5],"
        "'baseColorTexture':{'index':0}},'extensions':{'KHR_materials_unlit':{}}}]");
    const struct glint_material *m = &s->material[0];
    gltf_floats_equal(m->emission, (const float[]){0.5f, 0.25f, 1}, 3, 0);
    gltf_floats_equal(m->base_color, (const float[]){0, 0, 0}, 3, 0);
    assert_true(m->emission_texture.image == 0 && m->opacity == 0.5f && m->metallic == 0 &&
                m->specular == 0 && m->ior == 1);
    gltf_expect_warning(s, "KHR_materials_unlit of material \"flat\"");
    glint_scene_destroy(&s);
}

static void blend_is_a_mode_of_alpha(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad("'materials':[{'alphaMode':'BLEND','pbrMetallicRoughness':"
                                      "{'baseColorFactor':[1,1,1,0.25]}}]");
    assert_true(s->material[0].alpha_mode == GLINT_ALPHA_BLEND && s->material[0].opacity == 0.25f);
    assert_int_equal(s->warnings, 0);
    glint_scene_destroy(&s);
}

static void each_use_of_a_texture_has_its_own_coordinates(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad(
        "'extensionsRequired':['KHR_texture_transform'],'images':[{'uri':'" RED_PNG "'}],"
        "'textures':[{'source':0}],'materials':[{'name':'m','pbrMetallicRoughness':{"
        "'baseColorTexture':{'index':0,'texCoord':0,'extensions':{'KHR_texture_transform':{"
        "'offset':[0.5,-1],'rotation':0.25,'scale':[2,-3],'texCoord':1}}},"
        "'metallicRoughnessTexture':{'index':0,'texCoord':1}},'normalTexture':{'index':0},"
        "'emissiveTexture':{'index':0,'texCoord':2}}]");
    const struct glint_material *m = &s->material[0];
    const struct glint_texture *t = &m->base_color_texture;
    gltf_floats_equal(t->offset, (const float[]){0.5f, -1}, 2, 0);
    gltf_floats_equal(t->scale, (const float[]){2, -3}, 2, 0);
    assert_true(t->rotation == 0.25f && t->uv_set == 1);
    t = &m->metallic_roughness_texture;
    assert_true(t->uv_set == 1 && t->scale[0] == 1 && t->offset[0] == 0 && t->rotation == 0);
    assert_true(m->normal_texture.uv_set == 0 && m->emission_texture.uv_set == 0);
    gltf_expect_warning(s, "material \"m\" uses texture coordinates 2");
    assert_int_equal(s->warnings, 1);
    glint_scene_destroy(&s);
    gltf_refuse_quad("'images':[{'uri':'" RED_PNG "'}],'textures':[{'source':0}],'materials':[{"
                     "'emissiveTexture':{'index':0,'extensions':{'KHR_texture_transform':{'scale':"
                     "[1]}}}}]",
                     "/materials/0/emissiveTexture/extensions/KHR_texture_transform/scale", "2");
}

static void extensions_that_are_not_shown_are_named_with_their_material(void **state)
{
    (void)state;
    static const char *const names[] = {"KHR_materials_sheen",
                                        "KHR_materials_iridescence",
                                        "KHR_materials_anisotropy",
                                        "KHR_materials_dispersion",
                                        "KHR_materials_diffuse_transmission",
                                        "KHR_materials_pbrSpecularGlossiness"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char rest[256], words[256];
        snprintf(rest, sizeof rest, "'materials':[{'name':'m','extensions':{'%s':{}}}]", names[i]);
        snprintf(words, sizeof words, "%s on material \"m\" is ignored", names[i]);
        struct glint_scene *s = gltf_quad(rest);
        gltf_expect_warning(s, words);
        assert_int_equal(s->warnings, 1);
        glint_scene_destroy(&s);
    }
}

static void a_damaged_image_is_refused_by_its_number(void **state)
{
    (void)state;
    gltf_refuse_quad("'images':[{'bufferView':0}],'textures':[{'source':0}],'materials':[{"
                     "'emissiveTexture':{'index':0}}]",
                     "/images/0", "not PNG, JPEG, Radiance or OpenEXR");
    gltf_refuse_quad(
        "'images':[{}],'textures':[{'source':0}],'materials':[{'emissiveTexture':{'index':0}}]",
        "/images/0", "no data");
    gltf_refuse_quad("'images':[{'uri':'../secret.png'}],'textures':[{'source':0}],'materials':[{"
                     "'emissiveTexture':{'index':0}}]",
                     "/images/0/uri", "outside of the file");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(factors_and_extensions_reach_the_material),
        cmocka_unit_test(factors_out_of_range_are_all_named),
        cmocka_unit_test(textures_bring_image_and_wrapping),
        cmocka_unit_test(nearest_magnification_is_kept_and_minification_is_nothing_to_speak_of),
        cmocka_unit_test(a_damaged_image_is_refused_by_its_number),
        cmocka_unit_test(specular_and_clearcoat_bring_their_factors_and_textures),
        cmocka_unit_test(a_volume_absorbs_only_where_it_has_thickness),
        cmocka_unit_test(an_index_of_refraction_of_0_reflects_the_specular_colour),
        cmocka_unit_test(an_unlit_material_emits_its_base_colour_and_reflects_nothing),
        cmocka_unit_test(blend_is_a_mode_of_alpha),
        cmocka_unit_test(each_use_of_a_texture_has_its_own_coordinates),
        cmocka_unit_test(extensions_that_are_not_shown_are_named_with_their_material),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
