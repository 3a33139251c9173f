#include "tests/unit/model_expect.h"

#include <math.h>

static struct glint_files *files; // of the next file

static glint_status read_obj(struct glint_scene **out, const uint8_t *bytes, size_t size,
                             struct glint_error *err)
{
    return glint_obj_import(out, bytes, size, files, err);
}

static struct glint_scene *read_text(const char *text)
{
    return model_read(read_obj, text, strlen(text));
}

static void refused(const char *text, const char *words)
{
    model_refused(read_obj, text, strlen(text), GLINT_E_RANGE, words);
}

#define SQUARE "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
#define MTL(TEXT)                                                                       \
    struct glint_file one = {"m.mtl", (const uint8_t *)TEXT, sizeof TEXT - 1, false};   \
    struct glint_files all = {&one, 1};                                                 \
    files = &all;                                                                       \
    struct glint_scene *s = read_text("mtllib m.mtl\n" SQUARE "usemtl a\nf 1 2 3 4\n"); \
    const struct glint_material *m = &s->material[0];                                   \
    files = NULL

static void a_square_is_two_triangles_of_four_vertices(void **state)
{
    (void)state;
    struct glint_scene *s = read_text("# a comment\r\n" SQUARE "f 1 2 3 4\r\n");
    double sum[3];
    assert_int_equal(s->mesh[0].vertices, 4);
    assert_int_equal(s->mesh[0].triangles, 2);
    assert_true(model_area(&s->mesh[0], sum) == 1.0);
    assert_true(sum[2] == 1.0); // in the sense that it was drawn
    assert_null(s->mesh[0].normal);
    assert_null(s->mesh[0].uv);
    assert_null(s->mesh[0].color);
    assert_string_equal(s->object[0].name, "default");
    glint_scene_destroy(&s);
}

static void numbers_may_be_relative_or_come_before_what_they_name(void **state)
{
    (void)state;
    struct glint_scene *s = read_text("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n");
    assert_int_equal(s->mesh[0].vertices, 3);
    assert_int_equal(s->mesh[0].triangles, 2);
    assert_memory_equal(s->mesh[0].index, s->mesh[0].index + 3, 12);
    glint_scene_destroy(&s);
}

static void corners_that_agree_are_one_vertex(void **state)
{
    (void)state;
    struct glint_scene *s = read_text(SQUARE "vt 0 0.25\nvt 1 0\nvn 0 0 2\n"
                                             "f 1/1/1 2/1/1 3/1/1\nf 1/1/1 3/1/1 4/2/1\n"
                                             "f 1/2/1 2/1/1 3/1/1\n");
    const struct glint_mesh *m = &s->mesh[0];
    assert_int_equal(m->vertices, 5);                // 1/1, 2/1, 3/1, 4/2, 1/2
    assert_true(m->uv[0] == 0 && m->uv[1] == 0.75f); // v goes down here
    assert_true(m->normal[2] == 1);                  // made unit
    glint_scene_destroy(&s);
}

static void every_object_and_material_is_a_mesh_of_its_own(void **state)
{
    (void)state;
    struct glint_scene *s = read_text(
        SQUARE "o lid\nusemtl tin\nf 1 2 3\nusemtl wood\nf 1 3 4\ng box side\nusemtl tin\n"
               "f 1 2 4\ng lid\nusemtl wood\nf 2 3 4\n");
    assert_int_equal(s->objects, 2);
    assert_string_equal(s->object[0].name, "lid");
    assert_string_equal(s->object[1].name, "box side");
    assert_int_equal(s->materials, 2);
    assert_string_equal(s->material[1].name, "wood");
    assert_int_equal(s->meshes, 3);
    assert_int_equal(s->mesh[1].triangles, 2); // lid of wood, from two places
    assert_int_equal(s->instance[1].object, 0);
    assert_int_equal(s->instance[1].material, 1);
    assert_true(model_warns(s, "\"tin\" is in no library"));
    glint_scene_destroy(&s);
}

// Two faces of a tent: with one group the ridge is smooth, without groups nothing has normals.
static void smoothing_groups_share_normals_across_an_edge(void **state)
{
    (void)state;
#define TENT "v 0 0 0\nv 0 0 1\nv -1 -1 0\nv 1 -1 0\n"
    struct glint_scene *s = read_text(TENT "s 1\nf 1 2 3\nf 1 4 2\n");
    const struct glint_mesh *m = &s->mesh[0];
    assert_int_equal(m->vertices, 4);
    for (uint32_t i = 0; i < m->vertices; i++)
        if (m->position[3 * i] == 0) { // the ridge: the sum of (1, -1, 0) and (-1, -1, 0)
            assert_true(fabsf(m->normal[3 * i]) < 1e-6f);
            assert_true(fabsf(m->normal[3 * i + 1] + 1) < 1e-6f);
        }
    glint_scene_destroy(&s);
    s = read_text(TENT "s 1\nf 1 2 3\ns 2\nf 1 4 2\n"); // different groups: a sharp ridge
    assert_int_equal(s->mesh[0].vertices, 6);
    glint_scene_destroy(&s);
    s = read_text(TENT "s 1\ns off\nf 1 2 3\nf 1 4 2\n");
    assert_null(s->mesh[0].normal);
    glint_scene_destroy(&s);
}

