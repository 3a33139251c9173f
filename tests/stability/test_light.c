// Hard cases of light transport: what a picture must show where naive arithmetic overflows, cancels
// or loops. Statistical bounds are 4.9 standard errors.
#include "tests/stability/stable.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define UNIT 0x1p-24

// Two mirrors of albedo r that face each other and emit e: N hits show e (1 - r^N) / (1 - r).
static double facing_mirrors(float r, unsigned hits)
{
    struct glint_frame *f = stable_frame(
        &offline_crew,
        stable_text(
            "{'materials':{'m':{'base_color':[%.9g,%.9g,%.9g],'metallic':1,'roughness':0,"
            "'emission':[3,3,3]}},'meshes':{'q':{'primitive':'quad','size':[64,64]}},"
            "'instances':{'a':{'mesh':'q','material':'m','transform':{'translation':[0,0,-1]}},"
            "'b':{'mesh':'q','material':'m','transform':{'translation':[0,0,1]}}},"
            "'cameras':{'eye':{'yfov':1e-3}}}",
            r, r, r),
        stable_text("{'scene':'s','outputs':['beauty'],'resolution':[1,1],'max_bounces':%u,"
                    "'accuracy':{'roulette':'none'},'stop':{'samples':2}}",
                    hits - 1));
    const double seen = stable_most(f, "G");
    glint_frame_destroy(&f);
    return seen;
}

static void facing_mirrors_sum_a_geometric_series(void **state)
{
    (void)state;
    static const float albedo[] = {0.5f, 0.9f, 1.0f};
    static const unsigned hits[] = {1, 2, 65, 1025};
    for (int a = 0; a < 3; a++)
        for (int h = 0; h < 4; h++) {
            const double r = albedo[a], n = hits[h];
            const double want = r < 1.0 ? 3.0 * (1.0 - pow(r, n)) / (1.0 - r) : 3.0 * n;
            const double seen = facing_mirrors(albedo[a], hits[h]);
            if (fabs(seen / want - 1.0) > 4.0 * n * UNIT)
                fail_msg("albedo %g, %u hits: %.9g instead of %.9g", r, hits[h], seen, want);
        }
}

// Two rooms side by side, one lamp in each: one gives 10^30 of the other.
static struct glint_frame *uneven_lamps(double scale)
{
    return stable_frame(
        &offline_crew,
        stable_text(
            "{'materials':{'grey':{'base_color':[0.5,0.5,0.5],'roughness':0.5},"
            "'bright':{'base_color':[0,0,0],'emission':[%.9g,%.9g,%.9g]},"
            "'dim':{'base_color':[0,0,0],'emission':[%.9g,%.9g,%.9g]}},"
            "'meshes':{'room':{'primitive':'box','size':[2,2,6]},'lamp':{'primitive':'quad'}},"
            "'instances':{'l':{'mesh':'room','material':'grey','transform':{'translation':[-1,0,0]}"
            "},"
            "'r':{'mesh':'room','material':'grey','transform':{'translation':[1.01,0,0]}},"
            "'a':{'mesh':'lamp','material':'bright','transform':{'translation':[-1,0.9,-1],'"
            "rotation':[1,0,0,1]}},"
            "'b':{'mesh':'lamp','material':'dim','transform':{'translation':[1.01,0.9,-1],'"
            "rotation':[1,0,0,1]}}},"
            "'cameras':{'l':{'yfov':1,'transform':{'translation':[-1,0,2]}},"
            "'r':{'yfov':1,'transform':{'translation':[1.01,0,2]}}}}",
            1e10 * scale, 1e10 * scale, 1e10 * scale, 1e-20 * scale, 1e-20 * scale, 1e-20 * scale),
        stable_job("'camera':'r','resolution':[32,32],'max_bounces':4,'stop':{'samples':32}"));
}

// Upwards further than down: a sum takes what is below 2^-100 for nothing (gk_film.h).
static void lights_thirty_decades_apart_scale_by_bits(void **state)
{
    (void)state;
    struct glint_frame *base = uneven_lamps(1.0);
    assert_true(stable_mean(base, "G").mean > 0.0);
    assert_true(stable_most(base, "G") < 1e-19); // nothing of the bright room
    for (int k = -10; k <= 30; k += 40) {
        struct glint_frame *f = uneven_lamps(ldexp(1.0, k));
        const float *p = glint_frame_find(base, "G"), *q = glint_frame_find(f, "G");
        for (size_t i = 0; i < stable_pixels(f); i++)
            assert_true(q[i] == ldexpf(p[i], k));
        glint_frame_destroy(&f);
    }
    glint_frame_destroy(&base);
}

