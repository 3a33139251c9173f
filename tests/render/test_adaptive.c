// Adaptive jobs: more samples where there is more noise, the same picture in the mean, and the same
// bytes whoever renders them. And what a job's own error sees and what it cannot.
#include "kernels/gk_film.h"
#include "protocol/bias.h"
#include "tests/accuracy/scores.h"
#include "tests/render/filmed.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define WIDTH 48
#define HEIGHT 32
#define PIXELS (WIDTH * HEIGHT)
#define SEEDS 24

static struct offline o;
static glint_resident *corner;

// A wall under an even sky, and beyond one corner a lamp close to it.
static const char corner_text[] =
    "{'environment':{'radiance':[0.2,0.2,0.2]},"
    "'materials':{'grey':{'base_color':[0.5,0.5,0.5],'ior':1},"
    "'lamp':{'base_color':[0,0,0],'emission':[40,40,40],'ior':1}},"
    "'meshes':{'q':{'primitive':'quad'}},"
    "'instances':{'wall':{'mesh':'q','material':'grey','transform':{'scale':[9,9,9]}},"
    "'l':{'mesh':'q','material':'lamp','transform':{'translation':[-1.75,1.2,0.2],"
    "'rotation':[0,1,0,0],'scale':[0.4,0.4,0.4]}}},"
    "'cameras':{'eye':{'yfov':0.7,'transform':{'translation':[0,0,3]}}}}";

#define UNKNOWING "'estimate':'none',"

static glint_render *begin(glint_resident *scene, uint32_t seed, const char *members)
{
    struct glint_error err = {0};
    glint_render *render = NULL;
    const char *variance = strstr(members, UNKNOWING) ? "" : ",'variance'";
    char *text = stable_text("{'scene':'s','outputs':['beauty','samples'%s],%s'seed':%u,"
                             "'filter':{'kind':'box'},'resolution':[%d,%d]}",
                             variance, members, seed, WIDTH, HEIGHT);
    struct glint_job *job = offline_job(text);
    if (glint_render_create(&render, o.devices, scene, NULL, job, &err))
        offline_die("render", &err);
    glint_job_destroy(&job);
    free(text);
    return render;
}

static glint_render *whole(glint_resident *scene, uint32_t seed, const char *members)
{
    glint_render *render = begin(scene, seed, members);
    offline_render(&o, render);
    assert_true(glint_render_complete(render));
    return render;
}

static const float *channel(struct glint_frame *frame, const char *name)
{
    const float *values = glint_frame_find(frame, name);
    assert_non_null(values);
    return values;
}

// ---- where samples go

// Sums of a value and its square over seeds.
struct sums {
    double sum[PIXELS], square[PIXELS];
};

// The noise of a pixel's mean, from the estimate of its samples, is not looked at here: means and
// variances are those of seeds. Returns the samples of a pixel in the mean.
static double add_seeds(struct sums *s, const char *members)
{
    double samples = 0.0;
    for (uint32_t seed = 0; seed < SEEDS; seed++) {
        glint_render *render = whole(corner, seed, members);
        struct glint_frame *frame;
        assert_int_equal(
            glint_render_frame(render, GLINT_OUT_BEAUTY | GLINT_OUT_SAMPLES, &frame, NULL, NULL),
            GLINT_OK);
        const float *green = channel(frame, "G"), *count = channel(frame, "samples.Y");
        for (int i = 0; i < PIXELS; i++) {
            s->sum[i] += green[i];
            s->square[i] += (double)green[i] * green[i];
            samples += count[i] / (double)PIXELS / SEEDS;
        }
        glint_frame_destroy(&frame);
        glint_render_destroy(&render);
    }
    return samples;
}

static double variance_of(const struct sums *s, int i)
{
    const double mean = s->sum[i] / SEEDS;
    return fmax(s->square[i] / SEEDS - mean * mean, 0.0) * SEEDS / (SEEDS - 1.0);
}