// An arrow head: its fan about the first corner would cover more than its area, 3.
static void a_concave_polygon_keeps_its_area(void **state)
{
    (void)state;
    struct glint_scene *s = read_text("v 0 1 0\nv -2 -2 0\nv 0 -1 0\nv 2 -2 0\nf 2 3 4 1\n");
    double sum[3];
    assert_int_equal(s->mesh[0].triangles, 2);
    assert_true(fabs(model_area(&s->mesh[0], sum) - 4.0) < 1e-12);
    assert_true(fabs(sum[2] - 4.0) < 1e-12);
    glint_scene_destroy(&s);
}

static void colours_behind_positions_are_those_of_a_screen(void **state)
{
    (void)state;
    struct glint_scene *s = read_text("v 0 0 0 1 0.5 0\nv 1 0 0\nv 0 1 0 1 1 1\nf 1 2 3\n");
    const float *c = s->mesh[0].color;
    assert_true(c[0] == 1 && c[2] == 0 && c[3] == 1);
    assert_true(fabsf(c[1] - 0.21404114f) < 1e-6f); // IEC 61966-2-1 of 0.5
    assert_true(c[4] == 1 && c[5] == 1 && c[6] == 1);
    assert_true(s->material[0].base_color[0] == 1); // not tinted
    glint_scene_destroy(&s);
}

static void long_lines_join_and_strange_words_are_left_out(void **state)
{
    (void)state;
    struct glint_scene *s = read_text(SQUARE "f 1 \\\n2 \\\r\n3\nl 1 2\np 1\nf 1 2\nwobble 7\n");
    assert_int_equal(s->mesh[0].triangles, 1);
    assert_true(model_warns(s, "3 lines, points"));
    assert_true(model_warns(s, "line 11 is left out: \"wobble\""));
    glint_scene_destroy(&s);
}

static void what_is_wrong_is_named_by_its_line(void **state)
{
    (void)state;
    refused("v 0 0\nf 1 1 1\n", "line 1: 3 numbers are expected, 2 are there");
    refused("v 0 0 nan\nf 1 1 1\n", "line 1: \"nan\" is no number");
    refused("v 0 inf 0\nf 1 1 1\n", "line 1: \"inf\" is no number");
    refused("v 0 0 1e999\nf 1 1 1\n", "line 1: 1e999 is outside of");
    refused("v 0 0 -1e13\nf 1 1 1\n", "line 1: -1e13 is outside of");
    refused(SQUARE "f 1 2 5\n", "line 5: vertex 5: the file has 4");
    refused(SQUARE "f 0 1 2\n", "line 5: \"0\" is no number of a vertex");
    refused(SQUARE "f -5 1 2\n", "line 5: vertex -5: the file has 4");
    refused(SQUARE "f 1/1 2/1 3/1\n", "line 5: texture coordinate 1: the file has 0");
    refused(SQUARE "f 1//2 2 3\n", "line 5: normal 2: the file has 0");
    refused(SQUARE "f 1 2 99999999999999999999\n", "line 5: \"99999999999999999999\" is no number");
    refused(SQUARE "f 1 2 3/1/1/1\n", "line 5: \"3/1/1/1\" is no corner");
    refused(SQUARE "f 1 2 /3\n", "line 5: \"/3\" is no corner");
    refused(SQUARE, "no faces: 4 vertices");
    refused("", "no faces");
}

static void every_cut_of_a_file_is_read_or_refused(void **state)
{
    (void)state;
    static const char text[] = "mtllib a b\n" SQUARE "vt 0 0\nvn 0 0 1\ns 3\no x\nusemtl y\n"
                               "f 1/1/1 2/1/1 \\\n 3/1/1 4\n";
    for (size_t n = 0; n < sizeof text; n++) {
        struct glint_scene *s = NULL;
        struct glint_error err = {0};
        uint8_t *cut = malloc(n ? n : 1);
        memcpy(cut, text, n);
        read_obj(&s, cut, n, &err);
        assert_true((s == NULL) == (err.status != GLINT_OK));
        glint_scene_destroy(&s);
        glint_error_finish(&err);
        free(cut);
    }
}

// ---- materials

static void phong_exponents_become_widths(void **state)
{
    (void)state;
    MTL("newmtl a\nKd 0.5 0.25 0.125\nKs 0.5 0.5 0.5\nNs 198\nillum 2\n");
    assert_true(m->base_color[0] == 0.5f && m->base_color[2] == 0.125f);
    assert_true(m->metallic == 0);
    // alpha = sqrt(2 / (198 + 2)) = 0.1 is the square of the roughness
    assert_true(fabsf(m->roughness * m->roughness - 0.1f) < 1e-6f);
    // Ks 0.5 reflects as much as index 1.5: 0.04
    assert_true(m->specular == 1 && m->specular_color[0] == 1);
    glint_scene_destroy(&s);
}