// The brightest emission that a scene may have: no sum over- or underflows.
static void brightest_allowed_light_stays_finite(void **state)
{
    (void)state;
    struct glint_frame *f = stable_frame(
        &offline_crew,
        stable_text(
            "{'materials':{'m':{'base_color':[1,1,1],'ior':1,'emission':[1e20,1e20,0]}},"
            "'meshes':{'room':{'primitive':'box'}},"
            "'instances':{'r':{'mesh':'room','material':'m'}},'cameras':{'eye':{'yfov':1}}}"),
        stable_job("'resolution':[8,8],'max_bounces':16,'stop':{'samples':16}"));
    assert_true(stable_least(f, "G") > 1e20);
    assert_float_equal(stable_most(f, "B"), 0.0, 0.0);
    glint_frame_destroy(&f);
}

// A clear block of flat faces loses no path: every pixel shows the furnace.
static void clear_blocks_of_any_index_vanish_in_a_furnace(void **state)
{
    (void)state;
    static const double ior[] = {1.0, 1.000001, 1.0002, 1.1, 10.0};
    for (int i = 0; i < 5; i++) {
        struct glint_frame *f = stable_frame(
            &offline_crew,
            stable_text("{'environment':{'radiance':[1,1,1]},'materials':{'m':{'transmission':1,"
                        "'roughness':0,'ior':%.9g}},'meshes':{'b':{'primitive':'box'}},"
                        "'instances':{'b':{'mesh':'b','material':'m','transform':{'rotation':[0.3,"
                        "0.5,0.1,0.8]}}},"
                        "'cameras':{'eye':{'yfov':0.5,'transform':{'translation':[0,0,3]}}}}",
                        ior[i]),
            stable_job("'resolution':[32,32],'max_bounces':1024,'accuracy':{'roulette':'none'},"
                       "'stop':{'samples':16}"));
        print_message("# index %.7g: %.7g to %.7g\n", ior[i], stable_least(f, "G"),
                      stable_most(f, "G"));
        assert_float_equal(stable_least(f, "G"), 1.0, 1e-3);
        assert_float_equal(stable_most(f, "G"), 1.0, 1e-3);
        glint_frame_destroy(&f);
    }
}

// A quad seen from so near its plane that the cosine is 10^-k, and a sun as low.
static struct glint_frame *grazing_view(const char *material, double cosine, const char *job)
{
    return stable_frame(
        &offline_crew,
        stable_text(
            "{'environment':{'radiance':[1,1,1]},'materials':{'m':{%s}},"
            "'meshes':{'q':{'primitive':'quad','size':[20,20]}},"
            "'instances':{'q':{'mesh':'q','material':'m','transform':{'rotation':[-1,0,0,1]}}},"
            "'cameras':{'eye':{'yfov':%.9g,'transform':{'translation':[0,%.9g,9]}}}}",
            material, fmax(4.0 * cosine, 1e-6), 9.0 * cosine),
        stable_job(job));
}

#define GRAZING(microfacet)                                       \
    "'resolution':[16,32],'max_bounces':4,'stop':{'samples':32}," \
    "'accuracy':{'microfacet':'" microfacet "'}"

// What the table of multiple scattering is off by may be gained, where it is read.
static const struct {
    const char *job;
    double slack;
} scattering[] = {{GRAZING("single"), 1e-5}, {GRAZING("multiple"), 3e-3}};

