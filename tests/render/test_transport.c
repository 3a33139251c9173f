// What light must do whatever the renderer: furnaces, closed rooms, scaling, and the same bits for
// any number of workers. Seeds are fixed; statistical bounds are stated beside each test.
#include "tests/odds.h"
#include "tests/render/offline.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct glint_frame *render_text(const char *scene, const char *job)
{
    glint_resident *resident = offline_load_text(&offline_crew, scene);
    struct glint_frame *frame = offline_frame(&offline_crew, resident, job, 0);
    glint_resident_release(&resident);
    return frame;
}

// A frame, and what it took.
struct traced {
    struct glint_frame *frame;
    struct glint_render_state state;
};

static struct traced traced_text(const char *scene, const char *text)
{
    glint_resident *resident = offline_load_text(&offline_crew, scene);
    struct glint_job *job = offline_job(text);
    struct glint_error err = {0};
    glint_render *render = NULL;
    struct traced t = {.frame = NULL};
    if (glint_render_create(&render, offline_crew.devices, resident, NULL, job, &err))
        offline_die("render", &err);
    offline_render(&offline_crew, render);
    if (glint_render_frame(render, job->outputs, &t.frame, NULL, &err))
        offline_die("frame", &err);
    glint_render_state(render, &t.state);
    glint_render_destroy(&render);
    glint_job_destroy(&job);
    glint_resident_release(&resident);
    return t;
}

static size_t pixels(const struct glint_frame *f)
{
    return (size_t)f->width * f->height;
}

static double mean_of(const struct glint_frame *f, const char *channel)
{
    const float *p = glint_frame_find(f, channel);
    double sum = 0.0;
    for (size_t i = 0; i < pixels(f); i++)
        sum += p[i];
    return sum / (double)pixels(f);
}

static double most_of(const struct glint_frame *f, const char *channel)
{
    const float *p = glint_frame_find(f, channel);
    double most = -INFINITY;
    for (size_t i = 0; i < pixels(f); i++)
        most = fmax(most, p[i]);
    return most;
}

// Of pixels that all show the same but for noise: the mean's standard error.
static double error_of_even(const struct glint_frame *f)
{
    const float *p = glint_frame_find(f, "G");
    const double mean = mean_of(f, "G"), n = (double)pixels(f);
    double square = 0.0;
    for (size_t i = 0; i < pixels(f); i++)
        square += (p[i] - mean) * (p[i] - mean);
    return sqrt(square / (n * (n - 1.0)));
}

// Of any picture, by what its halves tell of each pixel.
static double error_of_any(const struct glint_frame *f)
{
    const float *v = glint_frame_find(f, "variance.G");
    double sum = 0.0;
    for (size_t i = 0; i < pixels(f); i++)
        sum += v[i];
    return sqrt(sum) / (double)pixels(f);
}

#define CAMERA(z) \
    "\"cameras\":{\"eye\":{\"yfov\":0.8,\"transform\":{\"translation\":[0,0," #z "]}}}"

// Inside a closed sphere with albedo 1/2 that emits 1/2 everywhere, radiance is 1/2 + 1/4 + ... = 1.
static void closed_emitting_sphere_shows_radiance_one(void **state)
{
    (void)state;
    struct glint_frame *f =
        render_text("{\"materials\":{\"m\":{\"base_color\":[0.5,0.5,0.5],\"ior\":1,\"emission\":[0."
                    "5,0.5,0.5]}},"
                    "\"meshes\":{\"s\":{\"primitive\":\"sphere\",\"radius\":2,\"segments\":256}},"
                    "\"instances\":{\"s\":{\"mesh\":\"s\",\"material\":\"m\"}}," CAMERA(0.5) "}",
                    "{\"scene\":\"s\",\"resolution\":[32,32],\"outputs\":[\"beauty\"],\"max_"
                    "bounces\":64,\"stop\":{\"samples\":256}}");
    // What the angle of a facet to its neighbours loses goes with its square: 1.2e-3 of 32 segments.
    // n = 262144, a sample's standard deviation s below 1/2: a bias of d = 0.008 shows.
    assert_odds(mean_of(f, "G") - 1.0, error_of_even(f), 4e-5);
    glint_frame_destroy(&f);
}

