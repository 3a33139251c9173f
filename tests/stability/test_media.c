// Media, solids that absorb or overlap, blended and single-sided surfaces: against closed forms.
#include "tests/stability/stable.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct offline o;

#define EYE(z) "'cameras':{'eye':{'yfov':0.02,'transform':{'translation':[0,0," #z "]}}}"
#define BLACK "'environment':{'radiance':[0,0,0]},"
#define WHITE "'environment':{'radiance':[1,1,1]},"
#define SHEETS "'meshes':{'sheet':{'primitive':'quad','size':[40,40]}},"

// With the standard error that the halves of each pixel tell: pixels need not show the same.
static struct stable_mean mean_of(char *scene, const char *job)
{
    struct glint_frame *f = stable_frame(&o, scene, stable_job(job));
    struct stable_mean m = stable_mean(f, "G");
    const float *v = glint_frame_find(f, "variance.G");
    double sum = 0.0;
    for (size_t i = 0; i < stable_pixels(f); i++)
        sum += v[i];
    m.error = sqrt(sum) / (double)stable_pixels(f);
    glint_frame_destroy(&f);
    return m;
}

// |z| < 4.892: a false alarm in 10^6.
static void assert_mean_of(const char *test, struct stable_mean m, double expected, double slack)
{
    assert_odds_of(test, m.mean - expected, m.error, slack);
}
#define assert_mean(m, expected, slack) assert_mean_of(__func__, m, expected, slack)

// ---- media

// A sheet of radiance 1, 5 m away in fog that only absorbs.
static void an_emitter_in_black_fog_fades_as_beer_says(void **state)
{
    (void)state;
    for (double density = 1e-3; density < 20; density *= 10) {
        char *scene = stable_text(
            "{" BLACK SHEETS "'materials':{'lamp':{'base_color':[0,0,0],'ior':1,"
            "'emission':[1,1,1]}},'instances':{'lamp':{'mesh':'sheet','material':'lamp'}},"
            "'media':{'fog':{'density':%.9g,'albedo':[0,0,0]}}," EYE(5) "}",
            density);
        assert_mean(mean_of(scene, "'resolution':[64,64],'stop':{'samples':64}"), exp(-5 * density),
                    1e-6);
    }
}

// The same from a diffuse floor that a lamp lights through the fog: two ways, 4 m and 3 m.
static void light_samples_are_dimmed_by_the_fog_they_cross(void **state)
{
    (void)state;
    const double density = 0.2;
    char *scene = stable_text(
        "{" BLACK SHEETS "'materials':{'floor':{'base_color':[0.5,0.5,0.5],'ior':1}},"
        "'instances':{'floor':{'mesh':'sheet','material':'floor'}},"
        "'lights':{'lamp':{'type':'point','intensity':9,'transform':{'translation':[0,0,3]}}},"
        "'media':{'fog':{'density':%.9g,'albedo':[0,0,0]}}," EYE(4) "}",
        density);
    // E = I / 9 at the foot of the lamp, L = albedo E / pi
    assert_mean(mean_of(scene, "'resolution':[32,32],'stop':{'samples':256}"),
                0.5 / M_PI * exp(-7 * density), 2e-4);
}

// One scattering of sunlight from above in a box of fog, seen along -z:
// L = albedo p E exp(-s h) (1 - exp(-s d)), h metres below the top, d deep.
static void fog_scatters_the_sun_once_as_the_integral_says(void **state)
{
    (void)state;
    const double density = 0.4, h = 1, d = 3, g[] = {0, 0.6, -0.6};
    for (int i = 0; i < 3; i++) {
        char *scene = stable_text(
            "{" BLACK "'lights':{'sun':{'type':'sun','intensity':10,'transform':{'rotation':"
            "[-0.70710678,0,0,0.70710678]}}},"
            "'media':{'fog':{'density':%.9g,'albedo':[0.8,0.8,0.8],'g':%.9g,"
            "'box':[-20,-20,-3,20,1,0]}}," EYE(5) "}",
            density, g[i]);
        const double phase = (1 - g[i] * g[i]) / (4 * M_PI * pow(1 + g[i] * g[i], 1.5));
        assert_mean(mean_of(scene, "'resolution':[64,64],'max_bounces':1,'stop':{'samples':64}"),
                    0.8 * phase * 10 * exp(-density * h) * (1 - exp(-density * d)), 1e-3 * phase);
    }
}

