// The slot table of one pixel: nothing is lost uncounted, no key is held twice.
#include "kernels/gk_matte.h"
#include "tests/kernel/check.h"
#include "tests/kernel/matte_double.h"

#include <stdlib.h>

enum { SLOTS = 12, MAX_SLOTS = 64 };

// The key of what a bounce has brought.
#define BOUNCED(matte) gk_matte_of_class(matte, 1u)

// Returns the units lost, of either kind.
static uint64_t deposit(gk_u64 *table, gk_u32 slots, gk_u32 key, gk_u32 direct, gk_u64 amount,
                        gk_u32 policy, gk_u32 random)
{
    struct gk_matte_lost lost = {0, 0};
    gk_matte_deposit(table, slots, key, direct, amount, policy, random, &lost);
    return lost.primary + lost.bounced;
}

static uint64_t kept(const gk_u64 *table, gk_u32 slots)
{
    uint64_t sum = 0;
    for (gk_u32 i = 0; i < slots; i++)
        sum += gk_matte_amount(table[i]);
    return sum;
}

static uint64_t amount_of(const gk_u64 *table, gk_u32 slots, gk_u32 key)
{
    uint64_t sum = 0;
    for (gk_u32 i = 0; i < slots; i++)
        if (gk_matte_key(table[i]) == key)
            sum += gk_matte_amount(table[i]);
    return sum;
}

static void assert_distinct(const gk_u64 *table, gk_u32 slots)
{
    for (gk_u32 i = 0; i < slots; i++)
        for (gk_u32 j = 0; j < i; j++)
            assert_true(!gk_matte_key(table[i]) ||
                        gk_matte_key(table[i]) != gk_matte_key(table[j]));
}

static void packing_keeps_every_field(void **state)
{
    (void)state;
    const gk_u64 full = gk_matte_pack(GK_MATTE_MAX_KEY, 1, GK_MATTE_MAX_AMOUNT);
    assert_true(full == UINT64_MAX);
    assert_int_equal(gk_matte_key(full), GK_MATTE_MAX_KEY);
    assert_true(gk_matte_amount(full) == GK_MATTE_MAX_AMOUNT && gk_matte_direct(full) == 1);
    const gk_u64 slot = gk_matte_pack(5, 0, 7);
    assert_int_equal(gk_matte_key(slot), 5);
    assert_true(gk_matte_amount(slot) == 7 && gk_matte_direct(slot) == 0);
}

// The last matte that a scene may have, in the last class.
static void a_class_does_not_run_into_its_matte(void **state)
{
    (void)state;
    const gk_u32 key = gk_matte_of_class(GK_MATTE_BASE_KEY, 15);
    assert_int_equal(key, GK_MATTE_MAX_KEY);
    assert_int_equal(gk_matte_class(key), 15);
    assert_int_equal(key & GK_MATTE_BASE_KEY, GK_MATTE_BASE_KEY);
    assert_int_equal(gk_matte_class(GK_MATTE_BASE_KEY), 0);
}

static void deposits_of_one_key_add_up(void **state)
{
    (void)state;
    gk_u64 table[SLOTS] = {0};
    for (gk_u32 i = 1; i <= 1000; i++)
        assert_true(deposit(table, SLOTS, 42, 1, i, GK_MATTE_DROP, 0) == 0);
    assert_true(amount_of(table, SLOTS, 42) == 1000 * 1001 / 2);
    assert_true(kept(table, SLOTS) == 1000 * 1001 / 2);
}

static void nothing_deposited_takes_no_slot(void **state)
{
    (void)state;
    gk_u64 table[SLOTS] = {0};
    assert_true(deposit(table, SLOTS, 42, 1, 0, GK_MATTE_DROP, 0) == 0);
    for (int i = 0; i < SLOTS; i++)
        assert_true(table[i] == 0);
}

// As many keys as slots are all kept, in any order and for every table size.
static void a_table_holds_as_many_keys_as_it_has_slots(void **state)
{
    (void)state;
    for (gk_u32 slots = 1; slots <= MAX_SLOTS; slots++) {
        gk_u64 table[MAX_SLOTS] = {0};
        for (gk_u32 turn = 0; turn < 3; turn++)
            for (gk_u32 k = 1; k <= slots; k++)
                assert_true(deposit(table, slots, k * 7919, 1, k, GK_MATTE_DROP, 0) == 0);
        for (gk_u32 k = 1; k <= slots; k++)
            assert_true(amount_of(table, slots, k * 7919) == 3 * k);
        assert_distinct(table, slots);
    }
}

