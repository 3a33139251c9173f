// Texture coordinates far from the origin: whole periods must not cost the fraction.
#include "tests/stability/stable.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define SIDE 6

// Black and white texels in turns, as a data URI.
static char *checker(void)
{
    float rgb[SIDE * SIDE * 3];
    for (int i = 0; i < SIDE * SIDE * 3; i++)
        rgb[i] = (float)((i / 3 % SIDE + i / 3 / SIDE) % 2);
    return stable_png(SIDE, SIDE, rgb);
}

// A quad that fills the picture and shows the checker as its emission, at uv from (u, v) to
// (u + du, v + dv).
static struct glint_frame *checkered(const char *wrap, double u, double v, double du, double dv)
{
    char *uri = checker();
    char *scene = stable_text(
        "{'images':{'c':{'data':'%s'}},'materials':{'m':{'base_color':[0,0,0],'ior':1,'emission':["
        "1,1,1],"
        "'emission_texture':{'image':'c','wrap_u':'%s','wrap_v':'%s'}}},"
        "'meshes':{'q':{'positions':[-1,-1,0,1,-1,0,1,1,0,-1,1,0],'indices':[0,1,2,0,2,3],"
        "'uvs':[%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g]}},"
        "'instances':{'q':{'mesh':'q','material':'m'}},"
        "'cameras':{'eye':{'yfov':0.6,'transform':{'translation':[0,0,3]}}}}",
        uri, wrap, wrap, u, v + dv, u + du, v + dv, u + du, v, u, v);
    free(uri);
    return stable_frame(&offline_crew, scene,
                        stable_job("'resolution':[64,64],'max_bounces':0,'stop':{'samples':16}"));
}

static void whole_periods_do_not_change_a_picture(void **state)
{
    (void)state;
    static const char *const wrap[] = {"repeat", "mirror"};
    static const double far[][2] = {{1e6, -1e6}, {-8, 123456}, {4194304, 2}};
    for (int w = 0; w < 2; w++) {
        struct glint_frame *near = checkered(wrap[w], 0, 0, 1.5, 1.5);
        assert_true(stable_most(near, "G") > 0.8 && stable_least(near, "G") < 0.2);
        for (int i = 0; i < 3; i++) {
            struct glint_frame *f = checkered(wrap[w], far[i][0], far[i][1], 1.5, 1.5);
            stable_assert_same(near, f);
            glint_frame_destroy(&f);
        }
        glint_frame_destroy(&near);
    }
}

static void clamped_coordinates_stay_on_the_border(void **state)
{
    (void)state;
    struct glint_frame *f = checkered("clamp", -1e6, 1e6, 2, 2); // the white texel in the corner
    assert_float_equal(stable_least(f, "G"), 1.0, 0.0);
    glint_frame_destroy(&f);
    f = checkered("clamp", 1e6, 1e6, 2, 2);
    assert_float_equal(stable_most(f, "G"), 0.0, 0.0);
    glint_frame_destroy(&f);
}

// A million periods on one quad: grey. 64 x 64 pixels of 16 samples; their spread gives the error.
static void million_periods_keep_the_mean(void **state)
{
    (void)state;
    static const double span[][4] = {
        {0, 0, 1e6, 1e6}, {0, 0, 1e6, 3}, {1e6, 0, 0.37, 1e6}, {-1e6, 1e5, 777777, 54321}};
    for (int i = 0; i < 4; i++) {
        struct glint_frame *f = checkered("repeat", span[i][0], span[i][1], span[i][2], span[i][3]);
        const struct stable_mean m = stable_mean(f, "G");
        print_message("# %.5f, standard error %.5f\n", m.mean, m.error);
        assert_odds(m.mean - 0.5, m.error, 0);
        glint_frame_destroy(&f);
    }
}

// Two instances of one stored mesh, of which one repeats its texture and the other clamps it.
static char *shared_mesh(const char *uri, const char *first, const char *second)
{
    enum { COPIES = 20000 }; // enough triangles for the mesh to be stored once and placed twice
    char *index = malloc(COPIES * 12 + 1), *end = index;
    assert_non_null(index);
    for (int i = 0; i < COPIES; i++)
        end += sprintf(end, "%s0,1,2,0,2,3", i ? "," : "");
    char *scene = stable_text(
        "{'images':{'c':{'data':'%s'}},'environment':{'radiance':[1,1,1]},'materials':{"
        "'a':{'ior':1,'base_color_texture':{'image':'c','wrap_u':'%s','wrap_v':'%s'}},"
        "'b':{'ior':1,'base_color_texture':{'image':'c','wrap_u':'%s','wrap_v':'%s'}}},"
        "'meshes':{'q':{'positions':[-1,-1,0,1,-1,0,1,1,0,-1,1,0],'indices':[%s],"
        "'uvs':[6,8,8,8,8,6,6,6]}},"
        "'instances':{'a':{'mesh':'q','material':'a','transform':{'translation':[-1,0,0]}},"
        "'b':{'mesh':'q','material':'b','transform':{'translation':[1,0,0]}}},"
        "'cameras':{'eye':{'yfov':0.6,'transform':{'translation':[0,0,3]}}}}",
        uri, first, first, second, second, index);
    free(index);
    return scene;
}

