// Light sampling: directions and points come with the density that is stated for them.
#include "kernels/gk_light_grid.h"
#include "tests/kernel/check.h"

enum { WIDTH = 16, HEIGHT = 8, CELLS = WIDTH * HEIGHT, FINE = 4, N = 1000000 };

static const struct gk_light_keys still;
static struct gk_env_cell cell[CELLS];
static struct gk_env_texel texel[CELLS];
static double weight[CELLS]; // probabilities of the cells

// Walker's table for `weight`, by Vose's method.
static void build_alias(void)
{
    double scaled[CELLS];
    int small[CELLS], large[CELLS], smalls = 0, larges = 0;
    for (int i = 0; i < CELLS; i++) {
        scaled[i] = weight[i] * CELLS;
        cell[i].pdf = (float)scaled[i];
        if (scaled[i] < 1)
            small[smalls++] = i;
        else
            large[larges++] = i;
    }
    while (smalls && larges) {
        const int s = small[--smalls], l = large[larges - 1];
        cell[s].keep = (float)scaled[s];
        cell[s].other = (gk_u32)l;
        scaled[l] -= 1 - scaled[s];
        if (scaled[l] < 1)
            small[smalls++] = large[--larges];
    }
    while (smalls)
        cell[small[--smalls]].keep = 1;
    while (larges)
        cell[large[--larges]].keep = 1;
}

// Weights over four decades, one cell that outshines the rest, turned by 0.7 radians.
static struct gk_environment make_environment(void)
{
    uint64_t seed = odds_seed(5);
    double sum = 0;
    for (int i = 0; i < CELLS; i++)
        sum += weight[i] = i == 37 ? 4.0 : pow(10, -4 * (double)check_uniform(&seed));
    for (int i = 0; i < CELLS; i++) {
        weight[i] /= sum;
        texel[i] = (struct gk_env_texel){.L = {1, (float)i, (float)weight[i]}};
    }
    build_alias();
    struct gk_environment e = {texel,  cell,       WIDTH,      HEIGHT,          WIDTH,
                               HEIGHT, cosf(0.7f), sinf(0.7f), gk_vec(1, 1, 1), gk_cut_none()};
    return e;
}

static struct gk_vec draw(const struct gk_environment *e, uint64_t *seed)
{
    const float choice = check_uniform(seed), keep = check_uniform(seed), u = check_uniform(seed);
    return gk_environment_sample(e, choice, keep, u, check_uniform(seed));
}

// Image coordinates of a direction as gk_environment.h defines them, in double.
static void exact_uv(struct gk_vec d, double *u, double *v)
{
    const double x = cos(0.7) * d.x - sin(0.7) * d.z, z = sin(0.7) * d.x + cos(0.7) * d.z;
    *u = 0.5 + atan2(x, -z) / (2 * M_PI);
    *v = acos(fmax(-1, fmin(1, d.y))) / M_PI;
}

// Each cell in 4 x 4 parts, n = 10^6.
static void environment_samples_follow_their_cells(void **state)
{
    (void)state;
    static uint32_t count[CELLS * FINE * FINE];
    static double probability[CELLS * FINE * FINE];
    const struct gk_environment e = make_environment();
    uint64_t seed = odds_seed(6);
    for (int i = 0; i < N; i++) {
        double u, v;
        exact_uv(draw(&e, &seed), &u, &v);
        const int x = (int)(u * WIDTH * FINE), y = (int)(v * HEIGHT * FINE);
        count[(y < HEIGHT * FINE ? y : HEIGHT * FINE - 1) * WIDTH * FINE + x % (WIDTH * FINE)]++;
    }
    for (int i = 0; i < CELLS * FINE * FINE; i++) {
        const int x = i % (WIDTH * FINE) / FINE, y = i / (WIDTH * FINE) / FINE;
        probability[i] = weight[y * WIDTH + x] / (FINE * FINE);
    }
    assert_odds_chi2(check_chi2(count, probability, CELLS * FINE * FINE, N));
}

static void environment_coordinates_are_exact(void **state)
{
    (void)state;
    const struct gk_environment e = make_environment();
    uint64_t seed = odds_seed(7);
    for (int i = 0; i < 100000; i++) {
        double u, v;
        const struct gk_vec d = draw(&e, &seed);
        const struct gk_direction_uv at = gk_environment_uv(&e, d);
        exact_uv(d, &u, &v);
        assert_within(at.v - v, 3e-7);
        assert_within((at.u - u - rint(at.u - u)) * at.sine, 5e-7);
        assert_within(gk_dot(d, d) - 1, 1e-6);
    }
}

