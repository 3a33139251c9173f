// matte_double.h - the exact twin of a slot table: coverage in double precision, for every key a slot.
#ifndef GLINT_TESTS_MATTE_DOUBLE_H
#define GLINT_TESTS_MATTE_DOUBLE_H

#include "kernels/gk_matte.h"

// `slots` slots, at least as many as there are keys; all zero before the first deposit.
struct matte_double {
    uint32_t key;
    double amount; // samples
};

static inline void matte_double_deposit(struct matte_double *table, uint32_t slots, uint32_t key,
                                        double weight)
{
    uint32_t at = gk_matte_start(key, slots);
    while (table[at].key && table[at].key != key)
        at = at + 1 == slots ? 0 : at + 1;
    table[at].key = key;
    table[at].amount += weight;
}

#endif