// Closed rooms of walls that reflect `albedo` and emit the rest show radiance 1. Walls are flat: nothing
// is lost at facets. Rays after the first scattering: all paths have one, and then
// - of .1, .04 times its light is below the share: one in ten goes on, each time. 1/(1 - .1).
// - of .4, .16 of the light is left: .64 go on, each carrying a quarter; then .4. 1 + .64/(1 - .4).
// - of .8, more than a quarter is left: all have three, and then .8 go on. 3 + .8/(1 - .8).
// `spread` is their standard deviation if samples are independent; strata make it less.
static void dark_rooms_end_paths_sooner_than_white_ones_and_show_the_same(void **state)
{
    (void)state;
    static const struct {
        double albedo, rays, spread;
    } room[] = {{0.1, 1.0 / 0.9, 0.352}, {0.4, 1.0 + 0.64 / 0.6, 1.163}, {0.8, 7.0, 4.473}};
    for (size_t i = 0; i < sizeof room / sizeof *room; i++) {
        const double a = room[i].albedo, e = 1.0 - a;
        char scene[512];
        snprintf(scene, sizeof scene,
                 "{\"materials\":{\"m\":{\"base_color\":[%g,%g,%g],\"ior\":1,\"emission\":[%g,%g,"
                 "%g]}},\"meshes\":{\"b\":{\"primitive\":\"box\",\"size\":[4,3,5]}},"
                 "\"instances\":{\"b\":{\"mesh\":\"b\",\"material\":\"m\"}}," CAMERA(0.5) "}",
                 a, a, a, e, e, e);
        struct traced t =
            traced_text(scene, "{\"scene\":\"s\",\"resolution\":[32,32],\"outputs\":[\"beauty\"],"
                               "\"max_bounces\":64,\"stop\":{\"samples\":256}}");
        const double n = (double)t.state.camera_rays, rays = (double)t.state.bounce_rays / n;
        const double error = room[i].spread / sqrt(n);
        print_message("# albedo %g: %.5f rays, %.5f +- %.5f expected; radiance %.5f\n", a, rays,
                      room[i].rays, error, mean_of(t.frame, "G"));
        odds_note(__FILE__, __func__, "slack", rays - room[i].rays, error);
        assert_float_equal(rays, room[i].rays, ODDS_Z * error);
        assert_odds(mean_of(t.frame, "G") - 1.0, error_of_even(t.frame), 1e-6);
        glint_frame_destroy(&t.frame);
    }
}

