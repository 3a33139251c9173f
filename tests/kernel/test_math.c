// Every bound is the one gk_math.h states, against double over a dense sweep.
#include "kernels/gk_math.h"
#include "tests/kernel/check.h"

typedef float function(float);
typedef double reference(double);

// Visits the floats of [lo, hi], both of one sign, in steps of `stride` representable numbers.
static double worst_ulp(function *f, reference *exact, float lo, float hi, uint32_t stride)
{
    double worst = 0;
    const uint32_t first = gk_as_u32(fminf(fabsf(lo), fabsf(hi)));
    const uint32_t last = gk_as_u32(fmaxf(fabsf(lo), fabsf(hi)));
    for (uint64_t bits = first; bits <= last; bits += stride) {
        const float x = copysignf(gk_as_f32((uint32_t)bits), lo);
        worst = fmax(worst, check_ulp(f(x), exact((double)x)));
    }
    return worst;
}

static float sqrt_(float x)
{
    return gk_sqrt(x);
}
static float rsqrt(float x)
{
    return gk_rsqrt(x);
}
static double exact_rsqrt(double x)
{
    return 1.0 / sqrt(x);
}
static float exp_(float x)
{
    return gk_exp(x);
}
static float exp2_(float x)
{
    return gk_exp2(x);
}
static float log_(float x)
{
    return gk_log(x);
}
static float log2_(float x)
{
    return gk_log2(x);
}
static float floor_(float x)
{
    return gk_floor(x);
}
static float acos_(float x)
{
    return gk_acos(x);
}

static void square_roots_keep_their_bounds(void **state)
{
    (void)state;
    assert_within(worst_ulp(sqrt_, sqrt, FLT_MIN, FLT_MAX, 1009), 0.5);
    assert_within(worst_ulp(rsqrt, exact_rsqrt, FLT_MIN, FLT_MAX, 1009), 1.5);
    assert_true(isinf(gk_rsqrt(0.0f)));
    assert_true(gk_rsqrt(INFINITY) == 0.0f);
}

static void exponentials_keep_their_bounds(void **state)
{
    (void)state;
    assert_within(worst_ulp(exp_, exp, 1e-9f, 88.7f, 211), 1.5);
    assert_within(worst_ulp(exp_, exp, -1e-9f, -87.3f, 211), 1.5);
    assert_within(worst_ulp(exp2_, exp2, 1e-9f, 127.99f, 211), 1.5);
    assert_within(worst_ulp(exp2_, exp2, -1e-9f, -126.0f, 211), 1.5);
    for (int n = -126; n < 128; n++)
        assert_true(gk_exp2((float)n) == ldexpf(1.0f, n));
}

static void exponentials_reach_their_limits(void **state)
{
    (void)state;
    assert_true(gk_exp(0.0f) == 1.0f && gk_exp(-0.0f) == 1.0f);
    assert_true(gk_exp(-INFINITY) == 0.0f && gk_exp2(-INFINITY) == 0.0f);
    assert_true(gk_exp(-1e30f) == 0.0f && gk_exp2(-152.0f) == 0.0f);
    assert_true(isinf(gk_exp(INFINITY)) && isinf(gk_exp2(INFINITY)));
    assert_true(isinf(gk_exp(88.73f)) && isinf(gk_exp2(128.0f)) && isinf(gk_exp(1e30f)));
    assert_true(gk_exp(88.72f) < INFINITY && gk_exp2(127.9999f) < INFINITY);
    assert_true(isnan(gk_exp(NAN)) && isnan(gk_exp2(NAN)));
}

static void logarithms_keep_their_bounds(void **state)
{
    (void)state;
    assert_within(worst_ulp(log_, log, 0x1p-149f, FLT_MAX, 499), 2);
    assert_within(worst_ulp(log2_, log2, 0x1p-149f, FLT_MAX, 499), 3);
    assert_within(worst_ulp(log_, log, 0.9f, 1.1f, 1), 2);
    assert_within(worst_ulp(log2_, log2, 0.9f, 1.1f, 1), 3);
    for (int n = -149; n < 128; n++)
        assert_true(gk_log2(ldexpf(1.0f, n)) == (float)n);
}

