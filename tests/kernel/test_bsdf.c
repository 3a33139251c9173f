// What must hold of scattering whatever its parameters: energy, reciprocity, finite values.
#include "tests/kernel/surface.h"

// Mean and standard error of f |cos| / pdf.
struct estimate {
    double mean, error;
};

// `as_energy`: what is refracted counts as flux, without the radiance's factor 1/eta^2, so that a
// lossless solid interface has albedo 1.
static struct estimate albedo(const struct material *m, float cosine, int few, int as_energy)
{
    const int n = (int)odds_samples((uint32_t)few);
    const struct gk_surface s = make_surface(m, cosine);
    const struct gk_vec wo = direction(cosine, 0.2);
    double sum = 0, square = 0;
    uint64_t seed = odds_seed(77);
    for (int i = 0; i < n; i++) {
        const struct gk_bsdf_sample sample = draw(&s, wo, &seed);
        double w = sample_weight(&s, wo, &sample);
        if (as_energy && sample.wi.z < 0 && !s.thin)
            w *= (double)s.eta * s.eta;
        sum += w;
        square += w * w;
    }
    const double mean = sum / n, variance = square / n - mean * mean;
    return (struct estimate){mean, sqrt(fmax(0, variance) / n)};
}

static const float cosines[] = {1, 0.6f, 0.3f, 0.1f, 0.02f};
static const float roughnesses[] = {0, 1e-4f, 0.01f, 0.035f, 0.1f, 0.5f, 1};

// No surface gives back more than it gets: base 1, albedo <= 1 + 4.9 standard errors. n = 4 10^5;
// delta lobes have hardly any variance.
static void a_white_furnace_never_brightens(void **state)
{
    (void)state;
    static const struct material kinds[] = {
        {"plastic", 1, 0, 0, 0, 1.5f, 0, 0}, {"metal", 1, 1, 0, 0, 1.5f, 0, 0},
        {"glass", 1, 0, 1, 0, 1.5f, 0, 0},   {"glass, inside", 1, 0, 1, 0, 1.5f, 0, 1},
        {"pane", 1, 0, 1, 0, 1.5f, 1, 0},    {"mixed", 1, 0.3f, 0.5f, 0, 1.5f, 0, 0},
        {"dense", 1, 0, 0, 0, 2.5f, 0, 0},   {"diamond", 1, 0, 1, 0, 2.42f, 0, 0},
    };
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
        for (size_t r = 0; r < sizeof roughnesses / sizeof *roughnesses; r++)
            for (size_t c = 0; c < sizeof cosines / sizeof *cosines; c++) {
                struct material m = kinds[k];
                m.roughness = roughnesses[r];
                const int n = m.roughness < 0.03f ? 10000 : 400000;
                const struct estimate e = albedo(&m, cosines[c], n, 1);
                odds_note(__FILE__, __func__, "bound", e.mean - 1, e.error);
                if (!(e.mean <= 1 + ODDS_Z * e.error + 1e-6))
                    fail_msg("%s, roughness %g, cos %g: albedo %.6f +- %.6f", m.name,
                             (double)m.roughness, (double)cosines[c], e.mean, e.error);
            }
}

// Directional albedo of single-scattering GGX with F = 1, height-correlated masking. 1 - ln 2 for
// alpha 1 at normal incidence is exact, the others were integrated numerically.
static void single_scattering_loses_what_is_known(void **state)
{
    (void)state;
    static const struct {
        float roughness, cosine;
        double albedo;
    } known[] = {{1, 1, 0.306853},
                 {1, 0.6f, 0.4114},
                 {1, 0.3f, 0.5594},
                 {1, 0.1f, 0.7601},
                 {0.31622777f, 1, 0.9885},
                 {0.31622777f, 0.6f, 0.9766},
                 {0.31622777f, 0.3f, 0.9367},
                 {0.31622777f, 0.1f, 0.8835}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        const struct material m = {"mirror", 1, 1, 0, known[i].roughness, 1.5f, 0, 0};
        const struct estimate e = albedo(&m, known[i].cosine, 400000, 0);
        // The first is exact, the others are printed to 4 digits.
        assert_odds(e.mean - known[i].albedo, e.error, i ? 5e-5 : 0);
    }
}

