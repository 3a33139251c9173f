// How far coverage follows a path: Eq. 2 to 7 against their plain forms in double precision.
#include "kernels/gk_coverage.h"
#include "kernels/gk_hit.h"
#include "tests/kernel/check.h"

#include <stdlib.h>

enum { VERTICES = 64, PATHS = 2000 };

static double log_uniform(uint64_t *random, double low, double high)
{
    return low * pow(high / low, check_uniform(random));
}

static void log1p_and_expm1_keep_small_arguments(void **state)
{
    (void)state;
    uint64_t random = 1;
    for (int i = 0; i < 200000; i++) {
        const float x = -(float)log_uniform(&random, 1e-30, 1.0 - 1e-7);
        assert_within(check_ulp(gk_log1p(x), log1p(x)), 4.0);
        const float z = (float)log_uniform(&random, 1e-30, 1e38);
        assert_within(check_ulp(gk_log1p(z), log1p(z)), 4.0);
        const float y = -(float)log_uniform(&random, 1e-30, 80.0);
        assert_within(check_ulp(gk_expm1(y), expm1(y)), 4.0);
    }
    assert_true(gk_log1p(-1.0f) == -INFINITY && gk_log1p(INFINITY) == INFINITY);
    assert_true(gk_expm1(-INFINITY) == -1.0f);
    assert_true(gk_log1p(0.0f) == 0.0f && gk_expm1(0.0f) == 0.0f);
}

static void the_variance_of_a_lobe_is_that_of_the_printed_form(void **state)
{
    (void)state;
    for (double p = 0.17; p < 1e12; p *= 1.03) {
        const double e = 1.0 / (2.0 * M_PI * (float)p);
        const double tangent2 = 1.0 / ((1.0 - e) * (1.0 - e)) - 1.0;
        // Near 1/(2 pi) the form is ill-conditioned: 1 - e has the error of e.
        const double bound = 16.0 * 0x1p-24 * (1.0 + 2.0 * e / (1.0 - e));
        const double exact =
            e < 1e-3 ? e * (2.0 - e) / (2.0 * (1.0 - e) * (1.0 - e)) : tangent2 / 2.0;
        assert_within(gk_lobe_variance((float)p, 1.0f) / exact - 1.0, bound);
    }
}

static void the_variance_of_a_lobe_has_its_limits(void **state)
{
    (void)state;
    assert_true(gk_lobe_variance(INFINITY, 1.0f) == 0.0f);
    assert_within(gk_lobe_variance((float)(1.0 / M_PI), 1.0f) - 1.5, 1e-6);
    assert_true(gk_lobe_variance(0.159f, 1.0f) == INFINITY);
    assert_true(gk_lobe_variance(1e-30f, 1.0f) == INFINITY);
    assert_true(gk_lobe_variance(3e38f, 1.0f) < 1e-38f);
}

struct path {
    double v2[VERTICES], t[VERTICES]; // scattering at vertex j + 1 and the way to the next
};

static void draw_path(struct path *p, uint64_t *random)
{
    for (int i = 0; i < VERTICES; i++) {
        p->v2[i] = check_uniform(random) < 0.2f ? 0.0 : (float)log_uniform(random, 1e-6, 3.0);
        p->t[i] = (float)log_uniform(random, 0.01, 100.0);
    }
}

// Eq. 2 as it stands, on arrival at vertex m + 1 of those counted from 1.
static double variance_by_double_sum(const struct path *p, int m)
{
    double sum = 0.0;
    for (int j = 0; j < m; j++) {
        double way = 0.0;
        for (int k = j; k < m; k++)
            way += p->t[k];
        sum += p->v2[j] * way * way;
    }
    return sum;
}

static double variance_by_eq3(const struct path *p, int m)
{
    double sum = 0.0, s0 = 0.0;
    for (int j = 0; j < m; j++) {
        s0 += p->v2[j];
        sum += p->t[j] * p->t[j] * s0;
    }
    return sum;
}

