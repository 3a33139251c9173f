// Sums of tiles added up word for word, and rectangles of tiles read pixel for pixel.
#include "kernels/gk_film.h"
#include "kernels/gk_matte_spill.h"
#include "protocol/film.h"
#include "protocol/film_add.h"
#include "protocol/film_parts.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <string.h>

enum { WORDS = GK_PLANES_BASE * GK_TILE_PIXELS, COLUMNS = 3, ROWS = 3 };

static struct glint_job job = {
    .width = 60,
    .height = 50,
    .region = {5, 3, 40, 35}, // the last tiles of rows and columns are cut
    .outputs = GLINT_OUT_BEAUTY,
    .dial = {[GLINT_DIAL_PRECISION] = 1},
};
static const struct glint_film_info info = {.job = &job, .software = "s", .revision = "r"};

static float *red(float *planes)
{
    return planes + GK_PLANE_COLOUR * GK_TILE_PIXELS;
}

// Addends whose sum takes three floats.
static float addend(int i)
{
    return ldexpf(1.0f + (float)(i * 37 % 101) / 128.0f, -20 * (i % 4));
}

static void films_add_up_to_the_words_of_one(void **state)
{
    (void)state;
    static float one[WORDS], a[WORDS], b[WORDS];
    const uint32_t pixel = 77;
    for (int i = 0; i < 200; i++) {
        gk_film_add(red(one), pixel, addend(i));
        gk_film_add(red(i % 3 ? a : b), pixel, addend(i));
    }
    assert_true(red(one)[pixel + 2 * GK_TILE_PIXELS] != 0.0f);
    glint_film_add_planes(&info, a, pixel, b, pixel);
    for (int k = 0; k < GK_SUM_PLANES; k++)
        assert_memory_equal(&red(a)[pixel + (uint32_t)k * GK_TILE_PIXELS],
                            &red(one)[pixel + (uint32_t)k * GK_TILE_PIXELS], 4);
}

// ---- tables

enum { SLOTS = 4, TABLE = SLOTS + GK_MATTE_LOST_WORDS };

// Units of what is seen directly and of what bounces have brought, in slots and without.
static void add_units(uint64_t sum[2], const uint64_t *table)
{
    for (int i = 0; i < SLOTS; i++)
        sum[!gk_matte_primary(gk_matte_key(table[i]))] += gk_matte_amount(table[i]);
    sum[0] += table[SLOTS + GK_MATTE_LOST_PRIMARY];
    sum[1] += table[SLOTS + GK_MATTE_LOST_BOUNCED];
}

static void fill_table(uint64_t *table, uint32_t policy, uint32_t seed)
{
    struct gk_matte_lost lost = {0, 0};
    memset(table, 0, TABLE * sizeof *table);
    for (uint32_t i = 0; i < 40; i++) {
        const uint32_t bits = gk_mix32(seed + i);
        gk_matte_deposit(table, SLOTS, gk_matte_of_class(1 + bits % 5, bits >> 8 & 1),
                         bits >> 9 & 1, 1 + (bits >> 16), policy, bits * 0x9e3779b9u, &lost);
    }
    table[SLOTS + GK_MATTE_LOST_PRIMARY] = lost.primary;
    table[SLOTS + GK_MATTE_LOST_BOUNCED] = lost.bounced;
}

static void full_tables_add_up_to_the_units_of_both_by_their_kind(void **state)
{
    (void)state;
    struct glint_job crowded = {.matte_slots = SLOTS};
    const struct glint_film_info of = {.job = &crowded};
    uint64_t lost[2] = {0, 0};
    for (uint32_t policy = GK_MATTE_DROP; policy <= GK_MATTE_USS_DIRECT_FIRST; policy++)
        for (uint32_t seed = 0; seed < 100; seed++) {
            uint64_t to[TABLE], from[TABLE], before[2] = {0, 0}, after[2] = {0, 0};
            crowded.dial[GLINT_DIAL_EVICTION] = (uint8_t)policy;
            fill_table(to, policy, 1000 * policy + 2 * seed);
            fill_table(from, policy, 500000 + 1000 * policy + seed);
            add_units(before, to);
            add_units(before, from);
            glint_film_add_table(&of, to, 0, from, 0);
            add_units(after, to);
            assert_true(before[0] == after[0] && before[1] == after[1]);
            lost[0] += to[SLOTS + GK_MATTE_LOST_PRIMARY];
            lost[1] += to[SLOTS + GK_MATTE_LOST_BOUNCED];
        }
    assert_true(lost[0] > 0 && lost[1] > 0);
}

