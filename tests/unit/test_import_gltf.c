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

// --- geometry

static void a_mesh_arrives_as_it_was_written(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad(GLB_QUAD_MESH "," ONE_NODE);
    assert_int_equal(s->meshes, 1);
    const struct glint_mesh *m = &s->mesh[0];
    assert_string_equal(m->id, "square");
    assert_int_equal(m->vertices, 4);
    assert_int_equal(m->triangles, 2);
    gltf_floats_equal(m->position, glb_quad_data.position, 12, 0);
    gltf_floats_equal(m->normal, glb_quad_data.normal, 12, 0);
    gltf_floats_equal(m->uv, glb_quad_data.uv, 8, 0);
    assert_null(m->tangent);
    for (int i = 0; i < 6; i++)
        assert_int_equal(m->index[i], glb_quad_data.index[i]);
    glint_scene_destroy(&s);
}

static void missing_normals_stay_missing(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_quad("'meshes':[{'primitives':[{'attributes':{'POSITION':0},"
                                      "'indices':3}]}]," ONE_NODE);
    assert_null(s->mesh[0].normal);
    assert_null(s->mesh[0].uv);
    glint_scene_destroy(&s);
}

static void strips_and_fans_become_triangles_of_one_orientation(void **state)
{
    (void)state;
    static const char *const json =
        "{'asset':{'version':'2.0'},'buffers':[{'byteLength':60}],'bufferViews':[{'buffer':0,"
        "'byteLength':60}],'accessors':[{'bufferView':0,'componentType':5126,'count':5,'type':"
        "'VEC3'}],'meshes':[{'primitives':[{'mode':%d,'attributes':{'POSITION':0}}]}]," ONE_NODE
        "}";
    static const float strip[15] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0};
    static const float fan[15] = {0, 0, 0, 2, 0, 0, 2, 1, 0, 1, 2, 0, 0, 2, 0};
    for (int mode = 5; mode <= 6; mode++) {
        char text[1024];
        snprintf(text, sizeof text, json, mode);
        struct glint_scene *s = gltf_data(text, mode == 5 ? strip : fan, 60);
        const struct glint_mesh *m = &s->mesh[0];
        assert_int_equal(m->triangles, 3);
        for (int t = 0; t < 3; t++) { // counter-clockwise seen from +z
            const float *a = m->position + 3 * m->index[3 * t];
            const float *b = m->position + 3 * m->index[3 * t + 1];
            const float *c = m->position + 3 * m->index[3 * t + 2];
            assert_true((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0);
        }
        glint_scene_destroy(&s);
    }
}

// Three vertices as normalised 16-bit positions, 8-bit texture coordinates and 8-bit indices.
static void normalised_integers_become_fractions(void **state)
{
    (void)state;
    static const struct {
        int16_t position[3][4];
        uint8_t uv[3][4], index[4];
    } bin = {{{-32767, 0, 0, 0}, {32767, 0, 0, 0}, {0, 16384, -32768, 0}},
             {{0, 51, 0, 0}, {255, 102, 0, 0}, {153, 204, 0, 0}},
             {2, 1, 0, 0}};
    struct glint_scene *s = gltf_data(
        "{'asset':{'version':'2.0'},'extensionsRequired':['KHR_mesh_quantization'],"
        "'extensionsUsed':['KHR_mesh_quantization'],'buffers':[{'byteLength':40}],'bufferViews':["
        "{'buffer':0,'byteLength':24,'byteStride':8},{'buffer':0,'byteOffset':24,'byteLength':12,"
        "'byteStride':4},{'buffer':0,'byteOffset':36,'byteLength':3}],'accessors':["
        "{'bufferView':0,'componentType':5122,'normalized':true,'count':3,'type':'VEC3'},"
        "{'bufferView':1,'componentType':5121,'normalized':true,'count':3,'type':'VEC2'},"
        "{'bufferView':2,'componentType':5121,'count':3,'type':'SCALAR'}],'meshes':[{'primitives':"
        "[{'attributes':{'POSITION':0,'TEXCOORD_0':1},'indices':2}]}]," ONE_NODE "}",
        &bin, sizeof bin);
    static const float position[9] = {-1, 0, 0, 1, 0, 0, 0, 16384 / 32767.0f, -1};
    static const float uv[6] = {0, 0.2f, 1, 0.4f, 0.6f, 0.8f};
    gltf_floats_equal(s->mesh[0].position, position, 9, 0);
    gltf_floats_equal(s->mesh[0].uv, uv, 6, 1e-6f);
    assert_int_equal(s->mesh[0].index[0], 2);
    assert_int_equal(s->mesh[0].index[2], 0);
    glint_scene_destroy(&s);
}

