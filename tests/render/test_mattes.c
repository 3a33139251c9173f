// ID coverage as the renderer gives it: the share of a pixel that a name covers, by geometry where
// that is known, and exact in its bookkeeping. Seeds are fixed; bounds are stated beside each test.
#include "tests/render/picture.h"
#include "tests/render/things.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CLASHING "object_8333" // has the ID of "object_48770"
#define RARE 5.0               // standard deviations: one of two million draws is beyond

// ---- geometry

static double overlap(double a, double b, double c, double d)
{
    return fmax(0.0, fmin(b, d) - fmax(a, c));
}

// Area that pixel i shares with a rectangle.
static double share(size_t i, double left, double right, double bottom, double top)
{
    const double x = (double)(i % WIDTH) - WIDTH / 2.0, y = HEIGHT / 2.0 - (double)(i / WIDTH);
    return overlap(x, x + 1, left, right) * overlap(y - 1, y, bottom, top);
}

static double share_of(size_t i, const struct thing *t)
{
    return share(i, t->x - t->w / 2, t->x + t->w / 2, t->y - t->h / 2, t->y + t->h / 2);
}

// n independent samples would be further off once in two million; ours are better spread.
static void assert_share(double got, double want, double n)
{
    const double bound = RARE * sqrt(want * fmax(0.0, 1.0 - want) / n) + 1e-6;
    if (fabs(got - want) > bound)
        print_error("coverage %.6f where %.6f is expected\n", got, want);
    assert_true(fabs(got - want) <= bound);
}

static void coverage_is_the_share_of_the_pixel_that_a_quad_covers(void **state)
{
    (void)state;
    const struct thing quad = {"quad", "m", "", 0.85, -0.6, 0, 9.4, 6.3, NULL, false};
    struct shot s;
    shoot_things(&s, &quad, 1, "", BOX, 1024);
    for (size_t i = 0; i < pixels(s.frame); i++) {
        assert_share(coverage_of(s.frame, "CryptoObject", "quad", i), share_of(i, &quad), 1024);
        assert_share(coverage_of_id(s.frame, "CryptoObject", 0, i), 1.0 - share_of(i, &quad), 1024);
    }
    finish_shot(&s);
}

// Probability that a Blackman-Harris offset of full width 1.5 is below x: the window's integral.
static double bell_below(double x)
{
    const double t = fmax(-1.0, fmin(1.0, x / 0.75)), a0 = 0.35875, a1 = 0.48829, a2 = 0.14128,
                 a3 = 0.01168;
    return 0.5 + 0.5 * (t + (a1 * sin(M_PI * t) + a2 / 2 * sin(2 * M_PI * t) +
                             a3 / 3 * sin(3 * M_PI * t)) /
                                (M_PI * a0));
}

static void coverage_has_the_weights_of_the_pixel_filter(void **state)
{
    (void)state;
    const double edge = 0.3;
    const struct thing half = {"half", "m", "", edge - 50, 0, 0, 100, 100, NULL, false};
    struct shot s;
    shoot_things(&s, &half, 1, "", "\"filter\":{\"kind\":\"blackman_harris\",\"width\":1.5},",
                 1024);
    for (size_t x = 0; x < WIDTH; x++) {
        double sum = 0.0;
        for (size_t y = 0; y < HEIGHT; y++)
            sum += coverage_of(s.frame, "CryptoObject", "half", y * WIDTH + x);
        assert_share(sum / HEIGHT, bell_below(edge - ((double)x + 0.5 - WIDTH / 2.0)),
                     1024 * HEIGHT);
    }
    finish_shot(&s);
}

// Share of a unit disk that lies left of t.
static double disk_below(double t)
{
    t = fmax(-1.0, fmin(1.0, t));
    return 0.5 + (t * sqrt(1.0 - t * t) + asin(t)) / M_PI;
}

static void assert_coverage_is_alpha(const struct glint_frame *f, const char *name)
{
    const float *alpha = glint_frame_find(f, "A");
    for (size_t i = 0; i < pixels(f); i++)
        assert_true((float)coverage_of(f, "CryptoObject", name, i) == alpha[i]);
}