// Of the mean of a tile over all seeds, whose pixels are independent.
static void tile_mean(const struct sums *s, int tile, double *mean, double *variance)
{
    *mean = *variance = 0.0;
    for (int i = 0; i < GK_TILE_PIXELS; i++) {
        const int x = tile % 3 * 16 + i % 16, y = tile / 3 * 16 + i / 16;
        *mean += s->sum[y * WIDTH + x] / SEEDS / GK_TILE_PIXELS;
        *variance += variance_of(s, y * WIDTH + x) / SEEDS / GK_TILE_PIXELS / GK_TILE_PIXELS;
    }
}

// The largest |z| of the means of tiles.
static double widest_difference(const struct sums *one, const struct sums *other)
{
    double widest = 0.0;
    for (int t = 0; t < 6; t++) {
        double a, b, va, vb;
        tile_mean(one, t, &a, &va);
        tile_mean(other, t, &b, &vb);
        print_message("# tile %d: %.5f and %.5f, z %.2f\n", t, a, b, (a - b) / sqrt(va + vb));
        widest = fmax(widest, fabs(a - b) / sqrt(va + vb));
    }
    return widest;
}

static double noise_ratio(const struct sums *over, const struct sums *under)
{
    double noise[2] = {0.0, 0.0};
    for (int i = 0; i < PIXELS; i++) {
        noise[0] += variance_of(under, i);
        noise[1] += variance_of(over, i);
    }
    print_message("# variance %.3g and %.3g\n", noise[0] / PIXELS, noise[1] / PIXELS);
    return noise[1] / noise[0];
}

// n = 24 seeds of 256 pixels for each of 6 tiles: |z| < 4.892 (1e-6 each). With an sd of .01 of a
// pixel's mean over seeds (the noisy tile), d = ((4.892 + 3.09) .01) / sqrt(6144) = .001 is seen with
// 99.9 %. The error falls by more than a tenth: with 24 seeds the ratio of the sums of variances has
// an sd of .02, and is about .6.
static void adaptive_picture_is_the_same_in_the_mean_and_less_noisy(void **state)
{
    (void)state;
    static struct sums even, adaptive;
    assert_float_equal(add_seeds(&even, "'stop':{'samples':96},"), 96.0, 1e-9);
    const double spent = add_seeds(&adaptive, "'adaptive':true,'stop':{'samples':96},");
    print_message("# %.1f samples of a pixel\n", spent);
    assert_true(spent < 96.0 - 16.0 + 1e-3 && spent > 96.0 - 16.0 - 32.0); // the pilot's are gone
    assert_true(widest_difference(&even, &adaptive) < 4.892);
    assert_true(noise_ratio(&adaptive, &even) < 0.9);
}

// Two halves of 8 samples have the strata of 8, one sequence has those of 16. With 24 seeds the ratio has
// an sd of about .02, and is about .8.
static void who_does_not_ask_for_the_error_has_the_same_picture_with_less_noise(void **state)
{
    (void)state;
    static struct sums halves, one;
    add_seeds(&halves, "'stop':{'samples':16},");
    add_seeds(&one, UNKNOWING "'stop':{'samples':16},");
    assert_true(widest_difference(&halves, &one) < 4.892);
    assert_true(noise_ratio(&one, &halves) < 0.9);
    glint_render *render = whole(corner, 1, UNKNOWING "'stop':{'samples':16},"), *opened;
    const int fd = filmed_write(render);
    assert_int_equal(glint_render_open(&opened, fd, NULL), GLINT_OK);
    filmed_assert_same(opened, render);
    struct glint_render_state known;
    glint_render_state(opened, &known);
    assert_true(isnan(known.estimate.error) && isnan(known.forecast.samples[0]));
    struct glint_convergence_point point;
    assert_int_equal(glint_render_convergence(render, &point, 1), 0);
    close(fd);
    glint_render_destroy(&opened);
    glint_render_destroy(&render);
}