// A smooth interface loses nothing; the diffuse base under a smooth coat returns base (1 - F).
static void smooth_surfaces_have_their_exact_albedo(void **state)
{
    (void)state;
    for (size_t c = 0; c < sizeof cosines / sizeof *cosines; c++) {
        for (int kind = 0; kind < 3; kind++) {
            const struct material m = {"glass", 1, 0, 1, 0, 1.5f, kind == 1, kind == 2};
            assert_within(albedo(&m, cosines[c], 1000, 1).mean - 1, 1e-5);
        }
        const struct material coat = {"coat", 0.5f, 0, 0, 0, 1.5f, 0, 0};
        const double f = exact_fresnel(cosines[c], 1.5);
        const struct estimate e = albedo(&coat, cosines[c], 400000, 1);
        assert_odds(e.mean - (f + 0.5 * (1 - f)), e.error, 1e-5);
    }
}

static void a_lambertian_surface_returns_its_base(void **state)
{
    (void)state;
    const struct material m = {"lambert", 0.7f, 0, 0, 1, 1.0f, 0, 0};
    for (size_t c = 0; c < sizeof cosines / sizeof *cosines; c++) {
        const struct gk_surface s = make_surface(&m, cosines[c]);
        const struct gk_vec wi = direction(0.5, 0.7);
        assert_within(gk_bsdf_eval(&s, direction(cosines[c], 0), wi).f.x - 0.7 * 0.5 / M_PI, 1e-6);
    }
}

// Just above the roughness where lobes become delta the albedo is that of the delta lobes.
static void narrow_lobes_continue_delta_lobes(void **state)
{
    (void)state;
    static const struct material kinds[] = {{"plastic", 0.5f, 0, 0, 0, 1.5f, 0, 0},
                                            {"metal", 0.8f, 1, 0, 0, 1.5f, 0, 0},
                                            {"glass", 1, 0, 1, 0, 1.5f, 0, 0},
                                            {"pane", 1, 0, 1, 0, 1.5f, 1, 0}};
    for (size_t k = 0; k < 4; k++)
        for (int c = 0; c < 3; c++) {
            struct material narrow = kinds[k];
            narrow.roughness = sqrtf(1.001f * GK_ALPHA_DELTA);
            const struct estimate a = albedo(&kinds[k], cosines[c], 400000, 1);
            const struct estimate b = albedo(&narrow, cosines[c], 400000, 1);
            odds_note(__FILE__, __func__, "slack", a.mean - b.mean, hypot(a.error, b.error));
            assert_within(a.mean - b.mean, 1e-3 + ODDS_Z * hypot(a.error, b.error));
        }
}

static double value(const struct material *m, struct gk_vec wo, struct gk_vec wi)
{
    const struct gk_surface s = make_surface(m, wo.z);
    return gk_bsdf_eval(&s, wo, wi).f.x / fabs((double)wi.z);
}

// Relative to the larger, or 16u where both are as small.
static void assert_reciprocal(const struct material *m, double a, double b, double bound)
{
    const double scale = fmax(fabs(a), fabs(b));
    if (!(fabs(a - b) <= bound * scale + 16 * GK_UNIT))
        fail_msg("%s, roughness %g: %.9g against %.9g, %.1f u, over %.1f", m->name,
                 (double)m->roughness, a, b, fabs(a - b) / scale / GK_UNIT, bound / GK_UNIT);
}

static struct gk_vec from_the_other_side(struct gk_vec v)
{
    return gk_vec(v.x, v.y, -v.z);
}