// Fog that absorbs nothing in light that is the same from everywhere cannot be seen.
static void white_fog_in_white_light_is_invisible(void **state)
{
    (void)state;
    const double density[] = {1e-30, 0.1, 2.0, 8.0}, g[] = {0, 1e-6, 0.7, -0.7, 0.9999, 1, -1};
    for (size_t i = 0; i < sizeof density / sizeof *density; i++)
        for (size_t k = 0; k < sizeof g / sizeof *g; k++) {
            if (density[i] > 1 && g[k] == -1)
                continue; // to and fro for ever
            char *scene =
                stable_text("{" WHITE "'media':{'fog':{'density':%.9g,'albedo':[1,1,1],'g':%.9g,"
                            "'box':[-1,-1,-1,1,1,1]}}," EYE(4) "}",
                            density[i], g[k]);
            assert_mean(mean_of(scene, "'resolution':[16,16],'max_bounces':1024,"
                                       "'stop':{'samples':64}"),
                        1.0, 1e-5);
        }
}

// Nor can it in a closed room whose walls glow alike: each vertex in the fog weighs what light samples
// find there against what its own directions do.
static void white_fog_in_a_glowing_room_is_invisible(void **state)
{
    (void)state;
    const double g[] = {0, 0.7, -0.7};
    for (size_t i = 0; i < sizeof g / sizeof *g; i++) {
        char *scene = stable_text(
            "{" BLACK "'materials':{'glow':{'base_color':[0,0,0],'ior':1,'emission':[1,1,1]}},"
            "'meshes':{'room':{'primitive':'box','size':[12,12,12]}},"
            "'instances':{'room':{'mesh':'room','material':'glow'}},"
            "'media':{'fog':{'density':1,'albedo':[1,1,1],'g':%.9g,'box':[-1,-1,-1,1,1,1]}}," EYE(
                4) "}",
            g[i]);
        assert_mean(mean_of(scene, "'resolution':[16,16],'max_bounces':256,'stop':{'samples':256}"),
                    1.0, 1e-5);
    }
}

static void fog_of_density_zero_is_none(void **state)
{
    (void)state;
    static const char *const media[] = {"", "'media':{'fog':{'density':0,'albedo':[1,1,1]}},"};
    struct glint_frame *f[2];
    for (int i = 0; i < 2; i++)
        f[i] = stable_frame(&o,
                            stable_text("{" WHITE SHEETS "'materials':{'m':{}},'instances':{'s':"
                                        "{'mesh':'sheet','material':'m'}},%s" EYE(5) "}",
                                        media[i]),
                            stable_job("'resolution':[16,16],'stop':{'samples':16}"));
    stable_assert_same(f[0], f[1]);
    glint_frame_destroy(&f[0]);
    glint_frame_destroy(&f[1]);
}

// All that has a length, times a power of two: fog and its box, smoked glass, a lens, the lamp.
static struct glint_frame *foggy_still_life(double s)
{
    return stable_frame(
        &o,
        stable_text(
            "{" BLACK "'materials':{'floor':{'base_color':[0.6,0.5,0.4]},'smoke':{'transmission':1,"
            "'roughness':0.1,'attenuation_color':[0.5,0.25,0.5],'attenuation_distance':%.17g}},"
            "'meshes':{'q':{'primitive':'quad','size':[%.17g,%.17g]},'s':{'primitive':'sphere',"
            "'radius':%.17g,'segments':24}},"
            "'instances':{'q':{'mesh':'q','material':'floor','transform':{'translation':"
            "[0,0,%.17g]}},'s':{'mesh':'s','material':'smoke'}},"
            "'lights':{'lamp':{'type':'point','intensity':%.17g,'transform':{'translation':"
            "[0,%.17g,%.17g]}}},"
            "'media':{'fog':{'density':%.17g,'albedo':[0.8,0.8,0.8],'g':0.5,"
            "'box':[%.17g,%.17g,%.17g,%.17g,%.17g,%.17g]}},"
            "'cameras':{'eye':{'yfov':0.6,'lens_radius':%.17g,'focus_distance':%.17g,"
            "'transform':{'translation':[0,0,%.17g]}}}}",
            0.5 * s, 9 * s, 9 * s, s, -2 * s, 40 * s * s, 3 * s, 2 * s, 0.25 / s, -2 * s, -2 * s,
            -1.5 * s, 2 * s, 2 * s, 2 * s, 0.0625 * s, 6 * s, 6 * s),
        stable_job("'resolution':[48,48],'max_bounces':6,'stop':{'samples':24}"));
}