static void grazing_views_are_finite_and_gain_nothing(void **state)
{
    (void)state;
    static const char *const material[] = {"'ior':1",
                                           "'metallic':1,'roughness':0.05",
                                           "'metallic':1,'roughness':0.6",
                                           "'roughness':0.3",
                                           "'roughness':0",
                                           "'transmission':1,'roughness':0.2",
                                           "'transmission':1,'roughness':0.2,'thin':true"};
    for (size_t m = 0; m < sizeof material / sizeof *material; m++)
        for (double cosine = 1e-3; cosine > 5e-9; cosine *= 1e-1)
            for (int s = 0; s < 2; s++) {
                struct glint_frame *f = grazing_view(material[m], cosine, scattering[s].job);
                const struct stable_mean seen = stable_mean(f, "G");
                if (seen.mean > 1.0 + 4.9 * seen.error + scattering[s].slack || seen.mean < 0.3)
                    fail_msg("%s at cosine %g: %g", material[m], cosine, seen.mean);
                glint_frame_destroy(&f);
            }
}

// A closed room whose vertices have normals in any direction, also outwards, below a strong sky.
static char *misled_room(const char *material)
{
    static const float corner[8][3] = {{-2, -1, -2}, {2, -1, -2}, {2, 1, -2}, {-2, 1, -2},
                                       {-2, -1, 2},  {2, -1, 2},  {2, 1, 2},  {-2, 1, 2}};
    static const int face[12][3] = {{0, 1, 2}, {0, 2, 3}, {4, 6, 5}, {4, 7, 6},
                                    {0, 5, 1}, {0, 4, 5}, {3, 2, 6}, {3, 6, 7},
                                    {0, 3, 7}, {0, 7, 4}, {1, 5, 6}, {1, 6, 2}};
    char positions[4096], normals[8192];
    int p = 0, n = 0;
    uint64_t seed = 7;
    for (int i = 0; i < 36; i++) {
        const float *at = corner[face[i / 3][i % 3]];
        p += snprintf(positions + p, sizeof positions - (size_t)p, "%s%g,%g,%g", i ? "," : "",
                      at[0], at[1], at[2]);
        n += snprintf(normals + n, sizeof normals - (size_t)n, "%s%.6f,%.6f,%.6f", i ? "," : "",
                      stable_random(&seed) - 0.5, stable_random(&seed) - 0.5,
                      stable_random(&seed) - 0.5);
    }
    return stable_text(
        "{'environment':{'radiance':[1e6,1e6,1e6]},'lights':{'sun':{'type':'sun','intensity':1e6,"
        "'transform':{'rotation':[-0.5,0.2,0.1,0.8]}}},'materials':{'m':{%s}},"
        "'meshes':{'r':{'positions':[%s],'normals':[%s]}},"
        "'instances':{'r':{'mesh':'r','material':'m'}},'cameras':{'eye':{'yfov':1.5}}}",
        material, positions, normals);
}

static void normals_below_the_horizon_leak_nothing_through_a_wall(void **state)
{
    (void)state;
    static const char *const material[] = {"'ior':1", "'metallic':1,'roughness':0.3",
                                           "'metallic':1,'roughness':0", "'roughness':0.1"};
    for (int m = 0; m < 4; m++) {
        struct glint_frame *f =
            stable_frame(&offline_crew, misled_room(material[m]),
                         stable_job("'resolution':[64,64],'max_bounces':6,'stop':{'samples':48}"));
        assert_float_equal(stable_most(f, "G"), 0.0, 0.0);
        glint_frame_destroy(&f);
    }
}

// A ball in a sky that changes smoothly: just above the roughness where the lobe becomes a delta,
// and at it.
static double ball_under_gradient(const char *sky, const char *material, double roughness)
{
    struct glint_frame *f = stable_frame(
        &offline_crew,
        stable_text("{'images':{'sky':{'data':'%s'}},'environment':{'image':'sky'},"
                    "'materials':{'m':{%s,'roughness':%.9g}},'meshes':{'s':{'primitive':'sphere','"
                    "segments':48}},"
                    "'instances':{'s':{'mesh':'s','material':'m'}},"
                    "'cameras':{'eye':{'yfov':0.6,'transform':{'translation':[0,0,4]}}}}",
                    sky, material, roughness),
        stable_job("'resolution':[32,32],'max_bounces':16,'stop':{'samples':64}"));
    const double mean = stable_mean(f, "G").mean;
    glint_frame_destroy(&f);
    return mean;
}

