// Sums of a film: exact, and so the same in any order and however they are split.
#include "kernels/gk_film.h"
#include "tests/kernel/check.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { ADDENDS = 400, PARTS = 3 };

// A three-plane sum of one pixel; index 0 of each plane is used.
struct sum {
    float word[GK_SUM_PLANES * GK_TILE_PIXELS];
};

static void words_of(const struct sum *s, float out[3])
{
    for (int k = 0; k < GK_SUM_PLANES; k++)
        out[k] = s->word[k * GK_TILE_PIXELS];
}

static void assert_same_words(const struct sum *a, const struct sum *b)
{
    float x[3], y[3];
    words_of(a, x);
    words_of(b, y);
    if (memcmp(x, y, sizeof x))
        fail_msg("%a %a %a and %a %a %a", x[0], x[1], x[2], y[0], y[1], y[2]);
}

static void add_sum(struct sum *to, const struct sum *from)
{
    float w[3];
    words_of(from, w);
    for (int k = 0; k < 3; k++)
        gk_sum_add(to->word, 0, w[k]);
}

static void shuffle(float *x, size_t n, uint64_t *seed)
{
    for (size_t i = n; i > 1; i--) {
        const size_t j = (check_random(seed) >> 33) % i;
        const float other = x[i - 1];
        x[i - 1] = x[j];
        x[j] = other;
    }
}

// The addends in one order, in another, and split in parts whose sums are added.
static void check_orders(float *x, size_t n, uint64_t *seed)
{
    struct sum *s = calloc(2 + PARTS, sizeof *s), *ahead = s, *other = s + 1, *part = s + 2;
    for (size_t i = 0; i < n; i++)
        gk_film_add(ahead->word, 0, x[i]);
    shuffle(x, n, seed);
    for (size_t i = 0; i < n; i++)
        gk_film_add(part[(check_random(seed) >> 40) % PARTS].word, 0, x[i]);
    for (int p = PARTS; p-- > 0;)
        add_sum(other, &part[p]);
    assert_same_words(ahead, other);
    memset(other, 0, sizeof *other);
    for (size_t i = 0; i < n; i++)
        gk_film_add(other->word, 0, x[i]);
    assert_same_words(ahead, other);
    free(s);
}

// Whole numbers of 2^-40 of all sizes up to 2^22: their sums stay below 2^31, 71 bits.
static float addend(uint64_t *seed, bool negative)
{
    const uint32_t mantissa = (uint32_t)(check_random(seed) >> 40) | 1u << 23;
    const int size = (int)((check_random(seed) >> 33) % 62) - 39; // 2^size at most
    const int bits = size + 40 < 24 ? size + 40 : 24;
    const float whole = (float)(mantissa >> (24 - bits));
    return ldexpf(whole, size - bits) * (negative && check_random(seed) >> 63 ? -1.0f : 1.0f);
}

static void any_order_and_any_split_give_the_same_words(void **state)
{
    (void)state;
    uint64_t seed = 17;
    float x[ADDENDS];
    for (int round = 0; round < 4000; round++) {
        for (int i = 0; i < ADDENDS; i++)
            x[i] = addend(&seed, round % 2);
        check_orders(x, ADDENDS, &seed);
    }
}

// Near ties: few bits at three places, so that a word is often half a unit of the one before.
static void ties_have_one_form(void **state)
{
    (void)state;
    uint64_t seed = 23;
    float x[12];
    for (int round = 0; round < 100000; round++) {
        const size_t n = 2 + (check_random(&seed) >> 33) % 11;
        for (size_t i = 0; i < n; i++) {
            const int place = (int)((check_random(&seed) >> 33) % 3) * 24 - 48;
            const int shift = (int)((check_random(&seed) >> 33) % 3) - 1;
            x[i] = ldexpf(check_random(&seed) >> 63 ? 1.0f : -1.0f, place + shift);
        }
        check_orders(x, n, &seed);
    }
}

// Each word is what the ones before leave out, rounded: no word has a bit of the one before.
static void words_are_the_exact_sum_rounded_three_times(void **state)
{
    (void)state;
    uint64_t seed = 5;
    for (int round = 0; round < 20000; round++) {
        struct sum s = {{0}};
        __int128 exact = 0; // in units of 2^-40
        for (int i = 0; i < 20; i++) {
            const float x = addend(&seed, false);
            exact += (__int128)ldexp(x, 40);
            gk_film_add(s.word, 0, x);
        }
        float w[3];
        words_of(&s, w);
        for (int k = 0; k < 3; k++) {
            const __int128 word = (__int128)ldexp(w[k], 40);
            const __int128 rest = exact - word, size = rest < 0 ? -rest : rest;
            const float unit = nextafterf(fabsf(w[k]), INFINITY) - fabsf(w[k]);
            assert_true(size <= (__int128)ldexp(unit, 39));
            exact = rest;
        }
        assert_true(exact == 0);
    }
}