// Every matte of the crowd in a class of bounces, or some of them seen first.
static void run_crowd(gk_u32 policy, int some_indirect)
{
    gk_u64 table[SLOTS] = {0};
    uint64_t seed = 7, total = 0, lost = 0;
    for (int i = 0; i < 100000; i++) {
        const gk_u32 matte = 1 + (gk_u32)(check_random(&seed) >> 33) % 10000;
        const gk_u32 key = some_indirect == 2 && matte % 3 == 0 ? matte : BOUNCED(matte);
        const gk_u32 direct = some_indirect ? key & 1 : 1;
        const gk_u64 amount = (check_random(&seed) >> 33) % (GK_MATTE_ONE + 1);
        total += amount;
        lost += deposit(table, SLOTS, key, direct, amount, policy, (gk_u32)check_random(&seed));
    }
    assert_true(kept(table, SLOTS) + lost == total);
    assert_true(policy == GK_MATTE_USS && some_indirect < 2 ? lost == 0 : lost > 0);
    assert_distinct(table, SLOTS);
}

static void kept_and_lost_make_the_total_with_10000_keys_on_a_pixel(void **state)
{
    (void)state;
    for (gk_u32 policy = GK_MATTE_DROP; policy <= GK_MATTE_USS; policy++)
        for (int some = 0; some < 3; some++)
            run_crowd(policy, some);
    run_crowd(GK_MATTE_USS_DIRECT_FIRST, 1);
    run_crowd(GK_MATTE_USS_DIRECT_FIRST, 2);
}

// As many slots as keys: each has all of its own.
static void with_a_slot_for_every_key_10000_of_them_lose_nothing(void **state)
{
    (void)state;
    enum { MATTES = 10000, KEYS = 2 * MATTES };
    gk_u64 *table = calloc(KEYS, sizeof *table), *sum = calloc(KEYS, sizeof *sum);
    struct gk_matte_lost lost = {0, 0};
    uint64_t seed = 11;
    for (int i = 0; i < 200000; i++) {
        const uint64_t bits = check_random(&seed);
        const gk_u32 matte = 1 + (gk_u32)(bits >> 33) % (MATTES - 1), bounced = bits & 1;
        const gk_u64 amount = bits >> 8 & 0xffff;
        gk_matte_deposit(table, KEYS, gk_matte_of_class(matte, bounced), !bounced, amount,
                         GK_MATTE_EXACT, (gk_u32)bits, &lost);
        sum[2 * matte + bounced] += amount;
    }
    assert_true(lost.primary == 0 && lost.bounced == 0);
    for (int i = 0; i < KEYS; i++) {
        const gk_u32 key = gk_matte_key(table[i]);
        gk_u64 *of = &sum[2 * (key & GK_MATTE_BASE_KEY) + gk_matte_class(key)];
        assert_true(gk_matte_amount(table[i]) == *of);
        *of = 0; // it is held once
    }
    for (int i = 0; i < KEYS; i++)
        assert_true(sum[i] == 0);
    free(table);
    free(sum);
}

// What is lost is told apart: of what is seen directly only where nothing else is left to go.
static void what_is_lost_is_of_its_own_kind(void **state)
{
    (void)state;
    gk_u64 table[2] = {0};
    struct gk_matte_lost lost = {0, 0};
    gk_matte_deposit(table, 2, 1, 1, 10, GK_MATTE_DROP, 0, &lost);
    gk_matte_deposit(table, 2, BOUNCED(1), 0, 20, GK_MATTE_DROP, 0, &lost);
    gk_matte_deposit(table, 2, BOUNCED(2), 0, 30, GK_MATTE_DROP, 0, &lost);
    assert_true(lost.primary == 0 && lost.bounced == 30);
    gk_matte_deposit(table, 2, 2, 1, 40, GK_MATTE_DROP, 0, &lost); // in the place of a bounce
    assert_true(lost.primary == 0 && lost.bounced == 50);
    gk_matte_deposit(table, 2, 3, 1, 60, GK_MATTE_DROP, 0, &lost);
    assert_true(lost.primary == 60 && lost.bounced == 50);
    assert_true(kept(table, 2) == 50);
}

