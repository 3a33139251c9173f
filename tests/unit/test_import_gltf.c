#include "scene/gltf.h"
#include "tests/unit/glb_maker.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ONE_NODE "'scene':0,'scenes':[{'nodes':[0]}],'nodes':[{'name':'n','mesh':0}]"

static struct glint_scene *take(uint8_t *glb, size_t size)
{
    struct glint_error err = {0};
    struct glint_scene *scene;
    const glint_status st = glint_gltf_import(&scene, glb, size, &err);
    if (st)
        fail_msg("%s: %s", err.count ? err.fault[0].pointer : "", glint_error_text(&err));
    free(glb);
    return scene;
}

static struct glint_scene *import_quad(const char *rest)
{
    size_t size;
    uint8_t *glb = glb_quad(rest, &size);
    return take(glb, size);
}

static struct glint_scene *import_data(const char *json, const void *bin, size_t bytes)
{
    size_t size;
    uint8_t *glb = glb_make(json, bin, bytes, &size);
    return take(glb, size);
}

// Expects a refusal at `pointer` whose sentence holds `word`.
static void refused(uint8_t *glb, size_t size, glint_status status, const char *pointer,
                    const char *word)
{
    struct glint_error err = {0};
    struct glint_scene *scene;
    assert_int_equal(glint_gltf_import(&scene, glb, size, &err), status);
    assert_null(scene);
    assert_string_equal(err.fault[0].pointer, pointer);
    if (!strstr(err.fault[0].detail, word))
        fail_msg("\"%s\" does not say \"%s\"", err.fault[0].detail, word);
    glint_error_finish(&err);
    free(glb);
}

static void refuse_quad(const char *rest, const char *pointer, const char *word)
{
    size_t size;
    uint8_t *glb = glb_quad(rest, &size);
    refused(glb, size, GLINT_E_RANGE, pointer, word);
}

static bool warns(const struct glint_scene *s, const char *word)
{
    for (uint32_t i = 0; i < s->warnings; i++)
        if (strstr(s->warning[i], word))
            return true;
    return false;
}

static void expect_warning(const struct glint_scene *s, const char *word)
{
    if (!warns(s, word))
        fail_msg("no warning says \"%s\"", word);
}

static void floats_equal(const float *a, const float *b, size_t count, float tolerance)
{
    for (size_t i = 0; i < count; i++)
        if (!(fabsf(a[i] - b[i]) <= tolerance))
            fail_msg("number %zu is %.9g, not %.9g", i, (double)a[i], (double)b[i]);
}

// --- geometry

static void a_mesh_arrives_as_it_was_written(void **state)
{
    (void)state;
    struct glint_scene *s = import_quad(GLB_QUAD_MESH "," ONE_NODE);
    assert_int_equal(s->meshes, 1);
    const struct glint_mesh *m = &s->mesh[0];
    assert_string_equal(m->id, "square");
    assert_int_equal(m->vertices, 4);
    assert_int_equal(m->triangles, 2);
    floats_equal(m->position, glb_quad_data.position, 12, 0);
    floats_equal(m->normal, glb_quad_data.normal, 12, 0);
    floats_equal(m->uv, glb_quad_data.uv, 8, 0);
    assert_null(m->tangent);
    for (int i = 0; i < 6; i++)
        assert_int_equal(m->index[i], glb_quad_data.index[i]);
    glint_scene_destroy(&s);
}

