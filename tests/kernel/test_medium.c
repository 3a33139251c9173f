// The phase function and the spans of the medium, compiled for the host.
#include "kernels/gk_medium.h"
#include "tests/kernel/check.h"

#include <math.h>

static const float anisotropy[] = {0.0f, 1e-6f,  -1e-6f,  0.3f,    -0.3f,
                                   0.9f, -0.99f, 0.9997f, 0.9999f, -0.9999f};
#define COUNT(a) (sizeof(a) / sizeof *(a))

static const struct gk_vec ahead = {0.36f, 0.48f, 0.8f};

// n = 10^6; the cosine's variance is at most 1. Of directions where these resolve it, of the form
// that does not cancel beyond.
static void mean_cosine_is_g(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(anisotropy); i++) {
        uint64_t seed = odds_seed(7 + i);
        const int n = 1000000;
        const bool steep = fabsf(anisotropy[i]) > 0.98f;
        double sum = 0.0, squares = 0.0;
        for (int k = 0; k < n; k++) {
            const float u = check_uniform(&seed);
            const struct gk_vec d = gk_phase_sample(anisotropy[i], ahead, u, 0.3f);
            const double toward = 1.0 - gk_phase_one_minus_cos(fabsf(anisotropy[i]), u),
                         met =
                             (double)d.x * ahead.x + (double)d.y * ahead.y + (double)d.z * ahead.z,
                         c = steep ? copysign(toward, met) : met;
            assert_true(c >= -1.0 - 4e-7 && c <= 1.0 + 4e-7 && toward >= -1.0 && toward <= 1.0);
            sum += c;
            squares += c * c;
        }
        const double mean = sum / n, error = sqrt(fmax(squares / n - mean * mean, 1e-14) / n);
        const double g =
            fabsf(anisotropy[i]) > GK_PHASE_DELTA ? copysign(1.0, anisotropy[i]) : anisotropy[i];
        assert_odds(mean - g, error, fabs(g) > 0.98 ? 1e-6 : 0);
    }
}

// 2 pi Int p dcos by the substitution that samples it: every stratum of u has the same share.
static void density_is_that_of_the_samples(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(anisotropy); i++) {
        if (fabsf(anisotropy[i]) > 0.995f)
            continue;
        const int n = 256;
        double worst = 0.0;
        for (int k = 0; k < n; k++) {
            const float u0 = (float)k / (float)n, u1 = (float)(k + 1) / (float)n;
            const double a = gk_phase_one_minus_cos(fabsf(anisotropy[i]), u0),
                         b = gk_phase_one_minus_cos(fabsf(anisotropy[i]), u1);
            double integral = 0.0; // Simpson over the stratum, in double
            for (int s = 0; s <= 16; s++) {
                const double x = a + (b - a) * s / 16, g = fabs((double)anisotropy[i]);
                const double q = (1 - g) * (1 - g) + 2 * g * x;
                const double p = (1 - g * g) / (4 * M_PI * q * sqrt(q));
                integral += p * (s == 0 || s == 16 ? 1 : s % 2 ? 4 : 2);
            }
            integral *= 2 * M_PI * fabs(b - a) / 48;
            worst = fmax(worst, fabs(integral * n - 1.0));
        }
        if (worst > 3e-3)
            fail_msg("g %g: a stratum is off by %.2e", anisotropy[i], worst);
    }
}

static void value_is_the_published_form(void **state)
{
    (void)state;
    uint64_t seed = 3;
    for (size_t i = 0; i < COUNT(anisotropy); i++)
        for (int k = 0; k < 1000; k++) {
            const struct gk_vec wi =
                gk_phase_sample(anisotropy[i], ahead, check_uniform(&seed), 0.3f);
            const double g = anisotropy[i], c = (double)wi.x * ahead.x + (double)wi.y * ahead.y +
                                                (double)wi.z * ahead.z;
            const double p = (1 - g * g) / (4 * M_PI * pow(1 + g * g - 2 * g * fmin(c, 1.0), 1.5));
            const float value = gk_phase_eval(anisotropy[i], ahead, wi);
            assert_true(isfinite(value) && value >= 0.0f);
            if (fabs(g) < 0.99)
                assert_true(fabs(value - p) <= 1e-4 * p);
            if (fabs(g) > (double)GK_PHASE_DELTA)
                assert_true(value == 0.0f);
        }
}

static void a_delta_goes_straight_on_or_back(void **state)
{
    (void)state;
    for (int back = 0; back < 2; back++) {
        const struct gk_vec d = gk_phase_sample(back ? -1.0f : 1.0f, ahead, 0.37f, 0.81f);
        const double c = (double)d.x * ahead.x + (double)d.y * ahead.y + (double)d.z * ahead.z;
        assert_float_equal(c, back ? -1.0 : 1.0, 4e-7);
    }
}

// Rays through, into, beside, along and away from a box, from afar and from inside; no bounds.
static void spans_lie_between_zero_and_the_hit(void **state)
{
    (void)state;
    struct gk_frame f = {.medium_density = 0.5f};
    for (int k = 0; k < 3; k++) {
        f.medium_low[k] = -1.0f;
        f.medium_high[k] = 1.0f;
    }
    const struct gk_vec x = {1, 0, 0};
    const struct {
        struct gk_vec o;
        float length, inside;
    } ray[] = {{{-3, 0, 0}, INFINITY, 2}, {{-3, 0, 0}, 3, 1},        {{-3, 0, 0}, 1, 0},
               {{0, 0, 0}, INFINITY, 1},  {{0, 0, 0}, 0.25f, 0.25f}, {{3, 0, 0}, INFINITY, 0},
               {{-3, 2, 0}, INFINITY, 0}, {{-3, 0, -1.5f}, 9, 0}};
    for (size_t i = 0; i < COUNT(ray); i++) {
        const double left = gk_medium_transmittance(&f, ray[i].o, x, ray[i].length);
        assert_float_equal(left, exp(-0.5 * (double)ray[i].inside), 1e-6);
    }
    for (int k = 0; k < 3; k++) {
        f.medium_low[k] = -INFINITY;
        f.medium_high[k] = INFINITY;
    }
    assert_float_equal(gk_medium_transmittance(&f, ray[0].o, x, 4.0f), exp(-2.0), 1e-6);
    assert_float_equal(gk_medium_transmittance(&f, ray[0].o, x, INFINITY), 0.0, 0.0);
}

// Light that enters the medium after 3 m meets it an exponential distance from there.
static void free_paths_begin_where_the_medium_does(void **state)
{
    (void)state;
    const struct gk_frame frame = {.medium_density = 0.5f};
    const struct gk_span span = {3.0f, 10.0f};
    for (int i = 0; i < 4096; i++) {
        const float u = (float)i / 4096.0f, t = gk_medium_distance(&frame, span, u);
        const double exact = 3.0 - log1p(-(double)u) / 0.5;
        if (exact < 10.0)
            assert_within(t - exact, 1e-5);
        else
            assert_true(isinf(t));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mean_cosine_is_g),
        cmocka_unit_test(density_is_that_of_the_samples),
        cmocka_unit_test(value_is_the_published_form),
        cmocka_unit_test(a_delta_goes_straight_on_or_back),
        cmocka_unit_test(spans_lie_between_zero_and_the_hit),
        cmocka_unit_test(free_paths_begin_where_the_medium_does),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