// A surface that absorbs nothing cannot be told from its uniform surroundings.
static void white_object_vanishes_in_a_white_environment(void **state)
{
    (void)state;
    static const char *const material[] = {
        "\"base_color\":[1,1,1],\"ior\":1",                          // Lambert
        "\"base_color\":[1,1,1],\"metallic\":1,\"roughness\":0",     // mirror
        "\"base_color\":[1,1,1],\"transmission\":1,\"roughness\":0", // clear glass
        "\"base_color\":[1,1,1],\"transmission\":1,\"roughness\":0,\"thin\":true",
        "\"base_color\":[1,1,1],\"transmission\":1,\"roughness\":0,\"ior\":1", // nothing at all
        "\"base_color\":[1,1,1],\"roughness\":0",                              // polished paint
        "\"base_color\":[1,1,1],\"roughness\":1",                              // matt paint
        "\"base_color\":[1,1,1],\"metallic\":1,\"roughness\":0.7",
        "\"base_color\":[1,1,1],\"metallic\":1,\"roughness\":0,\"clearcoat\":1",
        "\"base_color\":[1,1,1],\"transmission\":1,\"roughness\":0.1",
        "\"base_color\":[1,1,1],\"transmission\":1,\"roughness\":0.3",
        "\"base_color\":[1,1,1],\"transmission\":1,\"roughness\":0.5",
        "\"base_color\":[1,1,1],\"transmission\":1,\"roughness\":1",
        "\"base_color\":[1,1,1],\"transmission\":1,\"roughness\":0,\"collimation\":0.9",
        "\"base_color\":[1,1,1],\"transmission\":1,\"roughness\":0,\"collimation\":0.5",
        "\"base_color\":[1,1,1],\"transmission\":1,\"roughness\":0,\"collimation\":0",
        "\"base_color\":[1,1,1],\"transmission\":1,\"roughness\":0.5,\"thin\":true",
        "\"base_color\":[1,1,1],\"transmission\":1,\"roughness\":1,\"thin\":true",
        "\"base_color\":[1,1,1],\"transmission\":1,\"roughness\":0,\"collimation\":0,\"thin\":true",
    };
    for (size_t i = 0; i < sizeof material / sizeof *material; i++) {
        char scene[1024];
        snprintf(scene, sizeof scene,
                 "{\"environment\":{\"radiance\":[1,1,1]},\"materials\":{\"m\":{%s}},"
                 "\"meshes\":{\"s\":{\"primitive\":\"sphere\",\"segments\":48}},"
                 "\"instances\":{\"s\":{\"mesh\":\"s\",\"material\":\"m\"}}," CAMERA(4) "}",
                 material[i]);
        struct glint_frame *f =
            render_text(scene, "{\"scene\":\"s\",\"resolution\":[32,32],\"outputs\":[\"beauty\"],"
                               "\"max_bounces\":256,\"stop\":{\"samples\":256}}");
        print_message("# %s: %.5f\n", material[i], mean_of(f, "G"));
        // Bent rays cross facets whose shading and true normals differ: what they lose stays small.
        assert_odds(mean_of(f, "G") - 1.0, error_of_even(f), 0.002);
        glint_frame_destroy(&f);
    }
}

// Rough lobes lose what single scattering does not return, and never gain.
static void rough_surfaces_never_gain_energy(void **state)
{
    (void)state;
    for (int r = 1; r <= 10; r += 3) {
        char scene[1024];
        snprintf(scene, sizeof scene,
                 "{\"environment\":{\"radiance\":[1,1,1]},\"materials\":{\"metal\":{\"metallic\":1,"
                 "\"roughness\":%g},"
                 "\"glass\":{\"transmission\":1,\"roughness\":%g},\"paint\":{\"roughness\":%g}},"
                 "\"meshes\":{\"s\":{\"primitive\":\"sphere\",\"segments\":48}},\"instances\":{"
                 "\"a\":{\"mesh\":\"s\",\"material\":\"metal\",\"transform\":{\"translation\":[-2."
                 "2,0,0]}},"
                 "\"b\":{\"mesh\":\"s\",\"material\":\"glass\"},"
                 "\"c\":{\"mesh\":\"s\",\"material\":\"paint\",\"transform\":{\"translation\":[2.2,"
                 "0,0]}}}," CAMERA(8) "}",
                 r / 10.0, r / 10.0, r / 10.0);
        struct glint_frame *f =
            render_text(scene, "{\"scene\":\"s\",\"resolution\":[48,24],\"outputs\":[\"beauty\"],"
                               "\"max_bounces\":256,\"stop\":{\"samples\":256}}");
        odds_note(__FILE__, __func__, "bound", mean_of(f, "G") - 1.0, error_of_even(f));
        assert_true(mean_of(f, "G") <= 1.002);
        assert_true(mean_of(f, "G") > 0.8);
        glint_frame_destroy(&f);
    }
}