// The plane of focus is z = 0; an edge halfway to it is seen through a lens of radius 4. A point of
// the lens at x sees it at 2 edge - x on the plane of focus: a blur of 4 pixels' radius.
static void defocused_edge_has_the_coverage_of_its_circle_of_confusion(void **state)
{
    (void)state;
    const double edge = 0.4;
    const struct thing near = {"near", "m", "", edge - 100, 0, 8, 200, 200, NULL, false};
    struct shot s;
    shoot_things(&s, &near, 1, ",\"lens_radius\":4,\"focus_distance\":16", BOX, 1024);
    for (size_t x = 0; x < WIDTH; x++) {
        double sum = 0.0, want = 0.0;
        for (size_t y = 0; y < HEIGHT; y++)
            sum += coverage_of(s.frame, "CryptoObject", "near", y * WIDTH + x) / HEIGHT;
        for (int k = 0; k < 64; k++)
            want += disk_below((2 * edge - ((double)x + (k + 0.5) / 64 - WIDTH / 2.0)) / 4.0) / 64;
        assert_share(sum, want, 1024 * HEIGHT);
    }
    assert_coverage_is_alpha(s.frame, "near");
    finish_shot(&s);
}

// Between texel centres alpha is interpolated; of a checkerboard it crosses 1/2 on the texels' sides.
static void cutouts_let_through_the_share_of_their_holes(void **state)
{
    (void)state;
    char *checks = picture_checkerboard();
    const struct thing scene[] = {{"sieve", "m", "", 0.3, 0.45, 0, 8, 8, checks, false},
                                  {"wall", "w", "", 0, 0, -1, 100, 100, NULL, false}};
    struct shot s;
    shoot_things(&s, scene, 2, "", BOX, 1024);
    for (size_t i = 0; i < pixels(s.frame); i++) {
        double want = 0.0;
        for (int t = 0; t < 64; t++) {
            const double left = scene->x - 4 + t % 8, top = scene->y + 4 - t / 8;
            want += (t % 8 + t / 8) % 2 ? 0.0 : share(i, left, left + 1, top - 1, top);
        }
        assert_share(coverage_of(s.frame, "CryptoObject", "sieve", i), want, 1024);
        assert_share(coverage_of(s.frame, "CryptoObject", "wall", i), 1.0 - want, 1024);
    }
    finish_shot(&s);
    shoot_things(&s, scene, 1, ",\"lens_radius\":1,\"focus_distance\":12", "", 64);
    assert_coverage_is_alpha(s.frame, "sieve");
    finish_shot(&s);
    free(checks);
}

// ---- layers

static void coverages_of_every_pixel_sum_to_one(void **state)
{
    (void)state;
    static const char *const type[] = {"CryptoObject", "CryptoMaterial", "CryptoAsset"};
    struct shot s;
    shoot_things(&s, crowd, CROWD, LENS, ALL_RANKS, 96);
    assert_true(lost_in(&s) == 0.0);
    for (size_t l = 0; l < COUNT(type); l++)
        for (size_t i = 0; i < pixels(s.frame); i++) {
            double sum = 0.0;
            for (uint32_t k = 0; k < 16; k++)
                sum += rank_coverage(s.frame, type[l], k, i);
            assert_float_equal(sum, 1.0, 1e-5);
        }
    finish_shot(&s);
}

// Sum over the names of the crowd's members that have a material, or an asset.
static double sum_of_objects(const struct glint_frame *f, const char *material, const char *asset,
                             size_t pixel)
{
    double sum = 0.0;
    for (size_t i = 0; i < CROWD - 2; i++) // the twins are not told apart
        if ((!material || strcmp(crowd[i].material, material) == 0) &&
            (!asset || strcmp(crowd[i].asset, asset) == 0))
            sum += coverage_of(f, "CryptoObject", crowd[i].name, pixel);
    return sum;
}

