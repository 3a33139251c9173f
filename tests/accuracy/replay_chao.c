// replay_chao.c - a reservoir of deposits in the place of a table of names.
//
// Source: Chao 1982, "A general purpose unequal probability sampling plan": of a stream of weights a
// reservoir of n has each with a probability in proportion to its weight; each place then stands for
// an n-th of the total. What is seen directly has slots of its own, which it takes from the reservoir.
// A name may have several places: for one place each, totals of names would be wanted, which do not
// fit in a table.
#include "tests/accuracy/replay.h"

static uint32_t places_of(const uint64_t *table, uint32_t slots, uint32_t n)
{
    for (uint32_t s = 0; s < slots; s++)
        if (!gk_matte_primary(gk_matte_key(table[s])) && n-- == 0)
            return s;
    return slots;
}

static uint32_t count(const uint64_t *table, uint32_t slots)
{
    uint32_t n = 0;
    for (uint32_t s = 0; s < slots; s++)
        n += !gk_matte_primary(gk_matte_key(table[s]));
    return n;
}

static uint32_t below(uint32_t random, uint32_t n)
{
    return (uint32_t)((uint64_t)gk_mix32(random) * n >> 32);
}

static uint32_t free_slot(const uint64_t *table, uint32_t slots)
{
    uint32_t s = 0;
    while (s < slots && table[s])
        s++;
    return s;
}

static void put_direct(uint64_t *table, uint32_t slots, uint32_t key, uint64_t amount,
                       uint32_t random, struct gk_matte_lost *lost)
{
    uint32_t at = 0;
    while (at < slots && gk_matte_key(table[at]) != key)
        at++;
    at = at < slots ? at : free_slot(table, slots);
    if (at == slots && count(table, slots))
        table[at = places_of(table, slots, below(random, count(table, slots)))] = 0;
    if (at < slots)
        table[at] = gk_matte_pack(key, 1, gk_matte_amount(table[at]) + amount);
    else
        lost->primary += amount;
}

void replay_chao(uint64_t *table, uint64_t *total, uint32_t slots, uint32_t key, uint64_t amount,
                 uint32_t random, struct gk_matte_lost *lost)
{
    if (gk_matte_primary(key)) {
        put_direct(table, slots, key, amount, random, lost);
        return;
    }
    const uint32_t empty = free_slot(table, slots), n = count(table, slots);
    *total += amount;
    if (empty < slots)
        table[empty] = gk_matte_pack(key, 0, 1);
    else if (n && gk_matte_scaled(random, *total) < n * amount)
        table[places_of(table, slots, below(random, n))] = gk_matte_pack(key, 0, 1);
}