static void the_running_sums_give_the_exact_variance(void **state)
{
    (void)state;
    uint64_t random = 7;
    for (int n = 0; n < PATHS; n++) {
        struct path p;
        draw_path(&p, &random);
        struct gk_spread exact = {0}, eq3 = {0};
        for (int m = 1; m <= VERTICES; m++) {
            exact = gk_spread_advance(gk_spread_scatter(exact, (float)p.v2[m - 1]),
                                      (float)p.t[m - 1], 0);
            eq3 =
                gk_spread_advance(gk_spread_scatter(eq3, (float)p.v2[m - 1]), (float)p.t[m - 1], 1);
            const double all = exact.s2 + (double)exact.since * exact.since * exact.last;
            const double less = eq3.s2 + (double)eq3.since * eq3.since * eq3.last;
            const double want = variance_by_double_sum(&p, m), want3 = variance_by_eq3(&p, m);
            assert_within(all - want, 32.0 * 0x1p-24 * want);
            assert_within(less - want3, 32.0 * 0x1p-24 * want3);
            assert_true(less <= all * (1.0 + 64.0 * 0x1p-24));
        }
    }
}

// What scatters at x_1 alone, over n equal ways: n^2 of them by Eq. 2, n by Eq. 3, which is never less.
static void of_one_scattering_eq3_has_an_nth_over_n_equal_ways(void **state)
{
    (void)state;
    struct gk_spread exact = gk_spread_scatter(gk_spread_none(), 0.25f), eq3 = exact;
    for (int n = 1; n <= VERTICES; n++) {
        exact = gk_spread_advance(exact, 2.0f, 0);
        eq3 = gk_spread_advance(eq3, 2.0f, 1);
        const double all = exact.s2 + (double)exact.since * exact.since * exact.last;
        const double less = eq3.s2 + (double)eq3.since * eq3.since * eq3.last;
        assert_true(all == (double)n * n && less == n);
        exact = gk_spread_scatter(exact, 0.0f);
        eq3 = gk_spread_scatter(eq3, 0.0f);
    }
}

static double plain_weight(double part, double rest, double alpha)
{
    const double s2 = part + rest > 0.0 ? rest / (part + rest) : 1.0;
    return pow(sqrt(s2), alpha);
}

static double plain_cut(double part, double rest, double flat, double alpha)
{
    const double w = plain_weight(part, rest, alpha), wl = plain_weight(flat, rest, alpha);
    return wl < 1.0 ? fmax(0.0, (w - wl) / (1.0 - wl)) : 1.0;
}

static void weights_are_those_of_the_plain_forms(void **state)
{
    (void)state;
    uint64_t random = 11;
    for (int n = 0; n < 200000; n++) {
        const float part = (float)log_uniform(&random, 1e-9, 1e9);
        const float rest = (float)log_uniform(&random, 1e-9, 1e9);
        const float alpha = (float)log_uniform(&random, 1e-3, 16.0);
        const float flat = (float)log_uniform(&random, 1e-3, 1e6);
        assert_within(gk_coverage_weight(part, rest, -1.0f, alpha) -
                          plain_weight(part, rest, alpha),
                      32.0 * 0x1p-24);
        // In double the plain form has lost as much as the two weights are close to one.
        const double share = (double)flat / ((double)flat + rest);
        assert_within(gk_coverage_weight(part, rest, flat, alpha) -
                          plain_cut(part, rest, flat, alpha),
                      64.0 * 0x1p-24 * (1.0 + part / flat) + 8e-15 / (alpha * share));
    }
}

static void a_weight_is_never_outside_of_0_and_1(void **state)
{
    (void)state;
    static const float values[] = {0.0f, 1e-45f, 1e-38f, 1e-20f, 1e-6f,  0.3f,
                                   1.0f, 1.5f,   1e6f,   1e19f,  3.4e38f};
    static const float alphas[] = {0.0f, 1e-6f, 0.1f, 1.0f, 16.0f, 1e4f};
    const int n = sizeof values / sizeof *values;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            for (int k = -1; k < n; k++)
                for (int a = 0; a < 6; a++) {
                    const float flat = k < 0 ? -1.0f : values[k];
                    const float w = gk_coverage_weight(values[i], values[j], flat, alphas[a]);
                    assert_true(w >= 0.0f && w <= 1.0f);
                    assert_true(alphas[a] > 0.0f || w == 1.0f);
                }
}

