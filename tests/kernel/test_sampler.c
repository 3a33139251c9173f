// The sampler: every pair is a scrambled (0,2)-sequence in each half, the place in the pixel and the
// first direction are a (0,4)-sequence in base 4 together, and other pairs, halves and pixels have
// nothing to do with each other.
#include "kernels/gk_sampler.h"
#include "tests/kernel/check.h"

#include <stdlib.h>

enum { LOG_NET = 10, DIMENSIONS = 32 };

static gk_u32 order_of(gk_u32 base, gk_u32 index, gk_u32 bounce)
{
    return gk_sample_order(base, index, GK_PAIR_BOUNCE(bounce, GK_PAIR_ORDER));
}

// A pair as kernels take it: that of the filter across the order of the first vertex, those for light
// and direction in the order of theirs, others in one of their own.
static void take_bits(gk_u32 base, gk_u32 index, gk_u32 pair, gk_u32 *u, gk_u32 *v)
{
    const gk_u32 kind = pair & 7, bounce = pair / 8 - 1;
    if (pair == GK_PAIR_FILTER)
        gk_sample_crossed_bits(base, order_of(base, index, 0), pair, u, v);
    else if (pair >= 8 && (kind == GK_PAIR_LIGHT_POINT || kind == GK_PAIR_BSDF))
        gk_sample_ordered_bits(base, order_of(base, index, bounce), pair, u, v);
    else
        gk_sample_2d_bits(base, index, pair, u, v);
}

static void take(gk_u32 base, gk_u32 index, gk_u32 pair, gk_f32 *u, gk_f32 *v)
{
    gk_u32 a, b;
    take_bits(base, index, pair, &a, &b);
    *u = gk_unit_float(a);
    *v = gk_unit_float(b);
}

// Points [first, first + 2^m) of a pair lie one in each of the 2^k x 2^(m-k) boxes.
static void check_boxes(gk_u32 base, gk_u32 pair, gk_u32 first, int m, int k)
{
    static uint8_t seen[1 << LOG_NET];
    memset(seen, 0, (size_t)1 << m);
    for (gk_u32 i = 0; i < 1u << m; i++) {
        gk_u32 u, v;
        take_bits(base, first + i, pair, &u, &v);
        const gk_u32 column = (gk_u32)((uint64_t)u >> (32 - k));
        const gk_u32 row = (gk_u32)((uint64_t)v >> (32 - (m - k)));
        if (seen[row << k | column]++)
            fail_msg("pair %u, points %u + 2^%d: two in one box of 2^%d x 2^%d", pair, first, m, k,
                     m - k);
    }
}

static void check_nets(gk_u32 base, gk_u32 pair, gk_u32 block)
{
    for (int m = 0; m <= LOG_NET; m++)
        for (int k = 0; k <= m; k++)
            check_boxes(base, pair, block << m, m, k);
}

static void every_power_of_two_of_samples_is_a_net_in_every_pair(void **state)
{
    (void)state;
    for (gk_u32 part = 0; part < 2; part++)
        for (gk_u32 pair = 0; pair < 64; pair += 3)
            check_nets(gk_sampler_base(100 + pair, 7, 1, part), pair, 0);
}

static void later_blocks_are_nets_too(void **state)
{
    (void)state;
    for (gk_u32 block = 1; block < 12; block++)
        check_nets(gk_sampler_base(3, block, 9, block & 1), 11 + block, block * block);
    check_nets(gk_sampler_base(1, 2, 3, 0), 5, (1u << 22) - 1); // up to index 2^32 - 1
    check_nets(gk_sampler_base(1, 2, 3, 1), GK_PAIR_FILTER, (1u << 22) - 1);
}

// Which of the 4^k parts of [0, 1) a fraction of 2^32 lies in.
static gk_u32 quarter(gk_u32 u, int k)
{
    return (gk_u32)((uint64_t)u >> (32 - 2 * k));
}

// Points [first, first + 4^m) of two pairs lie one in each of the boxes of 4^-k[0] x ... x 4^-k[3].
static void check_boxes_of_both(const gk_u32 (*point)[4], int m, const int k[4])
{
    static uint8_t seen[1 << 8];
    memset(seen, 0, (size_t)1 << 2 * m);
    for (int i = 0; i < 1 << 2 * m; i++) {
        gk_u32 box = 0;
        for (int d = 0; d < 4; d++)
            box = box << 2 * k[d] | quarter(point[i][d], k[d]);
        if (seen[box]++)
            fail_msg("4^%d points: two in one box of %d %d %d %d", m, k[0], k[1], k[2], k[3]);
    }
}