// Sums are integers: what a table holds does not depend on the order while nothing is lost.
static void order_does_not_matter_while_keys_fit(void **state)
{
    (void)state;
    uint64_t seed = 3;
    for (int round = 0; round < 200; round++) {
        gk_u64 forward[SLOTS] = {0}, backward[SLOTS] = {0};
        gk_u32 key[500];
        for (int i = 0; i < 500; i++)
            key[i] = 1 + (gk_u32)(check_random(&seed) >> 40) % SLOTS;
        for (int i = 0; i < 500; i++) {
            deposit(forward, SLOTS, key[i], 1, (gk_u64)key[i] + 3, GK_MATTE_DROP, 0);
            deposit(backward, SLOTS, key[499 - i], 1, (gk_u64)key[499 - i] + 3, GK_MATTE_DROP, 0);
        }
        for (gk_u32 k = 1; k <= SLOTS; k++)
            assert_true(amount_of(forward, SLOTS, k) == amount_of(backward, SLOTS, k));
    }
}

static void fill(gk_u64 *table, gk_u32 first_key, gk_u32 count, gk_u32 direct)
{
    for (gk_u32 i = 0; i < count; i++)
        deposit(table, SLOTS, BOUNCED(first_key + i), direct, 100 + i, GK_MATTE_DROP, 0);
}

static void a_direct_newcomer_takes_the_smallest_indirect_slot(void **state)
{
    (void)state;
    gk_u64 table[SLOTS] = {0};
    fill(table, 1, SLOTS, 0); // amounts 100..111
    assert_true(deposit(table, SLOTS, BOUNCED(500), 1, 9, GK_MATTE_DIRECT_FIRST, 0) == 100);
    assert_true(amount_of(table, SLOTS, BOUNCED(500)) == 9 &&
                amount_of(table, SLOTS, BOUNCED(1)) == 0);
    assert_true(amount_of(table, SLOTS, BOUNCED(2)) == 101);
}

static void a_direct_key_is_never_evicted(void **state)
{
    (void)state;
    gk_u64 table[SLOTS] = {0};
    fill(table, 1, SLOTS, 1);
    assert_true(deposit(table, SLOTS, BOUNCED(500), 0, 9999, GK_MATTE_DIRECT_FIRST, 0) == 9999);
    assert_true(deposit(table, SLOTS, BOUNCED(501), 1, 9999, GK_MATTE_DIRECT_FIRST, 0) == 9999);
    for (gk_u32 i = 0; i < SLOTS; i++)
        assert_true(amount_of(table, SLOTS, BOUNCED(1 + i)) == 100 + i);
}

// A key once seen directly stays direct, whatever reaches it later.
static void a_key_becomes_direct_and_stays_so(void **state)
{
    (void)state;
    gk_u64 table[SLOTS] = {0};
    fill(table, 1, SLOTS, 0);
    deposit(table, SLOTS, BOUNCED(1), 1, 1, GK_MATTE_DIRECT_FIRST, 0);
    deposit(table, SLOTS, BOUNCED(1), 0, 1, GK_MATTE_DIRECT_FIRST, 0);
    assert_true(deposit(table, SLOTS, BOUNCED(500), 1, 9, GK_MATTE_DIRECT_FIRST, 0) ==
                101);                                    // key 2's
    for (gk_u32 key = 501; key < 500 + SLOTS - 1; key++) // they take all that are not direct
        deposit(table, SLOTS, BOUNCED(key), 1, 200, GK_MATTE_DIRECT_FIRST, 0);
    assert_true(amount_of(table, SLOTS, BOUNCED(1)) == 102);
}

static void no_indirect_key_outlives_a_dropped_direct_one(void **state)
{
    (void)state;
    uint64_t seed = 11;
    for (int round = 0; round < 2000; round++) {
        gk_u64 table[SLOTS] = {0};
        int dropped = 0;
        for (int i = 0; i < 60; i++) {
            const gk_u32 key = BOUNCED(1 + (gk_u32)(check_random(&seed) >> 40) % 40);
            const gk_u32 direct = (gk_u32)(check_random(&seed) >> 63);
            const uint64_t before = kept(table, SLOTS);
            deposit(table, SLOTS, key, direct, 5, GK_MATTE_DIRECT_FIRST, 0);
            dropped |= direct && kept(table, SLOTS) == before && !amount_of(table, SLOTS, key);
            for (int k = 0; dropped && k < SLOTS; k++)
                assert_true(gk_matte_direct(table[k]));
        }
    }
}

