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

static struct material kind(const char *name)
{
    size_t k = 0;
    while (strcmp(kinds[k].name, name) != 0)
        k++;
    return kinds[k];
}

struct estimate {
    double mean, error;
};

// Mean and standard error of f |cos| / pdf, as energy: without the factor 1/eta^2 of refracted
// radiance.
static struct estimate albedo(const struct material *m, float cosine, int few)
{
    const int n = (int)odds_samples((uint32_t)few);
    const struct gk_vec wo = direction(cosine, 0.2);
    const struct gk_surface s = make_surface_at(m, wo);
    double sum = 0, square = 0;
    uint64_t seed = odds_seed(77);
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

// With compensation what is white, metal or not, returns all at any roughness: 1 +- 0.01.
// n = 2 10^5.
static void white_opaque_surfaces_return_all(void **state)
{
    (void)state;
    static const char *const white[] = {"plastic", "metal", "dense", "matt plastic",
                                        "mirror of a dielectric"};
    double worst = 0;
    for (size_t k = 0; k < COUNT(white) * COUNT(roughnesses) * COUNT(cosines); k++) {
        struct material m = kind(white[k % COUNT(white)]);
        const float cosine = cosines[k / COUNT(white) % COUNT(cosines)];
        m.roughness = roughnesses[k / COUNT(white) / COUNT(cosines)];
        const struct estimate e = albedo(&m, cosine, 200000);
        odds_note(__FILE__, __func__, "slack", e.mean - 1, e.error);
        worst = fmax(worst, fabs(e.mean - 1) - CHECK_Z * e.error);
        if (!(fabs(e.mean - 1) <= 0.01 + CHECK_Z * e.error))
            fail_msg("%s, roughness %g, cos %g: albedo %.6f +- %.6f", m.name, (double)m.roughness,
                     (double)cosine, e.mean, e.error);
    }
    print_message("# off by %.5f at most, beyond 4.9 standard errors\n", worst);
}

// Clear glass passes or reflects all, from outside, from inside and as a wall, at any roughness and
// collimation: 1 +- 0.01. n = 10^4.
static void clear_glass_returns_all(void **state)
{
    (void)state;
    static const float collimations[] = {1, 0.98f, 0.9f, 0.5f, 0};
    double worst = 0;
    for (size_t k = 0; k < 3 * COUNT(roughnesses) * COUNT(collimations) * COUNT(cosines); k++) {
        const struct layers l = {1, {1, 1, 1}, 0, 0, 0, collimations[k / 3 % COUNT(collimations)]};
        struct material m = {"clear", 1, 0, 1, 0, 1.5f, k % 3 == 1, k % 3 == 2, &l};
        const float cosine = cosines[k / 3 / COUNT(collimations) % COUNT(cosines)];
        m.roughness = roughnesses[k / 3 / COUNT(collimations) / COUNT(cosines)];
        const struct estimate e = albedo(&m, cosine, 10000);
        odds_note(__FILE__, __func__, "slack", e.mean - 1, e.error);
        worst = fmax(worst, fabs(e.mean - 1) - CHECK_Z * e.error);
        if (!(fabs(e.mean - 1) <= 0.01 + CHECK_Z * e.error))
            fail_msg("thin %d, inside %d, roughness %g, collimation %g, cos %g: %.6f +- %.6f",
                     m.thin, m.leaving, (double)m.roughness, (double)l.collimation, (double)cosine,
                     e.mean, e.error);
    }
    print_message("# off by %.5f at most, beyond 4.9 standard errors\n", worst);
}

// The same as albedo() where nothing is left to chance: over a lattice in place of random numbers, to
// 0.003. Source: Roberts 2018 (the lattice of the root of x^4 = x + 1).
static double balance(const struct material *m, float cosine)
{
    const struct gk_vec wo = direction(cosine, 0.2);
    const struct gk_surface s = make_surface_at(m, wo);
    const double g = 1.2207440846057596;
    const int n = 3000;
    double sum = 0;
    for (int i = 0; i < n; i++) {
        const double t = i + 0.5, x = t / g, y = x / g, z = y / g;
        const struct gk_bsdf_sample sample = gk_bsdf_sample(
            &s, wo, (float)(x - floor(x)), (float)(y - floor(y)), (float)(z - floor(z)));
        const double w = sample_weight(&s, wo, &sample);
        sum += sample.wi.z < 0 && !s.thin ? w * s.eta * s.eta : w;
    }
    return sum / n;
}

// However much KHR_materials_specular takes from the reflection of white glass passes it: from
// outside, from inside, where total reflection keeps its share, and as a wall. 1 +- 0.02.
static void glass_passes_what_specular_takes_from_its_reflection(void **state)
{
    (void)state;
    static const float iors[] = {1.33f, 1.5f, 2.4f}, collimations[] = {1, 0.6f};
    static const struct layers kept[] = {{0, {1, 1, 1}, 0, 0, 0, 1},
                                         {0.3f, {1, 1, 1}, 0, 0, 0, 1},
                                         {0.7f, {30, 30, 30}, 0, 0, 0, 1},
                                         {1, {0, 0, 0}, 0, 0, 0, 1}};
    double least = 1, most = 1;
    for (size_t k = 0; k < COUNT(kept) * COUNT(collimations) * COUNT(iors) * 3; k++)
        for (size_t i = 0; i < COUNT(roughnesses) * COUNT(cosines); i++) {
            struct layers l = kept[k % COUNT(kept)];
            l.collimation = collimations[k / COUNT(kept) % COUNT(collimations)];
            const float ior = iors[k / COUNT(kept) / COUNT(collimations) % COUNT(iors)];
            const size_t side = k / COUNT(kept) / COUNT(collimations) / COUNT(iors);
            const struct material m = {
                "glass", 1, 0, 1, roughnesses[i / COUNT(cosines)], ior, side == 2, side == 1, &l};
            const double e = balance(&m, cosines[i % COUNT(cosines)]);
            least = fmin(least, e);
            most = fmax(most, e);
            if (!(fabs(e - 1) <= 0.02))
                fail_msg("index %g, side %zu, specular %g, %g, collimation %g, roughness %g, "
                         "cos %g: %.5f",
                         (double)ior, side, (double)l.specular, (double)l.color[0],
                         (double)l.collimation, (double)m.roughness,
                         (double)cosines[i % COUNT(cosines)], e);
        }
    print_message("# %.5f to %.5f\n", least, most);
}

// No layer gives back more than it gets; 0.005 is what the table may be off. n = 4 10^4.
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
                odds_note(__FILE__, __func__, "bound", e.mean - 1, e.error);
                most = fmax(most, e.mean - 4.9 * e.error);
                if (!(e.mean <= 1 + 4.9 * e.error + 0.005))
                    fail_msg("%s, roughness %g, cos %g: albedo %.6f +- %.6f", m.name,
                             (double)m.roughness, (double)cosines[c], e.mean, e.error);
            }
    print_message("# at most %.5f\n", most);
}