// The walls of a closed room let nothing in, wherever the room stands: 10 million rays at each place,
// a fifth of them from the camera, and the shadow rays of the others.
static void closed_room_lets_no_light_in(void **state)
{
    (void)state;
    static const double place[] = {0.0, 1e3, 1e5, 1e6};
    for (size_t i = 0; i < sizeof place / sizeof *place; i++) {
        char scene[1200];
        snprintf(
            scene, sizeof scene,
            "{\"environment\":{\"radiance\":[1e6,1e6,1e6]},\"materials\":{\"m\":{\"base_color\":[0."
            "8,0.8,0.8]}},"
            "\"lights\":{\"sun\":{\"type\":\"sun\",\"intensity\":1e6},"
            "\"far\":{\"type\":\"point\",\"intensity\":1e9,\"transform\":{\"translation\":[%.17g,9,"
            "0]}}},"
            "\"meshes\":{\"box\":{\"primitive\":\"box\",\"size\":[4,3,5]},\"ball\":{\"primitive\":"
            "\"sphere\",\"segments\":32}},"
            "\"instances\":{\"room\":{\"mesh\":\"box\",\"material\":\"m\",\"transform\":{"
            "\"translation\":[%.17g,0,0],"
            "\"rotation\":[0.1830127,0.1830127,0.6830127,0.6830127]}},"
            "\"ball\":{\"mesh\":\"ball\",\"material\":\"m\",\"transform\":{\"translation\":[%.17g,"
            "0,-0.5]}}},"
            "\"cameras\":{\"eye\":{\"yfov\":1.2,\"transform\":{\"translation\":[%.17g,0,1.2]}}}}",
            place[i], place[i], place[i], place[i]);
        struct glint_frame *f =
            render_text(scene, "{\"scene\":\"s\",\"resolution\":[128,128],\"outputs\":[\"beauty\"],"
                               "\"max_bounces\":4,\"accuracy\":{\"roulette\":\"none\"},"
                               "\"stop\":{\"samples\":128}}");
        assert_float_equal(most_of(f, "G"), 0.0, 0.0);
        glint_frame_destroy(&f);
    }
}

// Scene text with every length and every emission scaled.
static void mixed_scene(char *text, size_t bytes, double length, double light)
{
    snprintf(text, bytes,
             "{\"materials\":{\"floor\":{\"base_color\":[0.6,0.5,0.4],\"roughness\":0.6},"
             "\"gold\":{\"base_color\":[1,0.8,0.3],\"metallic\":1,\"roughness\":0.3},\"glass\":{"
             "\"transmission\":1,\"roughness\":0.1},"
             "\"lamp\":{\"base_color\":[0,0,0],\"emission\":[%.9g,%.9g,%.9g]}},"
             "\"meshes\":{\"q\":{\"primitive\":\"quad\",\"size\":[%.9g,%.9g]},\"s\":{\"primitive\":"
             "\"sphere\",\"radius\":%.9g,\"segments\":32}},"
             "\"lights\":{\"p\":{\"type\":\"point\",\"intensity\":%.9g,\"transform\":{"
             "\"translation\":[0,%.9g,%.9g]}}},"
             "\"instances\":{\"floor\":{\"mesh\":\"q\",\"material\":\"floor\",\"transform\":{"
             "\"translation\":[0,%.9g,0],\"rotation\":[-0.70710678,0,0,0.70710678]}},"
             "\"gold\":{\"mesh\":\"s\",\"material\":\"gold\",\"transform\":{\"translation\":[%.9g,"
             "0,0]}},"
             "\"glass\":{\"mesh\":\"s\",\"material\":\"glass\",\"transform\":{\"translation\":[%."
             "9g,0,%.9g]}},"
             "\"lamp\":{\"mesh\":\"q\",\"material\":\"lamp\",\"transform\":{\"translation\":[0,%."
             "9g,0],\"rotation\":[0.70710678,0,0,0.70710678]}}},"
             "\"cameras\":{\"eye\":{\"yfov\":0.7,\"transform\":{\"translation\":[0,0,%.9g]}}}}",
             4 * light, 3 * light, 2 * light, 8 * length, 8 * length, length, 5 * light, 3 * length,
             2 * length, -length, -1.25 * length, 1.25 * length, 0.5 * length, 6 * length,
             8 * length);
}