static void nothing_added_to_nothing_keeps_all(void **state)
{
    (void)state;
    assert_true(gk_coverage_weight(0.0f, 0.0f, -1.0f, 0.1f) == 1.0f);
    assert_true(gk_coverage_weight(0.0f, 0.0f, 0.0f, 0.1f) == 1.0f);
    assert_true(gk_coverage_weight(0.0f, 0.0f, 1.0f, 0.1f) == 1.0f); // a mirror under diffuse_cut
    assert_true(gk_coverage_weight(1.5f, 0.0f, 1.5f, 0.1f) == 0.0f); // Lambert under it
}

static void a_scattering_into_all_directions_keeps_nothing_but_at_alpha_0(void **state)
{
    (void)state;
    assert_true(gk_coverage_weight(INFINITY, 0.0f, -1.0f, 0.1f) == 0.0f);
    assert_true(gk_coverage_weight(INFINITY, 1.0f, 1.5f, 16.0f) == 0.0f);
    assert_true(gk_coverage_weight(INFINITY, 0.0f, -1.0f, 0.0f) == 1.0f);
}

static void a_miss_is_the_limit_of_far_hits(void **state)
{
    (void)state;
    uint64_t random = 13;
    for (int n = 0; n < 2000; n++) {
        const float slope = (float)log_uniform(&random, 1e-4, 1e-2), far = 1e9f;
        struct gk_spread s = {0};
        struct gk_cone c = {0.0f, slope, 0.0f}, beyond;
        for (int m = 0; m < 3; m++) {
            s = gk_spread_advance(s, 1.0f + check_uniform(&random), 0);
            gk_cone_advance(&c, 1.0f);
            s = gk_spread_scatter(s, (float)log_uniform(&random, 1e-5, 2.0));
        }
        beyond = c;
        gk_cone_advance(&beyond, far);
        for (int mode = 0; mode < 4; mode++) {
            const struct gk_weight_rule rule = {0.3f, 0.0f, slope, 1, mode & 1, 0, mode >> 1};
            const struct gk_spread arrived = gk_spread_advance(s, far, 0);
            assert_within(gk_path_weight(&arrived, &beyond, &rule, 0) -
                              gk_path_weight(&s, &c, &rule, 1),
                          1e-5);
        }
    }
}

// A mirror ball seen from far away: parallel rays leave as if from half its radius behind it.
static float bent(float r, float g, float curvature, float eta, int crosses)
{
    float of_slope, of_radius;
    gk_cone_bend(curvature, 1.0f, eta, crosses, &of_slope, &of_radius);
    return of_slope * g + of_radius * r;
}

static void a_cone_reflects_as_a_convex_mirror_does(void **state)
{
    (void)state;
    struct gk_cone c = {0.01f, 0.0f, 0.0f}, hollow = c;
    c.g = bent(c.r, c.g, 2.0f, 1.0f, 0); // radius 1/2: focal length 1/4
    assert_within(c.g - 0.04, 1e-8);
    gk_cone_advance(&c, 1.0f);
    assert_within(c.r - 0.05, 1e-8);
    hollow.g = bent(hollow.r, hollow.g, -2.0f, 1.0f, 0);
    gk_cone_advance(&hollow, 0.5f); // through its focus: the sign turns
    assert_within(hollow.r + 0.01, 1e-8);
}

static void the_clamp_keeps_a_cone_from_focusing_below_its_straight_width(void **state)
{
    (void)state;
    const struct gk_weight_rule eq5 = {0.1f, 0.001f, 0.01f, 1, 0, 0, 0};
    const struct gk_weight_rule eq6 = {0.1f, 0.001f, 0.01f, 1, 1, 0, 0};
    const struct gk_cone focused = {0.0f, -0.02f, 2.0f}, wide = {-0.5f, 0.1f, 2.0f};
    assert_true(gk_cone_area(&focused, &eq5) == 0.0f);
    assert_within(gk_cone_area(&focused, &eq6) - 0.021 * 0.021, 1e-9);
    assert_true(gk_cone_area(&wide, &eq5) == 0.25f && gk_cone_area(&wide, &eq6) == 0.25f);
}