// f(a, b) = f(b, a) to 32u.
static void opaque_reflection_is_reciprocal(void **state)
{
    (void)state;
    static const struct material kinds[] = {
        {"plastic", 0.6f, 0, 0, 0.5f, 1.5f, 0, 0},  {"plastic", 0.6f, 0, 0, 1, 1.5f, 0, 0},
        {"metal", 0.9f, 1, 0, 0.5f, 1.5f, 0, 0},    {"metal", 0.9f, 1, 0, 1, 1.5f, 0, 0},
        {"mixed", 0.6f, 0.5f, 0, 0.4f, 1.5f, 0, 0}, {"lambert", 0.5f, 0, 0, 1, 1, 0, 0},
    };
    uint64_t seed = 31;
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
        for (int i = 0; i < 20000; i++) {
            const struct gk_vec a = random_upper(&seed), b = random_upper(&seed);
            assert_reciprocal(&kinds[k], value(&kinds[k], a, b), value(&kinds[k], b, a),
                              32 * GK_UNIT);
        }
}

// Cosine at the half vector of a pair, in double; eta 1 for one side or a pane.
static double half_cosine(struct gk_vec a, struct gk_vec b, double eta)
{
    const double x = a.x + eta * b.x, y = a.y + eta * b.y, z = a.z + eta * b.z;
    return fabs(a.x * x + a.y * y + a.z * z) / sqrt(x * x + y * y + z * z);
}

// Reflection alone, or transmission alone, of a dielectric carries F or 1 - F, whose relative
// condition is what 8u absolute allow: 32u plus 16u over the factor.
static void panes_are_reciprocal(void **state)
{
    (void)state;
    const struct material pane = {"pane", 0.8f, 0, 1, 0.7f, 1.5f, 1, 0};
    uint64_t seed = 33;
    for (int i = 0; i < 20000; i++) {
        const struct gk_vec a = random_upper(&seed), b = random_upper(&seed);
        const double f = exact_fresnel(half_cosine(a, b, 1), 1.5);
        assert_reciprocal(&pane, value(&pane, a, b), value(&pane, b, a), (32 + 16 / f) * GK_UNIT);
        const struct gk_vec below = from_the_other_side(b), other = from_the_other_side(a);
        assert_reciprocal(&pane, value(&pane, a, below), value(&pane, b, other),
                          (32 + 16 / (1 - f)) * GK_UNIT);
    }
}

// f(a, b) eta^2 = f(b, a), eta that of going from a to b: radiance is squeezed by refraction. The
// half vector a + eta b is as short as eta - 1, which magnifies its rounding; the density of
// normals magnifies a change of slope by 4 / alpha, the square root at the edge of total reflection
// by 16 / T^2, T the transmittance.
static void refraction_is_reciprocal_up_to_eta_squared(void **state)
{
    (void)state;
    static const float indices[] = {1.33f, 1.5f, 2.42f};
    uint64_t seed = 32;
    for (int i = 0; i < 30000; i++) {
        const struct material out = {"glass",        0.8f, 0, 1, 0.5f + 0.5f * (float)(i & 1),
                                     indices[i % 3], 0,    0};
        struct material in = out;
        in.leaving = 1;
        const struct gk_vec a = random_upper(&seed), b = from_the_other_side(random_upper(&seed));
        const double eta = out.ior, t = 1 - exact_fresnel(half_cosine(a, b, eta), eta);
        const double there = value(&out, a, b) * eta * eta;
        const double back = value(&in, from_the_other_side(b), from_the_other_side(a));
        const double magnified = (1 + 4 / pow(out.roughness, 2)) / (eta - 1) + 16 / (t * t);
        assert_reciprocal(&out, there, back, 32 * GK_UNIT * magnified);
    }
}

static struct material random_material(uint64_t *seed)
{
    struct material m = {"random", check_uniform(seed), 0, 0, check_uniform(seed), 1, 0, 0};
    const float pick = check_uniform(seed);
    m.metallic = pick < 0.3f ? 0 : pick < 0.5f ? 1 : check_uniform(seed);
    m.transmission = check_uniform(seed) < 0.5f ? 0 : check_uniform(seed) < 0.5f ? 1 : 0.5f;
    m.roughness = check_uniform(seed) < 0.3f ? 0.04f : m.roughness;
    m.ior = check_uniform(seed) < 0.2f ? 1 : 1 + 2 * check_uniform(seed);
    m.thin = check_uniform(seed) < 0.3f;
    m.leaving = m.transmission > 0 && !m.thin && check_uniform(seed) < 0.5f;
    return m;
}