// A wall that a picture of a sky lights: every pixel has the same noise, and so has every tile, the
// whole ones of 256 pixels and those that the frame's edge cuts to 64.
static void tiles_that_the_edge_cuts_have_samples_by_their_noise(void **state)
{
    (void)state;
    struct glint_error err = {0};
    float sky[16 * 8 * 3], least = INFINITY, most = 0.0f;
    uint64_t seed = 3;
    for (int i = 0; i < 16 * 8 * 3; i++)
        sky[i] = (float)stable_random(&seed) + 0.1f;
    char *uri = stable_hdr(16, 8, sky);
    char *scene = stable_text("{'images':{'s':{'data':'%s'}},'environment':{'image':'s'},"
                              "'materials':{'m':{'ior':1}},'meshes':{'q':{'primitive':'quad'}},"
                              "'instances':{'wall':{'mesh':'q','material':'m','transform':{"
                              "'scale':[9,9,9]}}},'cameras':{'eye':{'yfov':0.7,'transform':{"
                              "'translation':[0,0,3]}}}}",
                              uri);
    glint_resident *wall = offline_load_text(&o, scene);
    char *text = stable_text("{'scene':'s','outputs':['beauty','samples'],'adaptive':true,"
                             "'resolution':[40,24],'max_bounces':1,'filter':{'kind':'box'},"
                             "'stop':{'samples':96}}");
    struct glint_job *job = offline_job(text);
    glint_render *render = NULL;
    struct glint_frame *frame;
    if (glint_render_create(&render, o.devices, wall, NULL, job, &err))
        offline_die("render", &err);
    offline_render(&o, render);
    assert_int_equal(glint_render_frame(render, job->outputs, &frame, NULL, NULL), GLINT_OK);
    const float *count = channel(frame, "samples.Y");
    for (size_t i = 0; i < stable_pixels(frame); i++) {
        least = fminf(least, count[i]);
        most = fmaxf(most, count[i]);
    }
    print_message("# %g to %g samples\n", least, most);
    assert_true(least >= 0.7f * most);
    glint_frame_destroy(&frame);
    glint_render_destroy(&render);
    glint_job_destroy(&job);
    glint_resident_release(&wall);
    free(text);
    free(scene);
    free(uri);
}

// ---- the same bytes

#define ADAPTIVE "'adaptive':true,'stop':{'samples':96},"

static void bytes_do_not_depend_on_the_number_of_workers(void **state)
{
    (void)state;
    glint_render *three = whole(corner, 1, ADAPTIVE), *one = begin(corner, 1, ADAPTIVE);
    filmed_run(&o, one, UINT32_MAX);
    assert_true(glint_render_complete(one));
    filmed_assert_same(one, three);
    glint_render_destroy(&one);
    glint_render_destroy(&three);
}

static void bytes_do_not_depend_on_a_restart_in_the_pilot_or_behind_it(void **state)
{
    (void)state;
    glint_render *twin = whole(corner, 1, ADAPTIVE);
    for (uint32_t slices = 0; slices < 40; slices += 7) {
        glint_render *before = begin(corner, 1, ADAPTIVE), *after = begin(corner, 1, ADAPTIVE);
        assert_int_equal(filmed_run(&o, before, slices), slices);
        const int fd = filmed_write(before);
        struct glint_error err = {0};
        if (glint_render_restore(after, fd, &err))
            offline_die("restore", &err);
        filmed_assert_same(before, after);
        filmed_run(&o, after, UINT32_MAX);
        filmed_assert_same(after, twin);
        close(fd);
        glint_render_destroy(&before);
        glint_render_destroy(&after);
    }
    glint_render_destroy(&twin);
}

static void film_that_has_ended_answers_as_its_render_did(void **state)
{
    (void)state;
    glint_render *render = whole(corner, 1, ADAPTIVE), *opened;
    const int fd = filmed_write(render);
    assert_int_equal(glint_render_open(&opened, fd, NULL), GLINT_OK);
    filmed_assert_same(opened, render);
    close(fd);
    glint_render_destroy(&opened);
    glint_render_destroy(&render);
}

static void adaptive_job_goes_on_to_more_samples(void **state)
{
    (void)state;
    glint_render *twin = whole(corner, 1, "'adaptive':true,'stop':{'samples':160},");
    glint_render *render = whole(corner, 1, ADAPTIVE);
    assert_false(glint_render_extend(render, 64, 0));
    assert_true(glint_render_extend(render, 160, 0));
    offline_render(&o, render);
    filmed_assert_same(render, twin);
    glint_render_destroy(&render);
    glint_render_destroy(&twin);
}