static void materials_and_assets_are_sums_of_their_objects(void **state)
{
    (void)state;
    static const char *const material[] = {"red", "green", "blue"};
    struct shot s;
    shoot_things(&s, crowd, CROWD - 2, LENS, ALL_RANKS, 96);
    for (size_t i = 0; i < pixels(s.frame); i++) {
        for (size_t m = 0; m < COUNT(material); m++)
            assert_float_equal(coverage_of(s.frame, "CryptoMaterial", material[m], i),
                               sum_of_objects(s.frame, material[m], NULL, i), 1e-6);
        assert_float_equal(coverage_of(s.frame, "CryptoAsset", "set", i),
                           sum_of_objects(s.frame, NULL, "set", i), 1e-6);
        // What belongs to no asset is 0, as the background is.
        assert_float_equal(coverage_of_id(s.frame, "CryptoAsset", 0, i),
                           coverage_of_id(s.frame, "CryptoObject", 0, i) +
                               sum_of_objects(s.frame, NULL, "", i),
                           1e-6);
    }
    finish_shot(&s);
}

static void objects_with_equal_names_share_one_matte(void **state)
{
    (void)state;
    // They meet inside a column of pixels.
    const struct thing pair[] = {{"twin", "red", "", -0.25, 0.1, 0, 6.7, 4, NULL, false},
                                 {"twin", "blue", "", 5.6, 0.1, 0, 5, 4, NULL, false}};
    struct shot s;
    shoot_things(&s, pair, 2, "", BOX, 1024);
    for (size_t i = 0; i < pixels(s.frame); i++) {
        assert_share(coverage_of(s.frame, "CryptoObject", "twin", i),
                     share_of(i, &pair[0]) + share_of(i, &pair[1]), 1024);
        assert_false(rank_id(s.frame, "CryptoObject", 0, i) ==
                         rank_id(s.frame, "CryptoObject", 1, i) &&
                     rank_coverage(s.frame, "CryptoObject", 1, i) > 0.0f);
    }
    struct glint_matte_totals totals;
    assert_int_equal(glint_render_mattes(s.render, 1u << GLINT_MATTE_OBJECT, &totals, NULL),
                     GLINT_OK);
    assert_int_equal(totals.count[GLINT_MATTE_OBJECT], 1);
    assert_string_equal(totals.of[GLINT_MATTE_OBJECT]->name, "twin");
    assert_float_equal(totals.of[GLINT_MATTE_OBJECT]->coverage[0], 6.7 * 4 + 5 * 4, 0.05);
    assert_null(totals.of[GLINT_MATTE_ASSET]);
    glint_matte_totals_finish(&totals);
    finish_shot(&s);
}

// ---- ranks

// Each quarter of the pixel at the middle of an odd frame gets a quarter of a power of two of
// Sobol samples, exactly.
static void names_that_share_an_id_are_told_apart(void **state)
{
    (void)state;
    static const char *const name[] = {"object_48770", CLASHING, CLASHING "~2"};
    const struct thing pair[] = {{name[0], "red", "", -0.25, 0.1, 0, 6.7, 4, NULL, false},
                                 {name[1], "blue", "", 5.6, 0.1, 0, 5, 4, NULL, false}};
    struct shot s;
    assert_int_equal(glint_cryptomatte_id(name[0]), glint_cryptomatte_id(name[1]));
    shoot_things(&s, pair, 2, "", BOX, 64);
    for (size_t i = 0; i < pixels(s.frame); i++) {
        assert_share(coverage_of(s.frame, "CryptoObject", name[0], i), share_of(i, &pair[0]), 64);
        assert_share(coverage_of(s.frame, "CryptoObject", name[2], i), share_of(i, &pair[1]), 64);
    }
    struct glint_matte_totals totals;
    assert_int_equal(glint_render_mattes(s.render, 1u << GLINT_MATTE_OBJECT, &totals, NULL),
                     GLINT_OK);
    assert_int_equal(totals.count[GLINT_MATTE_OBJECT], 2);
    assert_string_equal(totals.of[GLINT_MATTE_OBJECT][0].name, name[0]);
    assert_string_equal(totals.of[GLINT_MATTE_OBJECT][1].name, name[2]);
    glint_matte_totals_finish(&totals);
    finish_shot(&s);
}