#define MIXED_JOB                                                                                 \
    "{\"scene\":\"s\",\"resolution\":[80,56],\"outputs\":[\"beauty\",\"crypto_object\",\"crypto_" \
    "material\","                                                                                 \
    "\"depth\",\"normal\",\"albedo\",\"samples\",\"variance\"],\"stop\":{\"samples\":24}}"

static void same_bits_for_one_two_three_and_fifteen_workers(void **state)
{
    (void)state;
    char scene[4096];
    mixed_scene(scene, sizeof scene, 1.0, 1.0);
    static const uint32_t workers[] = {1, 2, 3, 15}; // PoCL has 16 devices, one of them spare
    struct glint_frame *frame[4];
    for (uint32_t n = 0; n < 4; n++) {
        struct offline crew;
        offline_start(&crew, workers[n]);
        glint_resident *resident = offline_load_text(&crew, scene);
        frame[n] = offline_frame(&crew, resident, MIXED_JOB, 0);
        glint_resident_release(&resident);
        offline_finish(&crew);
    }
    for (uint32_t c = 0; c < frame[0]->channels; c++)
        for (int n = 1; n < 4; n++)
            assert_memory_equal(frame[0]->channel[c].plane, frame[n]->channel[c].plane,
                                pixels(frame[0]) * 4);
    for (int n = 0; n < 4; n++)
        glint_frame_destroy(&frame[n]);
}

static void region_has_the_pixels_of_the_whole_frame(void **state)
{
    (void)state;
    char scene[4096];
    mixed_scene(scene, sizeof scene, 1.0, 1.0);
    struct glint_frame *whole = render_text(scene, MIXED_JOB);
    struct glint_frame *part =
        render_text(scene, "{\"scene\":\"s\",\"resolution\":[80,56],\"region\":[13,9,37,29],"
                           "\"outputs\":[\"beauty\",\"crypto_object\"],"
                           "\"stop\":{\"samples\":24}}");
    const char *const name[] = {"R", "A", "CryptoObject00.R", "CryptoObject00.G"};
    for (int c = 0; c < 4; c++)
        for (uint32_t y = 0; y < part->height; y++)
            assert_memory_equal(glint_frame_find(part, name[c]) + (size_t)y * part->width,
                                glint_frame_find(whole, name[c]) + (size_t)(y + 9) * whole->width +
                                    13,
                                part->width * 4);
    glint_frame_destroy(&whole);
    glint_frame_destroy(&part);
}

static void scaling_light_by_a_power_of_two_scales_every_bit(void **state)
{
    (void)state;
    static const float scale[] = {0x1p30f, 0x1p-30f};
    char text[4096];
    mixed_scene(text, sizeof text, 1.0, 1.0);
    struct glint_frame *a = render_text(text, MIXED_JOB);
    const float *p = glint_frame_find(a, "R");
    for (size_t k = 0; k < sizeof scale / sizeof *scale; k++) {
        mixed_scene(text, sizeof text, 1.0, scale[k]);
        struct glint_frame *b = render_text(text, MIXED_JOB);
        const float *q = glint_frame_find(b, "R");
        for (size_t i = 0; i < pixels(a); i++)
            assert_true(p[i] * scale[k] == q[i]);
        glint_frame_destroy(&b);
    }
    glint_frame_destroy(&a);
}