// ---- the error

static struct glint_render_state state_of(glint_render *render)
{
    struct glint_render_state s;
    glint_render_state(render, &s);
    return s;
}

// Both estimate one variance: of 1536 pixels the halves' relative sd is about .05, the batches' .02.
// Sixteen batches are less stratified than two halves, so theirs may be larger, by a fifth here.
static void batches_and_halves_tell_of_the_same_noise(void **state)
{
    (void)state;
    glint_render *halves = whole(corner, 1, "'stop':{'samples':64},");
    glint_render *batches = whole(corner, 1, "'estimate':'batches','stop':{'samples':64},");
    const struct glint_estimate a = state_of(halves).estimate, b = state_of(batches).estimate;
    print_message("# halves %.5f, batches %.5f\n", a.linear, b.linear);
    assert_true(b.spread < a.spread);
    assert_true(b.linear > 0.7 * a.linear && b.linear < 2.0 * a.linear);
    glint_render_destroy(&halves);
    glint_render_destroy(&batches);
}

// n = 6 seeds of some 4600 values, of which the three of a pixel are nearly one: s of the share is
// below sqrt(.95 .05 / 9000) = .0023 where seeds are independent, and 4.892 s = .011. Had v half of
// what it should, .85 of the values would be inside, which is seen with more than 99.9 %.
static void pixels_are_as_near_to_the_truth_as_their_batches_say(void **state)
{
    (void)state;
    char *text = stable_text("{'scene':'s','outputs':['beauty'],'stop':{'samples':128},"
                             "'filter':{'kind':'box'},'resolution':[%d,%d]}",
                             WIDTH, HEIGHT);
    struct glint_job *job = offline_job(text);
    const struct glint_posed rest = {.resident = corner};
    const struct scores s = scores_take(&o, &rest, job, 6);
    const double share = (double)s.inside / (double)s.values;
    print_message("# %.4f of %u values\n", share, (unsigned)s.values);
    assert_true(share > 0.935 && share < 0.965);
    glint_job_destroy(&job);
    free(text);
}

// The hook: half B is overwritten with half A, as if both had one seed.
static void copy_half_a_to_b(glint_render *render)
{
    const size_t words = (size_t)3 * GK_SUM_PLANES * GK_TILE_PIXELS;
    for (uint32_t t = 0; t < 6; t++) {
        struct glint_film_tile at;
        glint_film_tile(render->film, t, &at);
        float *planes = (float *)glint_buffer_host(at.planes) + at.planes_offset;
        memcpy(planes + words, planes, words * sizeof *planes);
        glint_render_measure(render, t, 64);
    }
    glint_render_measure_pass(render, 64);
}

static double squared_difference(glint_render *a, glint_render *b)
{
    struct glint_frame *x, *y;
    double square = 0.0;
    assert_int_equal(glint_render_frame(a, GLINT_OUT_BEAUTY, &x, NULL, NULL), GLINT_OK);
    assert_int_equal(glint_render_frame(b, GLINT_OUT_BEAUTY, &y, NULL, NULL), GLINT_OK);
    for (int c = 0; c < 3; c++) {
        static const char *const name[] = {"R", "G", "B"};
        const float *p = channel(x, name[c]), *q = channel(y, name[c]);
        for (int i = 0; i < PIXELS; i++)
            square += ((double)p[i] - q[i]) * ((double)p[i] - q[i]) / (3.0 * PIXELS);
    }
    glint_frame_destroy(&x);
    glint_frame_destroy(&y);
    return square;
}