// Mean of 1/pdf over the samples is the sphere's 4 pi, of (1 + y)^2/pdf its integral, 16 pi/3.
static void environment_pdf_integrates_the_sphere(void **state)
{
    (void)state;
    const struct gk_environment e = make_environment();
    uint64_t seed = odds_seed(8);
    double sum[2] = {0}, square[2] = {0};
    for (int i = 0; i < N; i++) {
        const struct gk_vec d = draw(&e, &seed);
        const double pdf = gk_environment_pdf(&e, gk_environment_uv(&e, d));
        const double value[2] = {1 / pdf, (1 + (double)d.y) * (1 + (double)d.y) / pdf};
        for (int k = 0; k < 2; k++) {
            sum[k] += value[k];
            square[k] += value[k] * value[k];
        }
    }
    const double exact[2] = {4 * M_PI, 16 * M_PI / 3};
    for (int k = 0; k < 2; k++) {
        const double mean = sum[k] / N, error = sqrt((square[k] / N - mean * mean) / N);
        assert_odds(mean - exact[k], error, 0);
    }
}

// Half way between texels, across the seam and at the poles: the look-up stays inside.
static void environment_radiance_interpolates(void **state)
{
    (void)state;
    const struct gk_environment e = make_environment();
    uint64_t seed = odds_seed(9);
    struct gk_direction_uv at = {(5 + 0.5f) / WIDTH, (2 + 0.5f) / HEIGHT, 1};
    assert_within(gk_environment_radiance(&e, at).y - (2 * WIDTH + 5), 1e-3);
    at.u = 6.0f / WIDTH;
    assert_within(gk_environment_radiance(&e, at).y - (2 * WIDTH + 5.5), 1e-3);
    at.u = 0;
    assert_within(gk_environment_radiance(&e, at).y - (2 * WIDTH + 7.5), 1e-3);
    for (int i = 0; i < 100000; i++) {
        at.u = i % 7 ? check_uniform(&seed) : 1.0f;
        at.v = i % 5 ? check_uniform(&seed) : (float)(i & 1);
        assert_within(gk_environment_radiance(&e, at).x - 1, 1e-6);
    }
}

static const struct gk_light triangle = {
    .p = {0.2f, -0.3f, 2},
    .a = {1.5f, 0.2f, 0.1f},
    .b = {0.1f, -1.1f, 0.4f},
    .L = {3, 2, 1},
    .kind = GK_LIGHT_TRIANGLE,
    .triangle = 5,
    .material = GK_NONE,
};

// Solid angle of a triangle seen from the origin. Source: Van Oosterom and Strackee 1983.
static double solid_angle(const double a[3], const double b[3], const double c[3])
{
    const double la = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    const double lb = sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2]);
    const double lc = sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
    const double ab = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const double bc = b[0] * c[0] + b[1] * c[1] + b[2] * c[2];
    const double ca = c[0] * a[0] + c[1] * a[1] + c[2] * a[2];
    const double volume = a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                          a[2] * (b[0] * c[1] - b[1] * c[0]);
    return 2 * fabs(atan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb));
}

// Mean of 1/pdf over the samples of a triangle is the solid angle it fills.
static void triangle_pdf_integrates_its_solid_angle(void **state)
{
    (void)state;
    double corner[3][3], sum = 0, square = 0;
    for (int k = 0; k < 3; k++) {
        corner[0][k] = triangle.p[k];
        corner[1][k] = (double)triangle.p[k] + triangle.a[k];
        corner[2][k] = (double)triangle.p[k] + triangle.b[k];
    }
    uint64_t seed = odds_seed(10);
    for (int i = 0; i < N; i++) {
        const float u = check_uniform(&seed);
        const struct gk_light_sample s =
            gk_light_from_table(&triangle, 0, still, gk_splat(0), 0.25f, u, check_uniform(&seed));
        sum += 0.25 / s.pdf;
        square += 0.0625 / ((double)s.pdf * s.pdf);
    }
    const double mean = sum / N, error = sqrt((square / N - mean * mean) / N);
    const double exact = solid_angle(corner[0], corner[1], corner[2]);
    assert_odds(mean - exact, error, 5e-6 * exact);
}

