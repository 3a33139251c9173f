// gk_bsdf_sample draws from the density that gk_bsdf_eval states: chi-squared over the sphere in
// 32 x 64 cells of equal solid angle, n = 10^6, and the mass of delta lobes by its binomial.
#include "tests/kernel/surface.h"

enum { ROWS = 32, COLUMNS = 64, CELLS = ROWS * COLUMNS, N = 1000000 };

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

struct view {
    const struct gk_surface *surface;
    struct gk_vec wo;
};

struct box {
    double polar, turn, dpolar, dturn; // angle from the z axis in radians, azimuth of 1
};

// Integral of the pdf over a box, 4 x 4 Gauss points.
static double gauss(const struct view *view, struct box b)
{
    static const double node[4] = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563,
                                   0.8611363115940526};
    static const double weight[4] = {0.3478548451374538, 0.6521451548625461, 0.6521451548625461,
                                     0.3478548451374538};
    double sum = 0;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            const double polar = b.polar + b.dpolar * 0.5 * (1 + node[i]);
            const struct gk_vec wi = direction(cos(polar), b.turn + b.dturn * 0.5 * (1 + node[j]));
            sum +=
                weight[i] * weight[j] * sin(polar) * gk_bsdf_eval(view->surface, view->wo, wi).pdf;
        }
    return sum * 0.25 * b.dpolar * b.dturn * 2 * M_PI;
}

// Halves the box three times at least, lest a narrow lobe slip between the points.
static double integrate(const struct view *view, struct box b, double whole, int depth)
{
    struct box quarter[4];
    double part[4], sum = 0;
    for (int k = 0; k < 4; k++) {
        quarter[k] = (struct box){b.polar + 0.5 * b.dpolar * (k & 1),
                                  b.turn + 0.5 * b.dturn * (k >> 1), 0.5 * b.dpolar, 0.5 * b.dturn};
        sum += part[k] = gauss(view, quarter[k]);
    }
    if (depth == 8 || (depth > 1 && fabs(sum - whole) < 1e-5 * sum + 1e-9))
        return sum;
    double refined = 0;
    for (int k = 0; k < 4; k++)
        refined += integrate(view, quarter[k], part[k], depth + 1);
    return refined;
}

// Probability of each cell; returns their sum.
static double cell_probabilities(const struct view *view, double *probability)
{
    double total = 0;
    for (int c = 0; c < CELLS; c++) {
        const int row = c / COLUMNS;
        const double top = acos(2.0 * row / ROWS - 1), bottom = acos(2.0 * (row + 1) / ROWS - 1);
        const struct box b = {bottom, (double)(c % COLUMNS) / COLUMNS, top - bottom, 1.0 / COLUMNS};
        probability[c] = integrate(view, b, 0, 0);
        total += probability[c];
    }
    return total;
}

// CELLS for a direction that does not transport anything, which the integrator drops.
static int cell_of(const struct view *view, const struct gk_bsdf_sample *sample)
{
    const struct gk_vec wi = sample->wi;
    if (gk_bsdf_eval(view->surface, view->wo, wi).pdf <= 0 || gk_dot(wi, wi) < 0.5f)
        return CELLS;
    const double turn = atan2(wi.y, wi.x) / (2 * M_PI);
    const int column = (int)((turn < 0 ? turn + 1 : turn) * COLUMNS);
    const int row = (int)((wi.z + 1) * 0.5 * ROWS);
    return (row < ROWS ? row : ROWS - 1) * COLUMNS + (column < COLUMNS ? column : 0);
}

static void check_density(const struct material *m, double cosine)
{
    static uint32_t count[CELLS + 1];
    static double probability[CELLS + 1];
    const struct gk_surface s = make_surface(m, (float)cosine);
    const struct view view = {&s, direction(cosine, 0.1)};
    uint64_t seed = 12345;
    memset(count, 0, sizeof count);
    for (int i = 0; i < N; i++) {
        const struct gk_bsdf_sample sample = draw(&s, view.wo, &seed);
        count[cell_of(&view, &sample)]++;
    }
    const double total = cell_probabilities(&view, probability);
    probability[CELLS] = fmax(0, 1 - total); // rejected
    if (total > 1 + 1e-4)
        fail_msg("%s, cos %g: the pdf integrates to %.6f", m->name, cosine, total);
    const double z = check_chi2(count, probability, CELLS + 1, N);
    if (!(z < CHECK_Z_ONE_SIDED))
        fail_msg("%s, cos %g: chi-squared is %.1f sigma off; pdf integrates to %.6f, %.6f drawn",
                 m->name, cosine, z, total, 1 - count[CELLS] / (double)N);
}

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
    uint64_t seed = 99;
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
            assert_within(reflected - n * f, CHECK_Z * sqrt(n * f * (1 - f)) + 1e-3);
        }
}

static void a_smooth_coat_leaves_the_rest_to_the_diffuse_lobe(void **state)
{
    (void)state;
    const struct material coat = {"coat", 0.5f, 0, 0, 0, 1.5f, 0, 0};
    const struct gk_surface s = make_surface(&coat, 0.5f);
    uint64_t seed = 98;
    const double n = 100000;
    double diffuse = 0;
    for (int i = 0; i < n; i++)
        diffuse += !draw(&s, direction(0.5, 0.3), &seed).delta;
    assert_within(diffuse - n * s.p_diffuse, CHECK_Z * sqrt(n * s.p_diffuse * (1 - s.p_diffuse)));
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