// Bytes as sparse indices: the width that Assimp takes for 16 bits.
static void sparse_values_replace_the_elements_they_name(void **state)
{
    (void)state;
    struct {
        float position[9], value[3];
        uint8_t index[4];
    } bin = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 5, 0}, {2, 0, 0, 0}};
    static const char *const json =
        "{'asset':{'version':'2.0'},'buffers':[{'byteLength':52}],'bufferViews':["
        "{'buffer':0,'byteLength':36},{'buffer':0,'byteOffset':36,'byteLength':12},"
        "{'buffer':0,'byteOffset':48,'byteLength':1}],'accessors':[{'bufferView':0,"
        "'componentType':5126,'count':3,'type':'VEC3','sparse':{'count':1,'indices':{'bufferView':"
        "2,"
        "'componentType':5121},'values':{'bufferView':1}}}],'meshes':[{'primitives':[{'attributes':"
        "{'POSITION':0}}]}]," ONE_NODE "}";
    static const float expected[9] = {0, 0, 0, 1, 0, 0, 0, 5, 0};
    struct glint_scene *s = gltf_data(json, &bin, sizeof bin);
    gltf_floats_equal(s->mesh[0].position, expected, 9, 0);
    glint_scene_destroy(&s);
    size_t size;
    bin.index[0] = 3;
    uint8_t *glb = glb_make(json, &bin, sizeof bin, &size);
    gltf_refused(glb, size, GLINT_E_RANGE, "/accessors/0", "sparse index 0 is 3");
}

