// check.h - numbers for tests of kernel functions: errors in ulp, statistics with stated odds.
#ifndef GLINT_TESTS_KERNEL_CHECK_H
#define GLINT_TESTS_KERNEL_CHECK_H

#include "kernels/gk_sampler.h"
#include "tests/odds.h"

#include <float.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#define CHECK_Z ODDS_Z
#define CHECK_Z_ONE_SIDED ODDS_Z_ONE_SIDED

// Fails unless |value| <= bound; NaN fails.
#define assert_within(value, bound)                                             \
    do {                                                                        \
        const double check_value = (value), check_bound = (bound);              \
        if (!(fabs(check_value) <= check_bound))                                \
            fail_msg("%s = %.9g, over %.9g", #value, check_value, check_bound); \
    } while (0)

// Error in units in the last place of `exact`, below FLT_MIN in those of FLT_MIN.
static inline double check_ulp(float y, double exact)
{
    const float f = fabsf((float)exact);
    const float base = f < FLT_MIN ? FLT_MIN : f;
    return fabs(y - exact) / (nextafterf(base, INFINITY) - base);
}

// A generator for inputs that shares nothing with the sampler: xorshift64*, Vigna 2016.
static inline uint64_t check_random(uint64_t *state)
{
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return *state * 0x2545f4914f6cdd1dULL;
}

// [0, 1 - 2^-24], as the sampler's numbers.
static inline float check_uniform(uint64_t *state)
{
    return (float)(check_random(state) >> 40) * 0x1p-24f;
}

// A chi-squared value as a standard normal one (Wilson and Hilferty 1931), good from 10 degrees up.
static inline double check_chi2_z(double chi2, double degrees)
{
    const double v = 2.0 / (9.0 * degrees);
    return (cbrt(chi2 / degrees) - (1.0 - v)) / sqrt(v);
}

// Chi-squared of `count` against n * `probability`, cells pooled in order until 5 are expected.
// Returns the standard normal equivalent.
static inline double check_chi2(const uint32_t *count, const double *probability, size_t cells,
                                double n)
{
    double chi2 = 0, seen = 0, expected = 0, degrees = -1;
    for (size_t i = 0; i < cells; i++) {
        seen += count[i];
        expected += n * probability[i];
        if (expected < 5)
            continue;
        chi2 += (seen - expected) * (seen - expected) / expected;
        degrees++;
        seen = expected = 0;
    }
    if (seen > 0 && expected < 5e-3) // what no cell expects must not occur
        return INFINITY;
    return check_chi2_z(chi2, degrees);
}

// Correlation of a and b.
static inline double check_correlation(const double *a, const double *b, size_t n)
{
    double sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
    for (size_t i = 0; i < n; i++) {
        sa += a[i];
        sb += b[i];
        saa += a[i] * a[i];
        sbb += b[i] * b[i];
        sab += a[i] * b[i];
    }
    const double m = (double)n;
    return (m * sab - sa * sb) / sqrt((m * saa - sa * sa) * (m * sbb - sb * sb));
}

#endif