static void missing_normals_stay_missing(void **state)
{
    (void)state;
    struct glint_scene *s = import_quad("'meshes':[{'primitives':[{'attributes':{'POSITION':0},"
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
        "'VEC3'}],'meshes':[{'primitives':[{'mode':%d,'attributes':{'POSITION':0}}]}]," ONE_NODE "}";
    static const float strip[15] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0};
    static const float fan[15] = {0, 0, 0, 2, 0, 0, 2, 1, 0, 1, 2, 0, 0, 2, 0};
    for (int mode = 5; mode <= 6; mode++) {
        char text[1024];
        snprintf(text, sizeof text, json, mode);
        struct glint_scene *s = import_data(text, mode == 5 ? strip : fan, 60);
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
    struct glint_scene *s = import_data(
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
    floats_equal(s->mesh[0].position, position, 9, 0);
    floats_equal(s->mesh[0].uv, uv, 6, 1e-6f);
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
        "'componentType':5126,'count':3,'type':'VEC3','sparse':{'count':1,'indices':{'bufferView':2,"
        "'componentType':5121},'values':{'bufferView':1}}}],'meshes':[{'primitives':[{'attributes':"
        "{'POSITION':0}}]}]," ONE_NODE "}";
    static const float expected[9] = {0, 0, 0, 1, 0, 0, 0, 5, 0};
    struct glint_scene *s = import_data(json, &bin, sizeof bin);
    floats_equal(s->mesh[0].position, expected, 9, 0);
    glint_scene_destroy(&s);
    size_t size;
    bin.index[0] = 3;
    uint8_t *glb = glb_make(json, &bin, sizeof bin, &size);
    refused(glb, size, GLINT_E_RANGE, "/accessors/0", "sparse index 0 is 3");
}

static void an_unpadded_interleaved_view_is_read_to_its_end(void **state)
{
    (void)state;
    static const float bin[] = {0, 0, 0, 9, 9, 9, 1, 0, 0, 9, 9, 9, 0, 1, 0};
    static const float expected[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    struct glint_scene *s = import_data(
        "{'asset':{'version':'2.0'},'buffers':[{'byteLength':60}],'bufferViews':[{'buffer':0,"
        "'byteLength':60,'byteStride':24}],'accessors':[{'bufferView':0,'componentType':5126,"
        "'count':3,'type':'VEC3'}],'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}],"
        ONE_NODE "}", bin, sizeof bin);
    floats_equal(s->mesh[0].position, expected, 9, 0);
    glint_scene_destroy(&s);
}

static void tangents_keep_their_side_and_normals_become_unit(void **state)
{
    (void)state;
    static const float bin[] = {0, 0, 0, 1,  0, 0, 0, 1,  0,  // positions
                                0, 0, 9, 0,  0, 0, 0, 0,  2,  // normals, the second without direction
                                1, 0, 0, -1, 3, 0, 0, 1,  0, 0, 0, 1}; // tangents
    struct glint_scene *s = import_data(
        "{'asset':{'version':'2.0'},'buffers':[{'byteLength':120}],'bufferViews':[{'buffer':0,"
        "'byteLength':36},{'buffer':0,'byteOffset':36,'byteLength':36},{'buffer':0,'byteOffset':72,"
        "'byteLength':48}],'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':"
        "'VEC3'},{'bufferView':1,'componentType':5126,'count':3,'type':'VEC3'},{'bufferView':2,"
        "'componentType':5126,'count':3,'type':'VEC4'}],'meshes':[{'name':'m','primitives':[{"
        "'attributes':{'POSITION':0,'NORMAL':1,'TANGENT':2}}]}]," ONE_NODE "}", bin, sizeof bin);
    static const float up[9] = {0, 0, 1, 0, 0, 1, 0, 0, 1};
    const struct glint_mesh *m = &s->mesh[0];
    floats_equal(m->normal, up, 9, 0);
    assert_true(m->tangent[3] == -1);
    floats_equal(m->tangent + 4, (const float[]){1, 0, 0}, 3, 0);
    const float *t = m->tangent + 8; // made up: unit, across the normal
    assert_true(fabsf(t[0] * t[0] + t[1] * t[1] - 1) < 1e-6f && t[2] == 0);
    expect_warning(s, "1 normals of mesh \"m\" have no direction");
    glint_scene_destroy(&s);
}

static void points_and_lines_are_left_out_with_a_warning(void **state)
{
    (void)state;
    struct glint_scene *s = import_quad(
        "'meshes':[{'name':'mix','primitives':[{'mode':0," GLB_QUAD_PRIMITIVE "},{'mode':1,"
        GLB_QUAD_PRIMITIVE "},{" GLB_QUAD_PRIMITIVE "}]}]," ONE_NODE);
    assert_int_equal(s->meshes, 1);
    assert_int_equal(s->instances, 1);
    expect_warning(s, "points of mesh \"mix\"");
    expect_warning(s, "lines of mesh \"mix\"");
    glint_scene_destroy(&s);
}

static void bad_geometry_is_refused_with_its_place(void **state)
{
    (void)state;
    static const struct { const char *mesh, *pointer, *word; } bad[] = {
        {"{'attributes':{'POSITION':7}}", "/meshes/0/primitives/0/attributes/POSITION", "4 accessors"},
        {"{'attributes':{'POSITION':2}}", "/meshes/0/primitives/0/attributes/POSITION", "type"},
        {"{'attributes':{'POSITION':0},'indices':0}", "/meshes/0/primitives/0/indices", "unsigned"},
        {"{'attributes':{'POSITION':0},'mode':9}", "/meshes/0/primitives/0/mode", "9"},
        {"{'attributes':{'POSITION':0},'material':0}", "/meshes/0/primitives/0/material", "0 materials"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char rest[512];
        snprintf(rest, sizeof rest, "'meshes':[{'primitives':[%s]}]," ONE_NODE, bad[i].mesh);
        refuse_quad(rest, bad[i].pointer, bad[i].word);
    }
}

static void an_index_out_of_range_is_refused(void **state)
{
    (void)state;
    struct glb_quad bin = glb_quad_data;
    bin.index[4] = 4;
    size_t size;
    uint8_t *glb = glb_make("{" GLB_QUAD "," GLB_QUAD_MESH "," ONE_NODE "}", &bin, sizeof bin, &size);
    refused(glb, size, GLINT_E_RANGE, "/accessors/3", "index 4 is 4");
}

static void a_position_that_is_no_number_is_refused(void **state)
{
    (void)state;
    struct glb_quad bin = glb_quad_data;
    bin.position[5] = NAN;
    size_t size;
    uint8_t *glb = glb_make("{" GLB_QUAD "," GLB_QUAD_MESH "," ONE_NODE "}", &bin, sizeof bin, &size);
    refused(glb, size, GLINT_E_RANGE, "/accessors/0", "vertex 1 of mesh \"square\"");
}

// --- nodes

static void transforms_of_parents_come_first(void **state)
{
    (void)state;
    struct glint_scene *s = import_quad(
        GLB_QUAD_MESH ",'scenes':[{'nodes':[0]}],'nodes':[{'name':'a','translation':[10,0,0],"
        "'rotation':[0,0,0.7071067811865476,0.7071067811865476],'children':[1]},{'name':'b',"
        "'translation':[1,2,3],'scale':[2,2,-2],'mesh':0}]");
    // turned by 90 degrees about z: x to y, y to -x; then moved
    static const float expected[16] = {0, 2, 0, 0, -2, 0, 0, 0, 0, 0, -2, 0, 8, 1, 3, 1};
    floats_equal(s->instance[0].transform, expected, 16, 1e-6f);
    assert_string_equal(s->object[0].name, "b");
    glint_scene_destroy(&s);
}

static void matrices_are_column_major(void **state)
{
    (void)state;
    struct glint_scene *s = import_quad(
        GLB_QUAD_MESH ",'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0,'matrix':[1,0,0,0, 0,1,0,0, "
        "0,0,1,0, 4,5,6,1]}]");
    static const float expected[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4, 5, 6, 1};
    floats_equal(s->instance[0].transform, expected, 16, 0);
    glint_scene_destroy(&s);
}

static void a_node_scaled_to_nothing_is_left_out(void **state)
{
    (void)state;
    struct glint_scene *s = import_quad(
        GLB_QUAD_MESH ",'scenes':[{'nodes':[0,1]}],'nodes':[{'name':'gone','mesh':0,'scale':[0,1,1]}"
        ",{'name':'here','mesh':0,'scale':[1e-6,1e-6,1e-6]}]");
    assert_int_equal(s->objects, 1);
    assert_string_equal(s->object[0].name, "here");
    expect_warning(s, "node \"gone\" is left out");
    glint_scene_destroy(&s);
}

static void objects_are_named_by_node_or_path(void **state)
{
    (void)state;
    struct glint_scene *s = import_quad(
        GLB_QUAD_MESH ",'scenes':[{'nodes':[0,3,5,6]}],'nodes':[{'name':'left','children':[1,2]},"
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
    struct glint_scene *s = import_quad(
        "'materials':[{'name':'a b'},{'name':'a/b'},{'name':'a_b_2'},{}]," GLB_QUAD_MESH "," ONE_NODE);
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
    struct glint_scene *s = import_quad(
        GLB_QUAD_MESH ",'scenes':[{'nodes':[0]}],'nodes':[{'extras':{'asset':'chair'},'children':[1,2]},"
        "{'name':'x:y','mesh':0},{'name':'z','mesh':0,'extras':{'asset':'cushion'}}]");
    assert_string_equal(s->object[0].asset, "chair");
    assert_string_equal(s->object[1].asset, "cushion");
    glint_scene_destroy(&s);
}

static void each_primitive_is_an_instance_of_one_object(void **state)
{
    (void)state;
    struct glint_scene *s = import_quad(
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
    refuse_quad("'scenes':[{'nodes':[0]}],'nodes':[{'children':[1]},{'children':[0]}]", "/nodes/0",
                "inside of itself");
    refuse_quad("'scenes':[{'nodes':[0,1]}],'nodes':[{'children':[1]},{}]", "/nodes/1", "two places");
    refuse_quad("'scenes':[{'nodes':[0,0]}],'nodes':[{},{}]", "/nodes/0", "two places");
    refuse_quad("'scenes':[{'nodes':[0,0,0]}],'nodes':[{},{}]", "/scenes/0/nodes", "tree");
    refuse_quad("'scenes':[{'nodes':[5]}],'nodes':[{}]", "/scenes/0/nodes/0", "1 nodes");
    refuse_quad("'scenes':[{'nodes':[0]}],'nodes':[{'rotation':[0,0,0,0]}]", "/nodes/0/rotation",
                "no rotation");
    refuse_quad("'scenes':[{'nodes':[0]}],'nodes':[{'matrix':[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]}]",
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
            struct glint_scene *s = import_quad(rest);
            glint_scene_destroy(&s);
        } else {
            refuse_quad(rest, "/nodes/513", "512 deep");
        }
        free(rest);
    }
}

static void without_a_scene_every_root_is_shown(void **state)
{
    (void)state;
    struct glint_scene *s =
        import_quad(GLB_QUAD_MESH ",'nodes':[{'mesh':0},{'children':[0]},{'mesh':0}]");
    assert_int_equal(s->instances, 2);
    glint_scene_destroy(&s);
}

// --- materials

static void factors_and_extensions_reach_the_material(void **state)
{
    (void)state;
    struct glint_scene *s = import_quad(
        "'materials':[{'name':'all','doubleSided':true,'alphaMode':'MASK','alphaCutoff':0.25,"
        "'pbrMetallicRoughness':{'baseColorFactor':[0.1,0.2,0.3,0.4],'metallicFactor':0.6,"
        "'roughnessFactor':0.7},'emissiveFactor':[1,0.5,0.25],'extensions':{"
        "'KHR_materials_emissive_strength':{'emissiveStrength':8},'KHR_materials_ior':{'ior':1.33},"
        "'KHR_materials_transmission':{'transmissionFactor':0.9},'KHR_materials_volume':{"
        "'thicknessFactor':0.5}}},"
        "{'extensions':{'KHR_materials_transmission':{'transmissionFactor':1}}},{}]");
    const struct glint_material *m = &s->material[0];
    floats_equal(m->base_color, (const float[]){0.1f, 0.2f, 0.3f}, 3, 0);
    floats_equal(m->emission, (const float[]){8, 4, 2}, 3, 0);
    floats_equal((const float[]){m->opacity, m->alpha_cutoff, m->metallic, m->roughness, m->ior,
                                 m->transmission},
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
    uint8_t *glb = glb_quad("'materials':[{'pbrMetallicRoughness':{'metallicFactor':2,"
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
#define RED_PNG \
    "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4" \
    "z8AAAAMBAQDJ/pLvAAAAAElFTkSuQmCC"

static void textures_bring_image_and_wrapping(void **state)
{
    (void)state;
    struct glint_scene *s = import_quad(
        "'images':[{'name':'unused','uri':'data:,nothing'},{'name':'red','uri':'" RED_PNG "'}],"
        "'samplers':[{'wrapS':33071,'wrapT':33648}],'textures':[{'source':1,'sampler':0},{'source':1}],"
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

static void a_damaged_image_is_refused_by_its_number(void **state)
{
    (void)state;
    refuse_quad("'images':[{'bufferView':0}],'textures':[{'source':0}],'materials':[{"
                "'emissiveTexture':{'index':0}}]", "/images/0", "not PNG, JPEG or Radiance");
    refuse_quad("'images':[{}],'textures':[{'source':0}],'materials':[{'emissiveTexture':{'index':0}}]",
                "/images/0", "no data");
    refuse_quad("'images':[{'uri':'../secret.png'}],'textures':[{'source':0}],'materials':[{"
                "'emissiveTexture':{'index':0}}]", "/images/0/uri", "outside of the file");
}

// --- lights and cameras

static void lights_keep_their_units_and_place(void **state)
{
    (void)state;
    struct glint_scene *s = import_quad(
        "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point','intensity':100,'color':"
        "[1,0.5,0.25]},{'type':'spot','name':'beam','intensity':50,'spot':{'innerConeAngle':0.25,"
        "'outerConeAngle':0.5}},{'type':'directional','intensity':3}]}},'scenes':[{'nodes':[0,1,2]}],"
        "'nodes':[{'name':'bulb','translation':[1,2,3],'scale':[5,5,5],'extensions':{"
        "'KHR_lights_punctual':{'light':0}}},{'extensions':{'KHR_lights_punctual':{'light':1}}},"
        "{'name':'sun','rotation':[-0.7071067811865476,0,0,0.7071067811865476],'extensions':{"
        "'KHR_lights_punctual':{'light':2}}}]");
    assert_int_equal(s->lights, 3);
    const struct glint_light *l = s->light;
    assert_string_equal(l[0].name, "bulb");
    assert_string_equal(l[1].name, "beam");
    assert_true(l[0].kind == GLINT_LIGHT_POINT && l[0].intensity == 100);
    floats_equal(l[0].color, (const float[]){1, 0.5f, 0.25f}, 3, 0);
    static const float moved[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1};
    floats_equal(l[0].transform, moved, 16, 1e-6f); // without the scale
    assert_true(l[1].kind == GLINT_LIGHT_SPOT && l[1].inner_cone == 0.25f && l[1].outer_cone == 0.5f);
    assert_true(l[2].kind == GLINT_LIGHT_SUN && l[2].intensity == 3);
    floats_equal(l[2].transform + 8, (const float[]){0, 1, 0}, 3, 1e-6f); // shines along -z: down
    glint_scene_destroy(&s);
}

static void bad_lights_are_refused_with_their_place(void **state)
{
    (void)state;
#define LIGHT(JSON) "'extensions':{'KHR_lights_punctual':{'lights':[" JSON "]}},'scenes':[{'nodes':[0]}]," \
                    "'nodes':[{'extensions':{'KHR_lights_punctual':{'light':0}}}]"
#define AT "/extensions/KHR_lights_punctual/lights/0"
    refuse_quad(LIGHT("{'type':'laser'}"), AT "/type", "laser");
    refuse_quad(LIGHT("{'type':'spot'}"), AT "/spot", "required");
    refuse_quad(LIGHT("{'type':'spot','spot':{'innerConeAngle':0.5,'outerConeAngle':0.5}}"), AT "/spot",
                "inside");
    refuse_quad(LIGHT("{'type':'point','intensity':-1}"), AT "/intensity", "-1");
    refuse_quad(LIGHT(""), "/nodes/0/extensions/KHR_lights_punctual/light", "0 lights");
}

static void cameras_keep_yfov_and_lose_scale(void **state)
{
    (void)state;
    struct glint_scene *s = import_quad(
        "'cameras':[{'name':'lens','type':'perspective','perspective':{'yfov':0.7,'aspectRatio':2,"
        "'znear':0.1}},{'type':'orthographic','orthographic':{'xmag':1,'ymag':1,'znear':0,'zfar':1}}],"
        "'scenes':[{'nodes':[0,1,2]}],'nodes':[{'camera':0,'translation':[0,0,5],'scale':[2,2,2]},"
        "{'name':'flat','camera':1},{'name':'cam','camera':0,'scale':[-1,1,1]}]");
    assert_int_equal(s->cameras, 2);
    assert_string_equal(s->camera[0].name, "lens");
    assert_string_equal(s->camera[1].name, "cam");
    assert_true(s->camera[0].yfov == 0.7f && s->camera[0].focus_distance > 0);
    static const float back[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1};
    floats_equal(s->camera[0].transform, back, 16, 1e-6f);
    floats_equal(s->camera[1].transform, (const float[]){1, 0, 0}, 3, 1e-6f); // not mirrored
    expect_warning(s, "camera \"flat\" is orthographic");
    glint_scene_destroy(&s);
    refuse_quad("'cameras':[{'type':'perspective','perspective':{'yfov':0}}],'scenes':[{'nodes':[0]}],"
                "'nodes':[{'camera':0}]", "/cameras/0/perspective/yfov", "0");
    refuse_quad("'cameras':[{'type':'perspective'}],'scenes':[{'nodes':[0]}],'nodes':[{'camera':0}]",
                "/cameras/0/perspective/yfov", "required");
}

// --- what is ignored

static void what_is_ignored_is_named(void **state)
{
    (void)state;
    struct glint_scene *s = import_quad(
        "'images':[{'uri':'" RED_PNG "'}],'textures':[{'source':0},{}],'materials':[{'name':'paint',"
        "'alphaMode':'BLEND','pbrMetallicRoughness':{'baseColorTexture':{'index':0,'texCoord':1,"
        "'extensions':{'KHR_texture_transform':{'scale':[2,2]}}}},'emissiveTexture':{'index':1},"
        "'extensions':{'KHR_materials_clearcoat':{},"
        "'KHR_materials_transmission':{'transmissionFactor':1,'transmissionTexture':{'index':0}},"
        "'KHR_materials_volume':{'attenuationDistance':1}}}],"
        "'meshes':[{'name':'body','primitives':[{'attributes':{'POSITION':0,'COLOR_0':1,'TEXCOORD_1':2"
        "},'targets':[{}],'extensions':{'KHR_materials_variants':{}}}]}],'skins':[{'name':'bones'}],"
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
        expect_warning(s, expected[i]);
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
    struct glint_scene *s = import_quad(rest);
    assert_int_equal(s->warnings, 9);
    expect_warning(s, "material \"m7\"");
    assert_false(warns(s, "material \"m8\""));
    expect_warning(s, "KHR_materials_sheen on a material: 12 more");
    glint_scene_destroy(&s);
}

static void required_extensions_that_are_not_read_are_refused_by_name(void **state)
{
    (void)state;
    refuse_quad("'extensionsRequired':['KHR_lights_punctual','KHR_draco_mesh_compression']",
                "/extensionsRequired/1", "KHR_draco_mesh_compression");
}

// --- the container

static void broken_containers_are_named(void **state)
{
    (void)state;
    static const struct { size_t at; uint8_t value; const char *word; } bad[] = {
        {0, 'x', "does not start with"},  {4, 3, "version is 3"},
        {8, 0xff, "header says"},         {15, 0xff, "bytes are left"},
        {16, 'B', "not JSON"},            {12, 1, "chunk"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        size_t size;
        uint8_t *glb = glb_quad(ONE_NODE, &size);
        glb[bad[i].at] = bad[i].value;
        refused(glb, size, GLINT_E_SYNTAX, "", bad[i].word);
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
        assert_int_equal(glint_gltf_import(&s, cut, n, NULL), GLINT_E_SYNTAX);
        if (n >= 12) { // and with a header that agrees
            for (int k = 0; k < 4; k++)
                cut[8 + k] = (uint8_t)(n >> (8 * k));
            assert_int_not_equal(glint_gltf_import(&s, cut, n, NULL), GLINT_OK);
        }
        free(cut);
    }
    free(glb);
}

static void buffers_and_views_are_bounded(void **state)
{
    (void)state;
#define REST ",'scenes':[{'nodes':[0]}],'nodes':[{}]}"
    static const struct { const char *json, *pointer, *word; } bad[] = {
        {"'buffers':[{'byteLength':149}]", "/buffers/0/byteLength", "149 bytes"},
        {"'buffers':[{'byteLength':8,'uri':'a.bin'}]", "/buffers/0/uri", "outside of the file"},
        {"'buffers':[{'byteLength':8,'uri':'data:;base64,@'}]", "/buffers/0/uri", "base64"},
        {"'buffers':[{'byteLength':8,'uri':'data:;base64,AAAA'}]", "/buffers/0/byteLength", "has 3"},
        {"'buffers':[{'byteLength':8}],'bufferViews':[{'buffer':0,'byteOffset':4,'byteLength':5}]",
         "/bufferViews/0/byteLength", "buffer of 8"},
        {"'buffers':[{'byteLength':8}],'bufferViews':[{'buffer':1,'byteLength':5}]",
         "/bufferViews/0/buffer", "1 buffers"},
        {"'buffers':[{'byteLength':8}],'bufferViews':[{'buffer':0,'byteLength':8,'byteStride':256}]",
         "/bufferViews/0/byteStride", "256"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char json[512];
        size_t size;
        snprintf(json, sizeof json, "{'asset':{'version':'2.0'},%s" REST, bad[i].json);
        uint8_t *glb = glb_make(json, &glb_quad_data, sizeof glb_quad_data, &size);
        refused(glb, size, GLINT_E_RANGE, bad[i].pointer, bad[i].word);
    }
}

static void accessors_are_bounded_by_their_views(void **state)
{
    (void)state;
    static const struct { const char *accessor, *pointer, *word; } bad[] = {
        {"'bufferView':0,'componentType':5126,'count':5,'type':'VEC3'", "/accessors/0", "60 bytes"},
        {"'bufferView':0,'byteOffset':4,'componentType':5126,'count':4,'type':'VEC3'", "/accessors/0",
         "from byte 4"},
        {"'bufferView':0,'componentType':5126,'count':0,'type':'VEC3'", "/accessors/0/count", "0"},
        {"'bufferView':0,'componentType':5124,'count':4,'type':'VEC3'", "/accessors/0/componentType",
         "5124"},
        {"'bufferView':0,'componentType':5126,'count':4,'type':'VEC5'", "/accessors/0/type", "VEC5"},
        {"'componentType':5126,'count':2000000000,'type':'VEC3'", "/accessors/0", "no data"},
        {"'bufferView':1,'componentType':5126,'count':1,'type':'VEC3'", "/accessors/0",
         "view 1 has no data"},
        {"'bufferView':9,'componentType':5126,'count':4,'type':'VEC3'", "/accessors/0/bufferView", "9"},
        {"'componentType':5126,'count':4,'type':'VEC3','sparse':{'count':5,'indices':{},'values':{}}",
         "/accessors/0/sparse/count", "5"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char json[1024];
        size_t size;
        snprintf(json, sizeof json,
                 "{'asset':{'version':'2.0'},'buffers':[{'byteLength':48},{'byteLength':48}],"
                 "'bufferViews':[{'buffer':0,'byteLength':48},{'buffer':1,'byteLength':48}],"
                 "'accessors':[{%s}],'meshes':[{'primitives':[{'attributes':{"
                 "'POSITION':0}}]}]," ONE_NODE "}", bad[i].accessor);
        uint8_t *glb = glb_make(json, &glb_quad_data, sizeof glb_quad_data, &size);
        refused(glb, size, GLINT_E_RANGE, bad[i].pointer, bad[i].word);
    }
}

static void an_accessor_without_data_is_zero(void **state)
{
    (void)state;
    struct glint_scene *s = import_data(
        "{'asset':{'version':'2.0'},'accessors':[{'componentType':5126,'count':3,'type':'VEC3'}],"
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]," ONE_NODE "}", NULL, 0);
    static const float zeros[9];
    floats_equal(s->mesh[0].position, zeros, 9, 0);
    glint_scene_destroy(&s);
}

static void json_with_data_uris_needs_no_container(void **state)
{
    (void)state;
    static const char *const json =
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/"
        "octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}],\"bufferViews\":[{"
        "\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
        "\"count\":3,\"type\":\"VEC3\"}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}"
        "],\"nodes\":[{\"mesh\":0}]}";
    struct glint_scene *s;
    static const float expected[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    assert_int_equal(glint_gltf_import(&s, (const uint8_t *)json, strlen(json), NULL), GLINT_OK);
    floats_equal(s->mesh[0].position, expected, 9, 0);
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
        cmocka_unit_test(a_damaged_image_is_refused_by_its_number),
        cmocka_unit_test(lights_keep_their_units_and_place),
        cmocka_unit_test(bad_lights_are_refused_with_their_place),
        cmocka_unit_test(cameras_keep_yfov_and_lose_scale),
        cmocka_unit_test(what_is_ignored_is_named),
        cmocka_unit_test(warnings_of_a_kind_are_capped_and_counted),
        cmocka_unit_test(required_extensions_that_are_not_read_are_refused_by_name),
        cmocka_unit_test(broken_containers_are_named),
        cmocka_unit_test(every_truncation_is_refused_as_syntax),
        cmocka_unit_test(buffers_and_views_are_bounded),
        cmocka_unit_test(accessors_are_bounded_by_their_views),
        cmocka_unit_test(an_accessor_without_data_is_zero),
        cmocka_unit_test(json_with_data_uris_needs_no_container),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