static double mean_of_half(const struct glint_frame *f, uint32_t half)
{
    const float *p = glint_frame_find(f, "G");
    double sum = 0.0;
    for (size_t i = 0; i < stable_pixels(f); i++)
        sum += i % f->width / (f->width / 2) == half ? p[i] : 0.0;
    return 2.0 * sum / (double)stable_pixels(f);
}

static void shared_mesh_repeats_and_clamps_as_its_materials_say(void **state)
{
    (void)state;
    static const char *const wrap[] = {"repeat", "clamp"};
    char *uri = checker();
    for (uint32_t clamped = 0; clamped < 2; clamped++) {
        struct glint_frame *f = stable_frame(
            &offline_crew, shared_mesh(uri, wrap[clamped == 0], wrap[clamped == 1]),
            stable_job(
                "'resolution':[32,32],'filter':{'kind':'box','width':1},'stop':{'samples':16}"));
        assert_float_equal(mean_of_half(f, clamped), 0.0, 1e-6); // the corner's black texel
        assert_float_equal(mean_of_half(f, 1 - clamped), 0.5, 0.03);
        glint_frame_destroy(&f);
    }
    free(uri);
}

// A quad that fills the picture and emits the checker. texture, mesh: more members of both.
static struct glint_frame *mapped(const char *texture, const char *mesh)
{
    char *uri = checker();
    char *scene = stable_text(
        "{'images':{'c':{'data':'%s'}},'materials':{'m':{'base_color':[0,0,0],'ior':1,'emission':["
        "1,1,1],'emission_texture':{'image':'c'%s}}},"
        "'meshes':{'q':{'positions':[-1,-1,0,1,-1,0,1,1,0,-1,1,0],'indices':[0,1,2,0,2,3],%s}},"
        "'instances':{'q':{'mesh':'q','material':'m'}},"
        "'cameras':{'eye':{'yfov':0.6,'transform':{'translation':[0,0,3]}}}}",
        uri, texture, mesh);
    free(uri);
    return stable_frame(
        &offline_crew, scene,
        stable_job("'resolution':[64,64],'max_bounces':0,'filter':{'kind':'box','width':1},"
                   "'stop':{'samples':16}"));
}

#define UVS "'uvs':[0,1,1,1,1,0,0,0]"

// Corners of the unit square under translation, rotation and scale, the last applied first, as
// KHR_texture_transform has it.
static char *transformed_corners(const double offset[2], double rotation, const double scale[2])
{
    static const double corner[4][2] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    double t[4][2];
    for (int i = 0; i < 4; i++) {
        const double u = scale[0] * corner[i][0], v = scale[1] * corner[i][1];
        t[i][0] = offset[0] + cos(rotation) * u + sin(rotation) * v;
        t[i][1] = offset[1] - sin(rotation) * u + cos(rotation) * v;
    }
    return stable_text("'uvs':[%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g]", t[0][0], t[0][1], t[1][0],
                       t[1][1], t[2][0], t[2][1], t[3][0], t[3][1]);
}

static double largest_difference(const struct glint_frame *a, const struct glint_frame *b)
{
    const float *p = glint_frame_find(a, "G"), *q = glint_frame_find(b, "G");
    double most = 0.0;
    for (size_t i = 0; i < stable_pixels(a); i++)
        most = fmax(most, fabs((double)p[i] - (double)q[i]));
    return most;
}

static void a_transformed_texture_is_one_with_transformed_coordinates(void **state)
{
    (void)state;
    static const struct {
        double offset[2], rotation, scale[2];
    } use[] = {{{0.25, 0}, 0, {1, 1}},   {{0, -0.4}, 0, {1, 1}},  {{0, 0}, 0.6, {1, 1}},
               {{0, 0}, 0, {1.5, 0.5}},  {{0, 0}, 1.2, {0.7, 2}}, {{0.3, 0.1}, -0.8, {1.3, -1}},
               {{1000, -7}, 0.1, {1, 1}}};
    struct glint_frame *plain = mapped("", UVS);
    for (size_t i = 0; i < sizeof use / sizeof *use; i++) {
        char *texture = stable_text(",'offset':[%.9g,%.9g],'rotation':%.9g,'scale':[%.9g,%.9g]",
                                    use[i].offset[0], use[i].offset[1], use[i].rotation,
                                    use[i].scale[0], use[i].scale[1]);
        char *corners = transformed_corners(use[i].offset, use[i].rotation, use[i].scale);
        struct glint_frame *f = mapped(texture, UVS), *expected = mapped("", corners);
        // 6 texels, a float's rounding at 1000 is 3e-5 and the steepest slope 1 a texel.
        assert_float_equal(largest_difference(f, expected), 0.0, 1e-3);
        assert_true(largest_difference(f, plain) > 0.1);
        glint_frame_destroy(&f);
        glint_frame_destroy(&expected);
        free(texture);
        free(corners);
    }
    glint_frame_destroy(&plain);
}

