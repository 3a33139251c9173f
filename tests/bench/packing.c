// packing - slots of 32 bits beside those of 64: CPU time of deposits in interleaved pairs, and how far
// the coverage of a pixel is off, by samples a pixel.
//
//   half   key 16 bits, sum of samples as a half float
//   fixed  key 16 bits, 16 bits of fixed point, so many behind the point that all samples fit
//
// What is deposited is that of a matte through glossy bounces: a sample is shared between two of nine
// keys at random, so that nothing is evicted.
#include "base/clock.h"
#include "kernels/gk_matte.h"
#include "protocol/half.h"
#include "tests/bench/bench.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { PAIRS = 15, PIXELS = 256, SLOTS = 12, KEYS = 9 };

// What every form is given: `share` of a sample to one key, the rest to another.
struct sample {
    uint32_t pixel, key[2];
    float share[2];
};

static uint32_t samples; // a pixel

static uint32_t next(uint32_t *random)
{
    *random = *random * 1664525u + 1013904223u;
    return gk_mix32(*random);
}

static struct sample draw(uint32_t i, uint32_t *random)
{
    const uint32_t a = next(random);
    const float share = (float)(a >> 8) * 0x1p-24f;
    return (struct sample){
        i % PIXELS, {1 + a % KEYS, 1 + next(random) % KEYS}, {share, 1.0f - share}};
}

// ---- 64 bits, as the product has them

static uint64_t wide[PIXELS][SLOTS + GK_MATTE_LOST_WORDS];

static double run_wide(void *user)
{
    (void)user;
    const double start = glint_thread_cpu();
    struct gk_matte_lost lost = {0, 0};
    uint32_t random = 1;
    memset(wide, 0, sizeof wide);
    for (uint32_t i = 0; i < samples * PIXELS; i++) {
        const struct sample s = draw(i, &random);
        const uint32_t units = gk_matte_units(s.share[0]);
        gk_matte_deposit(wide[s.pixel], SLOTS, s.key[0], 0, units, GK_MATTE_DROP, 0, &lost);
        gk_matte_deposit(wide[s.pixel], SLOTS, s.key[1], 0, GK_MATTE_ONE - units, GK_MATTE_DROP, 0,
                         &lost);
    }
    return glint_thread_cpu() - start;
}

// ---- 32 bits

static uint32_t narrow[PIXELS][SLOTS];

static uint32_t *place(uint32_t pixel, uint32_t key)
{
    uint32_t at = gk_matte_start(key, SLOTS);
    while (narrow[pixel][at] && narrow[pixel][at] >> 16 != key)
        at = at + 1 == SLOTS ? 0 : at + 1;
    return &narrow[pixel][at];
}

static double run_half(void *user)
{
    (void)user;
    const double start = glint_thread_cpu();
    uint32_t random = 1;
    memset(narrow, 0, sizeof narrow);
    for (uint32_t i = 0; i < samples * PIXELS; i++) {
        const struct sample s = draw(i, &random);
        for (int k = 0; k < 2; k++) {
            uint32_t *slot = place(s.pixel, s.key[k]);
            const float sum = glint_float_from_half((uint16_t)*slot) + s.share[k];
            *slot = s.key[k] << 16 | glint_half_from_float(sum, NULL);
        }
    }
    return glint_thread_cpu() - start;
}

static float one; // units of a sample, so that all of them are below 2^16

static double run_fixed(void *user)
{
    (void)user;
    const double start = glint_thread_cpu();
    const uint32_t whole = (uint32_t)one;
    uint32_t random = 1;
    memset(narrow, 0, sizeof narrow);
    for (uint32_t i = 0; i < samples * PIXELS; i++) {
        const struct sample s = draw(i, &random);
        const uint32_t units = (uint32_t)(s.share[0] * one + 0.5f);
        for (int k = 0; k < 2; k++) {
            uint32_t *slot = place(s.pixel, s.key[k]);
            *slot = s.key[k] << 16 | ((*slot & 0xffffu) + (k ? whole - units : units));
        }
    }
    return glint_thread_cpu() - start;
}

// ---- how far off

static double exact[PIXELS][KEYS + 1];

static void run_exact(void)
{
    uint32_t random = 1;
    memset(exact, 0, sizeof exact);
    for (uint32_t i = 0; i < samples * PIXELS; i++) {
        const struct sample s = draw(i, &random);
        for (int k = 0; k < 2; k++)
            exact[s.pixel][s.key[k]] += (double)s.share[k] / samples;
    }
}

static double coverage_wide(uint32_t pixel, uint32_t key)
{
    for (uint32_t k = 0; k < SLOTS; k++)
        if (gk_matte_key(wide[pixel][k]) == key)
            return (double)gk_matte_amount(wide[pixel][k]) / GK_MATTE_ONE / samples;
    return 0.0;
}

static double coverage_half(uint32_t pixel, uint32_t key)
{
    return (double)glint_float_from_half((uint16_t)*place(pixel, key)) / samples;
}

static double coverage_fixed(uint32_t pixel, uint32_t key)
{
    return (double)(*place(pixel, key) & 0xffffu) / (double)one / samples;
}

static void print_form(const char *name, double (*run)(void *),
                       double (*coverage)(uint32_t, uint32_t))
{
    double cost_wide[PAIRS], cost[PAIRS], worst = 0.0, sum = 0.0;
    bench_pairs(run_wide, run, NULL, cost_wide, cost, PAIRS);
    const struct bench_ratio r = bench_ratio_of(cost_wide, cost, PAIRS);
    for (uint32_t pixel = 0; pixel < PIXELS; pixel++)
        for (uint32_t key = 1; key <= KEYS; key++) {
            const double off = fabs(coverage(pixel, key) - exact[pixel][key]);
            worst = fmax(worst, off);
            sum += off / (PIXELS * KEYS);
        }
    printf(",\"%s\":{\"ratio\":%.4f,\"low\":%.4f,\"high\":%.4f,\"worst\":%.3g,\"mean\":%.3g}", name,
           r.median, r.low, r.high, worst, sum);
    fflush(stdout);
}

int main(void)
{
    printf("{\"bench\":\"packing\",\"pairs\":%d", PAIRS);
    for (samples = 64; samples <= 16384; samples *= 16) {
        one = exp2f(floorf(log2f(65535.0f / (float)samples)));
        printf(",\"%u\":{\"samples\":%u", samples, samples);
        run_exact();
        print_form("wide", run_wide, coverage_wide);
        print_form("half", run_half, coverage_half);
        print_form("fixed", run_fixed, coverage_fixed);
        printf("}");
    }
    puts("}");
    return 0;
}
