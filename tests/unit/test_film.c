// The film: tiles held by one, read by many, and numbers that come out as they went in.
#include "kernels/gk_film.h"
#include "kernels/gk_sampler.h"
#include "protocol/film.h"
#include "render/estimate.h"
#include "tests/render/offline.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static struct offline o;

static glint_film *film_of(uint32_t width, uint32_t height, uint32_t outputs)
{
    struct glint_scene_facts facts = {0};
    struct glint_job job = {.region = {0, 0, width, height}, .outputs = outputs, .matte_slots = 12};
    const struct glint_camera camera = {0};
    const struct glint_effect_input in = {.facts = &facts, .job = &job, .camera = &camera};
    struct glint_plan plan;
    struct glint_error err = {0};
    glint_film *film = NULL;
    glint_plan_make(&plan, &in, 0);
    assert_int_equal(glint_film_create(&film, o.devices, &plan, &job, 12, &err), GLINT_OK);
    return film;
}

static void exact_coverage_has_a_limit_that_is_named(void **state)
{
    (void)state;
    struct glint_job job = {.dial = {[GLINT_DIAL_EVICTION] = GLINT_EVICTION_EXACT}};
    struct glint_error err = {0};
    assert_int_equal(glint_matte_slots(&job, 16383), 2 * 16383);
    assert_int_equal(glint_matte_check(&job, 16383, "/p", &err), GLINT_OK);
    assert_int_equal(glint_matte_check(&job, 16384, "/p", &err), GLINT_E_RANGE);
    assert_string_equal(err.fault[0].pointer, "/p");
    assert_non_null(strstr(err.fault[0].detail, "32768 slots"));
    glint_error_finish(&err);
    job.dial[GLINT_DIAL_EVICTION] = GLINT_EVICTION_USS;
    job.matte_slots = 12;
    assert_int_equal(glint_matte_slots(&job, 16384), 12);
}

static void tiles_cover_a_region_of_any_size(void **state)
{
    (void)state;
    static const uint32_t size[][4] = {
        {1, 1, 1, 1}, {16, 16, 1, 1}, {17, 16, 2, 1}, {1280, 720, 80, 45}};
    for (size_t i = 0; i < sizeof size / sizeof *size; i++) {
        glint_film *film = film_of(size[i][0], size[i][1], GLINT_OUT_BEAUTY);
        assert_int_equal(glint_film_columns(film), size[i][2]);
        assert_int_equal(glint_film_rows(film), size[i][3]);
        glint_film_destroy(&film);
    }
}

static void tiles_share_no_memory(void **state)
{
    (void)state;
    glint_film *film =
        film_of(64, 48, GLINT_OUT_BEAUTY | GLINT_OUT_CRYPTO_OBJECT | GLINT_OUT_DEPTH);
    const uint32_t words = (GK_PLANES_BASE + GK_PLANES_AOV) * GK_TILE_PIXELS;
    for (uint32_t t = 0; t < 12; t++) {
        struct glint_film_tile at;
        glint_film_tile(film, t, &at);
        assert_int_equal(at.planes_offset, t * words);
        assert_int_equal(at.tables_offset, t * 14 * GK_TILE_PIXELS);
    }
    glint_film_destroy(&film);
}

// As a worker does before it writes.
static void begin_tiles(glint_film *film, uint32_t column, uint32_t row, uint32_t w, uint32_t h)
{
    glint_film_hold(film, column, row, w, h);
    glint_film_prepare(film, column, row, w, h);
}

static size_t pages_in_use(const glint_buffer *buffer)
{
    unsigned char there[4096];
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    const size_t pages = (glint_buffer_bytes(buffer) + page - 1) / page;
    size_t used = 0;
    assert_true(pages <= sizeof there);
    assert_int_equal(mincore(glint_buffer_host((glint_buffer *)buffer), pages * page, there), 0);
    for (size_t i = 0; i < pages; i++)
        used += there[i] & 1u;
    return used;
}

static void a_film_is_no_memory_in_use_before_it_is_written_to(void **state)
{
    (void)state;
    glint_film *film =
        film_of(64, 48, GLINT_OUT_BEAUTY | GLINT_OUT_CRYPTO_OBJECT | GLINT_OUT_DEPTH);
    struct glint_film_tile at;
    glint_film_tile(film, 0, &at);
    assert_int_equal(pages_in_use(at.planes) + pages_in_use(at.tables), 0);
    begin_tiles(film, 0, 0, 1, 1);
    assert_true(pages_in_use(at.planes) > 0);
    glint_film_release(film, 0, 0, 1, 1, 1);
    glint_film_destroy(&film);
}