// The check: what jobs say of their error, over what pictures of two seeds differ by. Half of a
// squared difference is the variance of one.
static double independence(bool one_seed)
{
    double said = 0.0, seen = 0.0;
    for (uint32_t pair = 0; pair < 12; pair++) {
        glint_render *a = whole(corner, 2 * pair + 1, "'stop':{'samples':64},");
        glint_render *b = whole(corner, 2 * pair + 2, "'stop':{'samples':64},");
        seen += 0.5 * squared_difference(a, b);
        if (one_seed)
            copy_half_a_to_b(a);
        said += a->estimate.whole.linear * a->estimate.whole.linear;
        glint_render_destroy(&a);
        glint_render_destroy(&b);
    }
    print_message("# error said over error seen: %.3f\n", sqrt(said / seen));
    return sqrt(said / seen);
}

static void halves_of_one_seed_are_noticed(void **state)
{
    (void)state;
    const double apart = independence(false);
    assert_true(apart > 0.8 && apart < 1.25);
    assert_true(independence(true) == 0.0);
}

// Two bounces of light in a white room: what comes later is lost whatever the samples, the error
// goes to 0 all the same, and the bias is on the list.
static void bias_of_short_paths_is_not_in_the_error_but_on_the_list(void **state)
{
    (void)state;
    char *text = stable_text(
        "{'materials':{'w':{'base_color':[0.9,0.9,0.9],'ior':1,'emission':[0.1,0.1,0.1]}},"
        "'meshes':{'b':{'primitive':'box','size':[4,4,4]}},"
        "'instances':{'r':{'mesh':'b','material':'w'}},"
        "'cameras':{'eye':{'yfov':0.9,'transform':{'translation':[0,0,1]}}}}");
    glint_resident *room = offline_load_text(&o, text);
    double before = INFINITY;
    for (uint32_t samples = 16; samples <= 256; samples *= 4) {
        char members[64];
        snprintf(members, sizeof members, "'max_bounces':2,'stop':{'samples':%u},", samples);
        glint_render *render = whole(room, 1, members);
        const struct glint_render_state s = state_of(render);
        assert_true(s.estimate.linear < 0.8 * before || s.estimate.linear < 1e-6);
        assert_true(s.biases & GLINT_BIAS_BOUNCES);
        before = s.estimate.linear;
        struct glint_frame *frame;
        assert_int_equal(glint_render_frame(render, GLINT_OUT_BEAUTY, &frame, NULL, NULL),
                         GLINT_OK);
        const double truth = 0.1 / (1 - 0.9); // 0.271 is what is seen
        const double off = fabs(channel(frame, "G")[PIXELS / 2] - truth);
        print_message("# %u samples: error said %.1e, true %.3f\n", samples, s.estimate.linear,
                      off);
        assert_true(off > 0.5 * truth);
        assert_true(s.estimate.linear < 0.05 * truth);
        glint_frame_destroy(&frame);
        glint_render_destroy(&render);
    }
    glint_resident_release(&room);
    free(text);
}

static int start(void **state)
{
    (void)state;
    offline_start(&o, 3);
    char *text = stable_text("%s", corner_text);
    corner = offline_load_text(&o, text);
    free(text);
    return 0;
}

static int finish(void **state)
{
    (void)state;
    glint_resident_release(&corner);
    offline_finish(&o);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_do_not_depend_on_the_number_of_workers),
        cmocka_unit_test(bytes_do_not_depend_on_a_restart_in_the_pilot_or_behind_it),
        cmocka_unit_test(film_that_has_ended_answers_as_its_render_did),
        cmocka_unit_test(adaptive_job_goes_on_to_more_samples),
        cmocka_unit_test(adaptive_picture_is_the_same_in_the_mean_and_less_noisy),
        cmocka_unit_test(who_does_not_ask_for_the_error_has_the_same_picture_with_less_noise),
        cmocka_unit_test(tiles_that_the_edge_cuts_have_samples_by_their_noise),
        cmocka_unit_test(batches_and_halves_tell_of_the_same_noise),
        cmocka_unit_test(pixels_are_as_near_to_the_truth_as_their_batches_say),
        cmocka_unit_test(halves_of_one_seed_are_noticed),
        cmocka_unit_test(bias_of_short_paths_is_not_in_the_error_but_on_the_list),
    };
    return cmocka_run_group_tests(tests, start, finish);
}
