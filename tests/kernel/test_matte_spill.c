// The places that the pixels of a tile have together: while there are any, mattes are exact.
#include "kernels/gk_matte_spill.h"
#include "tests/kernel/check.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { SLOTS = 4, WORDS = SLOTS + GK_MATTE_LOST_WORDS + GK_MATTE_SPILL_WORDS, TILE = 256 };
enum { KEYS = 200, THREADS = 16, UPDATES = 20000 };

struct tile {
    uint64_t table[TILE * WORDS];
    uint64_t given[TILE][KEYS], all; // truth, and the sum of it
    struct gk_matte_lost lost;
};

static void deposit(struct tile *t, uint32_t pixel, uint32_t key, uint64_t amount, uint32_t random)
{
    gk_matte_deposit_tile(t->table, pixel, SLOTS, key, key % 2, amount, GK_MATTE_SPILL, random,
                          &t->lost);
    t->given[pixel][gk_matte_class(key) * KEYS / 2 + (key & GK_MATTE_BASE_KEY)] += amount;
    t->all += amount;
}

// Units that the pixel has of a key, in slots and places; *holders: how many of these there are.
static uint64_t held(const struct tile *t, uint32_t pixel, uint32_t key, uint32_t *holders)
{
    uint64_t sum = 0;
    *holders = 0;
    for (uint32_t s = 0; s < SLOTS; s++)
        if (gk_matte_key(t->table[pixel * WORDS + s]) == key) {
            sum += gk_matte_amount(t->table[pixel * WORDS + s]);
            ++*holders;
        }
    for (uint32_t n = 0; n < GK_MATTE_SPILL_PLACES; n++) {
        const uint64_t place = t->table[gk_matte_spill_at(WORDS, pixel, n)];
        if (place && gk_matte_spilled(place, pixel, key)) {
            sum += gk_matte_amount(gk_matte_spill_slot(place));
            ++*holders;
        }
    }
    return sum;
}

static uint64_t kept(const struct tile *t)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < TILE; i++)
        for (size_t w = 0; w < WORDS; w++) {
            const uint64_t word = t->table[i * WORDS + w];
            if (w < SLOTS)
                sum += gk_matte_amount(word);
            else if (w >= SLOTS + GK_MATTE_LOST_WORDS)
                sum += word & GK_MATTE_SPILL_MOST;
        }
    return sum;
}

static struct tile *new_tile(void)
{
    struct tile *t = calloc(1, sizeof *t);
    assert_non_null(t);
    return t;
}

// A key of either class below KEYS / 2, of `keys` of them.
static uint32_t any_key(uint64_t bits, uint32_t keys)
{
    return gk_matte_of_class(1 + (uint32_t)(bits >> 8) % keys, bits & 1);
}

static void while_there_are_places_every_matte_is_exact(void **state)
{
    (void)state;
    struct tile *t = new_tile();
    uint64_t seed = 3;
    for (int i = 0; i < 100000; i++) { // of at most 12 keys a pixel has 4 in slots, 8 in places
        const uint64_t bits = check_random(&seed);
        deposit(t, (uint32_t)(bits >> 40) % TILE, any_key(bits, 6), bits >> 48, 0);
    }
    assert_true(t->lost.primary == 0 && t->lost.bounced == 0);
    for (uint32_t pixel = 0; pixel < TILE; pixel++)
        for (uint32_t k = 1; k <= 6; k++)
            for (uint32_t c = 0; c < 2; c++) {
                uint32_t holders;
                const uint64_t truth = t->given[pixel][c * KEYS / 2 + k];
                assert_true(held(t, pixel, gk_matte_of_class(k, c), &holders) == truth);
                assert_int_equal(holders, truth > 0);
            }
    free(t);
}

static void a_crowded_pixel_uses_places_of_its_neighbours(void **state)
{
    (void)state;
    struct tile *t = new_tile();
    uint32_t holders;
    for (uint32_t k = 1; k < 60; k++)
        deposit(t, 255, gk_matte_of_class(k, 1), 65536,
                0); // the pixel behind the last is the first
    for (uint32_t k = 1; k < 60; k++)
        assert_true(held(t, 255, gk_matte_of_class(k, 1), &holders) == 65536);
    assert_true(t->table[WORDS - 1] != 0 && t->lost.bounced == 0);
    free(t);
}

static void without_places_kept_and_lost_make_the_total(void **state)
{
    (void)state;
    struct tile *t = new_tile();
    uint64_t seed = 4;
    for (int i = 0; i < 200000; i++) {
        const uint64_t bits = check_random(&seed);
        deposit(t, (uint32_t)(bits >> 40) % TILE, any_key(bits, KEYS / 2 - 1), bits >> 48,
                (uint32_t)check_random(&seed));
    }
    assert_true(kept(t) + t->lost.primary + t->lost.bounced == t->all);
    assert_true(t->lost.primary > 0);
    free(t);
}

static void what_a_place_cannot_hold_goes_to_another(void **state)
{
    (void)state;
    struct tile *t = new_tile();
    uint32_t holders;
    for (uint32_t k = 1; k <= SLOTS + 1; k++)
        for (int i = 0; i < 3; i++)
            deposit(t, 9, k, 3000000000u, 0);
    assert_true(held(t, 9, SLOTS + 1, &holders) == 9000000000u);
    assert_int_equal(holders, 3);
    free(t);
}

struct member {
    struct tile *tile;
    uint64_t total, rest, seed;
};

static void *spill_many(void *arg)
{
    struct member *m = arg;
    for (int i = 0; i < UPDATES; i++) {
        const uint64_t bits = check_random(&m->seed);
        const uint32_t pixel = 5 + (uint32_t)(bits >> 40) % 3;
        const uint64_t amount = 1 + (bits >> 48);
        m->total += amount;
        m->rest +=
            gk_matte_spill(m->tile->table, WORDS, pixel, any_key(bits, 60), bits >> 62 & 1, amount);
    }
    return NULL;
}

static void pixels_that_share_places_at_a_time_lose_nothing_uncounted(void **state)
{
    (void)state;
    struct tile *t = new_tile();
    struct member m[THREADS];
    pthread_t thread[THREADS];
    uint64_t total = 0, rest = 0;
    for (int i = 0; i < THREADS; i++) {
        m[i] = (struct member){t, 0, 0, 900 + (uint64_t)i};
        assert_int_equal(pthread_create(&thread[i], NULL, spill_many, &m[i]), 0);
    }
    for (int i = 0; i < THREADS; i++) {
        pthread_join(thread[i], NULL);
        total += m[i].total;
        rest += m[i].rest;
    }
    assert_true(kept(t) + rest == total && rest > 0); // 360 keys for 340 places
    for (uint32_t pixel = 5; pixel < 8; pixel++)
        for (uint32_t k = 0; k < 120; k++) {
            uint32_t holders;
            held(t, pixel, gk_matte_of_class(1 + k / 2, k % 2), &holders);
            assert_true(holders <= 1);
        }
    free(t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(while_there_are_places_every_matte_is_exact),
        cmocka_unit_test(a_crowded_pixel_uses_places_of_its_neighbours),
        cmocka_unit_test(without_places_kept_and_lost_make_the_total),
        cmocka_unit_test(what_a_place_cannot_hold_goes_to_another),
        cmocka_unit_test(pixels_that_share_places_at_a_time_lose_nothing_uncounted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