// Pixels that held their names in places of one tile hold them in another, at another pixel.
static void places_of_two_tiles_add_up_by_pixel_and_name(void **state)
{
    (void)state;
    enum { PLACED = TABLE + GK_MATTE_SPILL_WORDS, NAMES = 30 };
    static uint64_t from[GK_TILE_PIXELS * PLACED], to[GK_TILE_PIXELS * PLACED];
    struct glint_job crowded = {.matte_slots = SLOTS};
    const struct glint_film_info of = {.job = &crowded, .mattes = NAMES + 1};
    uint64_t slot[NAMES + GK_MATTE_SPILL_PLACES];
    struct glint_film_held held = {slot, 0};
    struct gk_matte_lost lost = {0, 0};
    crowded.dial[GLINT_DIAL_EVICTION] = GLINT_EVICTION_SPILL;
    for (uint32_t pixel = 0; pixel < 15; pixel += 5)
        for (uint32_t k = 1; k <= NAMES; k++) {
            gk_matte_deposit_tile(from, pixel, SLOTS, k, 1, 100 * pixel + k, GK_MATTE_SPILL, 0,
                                  &lost);
            gk_matte_deposit_tile(to, 239 + pixel, SLOTS, k, 1, 7, GK_MATTE_SPILL, 0, &lost);
        }
    for (uint32_t pixel = 0; pixel < 15; pixel += 5)
        assert_true(glint_film_add_table(&of, to, 239 + pixel, from, pixel) == 0);
    for (uint32_t pixel = 0; pixel < 15; pixel += 5) {
        glint_film_held_read(&of, to, 239 + pixel, &held);
        assert_int_equal(held.count, NAMES);
        for (uint32_t i = 0; i < NAMES; i++)
            assert_true(gk_matte_amount(slot[i]) == 100 * pixel + gk_matte_key(slot[i]) + 7);
    }
    assert_true(lost.primary == 0 && lost.bounced == 0);
}

// ---- rectangles

// Every pixel of the region holds its own number, one sample of half A.
static float tiles[COLUMNS * ROWS][WORDS];

static float number_of(uint32_t x, uint32_t y)
{
    return (float)(1 + y * job.width + x);
}

static void fill(void)
{
    for (uint32_t t = 0; t < COLUMNS * ROWS; t++)
        for (uint32_t i = 0; i < GK_TILE_PIXELS; i++)
            red(tiles[t])[i] =
                number_of(job.region[0] + t % COLUMNS * GK_TILE_SIDE + i % GK_TILE_SIDE,
                          job.region[1] + t / COLUMNS * GK_TILE_SIDE + i / GK_TILE_SIDE);
}

static glint_status begin(void *user, uint32_t tile, struct glint_film_pixels *out,
                          struct glint_error *err)
{
    (void)user;
    (void)err;
    assert_in_range(tile, 0, COLUMNS * ROWS - 1);
    *out = (struct glint_film_pixels){.planes = tiles[tile], .half = {1, 0}};
    return GLINT_OK;
}

static void end(void *user, uint32_t tile)
{
    (void)user;
    (void)tile;
}

static void check_rectangle(const uint32_t rect[4])
{
    const struct glint_film_source source = {
        .info = &info, .complete = true, .begin = begin, .end = end};
    struct glint_frame *frame;
    uint32_t samples;
    assert_int_equal(glint_film_frame(&source, rect, GLINT_OUT_BEAUTY, &frame, &samples, NULL),
                     GLINT_OK);
    assert_int_equal(samples, 1);
    const float *r = glint_frame_find(frame, "R");
    for (uint32_t y = 0; y < rect[3]; y++)
        for (uint32_t x = 0; x < rect[2]; x++)
            assert_true(r[y * rect[2] + x] == number_of(rect[0] + x, rect[1] + y));
    glint_frame_destroy(&frame);
}

static void every_rectangle_has_the_pixels_of_its_tiles(void **state)
{
    (void)state;
    const uint32_t *r = job.region;
    fill();
    for (uint32_t first = 0; first < r[2]; first++)
        for (uint32_t last = first; last < r[2]; last += 3)
            check_rectangle((uint32_t[]){r[0] + first, r[1], last - first + 1, 1});
    for (uint32_t first = 0; first < r[3]; first++)
        for (uint32_t last = first; last < r[3]; last++)
            check_rectangle((uint32_t[]){r[0] + 15, r[1] + first, 2, last - first + 1});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(films_add_up_to_the_words_of_one),
        cmocka_unit_test(full_tables_add_up_to_the_units_of_both_by_their_kind),
        cmocka_unit_test(places_of_two_tiles_add_up_by_pixel_and_name),
        cmocka_unit_test(every_rectangle_has_the_pixels_of_its_tiles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