static float random_grazing(uint64_t *seed)
{
    return powf(10.0f, -8 * check_uniform(seed));
}

static void assert_sound(const struct gk_bsdf_value *v)
{
    assert_true(isfinite(v->f.x) && isfinite(v->f.y) && isfinite(v->f.z) && isfinite(v->pdf));
    assert_true(v->f.x >= 0 && v->f.y >= 0 && v->f.z >= 0 && v->pdf >= 0);
}

// cos 1 .. 1e-8 on either side, every kind of material: finite, not negative, and no sample
// outweighs 1/u.
static void grazing_angles_stay_finite(void **state)
{
    (void)state;
    uint64_t seed = 41;
    struct gk_surface s = {0};
    for (int i = 0; i < 1000000; i++) {
        const float cosine = random_grazing(&seed);
        if (i % 64 == 0) {
            const struct material m = random_material(&seed);
            s = make_surface(&m, cosine);
        }
        const struct gk_vec wo = direction(cosine, check_uniform(&seed));
        gk_surface_prepare(&s, wo);
        struct gk_vec wi = direction(random_grazing(&seed), check_uniform(&seed));
        wi.z *= i & 1 ? -1 : 1;
        struct gk_bsdf_value v = gk_bsdf_eval(&s, wo, wi);
        assert_sound(&v);
        const struct gk_bsdf_sample sample = draw(&s, wo, &seed);
        assert_true(isfinite(sample.wi.x) && isfinite(sample.wi.y) && isfinite(sample.wi.z));
        v = gk_bsdf_eval(&s, wo, sample.wi);
        assert_sound(&v);
        assert_within(sample_weight(&s, wo, &sample), 1 / GK_UNIT);
    }
}

// Samples and their mirror images about the normal, head-on and backwards: where half vectors
// vanish.
static void degenerate_pairs_stay_finite(void **state)
{
    (void)state;
    uint64_t seed = 42;
    for (int i = 0; i < 20000; i++) {
        const struct material m = random_material(&seed);
        const struct gk_vec wo = direction(i & 1 ? 1 : random_grazing(&seed), 0.1);
        const struct gk_surface s = make_surface(&m, wo.z);
        const struct gk_vec wi[] = {wo,
                                    gk_negate(wo),
                                    gk_vec(-wo.x, -wo.y, wo.z),
                                    gk_vec(wo.x, wo.y, -wo.z),
                                    gk_vec(0, 0, 1),
                                    gk_vec(0, 0, -1),
                                    gk_vec(1, 0, 0),
                                    gk_splat(0)};
        for (size_t k = 0; k < sizeof wi / sizeof *wi; k++) {
            const struct gk_bsdf_value v = gk_bsdf_eval(&s, wo, wi[k]);
            assert_sound(&v);
        }
    }
}

// An interface between equal indices is not there, smooth or rough: all goes straight through.
static void matched_indices_are_invisible(void **state)
{
    (void)state;
    uint64_t seed = 51;
    for (size_t r = 0; r < sizeof roughnesses / sizeof *roughnesses; r++)
        for (size_t c = 0; c < sizeof cosines / sizeof *cosines; c++) {
            const struct material m = {"nothing", 1, 0, 1, roughnesses[r], 1, 0, 0};
            const struct gk_surface s = make_surface(&m, cosines[c]);
            const struct gk_vec wo = direction(cosines[c], 0.4);
            for (int i = 0; i < 1000; i++) {
                const struct gk_bsdf_sample sample = draw(&s, wo, &seed);
                assert_within(sample.wi.x + wo.x, 4 * GK_UNIT);
                assert_within(sample.wi.y + wo.y, 4 * GK_UNIT);
                assert_within(sample.wi.z + wo.z, 4 * GK_UNIT);
                assert_within(sample_weight(&s, wo, &sample) - 1, 4 * GK_UNIT);
            }
        }
}