static void an_unpadded_interleaved_view_is_read_to_its_end(void **state)
{
    (void)state;
    static const float bin[] = {0, 0, 0, 9, 9, 9, 1, 0, 0, 9, 9, 9, 0, 1, 0};
    static const float expected[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    struct glint_scene *s = gltf_data(
        "{'asset':{'version':'2.0'},'buffers':[{'byteLength':60}],'bufferViews':[{'buffer':0,"
        "'byteLength':60,'byteStride':24}],'accessors':[{'bufferView':0,'componentType':5126,"
        "'count':3,'type':'VEC3'}],'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]"
        "," ONE_NODE "}",
        bin, sizeof bin);
    gltf_floats_equal(s->mesh[0].position, expected, 9, 0);
    glint_scene_destroy(&s);
}

static void tangents_keep_their_side_and_normals_become_unit(void **state)
{
    (void)state;
    static const float bin[] = {0, 0, 0, 1,  0, 0, 0, 1, 0, // positions
                                0, 0, 9, 0,  0, 0, 0, 0, 2, // normals, the second without direction
                                1, 0, 0, -1, 3, 0, 0, 1, 0, 0, 0, 1}; // tangents
    struct glint_scene *s = gltf_data(
        "{'asset':{'version':'2.0'},'buffers':[{'byteLength':120}],'bufferViews':[{'buffer':0,"
        "'byteLength':36},{'buffer':0,'byteOffset':36,'byteLength':36},{'buffer':0,'byteOffset':72,"
        "'byteLength':48}],'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':"
        "'VEC3'},{'bufferView':1,'componentType':5126,'count':3,'type':'VEC3'},{'bufferView':2,"
        "'componentType':5126,'count':3,'type':'VEC4'}],'meshes':[{'name':'m','primitives':[{"
        "'attributes':{'POSITION':0,'NORMAL':1,'TANGENT':2}}]}]," ONE_NODE "}",
        bin, sizeof bin);
    static const float up[9] = {0, 0, 1, 0, 0, 1, 0, 0, 1};
    const struct glint_mesh *m = &s->mesh[0];
    gltf_floats_equal(m->normal, up, 9, 0);
    assert_true(m->tangent[3] == -1);
    gltf_floats_equal(m->tangent + 4, (const float[]){1, 0, 0}, 3, 0);
    const float *t = m->tangent + 8; // made up: unit, across the normal
    assert_true(fabsf(t[0] * t[0] + t[1] * t[1] - 1) < 1e-6f && t[2] == 0);
    gltf_expect_warning(s, "1 normals of mesh \"m\" have no direction");
    glint_scene_destroy(&s);
}

static void points_and_lines_are_left_out_with_a_warning(void **state)
{
    (void)state;
    struct glint_scene *s =
        gltf_quad("'meshes':[{'name':'mix','primitives':[{'mode':0," GLB_QUAD_PRIMITIVE
                  "},{'mode':1," GLB_QUAD_PRIMITIVE "},{" GLB_QUAD_PRIMITIVE "}]}]," ONE_NODE);
    assert_int_equal(s->meshes, 1);
    assert_int_equal(s->instances, 1);
    gltf_expect_warning(s, "points of mesh \"mix\"");
    gltf_expect_warning(s, "lines of mesh \"mix\"");
    glint_scene_destroy(&s);
}

static void bad_geometry_is_refused_with_its_place(void **state)
{
    (void)state;
    static const struct {
        const char *mesh, *pointer, *word;
    } bad[] = {
        {"{'attributes':{'POSITION':7}}", "/meshes/0/primitives/0/attributes/POSITION",
         "4 accessors"},
        {"{'attributes':{'POSITION':2}}", "/meshes/0/primitives/0/attributes/POSITION", "type"},
        {"{'attributes':{'POSITION':0},'indices':0}", "/meshes/0/primitives/0/indices", "unsigned"},
        {"{'attributes':{'POSITION':0},'mode':9}", "/meshes/0/primitives/0/mode", "9"},
        {"{'attributes':{'POSITION':0},'material':0}", "/meshes/0/primitives/0/material",
         "0 materials"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char rest[512];
        snprintf(rest, sizeof rest, "'meshes':[{'primitives':[%s]}]," ONE_NODE, bad[i].mesh);
        gltf_refuse_quad(rest, bad[i].pointer, bad[i].word);
    }
}

static void an_index_out_of_range_is_refused(void **state)
{
    (void)state;
    struct glb_quad bin = glb_quad_data;
    bin.index[4] = 4;
    size_t size;
    uint8_t *glb =
        glb_make("{" GLB_QUAD "," GLB_QUAD_MESH "," ONE_NODE "}", &bin, sizeof bin, &size);
    gltf_refused(glb, size, GLINT_E_RANGE, "/accessors/3", "index 4 is 4");
}

static void a_position_that_is_no_number_is_refused(void **state)
{
    (void)state;
    struct glb_quad bin = glb_quad_data;
    bin.position[5] = NAN;
    size_t size;
    uint8_t *glb =
        glb_make("{" GLB_QUAD "," GLB_QUAD_MESH "," ONE_NODE "}", &bin, sizeof bin, &size);
    gltf_refused(glb, size, GLINT_E_RANGE, "/accessors/0", "vertex 1 of mesh \"square\"");
}

// --- the container

static void broken_containers_are_named(void **state)
{
    (void)state;
    static const struct {
        size_t at;
        uint8_t value;
        const char *word;
    } bad[] = {
        {0, 'x', "does not start with"}, {4, 3, "version is 3"}, {9, 0xff, "header says"},
        {15, 0xff, "bytes are left"},    {16, 'B', "not JSON"},  {12, 1, "chunk"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        size_t size;
        uint8_t *glb = glb_quad(ONE_NODE, &size);
        glb[bad[i].at] = bad[i].value;
        gltf_refused(glb, size, GLINT_E_SYNTAX, "", bad[i].word);
    }
}

// Each cut ends inside something, and the header's length no longer holds.
static void every_truncation_is_refused_as_syntax(void **state)
{
    (void)state;
    size_t size;
    uint8_t *glb = glb_quad(GLB_QUAD_MESH "," ONE_NODE, &size);
    for (size_t n = 0; n < size; n++) {
        struct glint_scene *s;
        uint8_t *cut = malloc(n ? n : 1); // exact, so that a sanitizer sees a step too far
        memcpy(cut, glb, n);
        assert_int_equal(glint_gltf_import(&s, cut, n, NULL, NULL), GLINT_E_SYNTAX);
        if (n >= 12) { // and with a header that agrees
            for (int k = 0; k < 4; k++)
                cut[8 + k] = (uint8_t)(n >> (8 * k));
            assert_int_not_equal(glint_gltf_import(&s, cut, n, NULL, NULL), GLINT_OK);
        }
        free(cut);
    }
    free(glb);
}

static void buffers_and_views_are_bounded(void **state)
{
    (void)state;
#define REST ",'scenes':[{'nodes':[0]}],'nodes':[{}]}"
    static const struct {
        const char *json, *pointer, *word;
    } bad[] = {
        {"'buffers':[{'byteLength':149}]", "/buffers/0/byteLength", "149 bytes"},
        {"'buffers':[{'byteLength':8,'uri':'a.bin'}]", "/buffers/0/uri", "outside of the file"},
        {"'buffers':[{'byteLength':8,'uri':'data:;base64,@'}]", "/buffers/0/uri", "base64"},
        {"'buffers':[{'byteLength':8,'uri':'data:;base64,AAAA'}]", "/buffers/0/byteLength",
         "has 3"},
        {"'buffers':[{'byteLength':8}],'bufferViews':[{'buffer':0,'byteOffset':4,'byteLength':5}]",
         "/bufferViews/0/byteLength", "buffer of 8"},
        {"'buffers':[{'byteLength':8}],'bufferViews':[{'buffer':1,'byteLength':5}]",
         "/bufferViews/0/buffer", "1 buffers"},
        {"'buffers':[{'byteLength':8}],'bufferViews':[{'buffer':0,'byteLength':8,'byteStride':256}"
         "]",
         "/bufferViews/0/byteStride", "256"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char json[512];
        size_t size;
        snprintf(json, sizeof json, "{'asset':{'version':'2.0'},%s" REST, bad[i].json);
        uint8_t *glb = glb_make(json, &glb_quad_data, sizeof glb_quad_data, &size);
        gltf_refused(glb, size, GLINT_E_RANGE, bad[i].pointer, bad[i].word);
    }
}

static void accessors_are_bounded_by_their_views(void **state)
{
    (void)state;
    static const struct {
        const char *accessor, *pointer, *word;
    } bad[] = {
        {"'bufferView':0,'componentType':5126,'count':5,'type':'VEC3'", "/accessors/0", "60 bytes"},
        {"'bufferView':0,'byteOffset':4,'componentType':5126,'count':4,'type':'VEC3'",
         "/accessors/0", "from byte 4"},
        {"'bufferView':0,'componentType':5126,'count':0,'type':'VEC3'", "/accessors/0/count", "0"},
        {"'bufferView':0,'componentType':5124,'count':4,'type':'VEC3'",
         "/accessors/0/componentType", "5124"},
        {"'bufferView':0,'componentType':5126,'count':4,'type':'VEC5'", "/accessors/0/type",
         "VEC5"},
        {"'componentType':5126,'count':2000000000,'type':'VEC3'", "/accessors/0", "no data"},
        {"'bufferView':9,'componentType':5126,'count':4,'type':'VEC3'", "/accessors/0/bufferView",
         "9"},
        {"'componentType':5126,'count':4,'type':'VEC3','sparse':{'count':5,'indices':{},'values':{}"
         "}",
         "/accessors/0/sparse/count", "5"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char json[1024];
        size_t size;
        snprintf(json, sizeof json,
                 "{'asset':{'version':'2.0'},'buffers':[{'byteLength':48},{'byteLength':48}],"
                 "'bufferViews':[{'buffer':0,'byteLength':48},{'buffer':1,'byteLength':48}],"
                 "'accessors':[{%s}],'meshes':[{'primitives':[{'attributes':{"
                 "'POSITION':0}}]}]," ONE_NODE "}",
                 bad[i].accessor);
        uint8_t *glb = glb_make(json, &glb_quad_data, sizeof glb_quad_data, &size);
        gltf_refused(glb, size, GLINT_E_RANGE, bad[i].pointer, bad[i].word);
    }
}

static void an_accessor_without_data_is_zero(void **state)
{
    (void)state;
    struct glint_scene *s = gltf_data(
        "{'asset':{'version':'2.0'},'accessors':[{'componentType':5126,'count':3,'type':'VEC3'}],"
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]," ONE_NODE "}",
        NULL, 0);
    static const float zeros[9];
    gltf_floats_equal(s->mesh[0].position, zeros, 9, 0);
    glint_scene_destroy(&s);
}

static void json_with_data_uris_needs_no_container(void **state)
{
    (void)state;
    static const char *const json =
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":36,\"uri\":\"data:"
        "application/"
        "octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}],\"bufferViews\":["
        "{"
        "\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
        "\"count\":3,\"type\":\"VEC3\"}],\"meshes\":[{\"primitives\":[{\"attributes\":{"
        "\"POSITION\":0}}]}"
        "],\"nodes\":[{\"mesh\":0}]}";
    struct glint_scene *s;
    static const float expected[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    assert_int_equal(glint_gltf_import(&s, (const uint8_t *)json, strlen(json), NULL, NULL),
                     GLINT_OK);
    gltf_floats_equal(s->mesh[0].position, expected, 9, 0);
    glint_scene_destroy(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mesh_arrives_as_it_was_written),
        cmocka_unit_test(missing_normals_stay_missing),
        cmocka_unit_test(strips_and_fans_become_triangles_of_one_orientation),
        cmocka_unit_test(normalised_integers_become_fractions),
        cmocka_unit_test(sparse_values_replace_the_elements_they_name),
        cmocka_unit_test(an_unpadded_interleaved_view_is_read_to_its_end),
        cmocka_unit_test(tangents_keep_their_side_and_normals_become_unit),
        cmocka_unit_test(points_and_lines_are_left_out_with_a_warning),
        cmocka_unit_test(bad_geometry_is_refused_with_its_place),
        cmocka_unit_test(an_index_out_of_range_is_refused),
        cmocka_unit_test(a_position_that_is_no_number_is_refused),
        cmocka_unit_test(broken_containers_are_named),
        cmocka_unit_test(every_truncation_is_refused_as_syntax),
        cmocka_unit_test(buffers_and_views_are_bounded),
        cmocka_unit_test(accessors_are_bounded_by_their_views),
        cmocka_unit_test(an_accessor_without_data_is_zero),
        cmocka_unit_test(json_with_data_uris_needs_no_container),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