// f over |cos|; the coat's part is over the cosine with its own normal, so only level ones do. What
// gk_pair.h makes up for depends on wo alone, and is left out.
static double value(const struct material *m, struct gk_vec wo, struct gk_vec wi)
{
    struct gk_surface s = make_surface_at(m, wo);
    s.gain = s.raise = gk_splat(1);
    return gk_bsdf_eval(&s, wo, wi).f.x / fabs((double)wi.z);
}

static void assert_reciprocal(const struct material *m, double a, double b, double bound)
{
    const double scale = fmax(fabs(a), fabs(b));
    if (!(fabs(a - b) <= bound * scale + 16 * GK_UNIT))
        fail_msg("%s, roughness %g: %.9g against %.9g, %.1f u, over %.1f", m->name,
                 (double)m->roughness, a, b, fabs(a - b) / scale / GK_UNIT, bound / GK_UNIT);
}

// f(a, b) = f(b, a) to 32u, above the surface. The table's slope is at most 1 / 0.06 in sqrt(cos),
// whose rounding it magnifies where little is left: 1 - E is known to 4u, absolutely.
static void reflection_is_reciprocal(void **state)
{
    (void)state;
    uint64_t seed = 31;
    for (size_t k = 0; k < COUNT(kinds); k++) {
        if (kinds[k].leaving || kinds[k].layers->coat_slope != 0)
            continue;
        for (int i = 0; i < 5000; i++) {
            struct material m = kinds[k];
            m.base = 0.6f;
            m.roughness = i & 1 ? 1 : 0.5f;
            const struct gk_vec a = random_upper(&seed), b = random_upper(&seed);
            assert_reciprocal(&m, value(&m, a, b), value(&m, b, a), 64 * GK_UNIT);
        }
    }
}