static void dropping_never_evicts(void **state)
{
    (void)state;
    gk_u64 table[SLOTS] = {0};
    fill(table, 1, SLOTS, 0);
    assert_true(deposit(table, SLOTS, BOUNCED(500), 1, 9, GK_MATTE_DROP, 0) == 9);
    assert_true(deposit(table, SLOTS, BOUNCED(3), 1, 9, GK_MATTE_DROP, 0) == 0);
}

// What is seen directly, of class 0, is as it would be without any bounce.
static void bounces_change_nothing_of_what_is_seen_directly(void **state)
{
    (void)state;
    uint64_t seed = 21;
    for (int round = 0; round < 4000; round++) {
        gk_u64 alone[SLOTS] = {0}, mixed[SLOTS] = {0};
        for (int i = 0; i < 80; i++) {
            const gk_u32 matte = 1 + (gk_u32)(check_random(&seed) >> 40) % (round % 2 ? 11 : 20);
            const gk_u32 primary = check_random(&seed) >> 63;
            const gk_u32 direct = primary | (gk_u32)(check_random(&seed) >> 63);
            const gk_u32 random = (gk_u32)check_random(&seed);
            deposit(mixed, SLOTS, primary ? matte : BOUNCED(matte), direct, 7,
                    (gk_u32)round / 2 % 4, random);
            if (primary)
                deposit(alone, SLOTS, matte, 1, 7, GK_MATTE_DROP, random);
        }
        for (gk_u32 matte = 1; matte <= 20; matte++)
            assert_true(amount_of(mixed, SLOTS, matte) == amount_of(alone, SLOTS, matte));
    }
}

static void a_direct_newcomer_hands_what_it_evicts_to_the_next(void **state)
{
    (void)state;
    gk_u64 table[SLOTS] = {0};
    fill(table, 1, SLOTS, 0); // amounts 100..111
    assert_true(deposit(table, SLOTS, BOUNCED(500), 1, 9, GK_MATTE_USS_DIRECT_FIRST, UINT32_MAX) ==
                0);
    assert_true(amount_of(table, SLOTS, BOUNCED(500)) == 9);
    assert_true(amount_of(table, SLOTS, BOUNCED(2)) == 201); // the draw was against key 1
    assert_true(deposit(table, SLOTS, BOUNCED(501), 1, 9, GK_MATTE_USS_DIRECT_FIRST, 0) == 0);
    assert_true(amount_of(table, SLOTS, BOUNCED(3)) == 102 + 103); // and for it
    assert_true(amount_of(table, SLOTS, BOUNCED(4)) == 0);
}

static void the_last_indirect_slot_goes_without_an_heir(void **state)
{
    (void)state;
    gk_u64 table[SLOTS] = {0};
    fill(table, 1, SLOTS - 1, 1);
    fill(table, 100, 1, 0);
    assert_true(deposit(table, SLOTS, BOUNCED(500), 1, 9, GK_MATTE_USS_DIRECT_FIRST, 0) == 100);
    assert_true(deposit(table, SLOTS, BOUNCED(501), 0, 5, GK_MATTE_USS_DIRECT_FIRST, 0) == 5);
    assert_true(deposit(table, SLOTS, BOUNCED(502), 1, 5, GK_MATTE_USS_DIRECT_FIRST, 0) == 0);
    assert_true(kept(table, SLOTS) == 9 + 5 + 11 * 100 + 55);
}