static void equal_coverages_are_ranked_by_the_bits_of_their_ids(void **state)
{
    (void)state;
    const struct thing quarter[] = {{"torus", "m", "", -20, 20, 0, 40, 40, NULL, false},
                                    {"bunny", "m", "", 20, 20, 0, 40, 40, NULL, false},
                                    {"default", "m", "", -20, -20, 0, 40, 40, NULL, false}};
    struct shot s;
    glint_resident *scene = load_things(quarter, 3, "");
    shoot(&s, scene,
          "{\"scene\":\"s\",\"resolution\":[5,3]," BOX
          "\"max_bounces\":0,\"stop\":{\"samples\":128}}");
    const size_t middle = 7;
    static const uint32_t ascending[] = {0, 0x13851a76, 0x42c9679f,
                                         0xf19c73fd}; // CONVENTIONS' table
    for (uint32_t k = 0; k < 4; k++) {
        assert_true(rank_coverage(s.frame, "CryptoObject", k, middle) == 0.25f);
        assert_int_equal(rank_id(s.frame, "CryptoObject", k, middle), ascending[k]);
    }
    finish_shot(&s);
    glint_resident_release(&scene);
}

static void assert_ranked(const struct glint_frame *f, const char *type, size_t pixel)
{
    for (uint32_t k = 1; k < 16; k++) {
        const float before = rank_coverage(f, type, k - 1, pixel),
                    c = rank_coverage(f, type, k, pixel);
        const uint32_t id = rank_id(f, type, k, pixel);
        assert_true(before >= c);
        assert_true(c > 0.0f || id == 0);
        assert_true(before > c || c == 0.0f || rank_id(f, type, k - 1, pixel) < id);
        for (uint32_t j = 0; j < k && c > 0.0f; j++)
            assert_true(rank_id(f, type, j, pixel) != id);
    }
}

static void ranks_descend_each_id_has_one_and_so_has_the_background(void **state)
{
    (void)state;
    struct shot s;
    shoot_things(&s, crowd, CROWD, LENS, ALL_RANKS, 96);
    bool background_below_another = false;
    for (size_t i = 0; i < pixels(s.frame); i++) {
        assert_ranked(s.frame, "CryptoObject", i);
        assert_ranked(s.frame, "CryptoMaterial", i);
        assert_ranked(s.frame, "CryptoAsset", i);
        for (uint32_t k = 1; k < 16; k++)
            background_below_another |= rank_coverage(s.frame, "CryptoObject", k, i) > 0.0f &&
                                        rank_id(s.frame, "CryptoObject", k, i) == 0;
    }
    assert_true(background_below_another);
    finish_shot(&s);
}

static void fewer_levels_are_the_first_ranks_of_more_whatever_the_slots(void **state)
{
    (void)state;
    static const uint32_t slots[] = {4, 6, 8, 12, 20, 32};
    const size_t things = 3; // and the background: as many keys as the smallest table has slots
    struct shot full;
    shoot_things(&full, crowd, things, LENS, ALL_RANKS, 32);
    for (size_t n = 0; n < COUNT(slots); n++)
        for (uint32_t levels = 1; levels <= 16 && 2 * levels <= slots[n]; levels++) {
            char members[64];
            struct shot s;
            snprintf(members, sizeof members, "\"mattes\":{\"levels\":%u,\"slots\":%u},", levels,
                     slots[n]);
            shoot_things(&s, crowd, things, LENS, members, 32);
            assert_true(lost_in(&s) == 0.0);
            assert_null(layer_plane(s.frame, "CryptoObject", (levels + 1) / 2 * 2, false));
            for (uint32_t k = 0; k < (levels + 1) / 2 * 2; k++)
                for (size_t i = 0; i < pixels(s.frame); i++) {
                    const bool written = k < levels;
                    assert_int_equal(rank_id(s.frame, "CryptoObject", k, i),
                                     written ? rank_id(full.frame, "CryptoObject", k, i) : 0);
                    assert_true(rank_coverage(s.frame, "CryptoObject", k, i) ==
                                (written ? rank_coverage(full.frame, "CryptoObject", k, i) : 0.0f));
                }
            finish_shot(&s);
        }
    finish_shot(&full);
}