static struct gk_vec from_the_other_side(struct gk_vec v)
{
    return gk_vec(v.x, v.y, -v.z);
}

// What is scattered on the way: f(a, b) eta^2 = f(b, a). The cosine in the thinner medium is the
// root of what is left of 1: relative to it, its rounding grows with its inverse square.
static void scattering_is_reciprocal_up_to_eta_squared(void **state)
{
    (void)state;
    uint64_t seed = 32;
    uint32_t met = 0;
    for (int i = 0; i < 20000; i++) {
        const struct material out = {"milk glass", 0.8f, 0, 1, 0.3f, 1.5f, i & 1, 0, &milk};
        struct material in = out;
        in.leaving = !out.thin;
        const struct gk_vec a = random_upper(&seed), b = from_the_other_side(random_upper(&seed));
        const double eta = out.thin ? 1 : 1.5;
        const double there = value(&out, a, b) * eta * eta;
        const double back = value(&in, from_the_other_side(b), from_the_other_side(a));
        const double z2 = 1 - eta * eta * (1 - (double)b.z * b.z);
        met += there > 0;
        if (z2 > 1e-4)
            assert_reciprocal(&out, there, back, 64 * GK_UNIT / z2);
    }
    assert_true(met > 10000);
}

static float random_grazing(uint64_t *seed)
{
    return powf(10.0f, -8 * check_uniform(seed));
}

static struct layers random_layers(uint64_t *seed)
{
    struct layers l = {check_uniform(seed), {0, 1, 1}, check_uniform(seed),
                       check_uniform(seed), 0,         check_uniform(seed)};
    l.color[0] = check_uniform(seed) < 0.2f ? 1e12f : 3 * check_uniform(seed);
    l.coat = check_uniform(seed) < 0.5f ? 0 : check_uniform(seed) < 0.5f ? 1 : l.coat;
    l.coat_roughness *= check_uniform(seed) < 0.3f ? 0.04f : 1;
    l.coat_slope = check_uniform(seed) < 0.5f ? 0 : 4 * check_uniform(seed) - 2;
    return l;
}

static struct material random_material(uint64_t *seed, const struct layers *layers)
{
    struct material m = {"random", check_uniform(seed), 0, 0, check_uniform(seed), 1.5f, 0, 0,
                         layers};
    const float pick = check_uniform(seed);
    m.metallic = pick < 0.3f ? 0 : pick < 0.5f ? 1 : check_uniform(seed);
    m.transmission = check_uniform(seed) < 0.5f ? 0 : check_uniform(seed) < 0.5f ? 1 : 0.5f;
    m.roughness *= check_uniform(seed) < 0.3f ? 0.04f : 1;
    m.ior = check_uniform(seed) < 0.5f ? 1.5f : 1;
    m.thin = check_uniform(seed) < 0.3f;
    m.leaving = m.transmission > 0 && !m.thin && check_uniform(seed) < 0.5f;
    return m;
}

static void assert_sound(const struct gk_bsdf_value *v)
{
    assert_true(isfinite(v->f.x) && isfinite(v->f.y) && isfinite(v->f.z) && isfinite(v->pdf));
    if (!(v->f.x >= 0 && v->f.y >= 0 && v->f.z >= 0 && v->pdf >= 0))
        fail_msg("f %g %g %g, pdf %g", (double)v->f.x, (double)v->f.y, (double)v->f.z,
                 (double)v->pdf);
}