static void scaling_the_scene_by_a_power_of_two_changes_no_picture(void **state)
{
    (void)state;
    static const double scale[] = {1.0 / 1048576.0, 1024.0, 1048576.0};
    char scene[4096];
    mixed_scene(scene, sizeof scene, 1.0, 1.0);
    struct glint_frame *unit = render_text(scene, MIXED_JOB);
    for (size_t s = 0; s < sizeof scale / sizeof *scale; s++) {
        mixed_scene(scene, sizeof scene, scale[s], 1.0);
        char *point = strstr(scene, "\"intensity\":5"); // W/sr: the square of the length
        char fixed[4096];
        snprintf(fixed, sizeof fixed, "%.*s\"intensity\":%.9g%s", (int)(point - scene), scene,
                 5 * scale[s] * scale[s], point + strlen("\"intensity\":5"));
        struct glint_frame *scaled = render_text(fixed, MIXED_JOB);
        const float *p = glint_frame_find(unit, "G"), *q = glint_frame_find(scaled, "G");
        size_t equal = 0;
        for (size_t i = 0; i < pixels(unit); i++)
            equal += memcmp(&p[i], &q[i], 4) == 0;
        print_message("# scale %g: %zu of %zu pixels equal\n", scale[s], equal, pixels(unit));
        assert_true(equal >= pixels(unit) * 9999 / 10000);
        glint_frame_destroy(&scaled);
    }
    glint_frame_destroy(&unit);
}

// Every estimator of the same light has the same mean: n = 524288 samples, s = 0.3, so that a
// bias of d = 0.0045, 4 % of the mean, shows.
static void dials_agree_in_the_mean(void **state)
{
    (void)state;
    static const char *const dial[] = {"\"roulette\":\"none\"", "\"lights\":\"uniform\"",
                                       "\"traversal\":\"watertight\"", "\"precision\":\"float64\""};
    char scene[4096], job[512];
    mixed_scene(scene, sizeof scene, 1.0, 1.0);
    const char *const format = "{\"scene\":\"s\",\"resolution\":[32,32],\"outputs\":[\"beauty\","
                               "\"variance\"],\"accuracy\":{%s},\"seed\":%d,"
                               "\"max_bounces\":6,\"stop\":{\"samples\":512}}";
    snprintf(job, sizeof job, format, "", 1);
    struct glint_frame *base = render_text(scene, job);
    for (size_t i = 0; i < sizeof dial / sizeof *dial; i++) {
        snprintf(job, sizeof job, format, dial[i], (int)i + 2);
        struct glint_frame *other = render_text(scene, job);
        print_message("# %s: %.5f against %.5f\n", dial[i], mean_of(other, "G"),
                      mean_of(base, "G"));
        assert_odds(mean_of(other, "G") - mean_of(base, "G"),
                    hypot(error_of_any(other), error_of_any(base)), 0);
        glint_frame_destroy(&other);
    }
    glint_frame_destroy(&base);
}

// Sums over pixels and channels of what the job says of its variance and of the square of its true
// error, less what the reference is off itself; both are relative to the reference, so that a bright
// path of the job has no part in the scale.
struct squares {
    double estimate, truth;
};

static void add_squares(struct squares *sum, const struct glint_frame *f,
                        const struct glint_frame *reference)
{
    static const char *const colour[] = {"R", "G", "B"}, *const variance[] = {"variance.R",
                                                                              "variance.G",
                                                                              "variance.B"};
    for (int c = 0; c < 3; c++) {
        const float *x = glint_frame_find(f, colour[c]), *v = glint_frame_find(f, variance[c]);
        const float *r = glint_frame_find(reference, colour[c]);
        const float *known = glint_frame_find(reference, variance[c]);
        for (size_t i = 0; i < pixels(f); i++) {
            const double scale = 1.0 / ((double)r[i] * r[i] + 0.01), off = (double)x[i] - r[i];
            sum->estimate += scale * v[i];
            sum->truth += scale * (off * off - known[i]);
        }
    }
}