// Opaque surfaces take no light from, and send none, below the horizon.
static void opaque_surfaces_do_not_leak(void **state)
{
    (void)state;
    uint64_t seed = 61;
    for (int i = 0; i < 100000; i++) {
        const struct material m = {"opaque", 1, (float)(i % 3) / 2, 0, check_uniform(&seed), 1.5f,
                                   0,        0};
        const struct gk_vec wo = random_upper(&seed);
        const struct gk_surface s = make_surface(&m, wo.z);
        const struct gk_bsdf_value v =
            gk_bsdf_eval(&s, wo, from_the_other_side(random_upper(&seed)));
        assert_true(v.f.x == 0 && v.f.y == 0 && v.f.z == 0);
        const struct gk_bsdf_sample sample = draw(&s, wo, &seed);
        assert_true(sample.wi.z >= 0 || sample_weight(&s, wo, &sample) == 0);
    }
}

// Where total reflection begins, in steps of u: what is reflected and what passes make one.
static void both_branches_make_one_at_the_edge(void **state)
{
    (void)state;
    static const float iors[] = {1.000001f, 1.1f, 1.5f, 2.42f, 10.0f};
    for (size_t e = 0; e < sizeof iors / sizeof *iors; e++) {
        const struct material glass = {"glass", 1, 0, 1, 0, iors[e], 0, 1};
        const double edge = sqrt(1 - 1 / ((double)iors[e] * iors[e]));
        const struct gk_surface s = make_surface(&glass, (float)edge);
        for (int k = -256; k <= 256; k++) {
            const struct gk_facet m = gk_facet_make(&s, (float)(edge * (1 + k * (double)GK_UNIT)));
            assert_true(m.reflect.x >= 0 && m.refract.x >= 0);
            assert_within((double)m.reflect.x + m.refract.x - 1, 2 * GK_UNIT);
        }
    }
}

// A sample with light but a density of nothing would have to be rejected: there is none.
static void samples_that_carry_light_have_a_density(void **state)
{
    (void)state;
    uint64_t seed = odds_seed(61);
    int drawn = 0;
    struct gk_surface s = {0};
    for (int i = 0; i < 300000; i++) {
        if (i % 12500 == 0) {
            const struct material m = random_material(&seed);
            s = make_surface(&m, 0.7f);
        }
        const struct gk_vec wo = direction(i & 1 ? random_grazing(&seed) : 0.7, 0.2);
        gk_surface_prepare(&s, wo);
        const struct gk_bsdf_sample sample = draw(&s, wo, &seed);
        const struct gk_bsdf_value v = gk_bsdf_eval(&s, wo, sample.wi);
        drawn += !sample.delta;
        if (!sample.delta && gk_max3(v.f) > 0 && !(v.pdf > 1e-30f))
            fail_msg("%g at density %g, alpha %g", v.f.x, v.pdf, s.alpha);
    }
    assert_true(drawn > 100000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_white_furnace_never_brightens),
        cmocka_unit_test(single_scattering_loses_what_is_known),
        cmocka_unit_test(smooth_surfaces_have_their_exact_albedo),
        cmocka_unit_test(a_lambertian_surface_returns_its_base),
        cmocka_unit_test(narrow_lobes_continue_delta_lobes),
        cmocka_unit_test(opaque_reflection_is_reciprocal),
        cmocka_unit_test(panes_are_reciprocal),
        cmocka_unit_test(refraction_is_reciprocal_up_to_eta_squared),
        cmocka_unit_test(grazing_angles_stay_finite),
        cmocka_unit_test(degenerate_pairs_stay_finite),
        cmocka_unit_test(matched_indices_are_invisible),
        cmocka_unit_test(opaque_surfaces_do_not_leak),
        cmocka_unit_test(both_branches_make_one_at_the_edge),
        cmocka_unit_test(samples_that_carry_light_have_a_density),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