// cos 1 .. 1e-8 on either side, every kind of layer: finite, not negative, and no sample outweighs
// 1/u.
static void grazing_angles_stay_finite(void **state)
{
    (void)state;
    uint64_t seed = 41;
    struct layers layers = plain;
    struct material m = kinds[0];
    for (int i = 0; i < 1000000; i++) {
        if (i % 64 == 0) {
            layers = random_layers(&seed);
            m = random_material(&seed, &layers);
        }
        const struct gk_vec wo = direction(random_grazing(&seed), check_uniform(&seed));
        const struct gk_surface s = make_surface_at(&m, wo);
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

// KHR_materials_specular: min(F0 color, 1) specular head on, specular at grazing angles.
static void specular_sets_both_ends_of_the_curve(void **state)
{
    (void)state;
    static const struct {
        float specular, color;
        double head_on, grazing;
    } known[] = {{1, 1, 0.04, 1}, {0.5f, 1, 0.02, 0.5},    {0, 1, 0, 0}, {1, 10, 0.4, 1},
                 {1, 30, 1, 1},   {0.25f, 30, 0.25, 0.25}, {1, 0, 0, 1}, {0.5f, 5, 0.1, 0.5}};
    for (size_t i = 0; i < COUNT(known); i++) {
        const float c = known[i].color;
        const struct layers l = {known[i].specular, {c, c, c}, 0, 0, 0, 1};
        const struct material m = {"black", 0, 0, 0, 0, 1.5f, 0, 0, &l};
        assert_within(albedo(&m, 1, 100).mean - known[i].head_on, 1e-6);
        assert_within(albedo(&m, 1e-6f, 100).mean - known[i].grazing, 1e-4);
    }
}

// A smooth coat over black reflects as its interface does; over a mirror it takes nothing away.
static void a_smooth_coat_is_its_interface(void **state)
{
    (void)state;
    for (size_t c = 0; c < COUNT(cosines); c++) {
        const struct material black = {"black", 0, 0, 0, 1, 1, 0, 0, &varnish};
        const struct material mirror = {"mirror", 1, 1, 0, 0, 1.5f, 0, 0, &varnish};
        const double f = exact_fresnel(cosines[c], 1.5);
        const struct estimate e = albedo(&black, cosines[c], 1000);
        assert_within(e.mean - f, 1e-5 + CHECK_Z * e.error);
        const struct estimate both = albedo(&mirror, cosines[c], 10000);
        assert_within(both.mean - 1, 1e-5 + CHECK_Z * both.error);
    }
}

// Collimation is of what passes: what is reflected has the same value at 1 and below.
static void collimation_leaves_the_reflection_alone(void **state)
{
    (void)state;
    uint64_t seed = 51;
    for (int i = 0; i < 10000; i++) {
        const struct material sharp = {"glass", 0.9f, 0, 1, 0.4f, 1.5f, i & 1, 0, &plain};
        struct material soft = sharp;
        soft.layers = &milk;
        const struct gk_vec a = random_upper(&seed), b = random_upper(&seed);
        assert_true(value(&sharp, a, b) == value(&soft, a, b));
        assert_true(value(&sharp, a, gk_negate(a)) != value(&soft, a, gk_negate(a)));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(white_opaque_surfaces_return_all),
        cmocka_unit_test(clear_glass_returns_all),
        cmocka_unit_test(glass_passes_what_specular_takes_from_its_reflection),
        cmocka_unit_test(a_white_furnace_never_brightens),
        cmocka_unit_test(reflection_is_reciprocal),
        cmocka_unit_test(scattering_is_reciprocal_up_to_eta_squared),
        cmocka_unit_test(grazing_angles_stay_finite),
        cmocka_unit_test(specular_sets_both_ends_of_the_curve),
        cmocka_unit_test(a_smooth_coat_is_its_interface),
        cmocka_unit_test(collimation_leaves_the_reflection_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