static void depth_starts_at_a_miss(void **state)
{
    (void)state;
    glint_film *film = film_of(32, 16, GLINT_OUT_BEAUTY | GLINT_OUT_DEPTH);
    begin_tiles(film, 0, 0, 2, 1);
    for (uint32_t t = 0; t < 2; t++) {
        struct glint_film_tile at;
        glint_film_tile(film, t, &at);
        const float *depth = (const float *)glint_buffer_host(at.planes) + at.planes_offset +
                             (GK_PLANES_BASE + GK_AOV_DEPTH) * GK_TILE_PIXELS;
        for (int i = 0; i < GK_TILE_PIXELS; i++)
            assert_true(depth[i] == 1e30f);
    }
    glint_film_destroy(&film);
}

static void release_without_samples_changes_no_version(void **state)
{
    (void)state;
    glint_film *film = film_of(48, 48, GLINT_OUT_BEAUTY);
    begin_tiles(film, 0, 0, 4, 4); // clipped to 3 x 3
    glint_film_release(film, 0, 0, 4, 4, 0);
    assert_int_equal(glint_film_version(film, 2, 2, 1, 1), 0);
    begin_tiles(film, 1, 1, 2, 2);
    glint_film_release(film, 1, 1, 2, 2, 16);
    assert_int_equal(glint_film_version(film, 0, 0, 1, 1), 0);
    assert_int_equal(glint_film_samples(film, 0), 0);
    assert_true(glint_film_version(film, 2, 2, 1, 1) > 0);
    assert_int_equal(glint_film_samples(film, 4), 16);
    glint_film_destroy(&film);
}

struct race {
    glint_film *film;
    bool torn;
};

// Every word of a held tile is written twice; a reader must never see the first of the two.
static void *write_tiles(void *user)
{
    struct race *race = user;
    for (uint32_t round = 1; round <= 400; round++) {
        struct glint_film_tile at;
        begin_tiles(race->film, 0, 0, 1, 1);
        glint_film_tile(race->film, 0, &at);
        float *planes = (float *)glint_buffer_host(at.planes) + at.planes_offset;
        for (uint32_t i = 0; i < GK_TILE_PIXELS; i++)
            planes[i] = -1.0f;
        for (uint32_t i = 0; i < GK_TILE_PIXELS; i++)
            planes[i] = (float)round;
        glint_film_release(race->film, 0, 0, 1, 1, round);
    }
    return NULL;
}

static void *read_tiles(void *user)
{
    struct race *race = user;
    uint32_t samples = 0;
    while (samples < 400) {
        struct glint_film_tile at;
        samples = glint_film_read_begin(race->film, 0, 0).samples;
        glint_film_tile(race->film, 0, &at);
        const float *planes = (const float *)glint_buffer_host(at.planes) + at.planes_offset;
        for (uint32_t i = 0; i < GK_TILE_PIXELS; i++)
            race->torn |= planes[i] != (float)samples;
        glint_film_read_end(race->film, 0);
    }
    return NULL;
}

static void readers_never_see_a_tile_half_written(void **state)
{
    (void)state;
    struct race race = {film_of(16, 16, GLINT_OUT_BEAUTY), false};
    pthread_t writer, reader;
    pthread_create(&reader, NULL, read_tiles, &race);
    pthread_create(&writer, NULL, write_tiles, &race);
    pthread_join(writer, NULL);
    pthread_join(reader, NULL);
    assert_false(race.torn);
    glint_film_destroy(&race.film);
}

// Samples with even indices are of half 0, wherever a range begins.
static void halves_share_samples_evenly(void **state)
{
    (void)state;
    for (uint32_t first = 0; first < 5; first++)
        for (uint32_t n = 0; n < 9; n++) {
            uint32_t half[2] = {0, 0};
            for (uint32_t i = first; i < first + n; i++)
                half[i % 2]++;
            assert_int_equal(glint_film_half(first, n, 0), half[0]);
            assert_int_equal(glint_film_half(first, n, 1), half[1]);
        }
}