// Over all draws: 4096 of them, evenly spread, are won by the share that the newcomer's amount has of
// both.
static void a_newcomer_wins_by_the_odds_of_his_part(void **state)
{
    (void)state;
    static const gk_u64 amount[][2] = {
        {1, 1}, {3, 1}, {1, 3}, {65536, 65536}, {7u * 65536u, 65536}, {1ull << 39, 1ull << 39}};
    for (size_t i = 0; i < sizeof amount / sizeof *amount; i++) {
        const gk_u64 held = amount[i][0], more = amount[i][1];
        gk_u64 won = 0;
        for (gk_u32 draw = 0; draw < 4096; draw++) {
            gk_u64 slot = gk_matte_pack(BOUNCED(1), 0, held);
            gk_matte_join(&slot, BOUNCED(2), 0, more, draw << 20);
            won += gk_matte_key(slot) == BOUNCED(2);
        }
        assert_int_equal(won, 4096 * more / (held + more));
    }
}

enum { CROWD = 40, ROUNDS = 400, TAKES = 600 };

// 40 mattes with shares 1/rank over 12 slots: the sum of any ten is right on average.
static void mattes_are_unbiased(gk_u32 policy)
{
    double share[CROWD], all = 0.0;
    for (int k = 0; k < CROWD; k++)
        all += share[k] = 1.0 / (k + 1);
    double sum[4] = {0}, square[4] = {0};
    uint64_t seed = odds_seed(99 + policy);
    for (int round = 0; round < ROUNDS; round++) {
        gk_u64 table[SLOTS] = {0};
        for (int i = 0; i < TAKES; i++) {
            double u = check_uniform(&seed) * all;
            gk_u32 k = 0;
            while (k < CROWD - 1 && (u -= share[k]) > 0.0)
                k++;
            deposit(table, SLOTS, BOUNCED(1 + k), 0, 1000, policy, (gk_u32)check_random(&seed));
        }
        assert_true(kept(table, SLOTS) == 1000u * TAKES);
        for (int part = 0; part < 4; part++) {
            double x = 0.0;
            for (gk_u32 k = 0; k < 10; k++)
                x += (double)amount_of(table, SLOTS, BOUNCED(1 + 10 * part + k));
            sum[part] += x;
            square[part] += x * x;
        }
    }
    for (int part = 0; part < 4; part++) {
        double want = 0.0;
        for (int k = 0; k < 10; k++)
            want += 1000.0 * TAKES * share[10 * part + k] / all;
        const double mean = sum[part] / ROUNDS;
        const double sd = sqrt((square[part] / ROUNDS - mean * mean) / (ROUNDS - 1));
        assert_odds_of("unbiased_space_saving_is_unbiased", mean - want, sd, 0);
    }
}

static void unbiased_space_saving_is_unbiased(void **state)
{
    (void)state;
    mattes_are_unbiased(GK_MATTE_USS);
    mattes_are_unbiased(GK_MATTE_USS_DIRECT_FIRST);
}

// Each deposit is rounded to nearest, so that n of them are off by n 2^-17 at most; n errors that are
// uniform have a deviation of sqrt(n/12) 2^-16. n = 11 111 for each key, s = 2^-16/sqrt(12): a bias
// of d = 0.076 s shows with 99.9 %.
static void fixed_point_is_double_precision_to_2_to_the_minus_17_a_deposit(void **state)
{
    (void)state;
    enum { KEYS = 9, DEPOSITS = 100000 };
    gk_u64 table[SLOTS] = {0};
    struct matte_double exact[SLOTS] = {{0}};
    uint32_t count[KEYS + 1] = {0};
    uint64_t seed = 77;
    for (int i = 0; i < DEPOSITS; i++) {
        const gk_u32 key = 1 + (gk_u32)(check_random(&seed) >> 32) % KEYS;
        const float weight = check_uniform(&seed);
        count[key]++;
        matte_double_deposit(exact, SLOTS, key, weight);
        assert_true(deposit(table, SLOTS, key, 0, gk_matte_units(weight), GK_MATTE_USS,
                            (gk_u32)check_random(&seed)) == 0);
    }
    for (int s = 0; s < SLOTS; s++) {
        if (!exact[s].key)
            continue;
        const double n = count[exact[s].key];
        const double fixed = (double)amount_of(table, SLOTS, exact[s].key) / GK_MATTE_ONE;
        assert_within(fixed - exact[s].amount, n * 0x1p-17);
        assert_within(fixed - exact[s].amount, CHECK_Z * sqrt(n / 12) * 0x1p-16);
    }
}

