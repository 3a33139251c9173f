// The slot table, and the places of a tile, under two or three work-items in every order of their steps
// there is: a step is one read or one compare and swap. Nothing is lost uncounted, no key that nothing
// evicts has two slots or places, each ends.
#include "kernels/gk_types.h"

#include <stdint.h>

static uint64_t read_step(const volatile uint64_t *at);
static uint64_t swap_step(volatile uint64_t *at, uint64_t expected, uint64_t desired);
#define GK_MATTE_READ(at) read_step(at)
#define GK_MATTE_CAS swap_step
#include "kernels/gk_matte_shared.h"
#include "tests/kernel/check.h"

#include <string.h>
#include <ucontext.h>

enum { ITEMS = 3, STEPS = 256, STACK = 65536, SLOTS = 2, PIXEL = 9 };
#define BOUNCED(matte) gk_matte_of_class(matte, 1u)

// One work-item: the deposits that it brings.
struct item {
    uint32_t key[2], deposits, direct, random;
    uint64_t amount;
};

// One order of steps, and how the next is found.
static struct {
    ucontext_t home, item[ITEMS];
    uint64_t table[SLOTS + GK_MATTE_LOST_WORDS];
    uint64_t
        places[GK_MATTE_SPILL_TILE * GK_MATTE_SPILL_WORDS]; // of a tile of pixels without slots
    const struct item *what;
    struct gk_matte_lost lost[ITEMS];
    bool ended[ITEMS];
    uint32_t items, running, policy;
    uint32_t steps, chosen[STEPS], runnable[STEPS]; // n-th of those that could go on; their number
} world;
static char stack[ITEMS][STACK];

static void give_way(void)
{
    swapcontext(&world.item[world.running], &world.home);
}

static uint64_t read_step(const volatile uint64_t *at)
{
    give_way();
    return *at;
}

static uint64_t swap_step(volatile uint64_t *at, uint64_t expected, uint64_t desired)
{
    give_way();
    const uint64_t found = *at;
    *at = found == expected ? desired : found;
    return found;
}

// Under GK_MATTE_SPILL the slots are full of others, and it is the places that matter.
static void deposit(const struct item *w, uint32_t key, struct gk_matte_lost *lost)
{
    if (world.policy == GK_MATTE_SPILL)
        lost->bounced +=
            gk_matte_spill(world.places, GK_MATTE_SPILL_WORDS, PIXEL, key, w->direct, w->amount);
    else
        gk_matte_deposit_shared(world.table, 0, SLOTS, key, w->direct, w->amount, world.policy,
                                w->random, lost);
}

static void work(void)
{
    const uint32_t me = world.running;
    const struct item *w = &world.what[me];
    for (uint32_t i = 0; i < w->deposits; i++)
        deposit(w, w->key[i], &world.lost[me]);
    world.ended[me] = true;
}

static void start(uint32_t item)
{
    getcontext(&world.item[item]);
    world.item[item].uc_stack.ss_sp = stack[item];
    world.item[item].uc_stack.ss_size = STACK;
    world.item[item].uc_link = &world.home;
    makecontext(&world.item[item], work, 0);
    world.ended[item] = false;
}

static uint32_t pick(uint32_t n)
{
    for (uint32_t i = 0; i < world.items; i++)
        if (!world.ended[i] && n-- == 0)
            return i;
    return world.items;
}

static void run_order(void)
{
    memset(world.table, 0, sizeof world.table);
    memset(world.places, 0, sizeof world.places);
    memset(world.lost, 0, sizeof world.lost);
    for (uint32_t i = 0; i < world.items; i++)
        start(i);
    for (world.steps = 0;; world.steps++) {
        uint32_t runnable = 0;
        for (uint32_t i = 0; i < world.items; i++)
            runnable += !world.ended[i];
        if (!runnable)
            return;
        assert_true(world.steps < STEPS);
        world.runnable[world.steps] = runnable;
        world.running = pick(world.chosen[world.steps]);
        swapcontext(&world.home, &world.item[world.running]);
    }
}