// Beyond 72 bits the largest part is still as good as three words are.
static void sums_of_any_range_keep_seventy_bits(void **state)
{
    (void)state;
    uint64_t seed = 29;
    for (int round = 0; round < 2000; round++) {
        struct sum s = {{0}};
        long double exact = 0.0L; // 64 bits
        for (int i = 0; i < 100; i++) {
            const int size = (int)((check_random(&seed) >> 33) % 180) - 90;
            const float x = ldexpf(1.0f + check_uniform(&seed), size);
            exact += x;
            gk_film_add(s.word, 0, x);
        }
        float w[3];
        words_of(&s, w);
        const long double got = (long double)w[0] + w[1] + w[2];
        assert_within((double)((got - exact) / exact), 1e-17);
    }
}

static void what_no_sum_can_hold_is_clamped(void **state)
{
    (void)state;
    struct sum s = {{0}};
    for (int i = 0; i < 3; i++)
        gk_film_add(s.word, 0, i == 1 ? FLT_MAX : 0x1p-120f);
    assert_true(s.word[0] == 0x1p100f && s.word[GK_TILE_PIXELS] == 0.0f);
    for (int i = 0; i < 1 << 20; i++)
        gk_film_add(s.word, 0, FLT_MAX);
    assert_true(isfinite(s.word[0]) && s.word[0] == ldexpf((1 << 20) + 1, 100));
}

// ---- integers

static double fixed(const gk_u32 *word, int bits)
{
    const int64_t sum = (int64_t)((uint64_t)word[GK_TILE_PIXELS] << 32 | word[0]);
    return ldexp((double)sum, -bits);
}

static void integers_hold_the_largest_sum_and_the_smallest_part(void **state)
{
    (void)state;
    static const struct {
        float largest;
        gk_u32 bits;
    } kind[] = {{GK_FIXED_UNIT_LARGEST, GK_FIXED_UNIT}, {GK_FIXED_FLOW_LARGEST, GK_FIXED_FLOW}};
    for (int k = 0; k < 2; k++) {
        gk_u32 word[2 * GK_TILE_PIXELS] = {0};
        const double unit = ldexp(1.0, -(int)kind[k].bits);
        gk_film_add_fixed(word, 0, (float)unit, kind[k].largest, kind[k].bits);
        assert_true(fixed(word, (int)kind[k].bits) == unit);
        gk_film_add_fixed(word, 0, (float)-unit, kind[k].largest, kind[k].bits);
        assert_true(word[0] == 0 && word[GK_TILE_PIXELS] == 0);
        for (int i = 0; i < 1 << 24; i++)
            gk_film_add_fixed(word, 0, -INFINITY, kind[k].largest, kind[k].bits);
        assert_true(fixed(word, (int)kind[k].bits) == -0x1p24 * kind[k].largest);
        gk_film_add_fixed(word, 0, NAN, kind[k].largest, kind[k].bits);
        assert_true(fixed(word, (int)kind[k].bits) == -0x1p24 * kind[k].largest);
    }
}

static void integers_are_the_numbers_rounded_towards_zero(void **state)
{
    (void)state;
    uint64_t seed = 31;
    for (int i = 0; i < 100000; i++) {
        gk_u32 word[2 * GK_TILE_PIXELS] = {0};
        const int size = (int)((check_random(&seed) >> 33) % 44) - 40;
        const float x = ldexpf(2.0f * check_uniform(&seed) - 1.0f, size);
        gk_film_add_fixed(word, 0, x, GK_FIXED_UNIT_LARGEST, GK_FIXED_UNIT);
        const double wanted = fmin(fmax(x, -8.0), 8.0);
        assert_true(fixed(word, GK_FIXED_UNIT) ==
                    ldexp(trunc(ldexp(wanted, GK_FIXED_UNIT)), -GK_FIXED_UNIT));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_order_and_any_split_give_the_same_words),
        cmocka_unit_test(ties_have_one_form),
        cmocka_unit_test(words_are_the_exact_sum_rounded_three_times),
        cmocka_unit_test(sums_of_any_range_keep_seventy_bits),
        cmocka_unit_test(what_no_sum_can_hold_is_clamped),
        cmocka_unit_test(integers_hold_the_largest_sum_and_the_smallest_part),
        cmocka_unit_test(integers_are_the_numbers_rounded_towards_zero),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