static void check_nets_of_both(gk_u32 base, gk_u32 pair, gk_u32 block, int m)
{
    gk_u32 point[1 << 8][4];
    for (gk_u32 i = 0; i < 1u << 2 * m; i++) {
        const gk_u32 index = (block << 2 * m) + i;
        take_bits(base, index, GK_PAIR_FILTER, &point[i][0], &point[i][1]);
        take_bits(base, index, pair, &point[i][2], &point[i][3]);
    }
    for (int a = 0; a <= m; a++)
        for (int b = 0; a + b <= m; b++)
            for (int c = 0; a + b + c <= m; c++)
                check_boxes_of_both((const gk_u32(*)[4])point, m, (int[4]){a, b, c, m - a - b - c});
}

static void place_and_first_vertex_are_nets_in_four_dimensions(void **state)
{
    (void)state;
    for (gk_u32 pixel = 0; pixel < 50; pixel++)
        for (int m = 0; m <= 4; m++) {
            const gk_u32 base = gk_sampler_base(pixel, 11, 5, pixel & 1);
            check_nets_of_both(base, GK_PAIR_BOUNCE(0, GK_PAIR_BSDF), pixel, m);
            check_nets_of_both(base, GK_PAIR_BOUNCE(0, GK_PAIR_LIGHT_POINT), pixel, m);
        }
}

// One point in each of N strips moves the mean by half a strip at most.
static void means_are_within_half_a_stratum(void **state)
{
    (void)state;
    for (gk_u32 pixel = 0; pixel < 200; pixel++) {
        double sum_u = 0, sum_v = 0;
        for (gk_u32 i = 0; i < 256; i++) {
            gk_f32 u, v;
            take(gk_sampler_base(pixel, 0, 0, 1), i, 3, &u, &v);
            sum_u += u;
            sum_v += v;
        }
        assert_within(sum_u / 256 - 0.5, 0.5 / 256 + 0x1p-24);
        assert_within(sum_v / 256 - 0.5, 0.5 / 256 + 0x1p-24);
    }
}

// The seed of a picture.
static gk_u32 fresh(gk_u32 fixed)
{
    return (gk_u32)odds_seed(fixed);
}

// Over scrambles one and the same element is uniform: 10^6 pixels, 32 x 32 cells.
static void each_element_is_uniform_over_pixels(void **state)
{
    (void)state;
    static const gk_u32 element[] = {0, 1, 5, 1000003};
    static uint32_t count[1024];
    static double probability[1024];
    for (size_t e = 0; e < sizeof element / sizeof *element; e++) {
        memset(count, 0, sizeof count);
        for (gk_u32 i = 0; i < 1000000; i++) {
            gk_u32 u, v;
            const gk_u32 base = gk_sampler_base(i % 1000, i / 1000, fresh(4), (gk_u32)e & 1);
            take_bits(base, element[e], 8, &u, &v);
            count[u >> 27 << 5 | v >> 27]++;
        }
        for (size_t c = 0; c < 1024; c++)
            probability[c] = 1.0 / 1024;
        assert_odds_chi2(check_chi2(count, probability, 1024, 1e6));
    }
}

static void all_32_bits_are_fair(void **state)
{
    (void)state;
    enum { N = 200000 };
    uint32_t ones[2][32] = {{0}};
    for (gk_u32 i = 0; i < N; i++) {
        gk_u32 value[2];
        take_bits(gk_sampler_base(i % 500, i / 500, fresh(1), 0), i & 15, 9, &value[0], &value[1]);
        for (int c = 0; c < 2; c++)
            for (int b = 0; b < 32; b++)
                ones[c][b] += value[c] >> b & 1;
    }
    for (int c = 0; c < 2; c++)
        for (int b = 0; b < 32; b++)
            assert_odds(ones[c][b] - 0.5 * N, 0.5 * sqrt(N), 0);
}

static void values_stay_below_one(void **state)
{
    (void)state;
    assert_true(gk_unit_float(0xffffffffu) == 1.0f - 0x1p-24f);
    assert_true(gk_unit_float(0) == 0.0f);
    assert_true(gk_unit_float(0x80000000u) == 0.5f);
}

static int by_value(const void *a, const void *b)
{
    const gk_u32 x = *(const gk_u32 *)a, y = *(const gk_u32 *)b;
    return (x > y) - (x < y);
}

static void pixels_of_one_picture_have_different_bases(void **state)
{
    (void)state;
    enum { SIDE = 512 };
    static gk_u32 base[SIDE * SIDE];
    for (gk_u32 i = 0; i < SIDE * SIDE; i++)
        base[i] = gk_sampler_base(i % SIDE * 31, i / SIDE * 127, 77, 1);
    qsort(base, SIDE * SIDE, sizeof *base, by_value);
    for (gk_u32 i = 1; i < SIDE * SIDE; i++)
        assert_true(base[i - 1] != base[i]);
}

