// gk_bsdf_sample draws from the density that gk_bsdf_eval states: chi-squared over the sphere, and
// the mass of delta lobes by its binomial.
#include "tests/kernel/density.h"

static const struct material materials[] = {
    {"lambert", 0.8f, 0, 0, 1.0f, 1.0f, 0, 0},
    {"plastic, rough", 0.8f, 0, 0, 0.5f, 1.5f, 0, 0},
    {"plastic, glossy", 0.2f, 0, 0, 0.2f, 1.5f, 0, 0},
    {"metal, rough", 0.9f, 1, 0, 1.0f, 1.5f, 0, 0},
    {"metal", 0.9f, 1, 0, 0.5f, 1.5f, 0, 0},
    {"metal, glossy", 0.9f, 1, 0, 0.2f, 1.5f, 0, 0},
    {"half metal", 0.5f, 0.5f, 0, 0.4f, 1.5f, 0, 0},
    {"glass, rough", 1, 0, 1, 1.0f, 1.5f, 0, 0},
    {"glass", 1, 0, 1, 0.5f, 1.5f, 0, 0},
    {"glass, glossy", 1, 0, 1, 0.25f, 1.5f, 0, 0},
    {"glass from inside, rough", 1, 0, 1, 0.8f, 1.5f, 0, 1},
    {"glass from inside, glossy", 1, 0, 1, 0.25f, 1.5f, 0, 1},
    {"diamond", 1, 0, 1, 0.4f, 2.42f, 0, 0},
    {"almost matched", 1, 0, 1, 0.5f, 1.05f, 0, 0},
    {"pane", 1, 0, 1, 0.5f, 1.5f, 1, 0},
    {"pane, rough", 0.7f, 0, 1, 1.0f, 1.5f, 1, 0},
    {"everything at once", 0.6f, 0.3f, 0.5f, 0.5f, 1.5f, 0, 0},
    {"everything from inside", 0.6f, 0.3f, 0.5f, 0.5f, 1.5f, 0, 1},
};
enum { MATERIALS = sizeof materials / sizeof *materials };

static void samples_follow_their_density(void **state)
{
    (void)state;
    static const double cosine[] = {1, 0.6, 0.1};
    for (int m = 0; m < MATERIALS; m++)
        for (int c = 0; c < 3; c++)
            check_density(&materials[m], cosine[c]);
}

// A smooth dielectric reflects with probability F, a smooth coat over a diffuse base takes the
// diffuse lobe with p_diffuse: binomial, 4.892 sigma.
static void delta_lobes_have_their_mass(void **state)
{
    (void)state;
    static const struct material smooth[] = {{"glass", 1, 0, 1, 0, 1.5f, 0, 0},
                                             {"glass from inside", 1, 0, 1, 0, 1.5f, 0, 1},
                                             {"pane", 1, 0, 1, 0, 1.5f, 1, 0}};
    uint64_t seed = odds_seed(99);
    for (int m = 0; m < 3; m++)
        for (int c = 1; c <= 10; c++) {
            const double cosine = c / 10.0;
            const struct gk_surface s = make_surface(&smooth[m], (float)cosine);
            const double f = exact_fresnel(cosine, s.eta), n = 100000;
            double reflected = 0;
            for (int i = 0; i < n; i++) {
                const struct gk_bsdf_sample sample = draw(&s, direction(cosine, 0.3), &seed);
                assert_true(sample.delta);
                reflected += sample.wi.z > 0;
            }
            assert_odds(reflected - n * f, sqrt(n * f * (1 - f)), 1e-3);
        }
}

static void a_smooth_coat_leaves_the_rest_to_the_diffuse_lobe(void **state)
{
    (void)state;
    const struct material coat = {"coat", 0.5f, 0, 0, 0, 1.5f, 0, 0};
    const struct gk_surface s = make_surface(&coat, 0.5f);
    uint64_t seed = odds_seed(98);
    const double n = 100000;
    double diffuse = 0;
    for (int i = 0; i < n; i++)
        diffuse += !draw(&s, direction(0.5, 0.3), &seed).delta;
    assert_odds(diffuse - n * s.p_diffuse, sqrt(n * s.p_diffuse * (1 - s.p_diffuse)), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_follow_their_density),
        cmocka_unit_test(delta_lobes_have_their_mass),
        cmocka_unit_test(a_smooth_coat_leaves_the_rest_to_the_diffuse_lobe),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