// ---- full tables

#define STRIPS 40

// One pixel, covered by 40 strips of equal width; strips outside [first, first + named) are "rest".
static void shoot_strips(struct shot *s, size_t first, size_t named, const char *mattes)
{
    struct thing strip[STRIPS];
    char name[STRIPS][8], job[256];
    for (size_t i = 0; i < STRIPS; i++) {
        const bool own = i >= first && i < first + named;
        snprintf(name[i], sizeof name[i], own ? "s%zu" : "rest", i);
        // A frame of one pixel is 16 units wide; the outer strips reach beyond it.
        const double left = i == 0 ? -20.0 : -8.0 + 16.0 * (double)i / STRIPS;
        const double right = i == STRIPS - 1 ? 20.0 : -8.0 + 16.0 * (double)(i + 1) / STRIPS;
        strip[i] = (struct thing){name[i], "m",  "",   (left + right) / 2, 0, 0, right - left,
                                  40,      NULL, false};
    }
    snprintf(job, sizeof job,
             "{\"scene\":\"s\",\"resolution\":[1,1]," BOX
             "%s\"max_bounces\":0,\"stop\":{\"samples\":1000}}",
             mattes);
    glint_resident *scene = load_things(strip, STRIPS, "");
    shoot(s, scene, job);
    glint_resident_release(&scene);
}

// Pixels that each strip covers, and all that found no slot.
static double strip_totals(const struct shot *s, double covered[STRIPS])
{
    struct glint_matte_totals totals;
    assert_int_equal(glint_render_mattes(s->render, 1u << GLINT_MATTE_OBJECT, &totals, NULL),
                     GLINT_OK);
    const struct glint_matte_total *total = totals.of[GLINT_MATTE_OBJECT];
    for (size_t i = 0; i < totals.count[GLINT_MATTE_OBJECT]; i++)
        if (total[i].name[0] == 's')
            covered[atoi(total[i].name + 1)] = total[i].coverage[0];
    const double lost = totals.lost[0];
    assert_true(totals.lost[1] == 0.0);
    glint_matte_totals_finish(&totals);
    return lost;
}

// Coverage of the union of all strips.
static double strips_together(const struct shot *s)
{
    char name[STRIPS][8];
    const char *names[STRIPS];
    struct glint_frame *matte;
    for (size_t i = 0; i < STRIPS; i++) {
        snprintf(name[i], sizeof name[i], "s%zu", i);
        names[i] = name[i];
    }
    assert_int_equal(
        glint_render_matte(s->render, GLINT_MATTE_OBJECT, 1u, names, STRIPS, &matte, NULL),
        GLINT_OK);
    const double coverage = glint_frame_find(matte, "A")[0];
    glint_frame_destroy(&matte);
    return coverage;
}

// What each strip gets where the table has room for all that are told apart.
static void true_coverages(double covered[STRIPS])
{
    for (size_t first = 0; first < STRIPS; first += 10) {
        struct shot s;
        shoot_strips(&s, first, 10, "");
        assert_true(strip_totals(&s, covered) == 0.0);
        finish_shot(&s);
    }
}