static void fog_and_lenses_of_any_scale_keep_their_bits(void **state)
{
    (void)state;
    struct glint_frame *unit = foggy_still_life(1.0);
    assert_true(stable_mean(unit, "G").mean > 0.01);
    for (int k = -20; k <= 20; k += 20) {
        struct glint_frame *f = foggy_still_life(ldexp(1.0, k ? k : 10));
        const size_t equal = stable_equal(unit, f, "G");
        print_message("# 2^%d: %zu of %zu pixels equal\n", k ? k : 10, equal, stable_pixels(f));
        assert_true(equal >= stable_pixels(f) * 9999 / 10000);
        glint_frame_destroy(&f);
    }
    glint_frame_destroy(&unit);
}

static void impenetrable_fog_ends(void **state)
{
    (void)state;
    char *scene = stable_text("{" WHITE "'media':{'fog':{'density':1e30,'albedo':[1,1,1],"
                              "'box':[-1,-1,-1,1,1,1]}}," EYE(4) "}");
    struct glint_frame *f =
        stable_frame(&o, scene, stable_job("'resolution':[8,8],'stop':{'samples':4}"));
    assert_true(stable_most(f, "G") <= 1.0);
    glint_frame_destroy(&f);
}

// ---- solids

#define CUBES                                              \
    "'meshes':{'cube':{'primitive':'box','size':[1,1,1]}," \
    "'sheet':{'primitive':'quad','size':[40,40]}},"
#define GLASS(ior, priority) \
    "{'roughness':0,'transmission':1,'ior':" #ior ",'priority':" #priority "}"
// Of index 1, so that nothing is reflected; a quarter of the light is left after half a metre.
#define SMOKE                                  \
    "{'roughness':0,'transmission':1,'ior':1," \
    "'attenuation_color':[0.5,0.25,0.5],'attenuation_distance':0.5}"

// White light through a cube of 1 m.
static void a_solid_takes_what_beer_says(void **state)
{
    (void)state;
    char *scene =
        stable_text("{" WHITE CUBES "'materials':{'glass':" SMOKE "},"
                    "'instances':{'cube':{'mesh':'cube','material':'glass'}}," EYE(5) "}");
    assert_mean(mean_of(scene, "'resolution':[16,16],'stop':{'samples':16}"), 0.25 * 0.25, 1e-5);
}

// A lamp embedded in the cube, 0.3 m behind its face, and the camera inside, 0.2 m before its back.
static void what_is_inside_a_solid_is_seen_through_its_part(void **state)
{
    (void)state;
    char *lamp = stable_text(
        "{" BLACK CUBES "'materials':{'glass':" SMOKE ",'lamp':{'base_color':[0,0,0],"
        "'ior':1,'emission':[1,1,1]}},'instances':{'cube':{'mesh':'cube','material':'glass'},"
        "'lamp':{'mesh':'sheet','material':'lamp','transform':{'translation':[0,0,0.2],"
        "'scale':[0.01,0.01,1]}}}," EYE(5) "}");
    assert_mean(mean_of(lamp, "'resolution':[16,16],'stop':{'samples':16}"), pow(0.25, 0.6), 2e-5);
    char *eye =
        stable_text("{" WHITE CUBES "'materials':{'glass':" SMOKE "},"
                    "'instances':{'cube':{'mesh':'cube','material':'glass'}}," EYE(-0.3) "}");
    assert_mean(mean_of(eye, "'resolution':[16,16],'stop':{'samples':16}"), pow(0.25, 0.4), 2e-5);
}

