// Texture coordinates far from the origin: whole periods must not cost the fraction.
#include "tests/stability/stable.h"

#include <stdio.h>
#include <stdlib.h>

static struct offline o;

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
    return stable_frame(&o, scene,
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
        assert_float_equal(m.mean, 0.5, 4.9 * m.error);
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
            &o, shared_mesh(uri, wrap[clamped == 0], wrap[clamped == 1]),
            stable_job(
                "'resolution':[32,32],'filter':{'kind':'box','width':1},'stop':{'samples':16}"));
        assert_float_equal(mean_of_half(f, clamped), 0.0, 1e-6); // the corner's black texel
        assert_float_equal(mean_of_half(f, 1 - clamped), 0.5, 0.03);
        glint_frame_destroy(&f);
    }
    free(uri);
}

static int start(void **state)
{
    (void)state;
    offline_start(&o, 2);
    return 0;
}

static int finish(void **state)
{
    (void)state;
    offline_finish(&o);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole_periods_do_not_change_a_picture),
        cmocka_unit_test(clamped_coordinates_stay_on_the_border),
        cmocka_unit_test(shared_mesh_repeats_and_clamps_as_its_materials_say),
        cmocka_unit_test(million_periods_keep_the_mean),
    };
    return cmocka_run_group_tests(tests, start, finish);
}
