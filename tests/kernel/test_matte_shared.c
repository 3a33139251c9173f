// The slot table under many at a time: nothing is lost uncounted in any order of their steps, and one
// alone gets what the owner's form gives.
#include "kernels/gk_types.h"

#include <stdint.h>

// Every step on shared memory goes through here, so that a test can put another's steps before it.
static uint64_t step(volatile uint64_t *at, uint64_t expected, uint64_t desired);
#define GK_MATTE_CAS step
#include "kernels/gk_matte_shared.h"
#include "tests/kernel/check.h"

#include <pthread.h>
#include <string.h>

enum { SLOTS = 12, FEW = 3, THREADS = 64, UPDATES = 15625 };

#define BOUNCED(matte) gk_matte_of_class(matte, 1u)

static void (*before_step)(void); // NULL: nobody comes in between

static uint64_t step(volatile uint64_t *at, uint64_t expected, uint64_t desired)
{
    void (*other)(void) = before_step;
    if (other) {
        before_step = NULL;
        other();
        before_step = other;
    }
    return gk_matte_cas(at, expected, desired);
}

static uint64_t kept(const volatile uint64_t *table, uint32_t slots)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < slots; i++)
        sum += gk_matte_amount(table[i]);
    return sum;
}

// Returns the units lost, of either kind.
static uint64_t deposit(volatile uint64_t *table, uint32_t slots, uint32_t key, uint32_t direct,
                        uint64_t amount, uint32_t policy, uint32_t random)
{
    struct gk_matte_lost lost = {0, 0};
    gk_matte_deposit_shared(table, 0, slots, key, direct, amount, policy, random, &lost);
    return lost.primary + lost.bounced;
}

static void alone_it_gives_what_the_owners_form_gives(void **state)
{
    (void)state;
    uint64_t seed = 5;
    for (int round = 0; round < 2000; round++) {
        uint64_t owner[SLOTS] = {0}, shared[SLOTS] = {0};
        struct gk_matte_lost lost = {0, 0}, lost_shared = {0, 0};
        for (int i = 0; i < 100; i++) {
            const uint32_t matte = 1 + (uint32_t)(check_random(&seed) >> 40) % 30;
            const uint32_t primary = (uint32_t)(check_random(&seed) >> 63);
            const uint32_t key = primary ? matte : BOUNCED(matte);
            const uint32_t direct = primary | (uint32_t)(check_random(&seed) >> 63);
            const uint64_t amount = check_random(&seed) >> 48;
            const uint32_t random = (uint32_t)check_random(&seed), policy = (uint32_t)round % 5;
            gk_matte_deposit(owner, SLOTS, key, direct, amount, policy, random, &lost);
            gk_matte_deposit_shared(shared, 0, SLOTS, key, direct, amount, policy, random,
                                    &lost_shared);
        }
        assert_memory_equal(owner, shared, sizeof owner);
        assert_memory_equal(&lost, &lost_shared, sizeof lost);
    }
}

// Another's deposits come in before each step, as many as there are numbers left.
static struct {
    uint64_t table[FEW], lost, total, seed;
    uint32_t policy, left;
} between;

static void deposit_one(uint32_t keys)
{
    const uint64_t bits = check_random(&between.seed);
    const uint32_t matte = 1 + (uint32_t)(bits >> 40) % keys, primary = bits & 1;
    const uint64_t amount = 1 + (bits >> 32) % 1000;
    between.total += amount;
    between.lost +=
        deposit(between.table, FEW, primary ? matte : BOUNCED(matte), primary | (bits >> 1 & 1),
                amount, between.policy, (uint32_t)check_random(&between.seed));
}

static void somebody_else(void)
{
    if (between.left > 0 && check_random(&between.seed) >> 62 != 0) {
        between.left--;
        deposit_one(6);
    }
}

static void no_order_of_steps_loses_anything_uncounted(void **state)
{
    (void)state;
    for (uint32_t round = 0; round < 40000; round++) {
        memset(&between, 0, sizeof between);
        between.seed = 1000 + round;
        between.policy = round % 5;
        for (int i = 0; i < 12; i++) {
            between.left = 3;
            before_step = somebody_else;
            deposit_one(6);
            before_step = NULL;
        }
        assert_true(kept(between.table, FEW) + between.lost == between.total);
    }
}

struct crowd {
    uint64_t table[SLOTS];
    uint32_t keys, policy;
    uint64_t lost[THREADS], total[THREADS];
};

struct member {
    struct crowd *crowd;
    int number;
};

static void *deposit_many(void *arg)
{
    const struct member *m = arg;
    struct crowd *c = m->crowd;
    uint64_t seed = 77 + (uint64_t)m->number;
    for (int i = 0; i < UPDATES; i++) {
        const uint64_t bits = check_random(&seed);
        const uint64_t amount = bits % 65537;
        c->total[m->number] += amount;
        c->lost[m->number] +=
            deposit(c->table, SLOTS, BOUNCED(1 + (uint32_t)(bits >> 33) % c->keys), bits >> 62 & 1,
                    amount, c->policy, (uint32_t)check_random(&seed));
    }
    return NULL;
}

static void run_crowd(struct crowd *c, uint64_t *lost, uint64_t *total)
{
    pthread_t thread[THREADS];
    struct member member[THREADS];
    for (int t = 0; t < THREADS; t++) {
        member[t] = (struct member){c, t};
        assert_int_equal(pthread_create(&thread[t], NULL, deposit_many, &member[t]), 0);
    }
    *lost = *total = 0;
    for (int t = 0; t < THREADS; t++) {
        pthread_join(thread[t], NULL);
        *lost += c->lost[t];
        *total += c->total[t];
    }
}

static void a_million_updates_of_three_keys_add_up_without_a_second_slot_for_any(void **state)
{
    (void)state;
    struct crowd c = {.keys = 3, .policy = GK_MATTE_USS_DIRECT_FIRST};
    uint64_t lost, total;
    run_crowd(&c, &lost, &total);
    assert_true(lost == 0 && kept(c.table, SLOTS) == total);
    for (int i = 0; i < SLOTS; i++)
        for (int j = 0; j < i; j++)
            assert_true(!c.table[i] || gk_matte_key(c.table[i]) != gk_matte_key(c.table[j]));
}

static void a_million_updates_of_a_crowd_are_kept_or_lost_under_every_policy(void **state)
{
    (void)state;
    for (uint32_t policy = GK_MATTE_DROP; policy <= GK_MATTE_USS_DIRECT_FIRST; policy++) {
        struct crowd c = {.keys = 40, .policy = policy};
        uint64_t lost, total;
        run_crowd(&c, &lost, &total);
        assert_true(kept(c.table, SLOTS) + lost == total);
        assert_true(policy != GK_MATTE_USS || lost == 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(alone_it_gives_what_the_owners_form_gives),
        cmocka_unit_test(no_order_of_steps_loses_anything_uncounted),
        cmocka_unit_test(a_million_updates_of_three_keys_add_up_without_a_second_slot_for_any),
        cmocka_unit_test(a_million_updates_of_a_crowd_are_kept_or_lost_under_every_policy),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