// A block of glass, with or without others of lower priority in it and sticking out of it.
static void where_solids_overlap_the_highest_priority_is_there(void **state)
{
    (void)state;
    static const char *const more[] = {
        "", "'in':{'mesh':'cube','material':'low','transform':{'scale':[0.5,0.6,1.2]}},"
            "'in2':{'mesh':'cube','material':'lower','transform':{'scale':[0.8,0.3,1.4]}},"};
    struct stable_mean m[2];
    for (int i = 0; i < 2; i++)
        m[i] = mean_of(
            stable_text(
                "{" WHITE "'lights':{'lamp':{'type':'area','intensity':8,'size':[2,2],"
                "'transform':{'translation':[0.5,0.5,4]}}}," CUBES
                "'materials':{'high':" GLASS(1.5, 3) ",'low':" GLASS(1.8, 2) ",'lower':" GLASS(
                    1.2,
                    1) ",'floor':{'base_color':[0.2,0.7,0.4]}},"
                       "'instances':{%s'a':{'mesh':'cube','material':'high','transform':{'scale':"
                       "[1,1,2]}},'floor':{'mesh':'sheet','material':'floor','transform':{"
                       "'translation':[0,-0.8,0],'rotation':[-0.70710678,0,0,0.70710678]}}},"
                       "'cameras':{'eye':{'yfov':0.7,'transform':{'translation':[2.2,1.2,2.6],"
                       "'rotation':[-0.1515,0.3420,0.0558,0.9258]}}}}",
                more[i]),
            "'resolution':[48,32],'max_bounces':24,'stop':{'samples':64}");
    m[0].error = sqrt(m[0].error * m[0].error + m[1].error * m[1].error);
    assert_mean(m[0], m[1].mean, 1e-6); // of the same samples: far closer than chance
}

// Eight balls of clear glasses, one in the other or overlapping, in white light: nothing is lost,
// nothing is gained, but for what the angle between facets and their shading normals takes: 6e-3 of
// balls of 48 segments, 4e-4 of 160.
static void eight_nested_glasses_are_invisible_in_white_light(void **state)
{
    (void)state;
    static const double ball[8][4] = {
        {0, 0, 0, 2},     {0.3, 0, 0, 1.5},     {-0.4, 0.2, 0, 1.4}, {0, -0.5, 0.1, 1.2},
        {0.1, 0.1, 0, 1}, {0.2, 0.4, 0.3, 0.8}, {0, 0, -0.2, 0.6},   {0.1, 0.05, 0.1, 0.4}};
    static const double ior[8] = {1.1, 1.7, 1.3, 1.5, 1.2, 1.9, 1.4, 1.6};
    for (int inside = 0; inside < 2; inside++) {
        char material[2048] = "", instance[2048] = "";
        for (int i = 0; i < 8; i++) {
            snprintf(material + strlen(material), sizeof material - strlen(material),
                     "%s'%d':{'roughness':0,'transmission':1,'ior':%g,'priority':%d}", i ? "," : "",
                     i, ior[i], i + 1);
            snprintf(instance + strlen(instance), sizeof instance - strlen(instance),
                     "%s'%d':{'mesh':'ball','material':'%d','transform':{'translation':[%g,%g,%g],"
                     "'scale':[%g,%g,%g]}}",
                     i ? "," : "", i, i, ball[i][0], ball[i][1], ball[i][2], ball[i][3], ball[i][3],
                     ball[i][3]);
        }
        char *scene = stable_text(
            "{" WHITE "'meshes':{'ball':{'primitive':'sphere','segments':160}},'materials':{%s},"
            "'instances':{%s},'cameras':{'eye':{'yfov':0.5,'transform':{'translation':[%s]}}}}",
            material, instance, inside ? "0.1,0.05,0.1" : "0,0,7");
        assert_mean(mean_of(scene, "'resolution':[24,24],'max_bounces':1024,"
                                   "'accuracy':{'roulette':'none'},'stop':{'samples':16}"),
                    1.0, 2e-3);
    }
}