static void what_finds_no_slot_is_reported_and_credited_to_nobody(void **state)
{
    (void)state;
    double truth[STRIPS] = {0}, all = 0.0;
    true_coverages(truth);
    for (size_t i = 0; i < STRIPS; i++)
        all += truth[i];
    assert_float_equal(all, 1.0, 1e-12);
    for (uint32_t slots = 12; slots <= 32; slots += 4) {
        char mattes[64];
        double covered[STRIPS] = {0}, kept = 0.0;
        struct shot s;
        snprintf(mattes, sizeof mattes,
                 "\"mattes\":{\"levels\":6,\"slots\":%u,\"eviction\":\"drop\"},", slots);
        shoot_strips(&s, 0, STRIPS, mattes);
        const double lost = strip_totals(&s, covered);
        uint32_t held = 0;
        for (size_t i = 0; i < STRIPS; i++) {
            assert_true(covered[i] == 0.0 || covered[i] == truth[i]);
            held += covered[i] > 0.0;
            kept += covered[i];
        }
        assert_int_equal(held, slots);
        assert_true(lost > 0.0);
        assert_float_equal(kept + lost, 1.0, 1e-12);
        assert_float_equal(strips_together(&s), kept, 1e-6);
        finish_shot(&s);
    }
}

static void what_finds_no_slot_has_a_place_of_its_tile(void **state)
{
    (void)state;
    double truth[STRIPS] = {0}, covered[STRIPS] = {0};
    struct shot s;
    true_coverages(truth);
    shoot_strips(&s, 0, STRIPS, "\"mattes\":{\"levels\":2,\"slots\":4},");
    assert_true(strip_totals(&s, covered) == 0.0);
    assert_memory_equal(covered, truth, sizeof truth);
    assert_float_equal(strips_together(&s), 1.0, 1e-6);
    finish_shot(&s);
}

static void exact_eviction_keeps_all_that_a_pixel_shows(void **state)
{
    (void)state;
    double truth[STRIPS] = {0}, covered[STRIPS] = {0};
    struct shot s;
    true_coverages(truth);
    shoot_strips(&s, 0, STRIPS, "\"mattes\":{\"eviction\":\"exact\"},");
    assert_true(strip_totals(&s, covered) == 0.0);
    assert_memory_equal(covered, truth, sizeof truth);
    assert_float_equal(strips_together(&s), 1.0, 1e-12);
    finish_shot(&s);
}

static void both_evictions_keep_the_same_of_what_is_seen_directly(void **state)
{
    (void)state;
    double a[STRIPS] = {0}, b[STRIPS] = {0};
    struct shot drop, direct;
    shoot_strips(&drop, 0, STRIPS, "\"mattes\":{\"eviction\":\"drop\"},");
    shoot_strips(&direct, 0, STRIPS, "\"mattes\":{\"eviction\":\"direct_first\"},");
    assert_true(strip_totals(&drop, a) == strip_totals(&direct, b));
    assert_memory_equal(a, b, sizeof a);
    finish_shot(&drop);
    finish_shot(&direct);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(coverage_is_the_share_of_the_pixel_that_a_quad_covers),
        cmocka_unit_test(coverage_has_the_weights_of_the_pixel_filter),
        cmocka_unit_test(defocused_edge_has_the_coverage_of_its_circle_of_confusion),
        cmocka_unit_test(cutouts_let_through_the_share_of_their_holes),
        cmocka_unit_test(coverages_of_every_pixel_sum_to_one),
        cmocka_unit_test(materials_and_assets_are_sums_of_their_objects),
        cmocka_unit_test(objects_with_equal_names_share_one_matte),
        cmocka_unit_test(names_that_share_an_id_are_told_apart),
        cmocka_unit_test(equal_coverages_are_ranked_by_the_bits_of_their_ids),
        cmocka_unit_test(ranks_descend_each_id_has_one_and_so_has_the_background),
        cmocka_unit_test(fewer_levels_are_the_first_ranks_of_more_whatever_the_slots),
        cmocka_unit_test(what_finds_no_slot_is_reported_and_credited_to_nobody),
        cmocka_unit_test(what_finds_no_slot_has_a_place_of_its_tile),
        cmocka_unit_test(exact_eviction_keeps_all_that_a_pixel_shows),
        cmocka_unit_test(both_evictions_keep_the_same_of_what_is_seen_directly),
    };
    return cmocka_run_group_tests(tests, things_start, things_finish);
}