// A = 1 + d, B = 1 - d everywhere: v = d^2, m = 1, so each channel gives d^2 / 1.01.
static void estimate_is_the_square_of_half_the_difference(void **state)
{
    (void)state;
    glint_film *film = film_of(16, 16, GLINT_OUT_BEAUTY);
    struct glint_film_tile at;
    glint_film_tile(film, 0, &at);
    float *planes = (float *)glint_buffer_host(at.planes) + at.planes_offset;
    for (uint32_t h = 0; h < 2; h++)
        for (uint32_t c = 0; c < 3; c++)
            for (uint32_t i = 0; i < GK_TILE_PIXELS; i++)
                planes[(h * 3 + c) * GK_SUM_PLANES * GK_TILE_PIXELS + i] =
                    4.0f * (h ? 0.75f : 1.25f);
    struct glint_tile_estimate e;
    const struct glint_estimate_source source = {.planes = planes, .samples = 8};
    glint_estimate_tile(&e, &source, 10, 7);
    assert_float_equal(e.relative, 10 * 7 * 3 * 0.0625 / 1.01, 1e-5);
    assert_float_equal(e.linear, 10 * 7 * 3 * 0.0625, 1e-5);
    const double tone = 1.25 / 2.25 - 0.75 / 1.75;
    assert_float_equal(e.tone, 10 * 7 * 3 * 0.25 * tone * tone, 1e-5);
    assert_float_equal(e.spread, 0.0, 1e-9);
    glint_film_destroy(&film);
}

// Of three samples one half has two: v = 2/9 (A - B)^2.
static void halves_weigh_by_their_samples(void **state)
{
    (void)state;
    static float planes[GK_PLANES_BASE * GK_TILE_PIXELS];
    const struct glint_estimate_source source = {.planes = planes, .samples = 3};
    const uint32_t first = glint_film_half(0, 3, 0);
    struct glint_tile_estimate e;
    for (uint32_t plane = 0; plane < 6; plane++)
        for (uint32_t i = 0; i < GK_TILE_PIXELS; i++)
            planes[plane * GK_SUM_PLANES * GK_TILE_PIXELS + i] =
                plane < 3 ? 1.25f * (float)first : 0.75f * (float)(3 - first);
    assert_true(first == 1 || first == 2);
    glint_estimate_tile(&e, &source, 10, 7);
    assert_float_equal(e.linear, 10 * 7 * 3 * 0.25 * 2 / 9, 1e-5);
}

// A tile whose halves are both 1, and `lamp` from column 6 on, but for one pixel beside that.
static void estimate_one(struct glint_film_estimate *out, float a, float b, float lamp)
{
    static float planes[GK_PLANES_BASE * GK_TILE_PIXELS];
    const struct glint_estimate_source source = {.planes = planes, .samples = 2};
    struct glint_tile_estimate e;
    for (uint32_t plane = 0; plane < 6; plane++)
        for (uint32_t i = 0; i < GK_TILE_PIXELS; i++) {
            const bool one = i == 5 * GK_TILE_SIDE + 5;
            const float other = i % GK_TILE_SIDE > 5 ? lamp : 1.0f;
            planes[plane * GK_SUM_PLANES * GK_TILE_PIXELS + i] = !one ? other : plane < 3 ? a : b;
        }
    glint_estimate_tile(&e, &source, 16, 16);
    glint_estimate_film(out, &e, 1, 1, GK_TILE_PIXELS);
}

// A sample of 100 in a pixel of 0 by a hundred pixels of 1: over its own mean its error is 1, over
// theirs 50. What is as bright in both halves is believed.
static void a_rare_sample_does_not_hide_in_its_own_mean(void **state)
{
    (void)state;
    struct glint_film_estimate e;
    estimate_one(&e, 100.0f, 0.0f, 1.0f);
    assert_float_equal(e.whole.error, sqrt(2500.0 / 1.01 / GK_TILE_PIXELS), 1e-3);
    assert_float_equal(e.whole.lift, sqrt(2500.01 / 1.01), 1e-2);
    e.whole.tail = 9.0;
    assert_true(glint_estimate_rare(&e.whole));
    estimate_one(&e, 101.0f, 99.0f, 1.0f);
    e.whole.tail = 9.0;
    assert_true(e.whole.lift > 1.0 && e.whole.lift < 1.1 && !glint_estimate_rare(&e.whole));
    estimate_one(&e, 0.5f, 0.0f, 1.0f); // brighter neighbours are no sign of rare samples
    assert_float_equal(e.whole.lift, 1.0, 1e-12);
}