static void a_full_counter_saturates_and_counts_the_rest(void **state)
{
    (void)state;
    gk_u64 table[SLOTS] = {0};
    const gk_u64 nearly = GK_MATTE_MAX_AMOUNT - 10;
    assert_true(deposit(table, SLOTS, 1, 1, nearly, GK_MATTE_DROP, 0) == 0);
    assert_true(deposit(table, SLOTS, 1, 1, 10, GK_MATTE_DROP, 0) == 0);
    assert_true(deposit(table, SLOTS, 1, 1, 10, GK_MATTE_DROP, 0) == 10);
    assert_true(deposit(table, SLOTS, 2, 1, GK_MATTE_MAX_AMOUNT + 4, GK_MATTE_DROP, 0) == 4);
    assert_true(kept(table, SLOTS) == 2 * GK_MATTE_MAX_AMOUNT);
    assert_int_equal(gk_matte_key(table[gk_matte_start(1, SLOTS)]), 1); // fields did not overflow
}

// Start slots of the first 12 000 keys: chi-squared with 11 degrees.
static void start_slots_are_spread(void **state)
{
    (void)state;
    uint32_t count[SLOTS] = {0};
    double probability[SLOTS];
    for (gk_u32 key = 1; key <= 12000; key++) {
        const gk_u32 at = gk_matte_start(key, SLOTS);
        assert_true(at < SLOTS);
        count[at]++;
    }
    for (int i = 0; i < SLOTS; i++)
        probability[i] = 1.0 / SLOTS;
    assert_true(check_chi2(count, probability, SLOTS, 12000) < ODDS_Z_ONE_SIDED);
    for (gk_u32 slots = 1; slots <= MAX_SLOTS; slots++)
        assert_true(gk_matte_start(GK_MATTE_MAX_KEY, slots) < slots);
}

static void weights_become_units(void **state)
{
    (void)state;
    assert_int_equal(gk_matte_units(1.0f), GK_MATTE_ONE);
    assert_int_equal(gk_matte_units(0.25f), GK_MATTE_ONE / 4);
    assert_int_equal(gk_matte_units(0x1p-16f), 1);
    assert_int_equal(gk_matte_units(0.4f * 0x1p-16f), 0);
    assert_int_equal(gk_matte_units(7.0f), GK_MATTE_ONE);
    assert_int_equal(gk_matte_units(INFINITY), GK_MATTE_ONE);
    assert_int_equal(gk_matte_units(-1.0f), 0);
    assert_int_equal(gk_matte_units(-0.0f), 0);
    assert_int_equal(gk_matte_units(NAN), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(packing_keeps_every_field),
        cmocka_unit_test(a_class_does_not_run_into_its_matte),
        cmocka_unit_test(deposits_of_one_key_add_up),
        cmocka_unit_test(nothing_deposited_takes_no_slot),
        cmocka_unit_test(a_table_holds_as_many_keys_as_it_has_slots),
        cmocka_unit_test(kept_and_lost_make_the_total_with_10000_keys_on_a_pixel),
        cmocka_unit_test(with_a_slot_for_every_key_10000_of_them_lose_nothing),
        cmocka_unit_test(what_is_lost_is_of_its_own_kind),
        cmocka_unit_test(order_does_not_matter_while_keys_fit),
        cmocka_unit_test(a_direct_newcomer_takes_the_smallest_indirect_slot),
        cmocka_unit_test(a_direct_key_is_never_evicted),
        cmocka_unit_test(a_key_becomes_direct_and_stays_so),
        cmocka_unit_test(no_indirect_key_outlives_a_dropped_direct_one),
        cmocka_unit_test(dropping_never_evicts),
        cmocka_unit_test(bounces_change_nothing_of_what_is_seen_directly),
        cmocka_unit_test(a_direct_newcomer_hands_what_it_evicts_to_the_next),
        cmocka_unit_test(the_last_indirect_slot_goes_without_an_heir),
        cmocka_unit_test(a_newcomer_wins_by_the_odds_of_his_part),
        cmocka_unit_test(unbiased_space_saving_is_unbiased),
        cmocka_unit_test(fixed_point_is_double_precision_to_2_to_the_minus_17_a_deposit),
        cmocka_unit_test(a_full_counter_saturates_and_counts_the_rest),
        cmocka_unit_test(start_slots_are_spread),
        cmocka_unit_test(weights_become_units),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