// 16 congruent parts of the triangle, equally likely.
static void points_on_a_triangle_are_uniform(void **state)
{
    (void)state;
    uint32_t count[32] = {0};
    double probability[32] = {0};
    uint64_t seed = odds_seed(11);
    for (int i = 0; i < N; i++) {
        const float u = check_uniform(&seed);
        const struct gk_light_sample s =
            gk_light_from_table(&triangle, 0, still, gk_splat(0), 1, u, check_uniform(&seed));
        assert_true(s.u >= 0 && s.v >= 0 && s.u + s.v <= 1.0f);
        const int x = (int)fminf(s.u * 4, 3), y = (int)fminf(s.v * 4, 3);
        const int upper = s.u * 4 - (float)x + s.v * 4 - (float)y > 1;
        count[(y * 4 + x) * 2 + upper]++;
    }
    for (int i = 0; i < 32; i++)
        probability[i] = i / 8 + i / 2 % 4 + i % 2 < 4 ? 1.0 / 16 : 0;
    assert_odds_chi2(check_chi2(count, probability, 32, N));
}

// What a BSDF sample that hits the same point would compute is the same pdf.
static void both_techniques_agree_on_the_pdf(void **state)
{
    (void)state;
    uint64_t seed = odds_seed(12);
    const struct gk_vec a = gk_vec(triangle.a[0], triangle.a[1], triangle.a[2]);
    const struct gk_vec b = gk_vec(triangle.b[0], triangle.b[1], triangle.b[2]);
    const struct gk_vec n = gk_normalise(gk_cross(a, b));
    for (int i = 0; i < 10000; i++) {
        const float u = check_uniform(&seed);
        const struct gk_light_sample s =
            gk_light_from_table(&triangle, 0, still, gk_splat(0), 0.25f, u, check_uniform(&seed));
        const float hit =
            gk_triangle_light_pdf(&triangle, 0, still, s.distance, gk_abs(gk_dot(s.wi, n)), 0.25f);
        assert_within(hit / s.pdf - 1, 1e-4);
        assert_true(!s.delta && s.triangle == 5);
    }
}

static void one_sided_emitters_are_dark_from_behind(void **state)
{
    (void)state;
    struct gk_light turned = triangle, both = triangle;
    memcpy(turned.a, triangle.b, sizeof turned.a);
    memcpy(turned.b, triangle.a, sizeof turned.b);
    both.kind |= 1u << 4;
    const struct gk_vec at = gk_splat(0);
    const float here = gk_light_from_table(&triangle, 0, still, at, 1, 0.3f, 0.4f).L.x;
    assert_true(here + gk_light_from_table(&turned, 0, still, at, 1, 0.3f, 0.4f).L.x == 3.0f);
    assert_true(gk_light_from_table(&both, 0, still, at, 1, 0.3f, 0.4f).L.x == 3.0f);
}

// A spot of 12 W/sr in the axis gives 12 / d^2; between the cones the square of the ramp (glTF
// KHR_lights_punctual), outside nothing.
static void punctual_lights_fall_off_with_the_square(void **state)
{
    (void)state;
    const struct gk_light spot = {.p = {0, 0, 2},
                                  .a = {0, 0, -1},
                                  .b = {0.5f, 1 / (0.9f - 0.5f), 0},
                                  .L = {12, 12, 12},
                                  .kind = GK_LIGHT_POINT,
                                  .triangle = GK_NONE};
    const struct gk_light_sample below =
        gk_light_from_table(&spot, 0, still, gk_splat(0), 0.5f, 0.1f, 0.2f);
    assert_true(below.delta && below.pdf == 1.0f && below.distance == 2.0f);
    assert_within(below.L.x - 12.0 / 4 / 0.5, 1e-5);
    assert_true(below.wi.x == 0 && below.wi.y == 0 && below.wi.z == 1);
    const float x = 2 * sqrtf(1 / 0.49f - 1); // under a cosine of 0.7: half the ramp
    const struct gk_light_sample aside =
        gk_light_from_table(&spot, 0, still, gk_vec(x, 0, 0), 1, 0.1f, 0.2f);
    assert_within(aside.L.x - 12 * 0.25 / (4 + (double)x * x), 1e-5);
    assert_true(gk_light_from_table(&spot, 0, still, gk_vec(9, 0, 0), 1, 0.1f, 0.2f).L.x == 0);
}

static void the_sun_is_infinitely_far_and_does_not_fall_off(void **state)
{
    (void)state;
    const struct gk_light sun = {.p = {0, 1, 0}, .L = {5, 5, 5}, .kind = GK_LIGHT_SUN};
    const struct gk_light_sample s =
        gk_light_from_table(&sun, 0, still, gk_vec(7, -3, 2), 0.5f, 0, 0);
    assert_true(s.delta && isinf(s.distance) && s.wi.y == 1 && s.L.x == 10);
}

