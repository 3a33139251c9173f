// odds.h - statistical tests: seeds, bounds, and what they report.
//
// The change-time suite draws the same numbers in every run, so a test that passes stays passing.
// In the environment, for runs with fresh numbers (tests/stability/nightly):
//   GLINT_TEST_SEED=n     seeds that go through odds_seed() and jobs of offline.h are others
//   GLINT_TEST_SAMPLES=k  odds_samples() and the samples of those jobs are k times as many
//   GLINT_TEST_ODDS=FILE  every z is appended: program, test, what it is of, z, its standard error;
//                         of: normal, chi2 (its upper tail), slack (and what the expectation may be
//                         off), bound (one that the truth stays clear of)
//
// One sub-test fails by chance once in 10^6. It sees a bias of 7.98 standard errors in 99.9% of the
// runs: of d at standard deviation s with n = ((4.892 + 3.09) s/d)^2 samples.
#ifndef GLINT_TESTS_ODDS_H
#define GLINT_TESTS_ODDS_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#define ODDS_Z 4.892 // two-sided, normal
#define ODDS_Z_ONE_SIDED 4.753

static inline uint64_t odds_mixed(uint64_t a, uint64_t b) // splitmix64
{
    uint64_t z = a + 0x9e3779b97f4a7c15u * (b + 1);
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

// A seed, not 0: `fixed`, or a fresh one for it.
static inline uint64_t odds_seed(uint64_t fixed)
{
    static const char *fresh;
    static bool asked; // the environment is searched once: some ask for every sample
    fresh = asked ? fresh : getenv("GLINT_TEST_SEED");
    asked = true;
    return fresh ? odds_mixed(fixed, strtoull(fresh, NULL, 10)) | 1 : fixed;
}

static inline uint32_t odds_samples(uint32_t n)
{
    const char *times = getenv("GLINT_TEST_SAMPLES");
    return times && atoi(times) > 0 ? n * (uint32_t)atoi(times) : n;
}

// Where the z of a test go that was asked for them.
static inline void odds_report(const char *file, const char *test, const char *kind, double z,
                               double error)
{
    const char *path = getenv("GLINT_TEST_ODDS");
    FILE *out = path ? fopen(path, "a") : NULL;
    if (!out)
        return;
    fprintf(out, "%s\t%s\t%s\t%.6g\t%.6g\n", file, test, kind, z, error);
    fclose(out);
}

// Fails unless |difference| < 4.892 error + slack. slack: what the expectation itself may be off;
// with none the differences of many seeds are normal.
#define assert_odds(difference, error, slack) assert_odds_of(__func__, difference, error, slack)

// The same in a function that tests call. test: their name.
#define assert_odds_of(test, difference, error, slack)                                             \
    do {                                                                                           \
        const double odds_d = (difference), odds_e = (error), odds_s = (slack);                    \
        odds_note(__FILE__, test, odds_s > 0 ? "slack" : "normal", odds_d, odds_e);                \
        if (!(fabs(odds_d) <= ODDS_Z * odds_e + odds_s))                                           \
            fail_msg("%s is %.9g, over %.9g + %.3g", #difference, odds_d, ODDS_Z *odds_e, odds_s); \
    } while (0)

// A difference whose own test says more of a failure than its name.
static inline void odds_note(const char *file, const char *test, const char *kind,
                             double difference, double error)
{
    if (error > 0) // what has no spread is no matter of odds
        odds_report(file, test, kind, difference / error, error);
}

// Fails unless z, of one-sided doubt, is below 4.753: too large a chi-squared.
#define assert_odds_chi2(z)                                    \
    do {                                                       \
        const double odds_z = (z);                             \
        odds_report(__FILE__, __func__, "chi2", odds_z, 1.0);  \
        if (!(odds_z < ODDS_Z_ONE_SIDED))                      \
            fail_msg("chi-squared is %.2f sigma off", odds_z); \
    } while (0)

#endif