static void logarithms_reach_their_limits(void **state)
{
    (void)state;
    assert_true(gk_log(1.0f) == 0.0f && gk_log2(1.0f) == 0.0f);
    assert_true(gk_log(0.0f) == -INFINITY && gk_log2(-0.0f) == -INFINITY);
    assert_true(gk_log(INFINITY) == INFINITY && gk_log2(INFINITY) == INFINITY);
    assert_true(isnan(gk_log(-1.0f)) && isnan(gk_log2(-INFINITY)) && isnan(gk_log(NAN)));
}

static void powers_keep_their_bound(void **state)
{
    (void)state;
    uint64_t seed = 1;
    for (int i = 0; i < 1000000; i++) {
        const float x = exp2f(40.0f * check_uniform(&seed) - 20.0f);
        const float y = 10.0f * check_uniform(&seed) - 5.0f;
        const double exact = pow(x, y), size = fabs(y * log2(x));
        if (size > 125)
            continue;
        assert_within(gk_pow(x, y) / exact - 1, (2 + 2 * size) * 0x1p-24 + 0x1p-23);
    }
}

static void powers_reach_their_limits(void **state)
{
    (void)state;
    assert_true(gk_pow(0.0f, 0.0f) == 1.0f && gk_pow(NAN, 0.0f) == 1.0f);
    assert_true(gk_pow(INFINITY, 0.0f) == 1.0f);
    assert_true(gk_pow(0.0f, 2.4f) == 0.0f && isinf(gk_pow(0.0f, -1.0f)));
    assert_true(gk_pow(1.0f, 1e30f) == 1.0f);
    assert_true(isnan(gk_pow(-2.0f, 2.0f)) && isnan(gk_pow(2.0f, NAN)));
}

static void floor_is_exact(void **state)
{
    (void)state;
    assert_within(worst_ulp(floor_, floor, FLT_MIN, FLT_MAX, 1009), 0);
    assert_within(worst_ulp(floor_, floor, -FLT_MIN, -FLT_MAX, 1009), 0);
    assert_within(worst_ulp(floor_, floor, -8388600.0f, -8388620.0f, 1), 0);
    assert_true(isinf(gk_floor(INFINITY)) && isnan(gk_floor(NAN)));
    assert_true(gk_floor(-0x1p-149f) == -1.0f);
}

static void sine_and_cosine_keep_their_bound(void **state)
{
    (void)state;
    uint64_t seed = 2;
    float s, c;
    for (int i = 0; i < 2000000; i++) {
        const float scale = exp2f((float)(i % 22));
        const float u = (2.0f * check_uniform(&seed) - 1.0f) * scale;
        gk_sincos_2pi(u, &s, &c);
        const double turn = u - rint(u); // exact
        assert_within(s - sin(2 * M_PI * turn), 1.5e-7);
        assert_within(c - cos(2 * M_PI * turn), 1.5e-7);
    }
}

static void sine_and_cosine_are_exact_at_quadrants(void **state)
{
    (void)state;
    static const float sine[4] = {0, 1, 0, -1}, cosine[4] = {1, 0, -1, 0};
    float s, c;
    for (int q = -400; q <= 400; q++) {
        gk_sincos_2pi(0.25f * (float)q, &s, &c);
        assert_true(s == sine[q & 3] && c == cosine[q & 3]);
    }
}

static void arc_cosine_keeps_its_bounds(void **state)
{
    (void)state;
    assert_within(worst_ulp(acos_, acos, 0.5f, 1.0f, 1), 4);
    for (uint32_t bits = 0; bits <= gk_as_u32(1.0f); bits += 499) {
        const float x = gk_as_f32(bits);
        assert_within(gk_acos(x) - acos(x), 3e-7);
        assert_within(gk_acos(-x) - acos(-x), 3e-7);
    }
    assert_true(gk_acos(1.0f) == 0.0f && gk_acos(1.0001f) == 0.0f);
    assert_true(gk_acos(-1.0001f) == gk_acos(-1.0f));
}