// What gk_light_from_table() brings to a receiver, over its density.
static double brought(const struct gk_light *light, const struct gk_light_receiver *to, float u,
                      float v)
{
    const struct gk_light_sample s = gk_light_from_table(light, 0, still, to->x, 0.125f, u, v);
    const double cosine = gk_dot(s.wi, to->n);
    const double weight = cosine > 0 ? cosine : -cosine * to->behind;
    return gk_mean3(s.L) / s.pdf * (gk_dot(to->n, to->n) > 0 ? weight : 1);
}

// Of what open space gets, what a candidate's point changes by, for it is not lifted off its emitter:
// that over the height of the receiver above the emitter's plane, for the emitter's cosine, the
// distance and the receiver's cosine.
static double unlifted(const struct gk_light *light, struct gk_vec x)
{
    if ((light->kind & GK_LIGHT_KIND) != GK_LIGHT_TRIANGLE)
        return 0.0;
    const struct gk_vec p = gk_vec(light->p[0], light->p[1], light->p[2]),
                        n = gk_normalise(gk_cross(gk_vec(light->a[0], light->a[1], light->a[2]),
                                                  gk_vec(light->b[0], light->b[1], light->b[2])));
    const double height = fabsf(gk_dot(gk_sub(x, p), n));
    const double lift = gk_point_error(gk_splat(3), 0.0f); // none of its coordinates is above 3
    return 4.0 * lift / fmax(height - lift, 1e-37);
}

// Of both kinds of triangles, spots and suns; on a surface, on one that lets light through, and in
// open space. 2e-5 of what open space gets for the rounding, and 1e-4 of some 10, for the rim of a
// spot.
static void what_a_candidate_promises_is_what_its_light_brings(void **state)
{
    (void)state;
    struct gk_light light[4] = {triangle,
                                triangle,
                                {.p = {0.2f, 0.1f, 2},
                                 .a = {0, 0, -1},
                                 .b = {0.3f, 1 / (0.9f - 0.3f), 0},
                                 .L = {12, 3, 6},
                                 .kind = GK_LIGHT_POINT},
                                {.p = {0.6f, 0.8f, 0}, .L = {5, 1, 3}, .kind = GK_LIGHT_SUN}};
    light[1].kind |= 1u << 4;
    uint64_t seed = odds_seed(16);
    int lit = 0;
    for (int i = 0; i < 40000; i++) {
        float r[8]; // drawn in this order, whatever the compiler
        for (int k = 0; k < 8; k++)
            r[k] = check_uniform(&seed);
        const struct gk_vec n = gk_normalise(gk_vec(r[0] - 0.5f, r[1] - 0.5f, r[2] - 0.5f));
        const struct gk_light_receiver to = {gk_vec(2 * r[3] - 1, 2 * r[4] - 1, 4 * r[5] - 2),
                                             i % 3 == 0 ? gk_splat(0) : n, i % 3 == 1 ? 1.0f : 0.0f,
                                             still};
        const float u = r[6], v = r[7];
        const struct gk_light *l = &light[i % 4];
        const struct gk_light_receiver open = {to.x, gk_splat(0), 0, still};
        const double expected = brought(l, &to, u, v), most = brought(l, &open, u, v);
        assert_within(gk_light_promise(l, 0, &to, 0.125f, u, v) - expected,
                      (2e-5 + unlifted(l, to.x)) * most + 1e-4);
        lit += expected > 0;
    }
    assert_true(lit > 10000);
}

// From pdfs of 2^-100 to 2^100, and with one technique that cannot or can only take the direction.
static void weights_of_two_techniques_sum_to_one(void **state)
{
    (void)state;
    for (int i = -100; i <= 100; i++)
        for (int j = -100; j <= 100; j++) {
            const float a = ldexpf(1.3f, i), b = ldexpf(1.7f, j);
            const float w = gk_mis_weight(a, b), v = gk_mis_weight(b, a);
            assert_true(w >= 0 && w <= 1 && v >= 0 && v <= 1);
            assert_within((double)w + v - 1, 4 * GK_UNIT);
        }
    assert_true(gk_mis_weight(1.0f, 0.0f) == 1.0f && gk_mis_weight(1.0f, INFINITY) == 0.0f);
    assert_true(gk_mis_weight(0.0f, 1.0f) == 0.0f && gk_mis_weight(INFINITY, 1.0f) == 1.0f);
}