static void whole_periods_are_nothing_to_transforms_by_whole_numbers(void **state)
{
    (void)state;
    static const char far[] = "'uvs':[1000000,-999999,1000001,-999999,1000001,-1000000,1000000,"
                              "-1000000]";
    struct glint_frame *near = mapped(",'scale':[3,2],'offset':[0.125,0]", UVS);
    struct glint_frame *f = mapped(",'scale':[3,2],'offset':[0.125,0]", far);
    stable_assert_same(near, f);
    glint_frame_destroy(&near);
    glint_frame_destroy(&f);
}

static void the_second_coordinates_are_read_where_a_texture_says_so(void **state)
{
    (void)state;
    static const char both[] = "'uvs':[0.1,0.1,0.1,0.1,0.1,0.1,0.1,0.1],"
                               "'uvs1':[0,1,1,1,1,0,0,0]";
    struct glint_frame *first = mapped("", UVS), *second = mapped(",'uv_set':1", both);
    struct glint_frame *neither = mapped("", both);
    stable_assert_same(first, second);
    assert_true(largest_difference(first, neither) > 0.1);
    glint_frame_destroy(&first);
    glint_frame_destroy(&second);
    glint_frame_destroy(&neither);
}

// Texel that a pixel's border is in; the picture shows 3 tan(0.3) of the quad's 1.
static double texel_at(double pixel)
{
    return (0.5 + (pixel / 32 - 1) * 1.5 * tan(0.3)) * SIDE;
}

// Pixels that lie inside of one texel have its colour, without a trace of its neighbours.
static void nearest_texels_have_hard_edges(void **state)
{
    (void)state;
    struct glint_frame *f = mapped(",'filter':'nearest'", UVS);
    const float *p = glint_frame_find(f, "G");
    uint32_t inside = 0;
    for (int y = 0; y < 64; y++)
        for (int x = 0; x < 64; x++) {
            const double u = texel_at(x), v = texel_at(y);
            if (floor(u + 1e-4) != floor(texel_at(x + 1) - 1e-4) ||
                floor(v + 1e-4) != floor(texel_at(y + 1) - 1e-4))
                continue;
            inside++;
            const double expected = ((int)u + (int)v) % 2;
            assert_float_equal(p[64 * y + x], expected, 0.0);
        }
    assert_in_range(inside, 3000, 4096);
    glint_frame_destroy(&f);
}

// A white quad in white light shows the colours of its vertices, and is there where their opacity
// is above the cutoff.
static void vertex_colours_tint_and_mask(void **state)
{
    (void)state;
    char *scene = stable_text(
        "{'environment':{'radiance':[1,1,1]},'materials':{'m':{'ior':1,'alpha_mode':'mask'}},"
        "'meshes':{'q':{'positions':[-1,-1,0,1,-1,0,1,1,0,-1,1,0],'indices':[0,1,2,0,2,3],"
        "'colors':[0,0,0.5,0, 1,0,0.5,1, 1,1,0.5,1, 0,1,0.5,0]}},"
        "'instances':{'q':{'mesh':'q','material':'m'}},"
        "'cameras':{'eye':{'yfov':0.6,'transform':{'translation':[0,0,3]}}}}");
    struct glint_frame *f = stable_frame(
        &offline_crew, scene,
        stable_job("'resolution':[64,64],'filter':{'kind':'box','width':1},'stop':{'samples':16}"));
    const float *r = glint_frame_find(f, "R"), *g = glint_frame_find(f, "G");
    const float *b = glint_frame_find(f, "B"), *a = glint_frame_find(f, "A");
    for (size_t i = 0; i < stable_pixels(f); i++) {
        const double x = texel_at((double)(i % 64) + 0.5) / SIDE;
        const double y = 1 - texel_at((double)(i / 64) + 0.5) / SIDE;
        const bool there = i % 64 >= 32;
        assert_float_equal(a[i], there, 0.0);
        if (!there)
            continue;
        assert_float_equal(r[i], x, 0.01); // half a pixel and the jitter of 16 samples
        assert_float_equal(g[i], y, 0.01);
        assert_float_equal(b[i], 0.5, 1e-5);
    }
    glint_frame_destroy(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole_periods_do_not_change_a_picture),
        cmocka_unit_test(clamped_coordinates_stay_on_the_border),
        cmocka_unit_test(shared_mesh_repeats_and_clamps_as_its_materials_say),
        cmocka_unit_test(million_periods_keep_the_mean),
        cmocka_unit_test(a_transformed_texture_is_one_with_transformed_coordinates),
        cmocka_unit_test(whole_periods_are_nothing_to_transforms_by_whole_numbers),
        cmocka_unit_test(the_second_coordinates_are_read_where_a_texture_says_so),
        cmocka_unit_test(nearest_texels_have_hard_edges),
        cmocka_unit_test(vertex_colours_tint_and_mask),
    };
    return cmocka_run_group_tests(tests, offline_crew_start, offline_crew_finish);
}