// The next order of steps; false: that was the last.
static bool next_order(void)
{
    uint32_t s = world.steps;
    while (s > 0 && world.chosen[s - 1] + 1 == world.runnable[s - 1])
        s--;
    if (s == 0)
        return false;
    world.chosen[s - 1]++;
    memset(world.chosen + s, 0, (STEPS - s) * sizeof *world.chosen);
    return true;
}

static uint64_t in_places(void)
{
    const uint64_t *place = world.places + PIXEL * GK_MATTE_SPILL_WORDS;
    uint64_t sum = 0;
    for (uint32_t i = 0; i < GK_MATTE_SPILL_WORDS; i++) {
        sum += place[i] & GK_MATTE_SPILL_MOST;
        for (uint32_t k = 0; k < i; k++)
            assert_true(!place[i] || gk_matte_key(place[i]) != gk_matte_key(place[k]));
    }
    return sum;
}

static void judge(uint64_t total, bool crowded)
{
    uint64_t sum = in_places();
    for (uint32_t i = 0; i < SLOTS; i++)
        sum += gk_matte_amount(world.table[i]);
    for (uint32_t i = 0; i < world.items; i++)
        sum += world.lost[i].primary + world.lost[i].bounced;
    assert_true(sum == total);
    assert_true(crowded || gk_matte_key(world.table[0]) != gk_matte_key(world.table[1]));
}

// crowded: with more keys than slots. Returns the number of orders.
static uint32_t every_order(const struct item *what, uint32_t items, uint32_t policy, bool crowded)
{
    uint64_t total = 0;
    uint32_t orders = 0;
    memset(&world, 0, sizeof world);
    world.what = what;
    world.items = items;
    world.policy = policy;
    for (uint32_t i = 0; i < items; i++)
        total += what[i].deposits * what[i].amount;
    do {
        run_order();
        judge(total, crowded);
        orders++;
    } while (next_order());
    return orders;
}

static void two_items_of_two_keys_that_fit(void **state)
{
    (void)state;
    const struct item what[] = {{{BOUNCED(1), BOUNCED(2)}, 2, 0, 0, 5},
                                {{BOUNCED(2), BOUNCED(1)}, 2, 1, 0, 7}};
    const uint32_t orders = every_order(what, 2, GK_MATTE_USS_DIRECT_FIRST, false);
    print_message("# %u orders\n", orders);
    assert_true(orders > 500);
}

static void three_items_of_one_key(void **state)
{
    (void)state;
    const struct item what[] = {{{3}, 1, 1, 0, 5}, {{3}, 1, 1, 0, 7}, {{3}, 1, 1, 0, 11}};
    const uint32_t orders = every_order(what, 3, GK_MATTE_DROP, false);
    print_message("# %u orders\n", orders);
    assert_true(orders > 100);
}

static void two_items_that_crowd_a_table_under_every_policy(void **state)
{
    (void)state;
    const struct item what[] = {{{BOUNCED(1), BOUNCED(2)}, 2, 0, 0x80000000u, 5},
                                {{BOUNCED(3), 4}, 2, 1, 0x20000000u, 7}};
    for (uint32_t policy = GK_MATTE_DROP; policy <= GK_MATTE_USS_DIRECT_FIRST; policy++)
        print_message("# policy %u: %u orders\n", policy, every_order(what, 2, policy, true));
}

static void two_items_that_find_the_slots_full_share_places(void **state)
{
    (void)state;
    const struct item what[] = {{{BOUNCED(1), BOUNCED(2)}, 2, 0, 0, 5},
                                {{BOUNCED(2), BOUNCED(2)}, 2, 1, 0, 7}};
    const uint32_t orders = every_order(what, 2, GK_MATTE_SPILL, true);
    print_message("# %u orders\n", orders);
    assert_true(orders > 500);
}

int main(void)
{
#if defined __SANITIZE_THREAD__
    return 77; // does not follow contexts
#endif
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_items_of_two_keys_that_fit),
        cmocka_unit_test(three_items_of_one_key),
        cmocka_unit_test(two_items_that_crowd_a_table_under_every_policy),
        cmocka_unit_test(two_items_that_find_the_slots_full_share_places),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