// A pixel that a lamp's edge touches has three neighbours of the lamp, and five that say what it is
// where no sample meets it.
static void a_lamp_does_not_vouch_for_a_sample_beside_it(void **state)
{
    (void)state;
    struct glint_film_estimate e;
    estimate_one(&e, 100.0f, 0.0f, 1000.0f);
    assert_float_equal(e.whole.error, sqrt(2500.0 / 1.01 / GK_TILE_PIXELS), 1e-3);
}

static int ascending(const void *a, const void *b)
{
    const double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

// Neighbours of a pixel, in order.
static void sort_around(double v[8], double mean[4][4], int x, int y)
{
    size_t n = 0;
    for (int k = 0; k < 9; k++) { // what stands beyond an edge is what is as far within
        const int column = x + k % 3 - 1, row = y + k / 3 - 1;
        if (k != 4)
            v[n++] = mean[row < 0   ? 1
                          : row > 3 ? 2
                                    : row][column < 0   ? 1
                                           : column > 3 ? 2
                                                        : column];
    }
    qsort(v, 8, sizeof *v, ascending);
}

// What a mean is taken for: quartiles of a normal law lie 0.6745 deviations from its middle.
static double posterior(double mean, double variance, const double v[8])
{
    const double middle = 0.5 * (v[3] + v[4]), off = mean - middle;
    const double up = 0.5 * (v[5] + v[6]) - middle, down = middle - 0.5 * (v[1] + v[2]);
    const double law = fmax(off * off - variance, up / 0.6745 * down / 0.6745);
    return variance > 0.0 ? (mean * law + middle * variance) / (law + variance) : mean;
}

// Sixteen pixels of light that either half may have alone, as a plain sort of neighbours has them.
static void neighbours_speak_by_their_quartiles(void **state)
{
    (void)state;
    static float planes[GK_PLANES_BASE * GK_TILE_PIXELS];
    const struct glint_estimate_source source = {.planes = planes, .samples = 2};
    double mean[4][4], variance[4][4], around[8], expected = 0.0;
    struct glint_tile_estimate e;
    for (uint32_t i = 0; i < 16; i++) {
        const double a = (double)(i * 7 % 16), b = (double)(i * 11 % 5);
        for (uint32_t plane = 0; plane < 6; plane++)
            planes[plane * GK_SUM_PLANES * GK_TILE_PIXELS + i / 4 * GK_TILE_SIDE + i % 4] =
                (float)(plane < 3 ? a : b);
        mean[i / 4][i % 4] = 0.5 * (a + b);
        variance[i / 4][i % 4] = 0.25 * (a - b) * (a - b);
    }
    for (int i = 0; i < 16; i++) {
        sort_around(around, mean, i % 4, i / 4);
        const double m = mean[i / 4][i % 4], v = variance[i / 4][i % 4];
        const double taken = posterior(m, v, around);
        expected += 3.0 * v / (taken * taken + 0.01);
    }
    glint_estimate_tile(&e, &source, 4, 4);
    assert_float_equal(e.relative, expected, 1e-9 * expected);
    assert_true(e.relative > 1.01 * e.own);
}

#define FLASH 10.0 // what one sample in so many has, in a pixel of 0.2

static float sum_of_half(uint32_t *key, uint32_t samples, double odds)
{
    double sum = 0.2 * samples;
    for (uint32_t s = 0; s < samples; s++)
        sum += (gk_mix32((*key)++) + 0.5) / 4294967296.0 < odds ? FLASH : 0.0;
    return (float)sum;
}

// The square of the estimate of tiles whose pixels flash, and of that by their own means, over the truth.
static void estimate_flashing(double ratio[2], uint32_t tiles, uint32_t samples, double odds)
{
    static float planes[GK_PLANES_BASE * GK_TILE_PIXELS];
    const struct glint_estimate_source source = {.planes = planes, .samples = samples};
    const double mean = 0.2 + FLASH * odds, variance = FLASH * FLASH * odds * (1.0 - odds);
    const double truth = 3.0 * GK_TILE_PIXELS * variance / samples / (mean * mean + 0.01);
    struct glint_tile_estimate e;
    uint32_t key = 1;
    ratio[0] = ratio[1] = 0.0;
    for (uint32_t t = 0; t < tiles; t++) {
        for (uint32_t half = 0; half < 2; half++)
            for (uint32_t i = 0; i < GK_TILE_PIXELS; i++)
                for (uint32_t c = 0; c < 3; c++)
                    planes[(3 * half + c) * GK_SUM_PLANES * GK_TILE_PIXELS + i] =
                        c ? planes[3 * half * GK_SUM_PLANES * GK_TILE_PIXELS + i]
                          : sum_of_half(&key, samples / 2, odds);
        glint_estimate_tile(&e, &source, GK_TILE_SIDE, GK_TILE_SIDE);
        ratio[0] += e.relative / truth / tiles;
        ratio[1] += e.own / truth / tiles;
    }
}

// Of 64 samples one in 3000 is fifty times as bright, in n = 100 * 256 pixels. Some 550 flashes have
// all of the variance, by which s of a square's ratio is .045, and 4.892 s = .22; squares of own means are off by
// .6 and more, which is seen with more than 99.9 %.
static void estimates_of_pixels_that_flash_are_of_the_truth(void **state)
{
    (void)state;
    double ratio[2];
    estimate_flashing(ratio, 100, 64, 1.0 / 3000.0);
    print_message("# by neighbours %.3f, by its own mean %.3f\n", ratio[0], ratio[1]);
    assert_float_equal(ratio[0], 1.0, 0.22);
    assert_true(ratio[1] < 0.6);
}

// Tiles whose pixels' variances lie above x in 1 / x^2 of cases.
static void estimate_tailed(struct glint_film_estimate *out, uint32_t tiles)
{
    struct glint_tile_estimate *tile = calloc(tiles, sizeof *tile);
    assert_non_null(tile);
    for (uint32_t t = 0; t < tiles; t++)
        for (int j = 0; j < 60; j++) {
            const double share = exp2(-0.5 * j) - exp2(-0.5 * (j + 1));
            tile[t].tail[GLINT_TAIL_BINS / 2 + j] =
                (uint8_t)(share * GK_TILE_PIXELS + fmod(0.618034 * t, 1.0));
        }
    glint_estimate_film(out, tile, tiles, 1, (uint64_t)tiles * GK_TILE_PIXELS);
    free(tile);
}

static void few_pixels_prove_no_heavy_tail(void **state)
{
    (void)state;
    struct glint_film_estimate e;
    estimate_tailed(&e, 1000);
    assert_true(e.whole.tail > 1.9 && e.whole.tail < 2.3 && glint_estimate_rare(&e.whole));
    estimate_tailed(&e, 2);
    assert_true(e.whole.tail > 2.5 && !glint_estimate_rare(&e.whole));
}

static void looks_come_in_whole_passes_and_ever_rarer(void **state)
{
    (void)state;
    uint32_t last = 0, looks = 0;
    for (uint32_t n = 1; n <= 4096; n++) {
        const uint32_t look = glint_estimate_look(n);
        if (!look)
            continue;
        assert_int_equal(look, looks + 1);
        assert_int_equal(n % 16, 0);
        assert_true(last == 0 || n <= last * 2);
        last = n;
        looks++;
    }
    assert_in_range(looks, 20, 40);
}

static int start(void **state)
{
    (void)state;
    offline_start(&o, 1);
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
        cmocka_unit_test(exact_coverage_has_a_limit_that_is_named),
        cmocka_unit_test(tiles_cover_a_region_of_any_size),
        cmocka_unit_test(tiles_share_no_memory),
        cmocka_unit_test(a_film_is_no_memory_in_use_before_it_is_written_to),
        cmocka_unit_test(depth_starts_at_a_miss),
        cmocka_unit_test(release_without_samples_changes_no_version),
        cmocka_unit_test(readers_never_see_a_tile_half_written),
        cmocka_unit_test(halves_share_samples_evenly),
        cmocka_unit_test(estimate_is_the_square_of_half_the_difference),
        cmocka_unit_test(halves_weigh_by_their_samples),
        cmocka_unit_test(a_rare_sample_does_not_hide_in_its_own_mean),
        cmocka_unit_test(a_lamp_does_not_vouch_for_a_sample_beside_it),
        cmocka_unit_test(neighbours_speak_by_their_quartiles),
        cmocka_unit_test(estimates_of_pixels_that_flash_are_of_the_truth),
        cmocka_unit_test(few_pixels_prove_no_heavy_tail),
        cmocka_unit_test(looks_come_in_whole_passes_and_ever_rarer),
    };
    return cmocka_run_group_tests(tests, start, finish);
}
