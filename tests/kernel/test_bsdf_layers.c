// The layers of a surface: multiple scattering, specular, clear coat, collimation.
#define GK_MULTISCATTER 1
#define GK_SPECULAR 1
#define GK_CLEARCOAT 1
#define GK_COLLIMATION 1
#include "tests/kernel/surface.h"

#define COUNT(a) (sizeof(a) / sizeof *(a))

static const float cosines[] = {1, 0.6f, 0.3f, 0.1f, 0.02f};
static const float roughnesses[] = {0, 0.035f, 0.1f, 0.2f, 0.32f, 0.5f, 0.7f, 0.85f, 1};

static const struct layers plain = {1, {1, 1, 1}, 0, 0, 0, 1};
static const struct layers matt = {0.3f, {1, 1, 1}, 0, 0, 0, 1};
static const struct layers strong = {1, {30, 30, 30}, 0, 0, 0, 1};
static const struct layers varnish = {1, {1, 1, 1}, 1, 0, 0, 1};
static const struct layers frost = {1, {1, 1, 1}, 1, 0.5f, 0, 1};
static const struct layers chalk = {1, {1, 1, 1}, 0.7f, 1, 0, 1};
static const struct layers orange_peel = {1, {1, 1, 1}, 1, 0.3f, 0.2f, 1};
static const struct layers milk = {1, {1, 1, 1}, 0, 0, 0, 0.6f};
static const struct layers paper = {1, {1, 1, 1}, 0, 0, 0, 0};
static const struct layers all = {0.8f, {3, 1, 0.2f}, 0.6f, 0.4f, 0.1f, 0.7f};

static const struct material kinds[] = {
    {"plastic", 1, 0, 0, 0, 1.5f, 0, 0, &plain},
    {"metal", 1, 1, 0, 0, 1.5f, 0, 0, &plain},
    {"mixed", 1, 0.3f, 0.5f, 0, 1.5f, 0, 0, &plain},
    {"dense", 1, 0, 0, 0, 2.5f, 0, 0, &plain},
    {"matt plastic", 1, 0, 0, 0, 1.5f, 0, 0, &matt},
    {"mirror of a dielectric", 1, 0, 0, 0, 1.5f, 0, 0, &strong},
    {"bright glass", 1, 0, 1, 0, 1.5f, 0, 0, &strong},
    {"matt glass, inside", 1, 0, 1, 0, 1.5f, 0, 1, &matt},
    {"varnished plastic", 1, 0, 0, 0, 1.5f, 0, 0, &varnish},
    {"varnished metal", 1, 1, 0, 0, 1.5f, 0, 0, &varnish},
    {"varnished glass", 1, 0, 1, 0, 1.5f, 0, 0, &varnish},
    {"varnished glass, inside", 1, 0, 1, 0, 1.5f, 0, 1, &varnish},
    {"frosted plastic", 1, 0, 0, 0, 1.5f, 0, 0, &frost},
    {"frosted metal", 1, 1, 0, 0, 1.5f, 0, 0, &frost},
    {"frosted pane", 1, 0, 1, 0, 1.5f, 1, 0, &frost},
    {"chalky metal", 1, 1, 0, 0, 1.5f, 0, 0, &chalk},
    {"orange peel", 1, 0.5f, 0, 0, 1.5f, 0, 0, &orange_peel},
    {"milk glass", 1, 0, 1, 0, 1.5f, 0, 0, &milk},
    {"milk glass, inside", 1, 0, 1, 0, 1.5f, 0, 1, &milk},
    {"milky pane", 1, 0, 1, 0, 1.5f, 1, 0, &milk},
    {"paper", 1, 0, 1, 0, 1.5f, 1, 0, &paper},
    {"paper glass", 1, 0, 1, 0, 1.5f, 0, 0, &paper},
    {"everything", 1, 0.3f, 0.5f, 0, 1.5f, 0, 0, &all},
    {"everything, inside", 1, 0.3f, 0.5f, 0, 1.5f, 0, 1, &all},
};

struct estimate {
    double mean, error;
};

// Mean of the least reflected and refracted colour, as energy: without the factor 1/eta^2 of
// refracted radiance.
static struct estimate albedo(const struct material *m, float cosine, int n)
{
    const struct gk_vec wo = direction(cosine, 0.2);
    const struct gk_surface s = make_surface_at(m, wo);
    double sum = 0, square = 0;
    uint64_t seed = 77;
    for (int i = 0; i < n; i++) {
        const struct gk_bsdf_sample sample = draw(&s, wo, &seed);
        double w = sample_weight(&s, wo, &sample);
        if (sample.wi.z < 0 && !s.thin)
            w *= (double)s.eta * s.eta;
        sum += w;
        square += w * w;
    }
    const double mean = sum / n, variance = square / n - mean * mean;
    return (struct estimate){mean, sqrt(fmax(0, variance) / n)};
}

// With compensation a white metal returns all at any roughness: 1 +- 0.01, n = 10^5.
static void a_white_metal_returns_all(void **state)
{
    (void)state;
    double worst = 0;
    for (size_t r = 0; r < COUNT(roughnesses); r++)
        for (size_t c = 0; c < COUNT(cosines); c++) {
            const struct material m = {"metal", 1, 1, 0, roughnesses[r], 1.5f, 0, 0, &plain};
            const struct estimate e = albedo(&m, cosines[c], 100000);
            worst = fmax(worst, fabs(e.mean - 1));
            if (!(fabs(e.mean - 1) <= 0.01 + CHECK_Z * e.error))
                fail_msg("roughness %g, cos %g: albedo %.6f +- %.6f", (double)m.roughness,
                         (double)cosines[c], e.mean, e.error);
        }
    print_message("# off by %.5f at most\n", worst);
}

// No layer gives back more than it gets; 0.003 is what the table may be off. n = 4 10^4.
static void a_white_furnace_never_brightens(void **state)
{
    (void)state;
    double most = 0;
    for (size_t k = 0; k < COUNT(kinds); k++)
        for (size_t r = 0; r < COUNT(roughnesses); r++)
            for (size_t c = 0; c < COUNT(cosines); c++) {
                struct material m = kinds[k];
                m.roughness = roughnesses[r];
                const struct estimate e = albedo(&m, cosines[c], 40000);
                most = fmax(most, e.mean - 4.9 * e.error);
                if (!(e.mean <= 1 + 4.9 * e.error + 0.003))
                    fail_msg("%s, roughness %g, cos %g: albedo %.6f +- %.6f", m.name,
                             (double)m.roughness, (double)cosines[c], e.mean, e.error);
            }
    print_message("# at most %.5f\n", most);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_white_metal_returns_all),
        cmocka_unit_test(a_white_furnace_never_brightens),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
