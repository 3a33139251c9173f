// Reflectance and refraction against double, where they are known to break: eta near 1, the edge
// of total reflection, grazing angles.
#include "tests/kernel/surface.h"

static const float etas[] = {0.1f,        0.5f,      1 / 1.5f, 0.9f,  1 - 1e-6f, 1 - 6e-8f, 1.0f,
                             1 + 1.2e-7f, 1 + 1e-6f, 1.1f,     1.33f, 1.5f,      2.42f,     10.0f};
enum { ETAS = sizeof etas / sizeof *etas };

// Distance of f from what F is for cosines and indices within 4u: at the edge of total reflection
// dF/dcos is unbounded, and no formula can do better than its arguments.
static double distance(float f, double c, double eta)
{
    double lo = 1, hi = 0;
    for (int k = 0; k < 27; k++) {
        const double nearby = fmin(1, c * (1 + (k % 3 - 1) * 4 * (double)GK_UNIT));
        const double exact = exact_fresnel(nearby, eta * (1 + (k / 3 - 4) * (double)GK_UNIT));
        lo = fmin(lo, exact);
        hi = fmax(hi, exact);
    }
    return fmax(0, fmax(lo - f, f - hi));
}

static void reflectance_is_exact_to_8u(void **state)
{
    (void)state;
    for (int e = 0; e < ETAS; e++)
        for (int i = 0; i <= 100000; i++) {
            const float c = (float)i / 100000;
            assert_within(distance(gk_fresnel_dielectric(c, etas[e]), c, etas[e]), 8 * GK_UNIT);
        }
}

static void reflectance_at_small_cosines_is_exact_to_8u(void **state)
{
    (void)state;
    for (int e = 0; e < ETAS; e++)
        for (float c = 1e-6f; c < 1e-2f; c *= 1.001f)
            assert_within(distance(gk_fresnel_dielectric(c, etas[e]), c, etas[e]), 8 * GK_UNIT);
}

static void matched_indices_reflect_nothing(void **state)
{
    (void)state;
    for (int i = 0; i <= 1000; i++)
        assert_true(gk_fresnel_dielectric((float)i / 1000, 1.0f) == 0.0f);
}

// Normal incidence: ((eta - 1) / (eta + 1))^2.
static void normal_incidence_follows_the_short_form(void **state)
{
    (void)state;
    assert_within(gk_fresnel_dielectric(1.0f, 1.5f) - 0.04, 4 * GK_UNIT);
    assert_within(gk_fresnel_dielectric(1.0f, 10.0f) - 81.0 / 121.0, 8 * GK_UNIT);
}

// cos of the critical angle and its neighbours in steps of 1u..256u: within [0, 1], 1 beyond, and
// off by no more than rounding of the argument explains, sqrt(8u) times the slope 4 / eta'.
static void total_reflection_begins_without_a_jump(void **state)
{
    (void)state;
    for (int e = 0; e < 4; e++) {
        const double edge = sqrt(1 - (double)etas[e] * etas[e]);
        for (int k = -256; k <= 256; k++) {
            const float c = (float)(edge * (1 + k * (double)GK_UNIT));
            const float f = gk_fresnel_dielectric(c, etas[e]);
            assert_true(f >= 0.0f && f <= 1.0f);
            assert_within(f - exact_fresnel(c, etas[e]), 16 * sqrt(8 * GK_UNIT));
        }
        for (int i = 0; i < 100; i++)
            assert_true(gk_fresnel_dielectric((float)(edge * (0.999 * i / 100)), etas[e]) == 1.0f);
    }
}

static void metals_run_from_base_to_white(void **state)
{
    (void)state;
    const struct gk_vec base = gk_vec(0.2f, 0.9f, 1.0f);
    assert_true(gk_fresnel_metal(base, 1.0f).x == 0.2f && gk_fresnel_metal(base, 1.0f).y == 0.9f);
    assert_within(gk_fresnel_metal(base, 0.0f).x - 1, GK_UNIT);
    assert_true(gk_fresnel_metal(base, 0.3f).z == 1.0f);
    assert_within(gk_fresnel_metal(base, 0.5f).x - (0.2 + 0.8 / 32), 4 * GK_UNIT);
}

static double length(struct gk_vec v)
{
    return sqrt((double)v.x * v.x + (double)v.y * v.y + (double)v.z * v.z);
}

// n1 sin = n2 sin, unit length, to 8u and 4u, away from the edge of total reflection.
static void refraction_obeys_snell(void **state)
{
    (void)state;
    uint64_t seed = 5;
    const struct gk_vec n = gk_vec(0, 0, 1);
    for (int i = 0; i < 200000; i++) {
        const float eta = etas[i % ETAS];
        const struct gk_vec wo = random_upper(&seed);
        if (1 - (1 - (double)wo.z * wo.z) / ((double)eta * eta) < 0.01)
            continue;
        const struct gk_vec wi = gk_refract(wo, n, wo.z, eta);
        const double sine_o = hypot(wo.x, wo.y), sine_i = hypot(wi.x, wi.y);
        assert_true(wi.z < 0);
        assert_within(eta * sine_i - sine_o, 8 * GK_UNIT);
        assert_within(length(wi) - 1,
                      4 * GK_UNIT / fmin(1, eta * eta)); // the integrator normalises
    }
}

static void matched_indices_keep_the_direction(void **state)
{
    (void)state;
    uint64_t seed = 6;
    for (int i = 0; i < 100000; i++) {
        const struct gk_vec wo = random_upper(&seed);
        const struct gk_vec wi = gk_refract(wo, gk_vec(0, 0, 1), wo.z, 1.0f);
        assert_within(wi.x + wo.x, 4 * GK_UNIT);
        assert_within(wi.y + wo.y, 4 * GK_UNIT);
        assert_within(wi.z + wo.z, 4 * GK_UNIT);
    }
}

static void beyond_the_edge_refraction_is_finite(void **state)
{
    (void)state;
    uint64_t seed = 7;
    for (int i = 0; i < 100000; i++) {
        const struct gk_vec wo = random_upper(&seed);
        const struct gk_vec wi = gk_refract(wo, gk_vec(0, 0, 1), wo.z, etas[i % 6]);
        assert_true(isfinite(wi.x) && isfinite(wi.y) && isfinite(wi.z));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reflectance_is_exact_to_8u),
        cmocka_unit_test(reflectance_at_small_cosines_is_exact_to_8u),
        cmocka_unit_test(matched_indices_reflect_nothing),
        cmocka_unit_test(normal_incidence_follows_the_short_form),
        cmocka_unit_test(total_reflection_begins_without_a_jump),
        cmocka_unit_test(metals_run_from_base_to_white),
        cmocka_unit_test(refraction_obeys_snell),
        cmocka_unit_test(matched_indices_keep_the_direction),
        cmocka_unit_test(beyond_the_edge_refraction_is_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
