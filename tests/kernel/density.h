// density.h - chi-squared of gk_bsdf_sample against the density that gk_bsdf_eval states, over the
// sphere in 32 x 64 cells of equal solid angle, n = 10^6.
#ifndef GLINT_TESTS_KERNEL_DENSITY_H
#define GLINT_TESTS_KERNEL_DENSITY_H

#include "tests/kernel/surface.h"

enum { ROWS = 32, COLUMNS = 64, CELLS = ROWS * COLUMNS, N = 1000000 };

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
    if (sample->delta || gk_bsdf_eval(view->surface, view->wo, wi).pdf <= 0 ||
        gk_dot(wi, wi) < 0.5f)
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
    const struct gk_vec wo = direction(cosine, 0.1);
    const struct gk_surface s = make_surface_at(m, wo);
    const struct view view = {&s, wo};
    uint64_t seed = odds_seed(12345);
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
    odds_report(__FILE__, "samples_follow_their_density", "chi2", z, 1);
    if (!(z < CHECK_Z_ONE_SIDED))
        fail_msg("%s, cos %g: chi-squared is %.1f sigma off; pdf integrates to %.6f, %.6f drawn",
                 m->name, cosine, z, total, 1 - count[CELLS] / (double)N);
}

#endif