static void a_black_surface_that_shines_is_a_metal(void **state)
{
    (void)state;
    MTL("newmtl a\nKd 0 0 0\nKs 0.9 0.8 0.7\nNs 1000\n");
    assert_true(m->metallic == 1);
    assert_true(m->base_color[0] == 0.9f && m->base_color[2] == 0.7f);
    glint_scene_destroy(&s);
}

static void a_surface_without_highlight_is_matt(void **state)
{
    (void)state;
    MTL("newmtl a\nKd 1 1 1\nKs 1 1 1\nNs 1000\nillum 1\n");
    assert_true(m->specular == 0 && m->roughness == 1);
    glint_scene_destroy(&s);
}

static void dissolve_blends_and_refraction_is_glass(void **state)
{
    (void)state;
    {
        MTL("newmtl a\nKd 1 0 0\nd 0.25\n");
        assert_int_equal(m->alpha_mode, GLINT_ALPHA_BLEND);
        assert_true(m->opacity == 0.25f);
        glint_scene_destroy(&s);
    }
    {
        MTL("newmtl a\nTr 0.25\n");
        assert_true(m->opacity == 0.75f);
        glint_scene_destroy(&s);
    }
    {
        MTL("newmtl a\nKd 0 0 0\nTf 0.5 1 1\nNi 1.33\nd 0.1\nillum 7\n");
        assert_true(m->transmission == 1 && m->ior == 1.33f && !m->thin);
        assert_int_equal(m->alpha_mode, GLINT_ALPHA_OPAQUE);
        assert_true(m->base_color[0] == 0.5f && m->roughness == 0);
        glint_scene_destroy(&s);
    }
}

static void physical_parameters_go_first(void **state)
{
    (void)state;
    MTL("newmtl a\nKd 1 1 1\nKs 1 1 1\nNs 5\nPr 0.3\nPm 0.7\nPc 0.5\nPcr 0.1\nNi 1.45\nKe 2 3 4\n");
    assert_true(m->roughness == 0.3f && m->metallic == 0.7f);
    assert_true(m->clearcoat == 0.5f && m->clearcoat_roughness == 0.1f);
    assert_true(m->specular == 1 && m->specular_color[0] == 1 && m->ior == 1.45f);
    assert_true(m->emission[0] == 2 && m->emission[2] == 4);
    glint_scene_destroy(&s);
}

static void refuse_library(const char *text, const char *words)
{
    struct glint_file one = {"m.mtl", (const uint8_t *)text, strlen(text), false};
    struct glint_files all = {&one, 1};
    files = &all;
    refused("mtllib m.mtl\n" SQUARE "usemtl a\nf 1 2 3 4\n", words);
    files = NULL;
}

static void what_is_wrong_in_a_library_is_named_by_file_and_line(void **state)
{
    (void)state;
    refuse_library("newmtl a\nKd 1 nan 1\n", "m.mtl, line 2: \"nan\" is no share of light");
    refuse_library("newmtl a\nNs 1e999\n", "m.mtl, line 2: \"1e999\" is no number");
    refuse_library("Kd 1 1 1\n", "m.mtl, line 1: Kd comes before any newmtl");
    refuse_library("newmtl a\n\nmap_Kd -s 2 2 1 a b.png\n",
                   "m.mtl, line 3: \"a b.png\" is not among the files");
    refuse_library("newmtl a\nmap_Kd -clamp on\n", "m.mtl, line 2: the map names no file");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_square_is_two_triangles_of_four_vertices),
        cmocka_unit_test(numbers_may_be_relative_or_come_before_what_they_name),
        cmocka_unit_test(corners_that_agree_are_one_vertex),
        cmocka_unit_test(every_object_and_material_is_a_mesh_of_its_own),
        cmocka_unit_test(smoothing_groups_share_normals_across_an_edge),
        cmocka_unit_test(a_concave_polygon_keeps_its_area),
        cmocka_unit_test(colours_behind_positions_are_those_of_a_screen),
        cmocka_unit_test(long_lines_join_and_strange_words_are_left_out),
        cmocka_unit_test(what_is_wrong_is_named_by_its_line),
        cmocka_unit_test(every_cut_of_a_file_is_read_or_refused),
        cmocka_unit_test(phong_exponents_become_widths),
        cmocka_unit_test(a_black_surface_that_shines_is_a_metal),
        cmocka_unit_test(a_surface_without_highlight_is_matt),
        cmocka_unit_test(dissolve_blends_and_refraction_is_glass),
        cmocka_unit_test(physical_parameters_go_first),
        cmocka_unit_test(what_is_wrong_in_a_library_is_named_by_file_and_line),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