// Balls one in the other: eight are known, the ninth ends the path, and that is counted.
static void a_ninth_nested_solid_is_a_rejected_sample(void **state)
{
    (void)state;
    for (int balls = 8; balls <= 9; balls++) {
        char instance[2048] = "";
        for (int i = 0; i < balls; i++)
            snprintf(instance + strlen(instance), sizeof instance - strlen(instance),
                     "%s'%d':{'mesh':'ball','material':'glass','transform':{'scale':[%d,%d,%d]}}",
                     i ? "," : "", i, i + 1, i + 1, i + 1);
        char *scene = stable_text("{" WHITE "'meshes':{'ball':{'primitive':'sphere'}},'materials':{"
                                  "'glass':" GLASS(1.5, 1) "},'instances':{%s}," EYE(30) "}",
                                  instance);
        const uint64_t rejected =
            stable_rejected(&o, scene, stable_job("'resolution':[8,8],'stop':{'samples':4}"));
        assert_int_equal(rejected > 0, balls == 9);
    }
}

// ---- blended and single-sided surfaces

#define PANE(name, a, e)                                                          \
    "'" name "':{'base_color':[0,0,0],'ior':1,'alpha_mode':'blend','opacity':" #a \
    ",'emission':[" #e "," #e "," #e "],'double_sided':true},"

// Three panes before white, over each other as Porter and Duff have it; what the middle one hides of
// the last is its own coverage.
static void blended_panes_lie_over_each_other(void **state)
{
    (void)state;
    char *scene = stable_text(
        "{" WHITE SHEETS "'materials':{" PANE("a", 0.3, 2) PANE("b", 0.8, 0.5)
            PANE("c", 0.5,
                 4) "'none':{'base_color':[0,0,0],'ior':1,'alpha_mode':'blend','opacity':0,'"
                    "emission':[99,99,"
                    "99]}},'instances':{'a':{'mesh':'sheet','material':'a','transform':{'"
                    "translation':[0,0,2]}},"
                    "'b':{'mesh':'sheet','material':'b','transform':{'translation':[0,0,1]}},"
                    "'n':{'mesh':'sheet','material':'none','transform':{'translation':[0,0,0.5]}},"
                    "'c':{'mesh':'sheet','material':'c'}}," EYE(5) "}");
    const double behind = 0.5 * 4 + 0.5 * 1;
    assert_mean(mean_of(scene, "'resolution':[64,64],'stop':{'samples':64}"),
                0.3 * 2 + 0.7 * (0.8 * 0.5 + 0.2 * behind), 0.0);
}

// Light through a pane of opacity 0.6 that reflects nothing: the floor gets 0.4 of it.
static void blended_panes_let_their_share_of_light_through(void **state)
{
    (void)state;
    char *scene = stable_text(
        "{" BLACK SHEETS "'materials':{'floor':{'base_color':[0.5,0.5,0.5],'ior':1}," PANE(
            "pane", 0.6,
            0) "'unused':{}},'instances':{'floor':{'mesh':'sheet','material':'floor'},"
               "'pane':{'mesh':'sheet','material':'pane','transform':{'translation':[0,0,2]}}},"
               "'lights':{'lamp':{'type':'point','intensity':9,'transform':{'translation':[0,0,3]}}"
               "}," EYE(1) "}");
    assert_mean(mean_of(scene, "'resolution':[32,32],'stop':{'samples':256}"), 0.4 * 0.5 / M_PI,
                2e-4);
}