// Into a ball of glass of index 1.5: paraxial rays meet three radii behind its front.
static void a_cone_refracts_as_one_face_of_a_lens_does(void **state)
{
    (void)state;
    struct gk_cone c = {0.01f, 0.0f, 0.0f};
    c.g = bent(c.r, c.g, 1.0f, 1.5f, 1);
    gk_cone_advance(&c, 3.0f);
    assert_within(c.r, 1e-8);
    assert_within(bent(0.01f, 0.3f, 0.0f, 1.5f, 1) - 0.2, 1e-7);
}

static void what_goes_on_is_never_more_than_there_is(void **state)
{
    (void)state;
    gk_u32 excess;
    assert_int_equal(gk_coverage_carry(65536, 65536.0f, 0.25f, &excess), 16384);
    assert_int_equal(excess, 0);
    assert_int_equal(gk_coverage_carry(1000, 2000.0f, 1.0f, &excess), 1000);
    assert_int_equal(excess, 1000);
    assert_int_equal(gk_coverage_carry(1000, INFINITY, 1.0f, &excess), 1000);
    assert_true(excess > 0);
    assert_int_equal(gk_coverage_carry(0, 0.0f, 1.0f, &excess), 0);
}

// Each vertex rounds what goes on to half a unit, weights up to 1 do not let that grow, and what
// stays is what is left: to a vertex of depth k the share is right to k units of 2^-16.
static void a_chain_of_carries_is_double_precision_to_a_unit_a_vertex(void **state)
{
    (void)state;
    uint64_t seed = 3;
    for (int path = 0; path < 20000; path++) {
        gk_u32 held = 65536, given = 0;
        double exact = 65536.0;
        for (int k = 1; k <= 64; k++) {
            const float weight = 1.0f - 0.2f * check_uniform(&seed);
            gk_u32 excess;
            const gk_u32 on = gk_coverage_carry(held, (float)held, weight, &excess);
            assert_within((double)(held - on) - exact * (1.0 - (double)weight), k + 0.01);
            exact *= (double)weight;
            given += held - on;
            held = on;
            assert_within((double)held - exact, 0.5 * k + 0.01);
        }
        assert_int_equal(given + held, 65536);
    }
}

// A ball of 4 m, half the size of its mesh: 1/4 from outside, -1/4 from inside.
static void a_surface_that_bulges_is_hollow_from_its_other_side(void **state)
{
    (void)state;
    const struct gk_triangle triangle = {.flags = gk_as_u32(0.125f) & GK_TRIANGLE_CURVATURE};
    const struct gk_instance instance = {.shrink = 2.0f};
    const struct gk_resident scene = {.triangle = &triangle, .instance = &instance};
    struct gk_hit hit = {.cos_g = -0.5f};
    assert_true(gk_hit_curvature(&scene, &hit) == 0.25f);
    hit.cos_g = 0.5f;
    assert_true(gk_hit_curvature(&scene, &hit) == -0.25f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(log1p_and_expm1_keep_small_arguments),
        cmocka_unit_test(the_variance_of_a_lobe_is_that_of_the_printed_form),
        cmocka_unit_test(the_variance_of_a_lobe_has_its_limits),
        cmocka_unit_test(the_running_sums_give_the_exact_variance),
        cmocka_unit_test(of_one_scattering_eq3_has_an_nth_over_n_equal_ways),
        cmocka_unit_test(weights_are_those_of_the_plain_forms),
        cmocka_unit_test(a_weight_is_never_outside_of_0_and_1),
        cmocka_unit_test(nothing_added_to_nothing_keeps_all),
        cmocka_unit_test(a_scattering_into_all_directions_keeps_nothing_but_at_alpha_0),
        cmocka_unit_test(a_miss_is_the_limit_of_far_hits),
        cmocka_unit_test(a_cone_reflects_as_a_convex_mirror_does),
        cmocka_unit_test(the_clamp_keeps_a_cone_from_focusing_below_its_straight_width),
        cmocka_unit_test(a_cone_refracts_as_one_face_of_a_lens_does),
        cmocka_unit_test(what_goes_on_is_never_more_than_there_is),
        cmocka_unit_test(a_surface_that_bulges_is_hollow_from_its_other_side),
        cmocka_unit_test(a_chain_of_carries_is_double_precision_to_a_unit_a_vertex),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
