// Survivors of a wave: those that hold coverage first, each part in its order.
#include "render/compact.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <string.h>

enum { ROOM = GLINT_WAVE_LANES + GLINT_COMPACT_BLOCK };

static float distance[ROOM], column[ROOM] __attribute__((aligned(64)));
static uint32_t held[ROOM], random_state;

static uint32_t draw(uint32_t n)
{
    random_state = random_state * 1664525u + 1013904223u;
    return (uint32_t)((uint64_t)random_state * n >> 32);
}

// One of `odds` lanes ends, one of `odds` holds nothing.
static void fill(uint32_t lanes, uint32_t odds)
{
    static const float ended[] = {-INFINITY, 0.0f, -0.0f, NAN};
    for (uint32_t i = 0; i < ROOM; i++) {
        distance[i] = i < lanes && draw(odds) ? 1.0f + (float)i : ended[draw(4)];
        held[i] = draw(odds) ? 1u << draw(32) : 0u;
        column[i] = (float)i;
    }
}

// What is expected, one lane at a time. Returns the number.
static uint32_t survivors(uint32_t lanes, uint32_t holding, bool holds, float *out)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < lanes; i++)
        if (distance[i] > 0.0f && (i < holding && held[i]) == holds)
            out[n++] = (float)i;
    return n;
}

static void check_by(struct glint_compact *c, uint32_t lanes, uint32_t holding, uint32_t odds)
{
    static float wanted[ROOM], again[ROOM] __attribute__((aligned(64)));
    fill(lanes, odds);
    memcpy(again, column, sizeof again);
    const uint32_t first = survivors(lanes, holding, true, wanted);
    const uint32_t all = first + survivors(lanes, holding, false, wanted + first);
    glint_compact_look(c, distance, lanes, held, holding);
    assert_int_equal(c->holding.count, first);
    assert_int_equal(c->holding.count + c->others.count, all);
    glint_compact_column(c, column);
    assert_memory_equal(column, wanted, all * sizeof *wanted);
    glint_compact_holding(c, again);
    assert_memory_equal(again, wanted, first * sizeof *wanted);
}

// Sixteen lanes at a time, and eight, where that is to be had, and one.
static void check(uint32_t lanes, uint32_t holding, uint32_t odds)
{
    static const uint32_t steps[] = {16, 8, 1};
    static struct glint_compact c;
    glint_compact_init(&c);
    const uint32_t widest = c.step;
    for (size_t s = 0; s < sizeof steps / sizeof *steps; s++)
        if (steps[s] <= widest) {
            c.step = steps[s];
            check_by(&c, lanes, holding, odds);
        }
}

static void survivors_come_first_and_keep_their_order(void **state)
{
    (void)state;
    static const uint32_t lanes[] = {0, 1, 15, 16, 17, 255, 4095, GLINT_WAVE_LANES};
    random_state = 1;
    for (size_t l = 0; l < sizeof lanes / sizeof *lanes; l++)
        for (uint32_t odds = 1; odds < 12; odds++) {
            check(lanes[l], 0, odds);
            check(lanes[l], lanes[l], odds);
            check(lanes[l], draw(lanes[l] + 1), odds);
        }
}

static void a_wave_that_goes_on_whole_stays_where_it_is(void **state)
{
    (void)state;
    check(GLINT_WAVE_LANES, 0, UINT32_MAX);
    check(GLINT_WAVE_LANES, GLINT_WAVE_LANES, UINT32_MAX);
    check(100, 37, UINT32_MAX);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(survivors_come_first_and_keep_their_order),
        cmocka_unit_test(a_wave_that_goes_on_whole_stays_where_it_is),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