static struct glint_frame *diffuse_still_life(int seed, int samples)
{
    // No caustics: their rare bright paths would need more pixels than these.
    const char *const scene =
        "{\"materials\":{\"grey\":{\"base_color\":[0.6,0.5,0.4],\"ior\":1},"
        "\"lamp\":{\"base_color\":[0,0,0],\"ior\":1,\"emission\":[6,5,4]}},"
        "\"meshes\":{\"q\":{\"primitive\":\"quad\",\"size\":[6,6]},\"s\":{\"primitive\":\"sphere\"}"
        ","
        "\"l\":{\"primitive\":\"quad\",\"size\":[2,2]}},"
        "\"instances\":{\"floor\":{\"mesh\":\"q\",\"material\":\"grey\",\"transform\":{"
        "\"translation\":[0,-1,0],\"rotation\":[-0.70710678,0,0,0.70710678]}},"
        "\"back\":{\"mesh\":\"q\",\"material\":\"grey\",\"transform\":{\"translation\":[0,0,-2]}},"
        "\"ball\":{\"mesh\":\"s\",\"material\":\"grey\"},"
        "\"lamp\":{\"mesh\":\"l\",\"material\":\"lamp\",\"transform\":{\"translation\":[1.5,3,1],"
        "\"rotation\":[0.70710678,0,0,0.70710678]}}}," CAMERA(5) "}";
    char job[256];
    snprintf(job, sizeof job,
             "{\"scene\":\"s\",\"resolution\":[64,64],\"outputs\":[\"beauty\",\"variance\"],"
             "\"seed\":%d,\"stop\":{\"samples\":%d}}",
             seed, samples);
    return render_text(scene, job);
}

// The estimate of a job that knows no reference, against the true error by one: 16 pictures of 4096
// pixels, each of which has its ratio to 3 %.
static void own_error_estimate_is_the_true_error(void **state)
{
    (void)state;
    enum { SEEDS = 16 };
    struct glint_frame *reference = diffuse_still_life(100, 4096);
    struct squares all = {0.0, 0.0};
    double ratios = 0.0, squares = 0.0;
    for (int seed = 1; seed <= SEEDS; seed++) {
        struct glint_frame *f = diffuse_still_life(seed, 32);
        struct squares one = {0.0, 0.0};
        add_squares(&one, f, reference);
        all.estimate += one.estimate;
        all.truth += one.truth;
        const double ratio = sqrt(one.estimate / one.truth);
        ratios += ratio / SEEDS;
        squares += ratio * ratio / SEEDS;
        glint_frame_destroy(&f);
    }
    const double ratio = sqrt(all.estimate / all.truth);
    const double spread = sqrt(fmax(squares - ratios * ratios, 0.0) / (SEEDS - 1));
    print_message("# estimate over truth %.4f +- %.4f\n", ratio, spread);
    odds_note(__FILE__, __func__, "slack", ratio - 1.0, spread);
    assert_float_equal(ratio, 1.0, 0.03);
    glint_frame_destroy(&reference);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_emitting_sphere_shows_radiance_one),
        cmocka_unit_test(dark_rooms_end_paths_sooner_than_white_ones_and_show_the_same),
        cmocka_unit_test(white_object_vanishes_in_a_white_environment),
        cmocka_unit_test(rough_surfaces_never_gain_energy),
        cmocka_unit_test(closed_room_lets_no_light_in),
        cmocka_unit_test(same_bits_for_one_two_three_and_fifteen_workers),
        cmocka_unit_test(region_has_the_pixels_of_the_whole_frame),
        cmocka_unit_test(scaling_light_by_a_power_of_two_scales_every_bit),
        cmocka_unit_test(scaling_the_scene_by_a_power_of_two_changes_no_picture),
        cmocka_unit_test(dials_agree_in_the_mean),
        cmocka_unit_test(own_error_estimate_is_the_true_error),
    };
    return cmocka_run_group_tests(tests, offline_crew_start, offline_crew_finish);
}