static void alias_table_chooses_by_weight(void **state)
{
    (void)state;
    static const struct gk_alias table[4] = {{0.4f, 3}, {1, 1}, {0.2f, 1}, {0.8f, 2}};
    const double probability[4] = {0.1, 0.25 + 0.2, 0.05 + 0.05, 0.15 + 0.2};
    uint32_t count[4] = {0};
    uint64_t seed = odds_seed(13);
    for (int i = 0; i < N; i++) {
        struct gk_light_pair r;
        const float u = check_uniform(&seed);
        gk_light_pair_make(&r, u, check_uniform(&seed));
        count[gk_alias_choose(table, 4, &r, gk_cut_none())]++;
    }
    for (int k = 0; k < 4; k++)
        assert_odds(count[k] - N * probability[k], sqrt(N * probability[k] * (1 - probability[k])),
                    0);
}

// Which light, and the place on it, each in 8 x 8 parts: n = 10^6.
static void one_pair_takes_a_light_by_weight_and_a_uniform_point_on_it(void **state)
{
    (void)state;
    enum { SIDE = 8, PARTS = SIDE * SIDE };
    static const struct gk_alias table[5] = {
        {0.40625f, 3}, {1, 1}, {0.1875f, 1}, {0.8125f, 2}, {0x1p-12f, 0}};
    const double share[5] = {0.08125 + 0.2 * (1 - 0x1p-12), 0.2 + 0.1625, 0.0375 + 0.0375,
                             0.1625 + 0.11875, 0.2 * 0x1p-12};
    static uint32_t count[5 * PARTS];
    static double probability[5 * PARTS];
    uint64_t seed = odds_seed(15);
    memset(count, 0, sizeof count);
    for (int i = 0; i < N; i++) {
        struct gk_light_pair r;
        const float u = check_uniform(&seed);
        gk_light_pair_make(&r, u, check_uniform(&seed));
        const uint32_t light = gk_alias_choose(table, 5, &r, gk_cut_none());
        assert_true(light < 5 && r.v >= 0 && r.v < 1);
        count[light * PARTS + (r.u >> 29) * SIDE + (uint32_t)(r.v * SIDE)]++;
    }
    for (int i = 0; i < 5 * PARTS; i++)
        probability[i] = share[i / PARTS] / PARTS;
    assert_odds_chi2(check_chi2(count, probability, 5 * PARTS, N));
}

// A million lights leave 4 of the 24 bits of u; the rest is filled.
static void the_last_of_many_lights_is_taken_at_every_place(void **state)
{
    (void)state;
    enum { LIGHTS = 1000000, PARTS = 64 };
    uint32_t count[PARTS] = {0};
    double probability[PARTS];
    uint64_t seed = odds_seed(14);
    for (int i = 0; i < N; i++) {
        struct gk_light_pair r;
        const float u = check_uniform(&seed);
        gk_light_pair_make(&r, u, check_uniform(&seed));
        assert_true(gk_light_pair_slot(&r, LIGHTS) < LIGHTS);
        count[r.u >> 26]++;
    }
    for (int i = 0; i < PARTS; i++)
        probability[i] = 1.0 / PARTS;
    assert_odds_chi2(check_chi2(count, probability, PARTS, N));
    struct gk_light_pair last;
    gk_light_pair_make(&last, 1.0f - GK_UNIT, 0.99f);
    assert_int_equal(gk_light_pair_slot(&last, LIGHTS), LIGHTS - 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(environment_samples_follow_their_cells),
        cmocka_unit_test(environment_coordinates_are_exact),
        cmocka_unit_test(environment_pdf_integrates_the_sphere),
        cmocka_unit_test(environment_radiance_interpolates),
        cmocka_unit_test(triangle_pdf_integrates_its_solid_angle),
        cmocka_unit_test(points_on_a_triangle_are_uniform),
        cmocka_unit_test(both_techniques_agree_on_the_pdf),
        cmocka_unit_test(one_sided_emitters_are_dark_from_behind),
        cmocka_unit_test(punctual_lights_fall_off_with_the_square),
        cmocka_unit_test(the_sun_is_infinitely_far_and_does_not_fall_off),
        cmocka_unit_test(what_a_candidate_promises_is_what_its_light_brings),
        cmocka_unit_test(weights_of_two_techniques_sum_to_one),
        cmocka_unit_test(alias_table_chooses_by_weight),
        cmocka_unit_test(one_pair_takes_a_light_by_weight_and_a_uniform_point_on_it),
        cmocka_unit_test(the_last_of_many_lights_is_taken_at_every_place),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