static void arc_tangent_keeps_its_bound_in_every_direction(void **state)
{
    (void)state;
    uint64_t seed = 3;
    for (int i = 0; i < 2000000; i++) {
        const double angle = 2 * M_PI * (i / 2e6);
        const double r = exp2(60 * check_uniform(&seed) - 30);
        const float x = (float)(r * cos(angle)), y = (float)(r * sin(angle));
        assert_within(check_ulp(gk_atan2(y, x), atan2(y, x)), 3);
    }
    assert_true(gk_atan2(0.0f, 0.0f) == 0.0f && signbit(gk_atan2(-0.0f, 0.0f)));
    assert_true(gk_atan2(0.0f, 2.0f) == 0.0f && gk_atan2(1.0f, 0.0f) == GK_HALF_PI);
    assert_true(gk_atan2(0.0f, -2.0f) == GK_PI && gk_atan2(-0.0f, -2.0f) == -GK_PI);
}

static void clamps_turn_nan_into_the_bound(void **state)
{
    (void)state;
    assert_true(gk_min(NAN, 1.0f) == 1.0f && gk_max(NAN, 1.0f) == 1.0f);
    assert_true(gk_clamp(NAN, 2.0f, 3.0f) == 2.0f && gk_saturate(NAN) == 0.0f);
    assert_true(gk_saturate(INFINITY) == 1.0f && gk_saturate(-INFINITY) == 0.0f);
    assert_true(gk_isfinite(FLT_MAX) && !gk_isfinite(-INFINITY) && !gk_isfinite(NAN));
}

static double length_error(float x, float y, float z)
{
    return sqrt((double)x * x + (double)y * y + (double)z * z) - 1;
}

static void normalising_works_at_every_scale(void **state)
{
    (void)state;
    uint64_t seed = 4;
    for (int i = 0; i < 100000; i++) {
        float v[3], w[3];
        const float scale = ldexpf(1.0f, i % 220 - 110); // all bits survive scaling
        for (int k = 0; k < 3; k++) {
            v[k] = check_uniform(&seed) + 0x1p-10f;
            w[k] = v[k] * scale;
        }
        assert_true(gk_safe_normalise(&v[0], &v[1], &v[2]));
        assert_true(gk_safe_normalise(&w[0], &w[1], &w[2]));
        assert_within(length_error(v[0], v[1], v[2]), 4 * 0x1p-24);
        for (int k = 0; k < 3; k++)
            assert_true(v[k] == w[k]);
    }
}

static void normalising_takes_the_extremes(void **state)
{
    (void)state;
    static const float extreme[] = {0x1p-149f, 0x1p-140f, FLT_MIN, FLT_MAX, 0x1p127f};
    for (size_t i = 0; i < sizeof extreme / sizeof *extreme; i++) {
        float x = extreme[i], y = -extreme[i], z = extreme[i];
        assert_true(gk_safe_normalise(&x, &y, &z));
        assert_within(length_error(x, y, z), 4 * 0x1p-24);
        assert_true(x == -y && x == z);
    }
}

static void what_has_no_direction_becomes_z(void **state)
{
    (void)state;
    static const float bad[][3] = {{0, 0, 0},         {-0.0f, 0, -0.0f}, {INFINITY, 1, 1},
                                   {1, -INFINITY, 1}, {NAN, 1, 1},       {1, NAN, 0},
                                   {0, 0, NAN},       {INFINITY, NAN, 0}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        float x = bad[i][0], y = bad[i][1], z = bad[i][2];
        assert_false(gk_safe_normalise(&x, &y, &z));
        assert_true(x == 0.0f && y == 0.0f && z == 1.0f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(square_roots_keep_their_bounds),
        cmocka_unit_test(exponentials_keep_their_bounds),
        cmocka_unit_test(exponentials_reach_their_limits),
        cmocka_unit_test(logarithms_keep_their_bounds),
        cmocka_unit_test(logarithms_reach_their_limits),
        cmocka_unit_test(powers_keep_their_bound),
        cmocka_unit_test(powers_reach_their_limits),
        cmocka_unit_test(floor_is_exact),
        cmocka_unit_test(sine_and_cosine_keep_their_bound),
        cmocka_unit_test(sine_and_cosine_are_exact_at_quadrants),
        cmocka_unit_test(arc_cosine_keeps_its_bounds),
        cmocka_unit_test(arc_tangent_keeps_its_bound_in_every_direction),
        cmocka_unit_test(clamps_turn_nan_into_the_bound),
        cmocka_unit_test(normalising_works_at_every_scale),
        cmocka_unit_test(normalising_takes_the_extremes),
        cmocka_unit_test(what_has_no_direction_becomes_z),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