// Value of one of the first 32 dimensions (16 pairs) at a pixel.
static double dimension(gk_u32 x, gk_u32 y, gk_u32 seed, gk_u32 part, gk_u32 index, int d)
{
    gk_f32 u, v;
    take(gk_sampler_base(x, y, seed, part), index, (gk_u32)d / 2, &u, &v);
    return d & 1 ? v : u;
}

struct shift {
    gk_u32 dx, dy, dseed, dpart, dindex;
};

// Correlation over 10^4 pixels between a dimension here and one at a shifted place.
static double shifted_correlation(struct shift s, int d, int e)
{
    enum { N = 10000 };
    static double a[N], b[N];
    for (gk_u32 i = 0; i < N; i++) {
        const gk_u32 x = i % 100 + 50, y = i / 100 + 20;
        a[i] = dimension(x, y, fresh(5), 0, 2, d);
        b[i] = dimension(x + s.dx, y + s.dy, fresh(5) + s.dseed, s.dpart, 2 + s.dindex, e);
    }
    return check_correlation(a, b, N);
}

static void neighbours_halves_and_seeds_are_uncorrelated(void **state)
{
    (void)state;
    static const struct shift shift[] = {
        {1, 0, 0, 0, 0}, {0, 1, 0, 0, 0}, {1, 1, 0, 0, 0}, {16, 0, 0, 0, 0}, {256, 0, 0, 0, 0},
        {0, 0, 0, 1, 0}, {0, 0, 1, 0, 0}, {1, 0, 1, 1, 0}, {1, 0, 0, 0, 1},
    };
    for (size_t s = 0; s < sizeof shift / sizeof *shift; s++)
        for (int d = 0; d < DIMENSIONS; d++)
            assert_odds(shifted_correlation(shift[s], d, d), 1 / sqrt(10000), 0);
}

static void dimensions_are_uncorrelated(void **state)
{
    (void)state;
    const struct shift none = {0, 0, 0, 0, 0};
    for (int d = 0; d < DIMENSIONS; d++)
        for (int e = 0; e < d; e++)
            assert_odds(shifted_correlation(none, d, e), 1 / sqrt(10000), 0);
}

// Mean over n elements of the part of a disc that a pair falls in, or of a smooth bump.
static double estimate(gk_u32 base, gk_u32 pair, gk_u32 n, int smooth)
{
    double sum = 0;
    for (gk_u32 i = 0; i < n; i++) {
        gk_f32 u, v;
        take(base, i, pair, &u, &v);
        const double r2 = (double)u * u + (double)v * v;
        sum += smooth ? exp(-r2) : r2 < 1;
    }
    return sum / n;
}

static double exact_estimate(int smooth)
{
    const double bump = 0.5 * sqrt(M_PI) * erf(1);
    return smooth ? bump * bump : M_PI / 4;
}

static double rms_error(gk_u32 n, int smooth)
{
    enum { PIXELS = 400 };
    double square = 0;
    for (gk_u32 i = 0; i < PIXELS; i++) {
        const gk_u32 base = gk_sampler_base(i, 3, 0, i & 1);
        const double e = estimate(base, i % 64, n, smooth) - exact_estimate(smooth);
        square += e * e;
    }
    return sqrt(square / PIXELS);
}

// Owen's rate is n^-1.5 for a smooth function and n^-0.75 for an edge; plain random has n^-0.5.
// 400 scrambles give each root mean square to 3.5%, so a slope over 2^6 to 0.012 (one sigma).
static void error_falls_faster_than_plain_random(void **state)
{
    (void)state;
    const double steps = log(64);
    assert_true(log(rms_error(16, 1) / rms_error(1024, 1)) / steps > 1.4);
    assert_true(log(rms_error(16, 0) / rms_error(1024, 0)) / steps > 0.68);
}

// Errors of the halves are independent, or their difference would say nothing about their mean.
static void errors_of_the_halves_are_independent(void **state)
{
    (void)state;
    enum { N = 10000 };
    static double a[N], b[N], right[N];
    for (gk_u32 i = 0; i < N; i++) {
        a[i] = estimate(gk_sampler_base(i % 100, i / 100, fresh(0), 0), 11, 16, 0);
        b[i] = estimate(gk_sampler_base(i % 100, i / 100, fresh(0), 1), 11, 16, 0);
        right[i] = estimate(gk_sampler_base(i % 100 + 1, i / 100, fresh(0), 0), 11, 16, 0);
    }
    assert_odds(check_correlation(a, b, N), 1 / sqrt(N), 0);
    assert_odds(check_correlation(a, right, N), 1 / sqrt(N), 0);
}

