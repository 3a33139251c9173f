// Pixel filters: the density of the samples is the filter.
#include "kernels/gk_filter.h"
#include "tests/kernel/check.h"

enum { CELLS = 64, N = 1000000 };

// Harris's window in double, x in [-1, 1], and its integral from -1.
static double window(double x)
{
    return (0.35875 + 0.48829 * cos(M_PI * x) + 0.14128 * cos(2 * M_PI * x) +
            0.01168 * cos(3 * M_PI * x)) /
           (2 * 0.35875);
}

static double integral(double x)
{
    return 0.5 +
           (0.35875 * x + 0.48829 * sin(M_PI * x) / M_PI +
            0.14128 * sin(2 * M_PI * x) / (2 * M_PI) + 0.01168 * sin(3 * M_PI * x) / (3 * M_PI)) /
               (2 * 0.35875);
}

static void density_is_harris_window(void **state)
{
    (void)state;
    for (int i = -1000; i <= 1000; i++) {
        const float x = (float)i / 1000;
        assert_within(gk_blackman_harris_pdf(x) - window(x), 1e-6);
        const double within = 2 * integral(fabs(x)) - 1;
        assert_within(gk_blackman_harris_within(fabsf(x)) - within, 5e-7);
    }
    assert_within(integral(1) - 1, 1e-15);
}

static double chi2_of_blackman_harris(uint64_t seed)
{
    static uint32_t count[CELLS];
    static double probability[CELLS];
    memset(count, 0, sizeof count);
    for (int i = 0; i < N; i++) {
        const float x = gk_filter_blackman_harris(check_uniform(&seed), 3.0f);
        const int cell = (int)((x / 3.0f + 0.5f) * CELLS);
        count[cell == CELLS ? CELLS - 1 : cell]++;
    }
    for (int c = 0; c < CELLS; c++)
        probability[c] = integral(2.0 * (c + 1) / CELLS - 1) - integral(2.0 * c / CELLS - 1);
    return check_chi2(count, probability, CELLS, N);
}

static void blackman_harris_samples_follow_their_density(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 4; seed++)
        assert_odds_chi2(chi2_of_blackman_harris(odds_seed(seed)));
}

// The probability below the inverse of u is u: over every 64th of the 2^24 values there are.
static void inverse_is_exact_to_a_millionth(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1u << 24; i += 64) {
        const float u = (float)i * 0x1p-24f;
        const double x = gk_filter_blackman_harris(u, 2.0f);
        assert_within(integral(x) - u, 1e-6);
    }
}

static void blackman_harris_is_symmetric_and_monotone(void **state)
{
    (void)state;
    float before = -1;
    for (int i = 1; i < 4096; i++) {
        const float u = (float)i / 4096;
        const float x = gk_filter_blackman_harris(u, 1.0f);
        assert_true(x == -gk_filter_blackman_harris(1.0f - u, 1.0f));
        assert_true(x > before);
        before = x;
    }
    assert_true(gk_filter_blackman_harris(0.5f, 1.0f) == 0.0f);
}

static void offsets_stay_inside_the_support(void **state)
{
    (void)state;
    static const float end[] = {0.0f, 0x1p-24f, 1.0f - 0x1p-24f};
    for (int i = 0; i < 3; i++) {
        assert_within(gk_filter_blackman_harris(end[i], 1.5f), 0.75);
        assert_within(gk_filter_box(end[i], 1.5f), 0.75);
    }
    assert_true(gk_filter_box(0.0f, 1.0f) == -0.5f && gk_filter_box(0.5f, 4.0f) == 0.0f);
    assert_true(gk_filter_box(1.0f - 0x1p-24f, 1.0f) < 0.5f);
}

static void box_samples_are_uniform(void **state)
{
    (void)state;
    static uint32_t count[CELLS];
    static double probability[CELLS];
    uint64_t seed = odds_seed(9);
    for (int i = 0; i < N; i++)
        count[(int)((gk_filter_box(check_uniform(&seed), 2.0f) + 1.0f) * (CELLS / 2))]++;
    for (int c = 0; c < CELLS; c++)
        probability[c] = 1.0 / CELLS;
    assert_odds_chi2(check_chi2(count, probability, CELLS, N));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(density_is_harris_window),
        cmocka_unit_test(blackman_harris_samples_follow_their_density),
        cmocka_unit_test(inverse_is_exact_to_a_millionth),
        cmocka_unit_test(blackman_harris_is_symmetric_and_monotone),
        cmocka_unit_test(offsets_stay_inside_the_support),
        cmocka_unit_test(box_samples_are_uniform),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