static void roughness_near_zero_continues_roughness_zero(void **state)
{
    (void)state;
    float sky[16 * 8 * 3];
    for (int i = 0; i < 16 * 8 * 3; i++)
        sky[i] = 0.25f + 0.125f * (float)(8 - abs(8 - i / 3 % 16)) / 2.0f;
    char *uri = stable_hdr(16, 8, sky);
    static const char *const material[] = {"'metallic':1", "'transmission':1,'ior':1.5",
                                           "'base_color':[0.2,0.2,0.2]"};
    for (int m = 0; m < 3; m++) {
        const double rough = ball_under_gradient(uri, material[m], 0.0317),
                     smooth = ball_under_gradient(uri, material[m], 0.0);
        print_message("# %s: %.6f and %.6f\n", material[m], rough, smooth);
        assert_float_equal(rough, smooth, 1e-3);
    }
    free(uri);
}

// ---- more lamps than are all asked

enum { LAMPS = 40 }; // more than a grid is made from, fewer than sixteen candidates are drawn of

// Writes lamps around the origin of the plane z = 0: half of them low, at -x, half high, at +x.
// Returns what the low ones bring there, seen as radiance of a white surface.
static double print_lamps(FILE *text)
{
    uint64_t seed = 5;
    double sum = 0.0;
    for (int i = 0; i < LAMPS; i++) {
        const bool low = i % 2 == 0;
        const float power = (float)(1.0 + 2.0 * stable_random(&seed));
        const float x = (float)(1.0 + stable_random(&seed)) * (low ? -1 : 1);
        const float y = (float)(2.0 * stable_random(&seed) - 1.0);
        const float z = (float)((low ? 0.25 : 2.0) * (1.0 + stable_random(&seed)));
        const double square = (double)x * x + (double)y * y + (double)z * z;
        fprintf(text,
                "%s'l%d':{'type':'point','intensity':%.9g,'transform':{'translation':"
                "[%.9g,%.9g,%.9g]}}",
                i ? "," : "", i, power, x, y, z);
        sum += low ? power * z / (square * sqrt(square)) / M_PI : 0.0;
    }
    return sum;
}

// A sheet hides the high lamps, which promise most. n = 262144, s = 0.5 of what is seen, so that a
// bias of d = 0.008 of it shows.
static void lamps_in_a_grid_bring_what_each_of_them_does(void **state)
{
    (void)state;
    char *lamps = NULL;
    size_t size = 0;
    FILE *text = open_memstream(&lamps, &size);
    assert_non_null(text);
    const double want = print_lamps(text);
    fclose(text);
    char *scene = stable_text(
        "{'lights':{%s},'materials':{'m':{'ior':1,'base_color':[1,1,1]},"
        "'black':{'ior':1,'base_color':[0,0,0]}},"
        "'meshes':{'q':{'primitive':'quad','size':[9,9]}},"
        "'instances':{'floor':{'mesh':'q','material':'m'},'sheet':{'mesh':'q','material':'black',"
        "'transform':{'translation':[4.501,0,0.2]}}},'cameras':{'eye':{'projection':"
        "'orthographic','ymag':1e-4,'transform':{'translation':[0,0,0.1]}}}}",
        lamps);
    free(lamps);
    struct glint_frame *f =
        stable_frame(&offline_crew, scene,
                     stable_text("{'scene':'s','outputs':['beauty'],'resolution':[32,32],"
                                 "'max_bounces':1,'stop':{'samples':%u}}",
                                 odds_samples(256)));
    const struct stable_mean seen = stable_mean(f, "G");
    print_message("# %.6g of %.6g, 1 se %.2g\n", seen.mean, want, seen.error);
    assert_odds(seen.mean - want, seen.error, 1e-4 * want);
    glint_frame_destroy(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(facing_mirrors_sum_a_geometric_series),
        cmocka_unit_test(lights_thirty_decades_apart_scale_by_bits),
        cmocka_unit_test(brightest_allowed_light_stays_finite),
        cmocka_unit_test(clear_blocks_of_any_index_vanish_in_a_furnace),
        cmocka_unit_test(grazing_views_are_finite_and_gain_nothing),
        cmocka_unit_test(normals_below_the_horizon_leak_nothing_through_a_wall),
        cmocka_unit_test(roughness_near_zero_continues_roughness_zero),
        cmocka_unit_test(lamps_in_a_grid_bring_what_each_of_them_does),
    };
    return cmocka_run_group_tests(tests, offline_crew_start, offline_crew_finish);
}