// What is found by light and what is found by direction are summands: sharing an order must not make
// their errors add up.
static void errors_of_light_and_direction_are_independent(void **state)
{
    (void)state;
    enum { N = 10000 };
    static double light[N], direction[N];
    for (int smooth = 0; smooth < 2; smooth++) {
        for (gk_u32 i = 0; i < N; i++) {
            const gk_u32 base = gk_sampler_base(i % 100, i / 100, fresh(6), 0);
            light[i] = estimate(base, GK_PAIR_BOUNCE(1, GK_PAIR_LIGHT_POINT), 16, smooth);
            direction[i] = estimate(base, GK_PAIR_BOUNCE(1, GK_PAIR_BSDF), 16, smooth);
        }
        assert_odds(check_correlation(light, direction, N), 1 / sqrt(N), 0);
    }
}

// Pairs are padded: a 4-D product over two of them is unbiased. Mean of (u - 1/2)(u' - 1/2) over
// 4096 pixels of 16 points each, every term of variance 1/144 if independent.
static void pairs_are_padded_independently(void **state)
{
    (void)state;
    enum { PIXELS = 4096, POINTS = 16 };
    for (gk_u32 pair = 8; pair < 24; pair++) {
        double sum = 0;
        for (gk_u32 i = 0; i < PIXELS * POINTS; i++) {
            const gk_u32 base = gk_sampler_base(i / POINTS, 8, fresh(2), 0);
            gk_f32 u, w, v;
            take(base, i % POINTS, pair, &u, &v);
            take(base, i % POINTS, pair + 1, &w, &v);
            sum += (u - 0.5) * (w - 0.5);
        }
        assert_odds(sum, sqrt((double)PIXELS * POINTS / 144), 0);
    }
}

// Flips of the first 63 nodes of the scramble's binary tree, over seeds: fair and, in pairs,
// independent. 2016 sub-tests share the level, so each has 5e-10: 6.2 sigma. (The constants first
// published for this hash fail with correlations of 0.63.)
static void scrambling_decides_each_node_by_itself(void **state)
{
    (void)state;
    enum { NODES = 63, SEEDS = 40000 };
    static int8_t flip[NODES][SEEDS];
    for (gk_u32 s = 0; s < SEEDS; s++) {
        int node = 0;
        for (gk_u32 depth = 0; depth < 6; depth++)
            for (gk_u32 path = 0; path < 1u << depth; path++)
                flip[node++][s] = gk_owen_reversed(path, gk_mix32(s)) >> depth & 1 ? 1 : -1;
    }
    for (int a = 0; a < NODES; a++)
        for (int b = 0; b <= a; b++) {
            int sum = 0;
            for (int s = 0; s < SEEDS; s++)
                sum += a == b ? flip[a][s] : flip[a][s] * flip[b][s];
            assert_within(sum / sqrt(SEEDS), 6.2);
        }
}

static void dimension_pairs_never_overlap(void **state)
{
    (void)state;
    assert_true(GK_PAIR_FILTER < GK_PAIR_LENS && GK_PAIR_LENS < GK_PAIR_TIME);
    assert_int_equal(GK_PAIR_BOUNCE(0, GK_PAIR_LIGHT_CHOICE), 8);
    assert_int_equal(GK_PAIR_BOUNCE(3, GK_PAIR_ALPHA), 8 + 24 + 4);
    assert_true(GK_PAIR_ORDER < GK_PAIR_LIGHT_PICK && GK_PAIR_LIGHT_PICK < GK_PAIRS_PER_BOUNCE);
    assert_true(GK_PAIR_BOUNCE(0, GK_PAIR_ALPHA) < GK_PAIR_BOUNCE(1, GK_PAIR_LIGHT_CHOICE));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_power_of_two_of_samples_is_a_net_in_every_pair),
        cmocka_unit_test(later_blocks_are_nets_too),
        cmocka_unit_test(place_and_first_vertex_are_nets_in_four_dimensions),
        cmocka_unit_test(means_are_within_half_a_stratum),
        cmocka_unit_test(each_element_is_uniform_over_pixels),
        cmocka_unit_test(all_32_bits_are_fair),
        cmocka_unit_test(values_stay_below_one),
        cmocka_unit_test(pixels_of_one_picture_have_different_bases),
        cmocka_unit_test(neighbours_halves_and_seeds_are_uncorrelated),
        cmocka_unit_test(dimensions_are_uncorrelated),
        cmocka_unit_test(error_falls_faster_than_plain_random),
        cmocka_unit_test(errors_of_the_halves_are_independent),
        cmocka_unit_test(errors_of_light_and_direction_are_independent),
        cmocka_unit_test(pairs_are_padded_independently),
        cmocka_unit_test(scrambling_decides_each_node_by_itself),
        cmocka_unit_test(dimension_pairs_never_overlap),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