// The camera does not see the back of a single-sided sheet, but light is stopped by it.
static void single_sided_sheets_are_seen_from_their_front_only(void **state)
{
    (void)state;
    for (int turned = 0; turned < 2; turned++) {
        char *scene = stable_text(
            "{" BLACK SHEETS "'materials':{'sheet':{'base_color':[0,0,0],'ior':1,'double_sided':"
            "false,'emission':[3,3,3]},'lamp':{'base_color':[0,0,0],'ior':1,'emission':[1,1,1]}},"
            "'instances':{'sheet':{'mesh':'sheet','material':'sheet','transform':{'translation':"
            "[0,0,1],'rotation':[%s]}},'lamp':{'mesh':'sheet','material':'lamp'}}," EYE(5) "}",
            turned ? "0,1,0,0" : "0,0,0,1");
        assert_mean(mean_of(scene, "'resolution':[16,16],'stop':{'samples':16}"),
                    turned ? 1.0 : 3.0, 1e-6);
    }
    char *shade = stable_text(
        "{" BLACK SHEETS "'materials':{'floor':{'base_color':[0.5,0.5,0.5],'ior':1},'sheet':{"
        "'base_color':[0,0,0],'double_sided':false}},'instances':{'floor':{'mesh':'sheet',"
        "'material':'floor'},'sheet':{'mesh':'sheet','material':'sheet','transform':{"
        "'translation':[0,0,2],'rotation':[0,1,0,0]}}},'lights':{'lamp':{'type':'point',"
        "'intensity':9,'transform':{'translation':[0,0,3]}}}," EYE(5) "}");
    assert_mean(mean_of(shade, "'resolution':[16,16],'stop':{'samples':16}"), 0.0, 0.0);
}

// ---- parallel views

// Half of a picture 4 m high shows a sheet 2 m high, however far away it is.
static void an_orthographic_camera_shows_the_same_size_at_any_distance(void **state)
{
    (void)state;
    for (double z = 2; z < 1e4; z *= 7) {
        char *scene = stable_text(
            "{" BLACK SHEETS "'materials':{'lamp':{'base_color':[0,0,0],'ior':1,'emission':[1,1,1]}"
            "},'instances':{'lamp':{'mesh':'sheet','material':'lamp','transform':{'scale':"
            "[0.05,0.05,1]}}},'cameras':{'eye':{'projection':'orthographic','ymag':2,'transform':{"
            "'translation':[0,0,%.9g]}}}}",
            z);
        struct glint_frame *f =
            stable_frame(&o, scene,
                         stable_job("'resolution':[32,32],'filter':{'kind':'box',"
                                    "'width':1},'stop':{'samples':16}"));
        assert_float_equal(stable_mean(f, "G").mean, 0.25, 1e-6);
        glint_frame_destroy(&f);
    }
}

static int start(void **state)
{
    (void)state;
    offline_start(&o, offline_workers());
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
        cmocka_unit_test(an_emitter_in_black_fog_fades_as_beer_says),
        cmocka_unit_test(light_samples_are_dimmed_by_the_fog_they_cross),
        cmocka_unit_test(fog_scatters_the_sun_once_as_the_integral_says),
        cmocka_unit_test(white_fog_in_white_light_is_invisible),
        cmocka_unit_test(white_fog_in_a_glowing_room_is_invisible),
        cmocka_unit_test(fog_of_density_zero_is_none),
        cmocka_unit_test(fog_and_lenses_of_any_scale_keep_their_bits),
        cmocka_unit_test(impenetrable_fog_ends),
        cmocka_unit_test(a_solid_takes_what_beer_says),
        cmocka_unit_test(what_is_inside_a_solid_is_seen_through_its_part),
        cmocka_unit_test(where_solids_overlap_the_highest_priority_is_there),
        cmocka_unit_test(eight_nested_glasses_are_invisible_in_white_light),
        cmocka_unit_test(a_ninth_nested_solid_is_a_rejected_sample),
        cmocka_unit_test(blended_panes_lie_over_each_other),
        cmocka_unit_test(blended_panes_let_their_share_of_light_through),
        cmocka_unit_test(single_sided_sheets_are_seen_from_their_front_only),
        cmocka_unit_test(an_orthographic_camera_shows_the_same_size_at_any_distance),
    };
    return cmocka_run_group_tests(tests, start, finish);
}
