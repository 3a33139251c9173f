// The light grid of hard scenes: probabilities sum to one everywhere, and nothing that shines is lost.
#include "kernels/gk_light_grid.h"
#include "scene/light_grid.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdlib.h>

enum { LIGHTS = 3000 };

static struct gk_light light[LIGHTS];
static double power[LIGHTS];
static uint64_t seed = 3;

static double random_number(void)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(seed >> 11) * 0x1p-53;
}

// Points in a box of the given half sizes, powers over `decades`.
static void make_points(uint32_t n, const double half[3], double decades)
{
    for (uint32_t i = 0; i < n; i++) {
        light[i] = (struct gk_light){.kind = GK_LIGHT_POINT, .triangle = GK_NONE};
        for (int k = 0; k < 3; k++)
            light[i].p[k] = (float)(half[k] * (2.0 * random_number() - 1.0));
        power[i] = pow(10.0, decades * random_number());
        light[i].b[0] = -2.0f; // shines all around
    }
}

struct grid {
    uint32_t *words;
    struct gk_frame frame;
};

static struct grid build(uint32_t n, const double half[3])
{
    struct grid g = {0};
    struct glint_scene_lighting l = {0};
    struct glint_error err = {0};
    size_t count;
    const struct glint_light_grid_order order = {light, power, n, half};
    assert_int_equal(glint_light_grid_build(&g.words, &count, &l, &order, &err), GLINT_OK);
    for (int k = 0; k < 3; k++) {
        g.frame.grid_origin[k] = l.grid_origin[k];
        g.frame.grid_scale[k] = l.grid_scale[k];
        g.frame.grid_size[k] = l.grid_size[k];
    }
    g.frame.grid_clusters = l.grid_clusters;
    g.frame.grid_members = l.grid_members;
    g.frame.grid_owners = l.grid_owners;
    return g;
}

// At points inside and far outside: all of one, and each that shines more than none.
static void assert_complete(uint32_t n, const double half[3])
{
    struct grid g = build(n, half);
    for (int t = 0; t < 50; t++) {
        const double reach = t % 2 ? 1e6 : 1.0;
        const struct gk_vec p = gk_vec((float)(reach * half[0] * (2.0 * random_number() - 1.0)),
                                       (float)(reach * half[1] * (2.0 * random_number() - 1.0)),
                                       (float)(reach * half[2] * (2.0 * random_number() - 1.0)));
        const struct gk_light_grid at = gk_light_grid_at(&g.frame, g.words, p, gk_cut_none());
        double sum = 0.0;
        for (uint32_t i = 0; i < n; i++) {
            const float choice = gk_grid_choice(&at, i);
            if ((choice > 0.0f) != (power[i] > 0.0))
                fail_msg("light %u of power %g has probability %g", i, power[i], choice);
            sum += choice;
        }
        assert_true(fabs(sum - 1.0) < 8 * 0x1p-24);
    }
    free(g.words);
}

static const double room[3] = {5, 1.5, 4};

static void probabilities_sum_to_one(void **state)
{
    (void)state;
    static const uint32_t n[] = {17, 100, 2000, LIGHTS};
    for (int i = 0; i < 4; i++) {
        make_points(n[i], room, 4.0);
        assert_complete(n[i], room);
    }
}

static void thirty_decades_lose_no_light(void **state)
{
    (void)state;
    make_points(500, room, 30.0);
    assert_complete(500, room);
}

static void black_lights_are_never_chosen(void **state)
{
    (void)state;
    make_points(LIGHTS, room, 4.0);
    for (int i = 0; i < LIGHTS; i += 3)
        power[i] = 0.0;
    assert_complete(LIGHTS, room);
}

static void flat_and_pointlike_scenes_have_a_grid(void **state)
{
    (void)state;
    static const double flat[3] = {5, 0, 4}, line[3] = {0, 0, 7}, point[3] = {0, 0, 0};
    const double *const half[3] = {flat, line, point};
    for (int i = 0; i < 3; i++) {
        make_points(LIGHTS, half[i], 4.0);
        assert_complete(LIGHTS, half[i]);
    }
}

static void suns_alone_have_a_grid(void **state)
{
    (void)state;
    make_points(40, room, 2.0);
    for (int i = 0; i < 40; i++) {
        light[i].kind = GK_LIGHT_SUN;
        light[i].L[0] = light[i].L[1] = light[i].L[2] = (float)power[i];
    }
    assert_complete(40, room);
}

// The words are the same bits when all power is scaled by 2^k.
static void scaling_by_a_power_of_two_changes_no_bit(void **state)
{
    (void)state;
    make_points(1000, room, 4.0);
    struct grid a = build(1000, room);
    for (int i = 0; i < 1000; i++)
        power[i] = ldexp(power[i], 30);
    struct grid b = build(1000, room);
    assert_memory_equal(&a.frame, &b.frame, sizeof a.frame);
    assert_memory_equal(a.words, b.words, (b.frame.grid_owners + 2000) * sizeof *a.words);
    free(a.words);
    free(b.words);
}

// What is chosen is chosen as often as is said: n = 10^6 at one point, 4.9 standard errors.
static void choices_are_as_frequent_as_said(void **state)
{
    (void)state;
    enum { FEW = 20, N = 1000000 };
    static uint32_t count[FEW];
    make_points(FEW, room, 2.0);
    struct grid g = build(FEW, room);
    const struct gk_light_grid at =
        gk_light_grid_at(&g.frame, g.words, gk_vec(1, 0.5f, -2), gk_cut_none());
    for (int i = 0; i < N; i++) {
        struct gk_light_pair r;
        const float u = (float)(random_number() * 0.9999999);
        gk_light_pair_make(&r, u, (float)(random_number() * 0.9999999));
        count[gk_grid_choose(&at, &r).light]++;
    }
    for (uint32_t i = 0; i < FEW; i++) {
        const double p = gk_grid_choice(&at, i);
        assert_true(fabs(count[i] - N * p) <= 4.9 * sqrt(N * p * (1.0 - p)));
    }
    free(g.words);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(probabilities_sum_to_one),
        cmocka_unit_test(thirty_decades_lose_no_light),
        cmocka_unit_test(black_lights_are_never_chosen),
        cmocka_unit_test(flat_and_pointlike_scenes_have_a_grid),
        cmocka_unit_test(suns_alone_have_a_grid),
        cmocka_unit_test(scaling_by_a_power_of_two_changes_no_bit),
        cmocka_unit_test(choices_are_as_frequent_as_said),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
