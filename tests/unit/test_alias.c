// Alias tables: the probability of each entry, added up over the slots that lead to it.
#include "scene/alias.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>

enum { MOST = 100 };

// What a table of n makes of `weight`, against its shares; `bound`: of the difference, relative to
// 1/n.
static void assert_chooses_by_weight(const double *weight, uint32_t n, double bound)
{
    float keep[MOST];
    uint32_t other[MOST];
    double probability[MOST] = {0}, total = 0;
    assert_true(glint_alias_build(weight, n, keep, other, 1));
    for (uint32_t i = 0; i < n; i++) {
        assert_true(keep[i] >= 0 && keep[i] <= 1 && other[i] < n);
        probability[i] += keep[i];
        probability[other[i]] += 1.0 - (double)keep[i];
        total += weight[i];
    }
    for (uint32_t i = 0; i < n; i++)
        assert_true(fabs(probability[i] - weight[i] / total * n) <= bound * n);
}

static void entries_have_their_shares(void **state)
{
    (void)state;
    double weight[MOST];
    for (uint32_t n = 1; n <= MOST; n++) {
        for (uint32_t i = 0; i < n; i++)
            weight[i] = (double)(i * 7919 % 101) + (i % 5 == 0 ? 1000 : 0.5);
        assert_chooses_by_weight(weight, n, 0x1p-22);
    }
}

static void one_entry_may_have_nearly_everything(void **state)
{
    (void)state;
    double weight[MOST] = {0};
    weight[17] = 1;
    assert_chooses_by_weight(weight, MOST, 0x1p-22);
    for (int i = 0; i < MOST; i++)
        weight[i] = ldexp(1.0, i - 90);
    assert_chooses_by_weight(weight, MOST, 0x1p-22);
}

static void rounding_tells_the_probabilities_that_come_of_it(void **state)
{
    (void)state;
    const double weight[] = {1, 2, 3, 5, 0.001};
    float keep[5];
    uint32_t other[5];
    double probability[5], total = 0;
    assert_true(glint_alias_build(weight, 5, keep, other, 1));
    glint_alias_round(keep, other, 5, 1, probability);
    for (int i = 0; i < 5; i++) {
        assert_true(fabs(probability[i] - weight[i] / 11.001) <= 0x1p-22);
        assert_true(keep[i] * 0x1p24f == floorf(keep[i] * 0x1p24f));
        total += probability[i];
    }
    assert_true(fabs(total - 1.0) <= 0x1p-50);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(entries_have_their_shares),
        cmocka_unit_test(one_entry_may_have_nearly_everything),
        cmocka_unit_test(rounding_tells_the_probabilities_that_come_of_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
