// Samples of layered surfaces follow the density that is stated for them, every layer compiled in.
#define GK_MULTISCATTER 1
#define GK_SPECULAR 1
#define GK_CLEARCOAT 1
#define GK_COLLIMATION 1
#include "tests/kernel/density.h"

static const struct layers bright = {0.7f, {8, 8, 8}, 0, 0, 0, 1};
static const struct layers frost = {1, {1, 1, 1}, 1, 0.5f, 0, 1};
static const struct layers orange_peel = {1, {1, 1, 1}, 1, 0.4f, 0.3f, 1};
static const struct layers varnish = {1, {1, 1, 1}, 1, 0, 0, 1};
static const struct layers milk = {1, {1, 1, 1}, 0, 0, 0, 0.5f};
static const struct layers all = {0.8f, {3, 3, 3}, 0.6f, 0.4f, 0.1f, 0.7f};

static const struct material materials[] = {
    {"metal, rough", 0.9f, 1, 0, 1.0f, 1.5f, 0, 0, NULL},
    {"plastic, rough", 0.8f, 0, 0, 0.7f, 1.5f, 0, 0, NULL},
    {"bright plastic", 0.4f, 0, 0, 0.5f, 1.5f, 0, 0, &bright},
    {"frosted metal", 0.9f, 1, 0, 0.3f, 1.5f, 0, 0, &frost},
    {"frosted glass", 0.9f, 0, 1, 0.6f, 1.5f, 0, 0, &frost},
    {"orange peel", 0.5f, 0.5f, 0, 0.6f, 1.5f, 0, 0, &orange_peel},
    {"varnished plastic", 0.5f, 0, 0, 0.6f, 1.5f, 0, 0, &varnish},
    {"milk glass", 1, 0, 1, 0.3f, 1.5f, 0, 0, &milk},
    {"milk glass from inside", 1, 0, 1, 0.3f, 1.5f, 0, 1, &milk},
    {"milky pane", 1, 0, 1, 0.25f, 1.5f, 1, 0, &milk},
    {"milk without interface", 1, 0, 1, 0.25f, 1, 0, 0, &milk},
    {"everything", 0.6f, 0.3f, 0.5f, 0.5f, 1.5f, 0, 0, &all},
    {"everything from inside", 0.6f, 0.3f, 0.5f, 0.5f, 1.5f, 0, 1, &all},
};
enum { MATERIALS = sizeof materials / sizeof *materials };

static void samples_follow_their_density(void **state)
{
    (void)state;
    static const double cosine[] = {1, 0.5, 0.1};
    for (int m = 0; m < MATERIALS; m++)
        for (int c = 0; c < 3; c++)
            check_density(&materials[m], cosine[c]);
}

// The coat over a diffuse base takes its albedo's share: binomial, 4.892 sigma.
static void a_delta_coat_has_its_mass(void **state)
{
    (void)state;
    const struct material m = {"varnished", 0.5f, 0, 0, 1, 1, 0, 0, &varnish};
    const struct gk_surface s = make_surface(&m, 0.3f);
    const struct gk_vec wo = direction(0.3f, 0.2);
    uint64_t seed = odds_seed(98);
    const double n = 100000, p = s.coat.p;
    const double f = exact_fresnel(0.3f, 1.5);
    double coat = 0;
    for (int i = 0; i < n; i++)
        coat += draw(&s, wo, &seed).delta;
    assert_within(p - f / (f + 0.5 * (1 - f)), 1e-5);
    assert_odds(coat - n * p, sqrt(n * p * (1 - p)), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_follow_their_density),
        cmocka_unit_test(a_delta_coat_has_its_mass),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
