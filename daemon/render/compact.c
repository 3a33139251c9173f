#include "render/compact.h"

#include <string.h>

#define BLOCK GLINT_COMPACT_BLOCK

static uint32_t blocks_of(const struct glint_compact *c)
{
    return (c->lanes + BLOCK - 1) / BLOCK;
}

static uint32_t lanes_in(uint32_t lanes, uint32_t block)
{
    const uint32_t first = block * BLOCK;
    return lanes <= first ? 0 : lanes - first < BLOCK ? lanes - first : BLOCK;
}

// ---- one lane at a time

static uint16_t alive_scalar(const float *distance, uint32_t n)
{
    uint32_t mask = 0;
    for (uint32_t k = 0; k < n; k++)
        mask |= (uint32_t)(distance[k] > 0.0f) << k;
    return (uint16_t)mask;
}

static uint16_t held_scalar(const uint32_t *held, uint32_t n)
{
    uint32_t mask = 0;
    for (uint32_t k = 0; k < n; k++)
        mask |= (uint32_t)(held[k] != 0) << k;
    return (uint16_t)mask;
}

static void take_scalar(const struct glint_lanes *lanes, uint32_t blocks, const float *from,
                        float *to)
{
    for (uint32_t b = 0; b < blocks; b++, from += BLOCK)
        for (uint32_t mask = lanes->mask[b]; mask; mask &= mask - 1)
            *to++ = from[__builtin_ctz(mask)];
}

// ---- 16 at a time

#ifdef __x86_64__
#include <immintrin.h>

#define WIDE __attribute__((target("avx512f")))

WIDE static uint16_t alive_wide(const float *distance, uint32_t n)
{
    const __mmask16 some = (__mmask16)((1u << n) - 1u);
    return _mm512_mask_cmp_ps_mask(some, _mm512_maskz_loadu_ps(some, distance), _mm512_setzero_ps(),
                                   _CMP_GT_OQ);
}

WIDE static uint16_t held_wide(const uint32_t *held, uint32_t n)
{
    const __mmask16 some = (__mmask16)((1u << n) - 1u);
    const __m512i all = _mm512_maskz_loadu_epi32(some, held);
    return _mm512_test_epi32_mask(all, all);
}

// A store of a whole block ends where a block that has been read ends, or before.
WIDE static void take_wide(const struct glint_lanes *lanes, uint32_t blocks, const float *from,
                           float *to)
{
    for (uint32_t b = 0; b < blocks; b++, from += BLOCK) {
        const uint32_t mask = lanes->mask[b];
        _mm512_storeu_ps(to, _mm512_maskz_compress_ps((__mmask16)mask, _mm512_loadu_ps(from)));
        to += __builtin_popcount(mask);
    }
}

static bool is_wide(void)
{
    return __builtin_cpu_supports("avx512f");
}
#else
#define alive_wide alive_scalar
#define held_wide held_scalar
#define take_wide take_scalar

static bool is_wide(void)
{
    return false;
}
#endif

// ---- both

static void add(struct glint_lanes *lanes, uint32_t block, uint32_t mask)
{
    lanes->mask[block] = (uint16_t)mask;
    lanes->count += (uint32_t)__builtin_popcount(mask);
}

void glint_compact_init(struct glint_compact *c)
{
    c->wide = is_wide();
}

void glint_compact_look(struct glint_compact *c, const float *distance, uint32_t lanes,
                        const uint32_t *held, uint32_t holding)
{
    c->lanes = lanes;
    c->holding.count = c->others.count = 0;
    for (uint32_t b = 0; b < blocks_of(c); b++) {
        const float *t = distance + b * BLOCK;
        const uint32_t *units = held + b * BLOCK, n = lanes_in(lanes, b), h = lanes_in(holding, b);
        const uint32_t alive = c->wide ? alive_wide(t, n) : alive_scalar(t, n);
        const uint32_t holds = c->wide ? held_wide(units, h) : held_scalar(units, h);
        add(&c->holding, b, alive & holds);
        add(&c->others, b, alive & ~holds);
    }
}

static void take(const struct glint_compact *c, const struct glint_lanes *lanes, const float *from,
                 float *to)
{
    if (c->wide)
        take_wide(lanes, blocks_of(c), from, to);
    else
        take_scalar(lanes, blocks_of(c), from, to);
}

void glint_compact_holding(const struct glint_compact *c, float *column)
{
    if (c->holding.count < c->lanes)
        take(c, &c->holding, column, column);
}

void glint_compact_column(const struct glint_compact *c, float *column)
{
    float others[GLINT_WAVE_LANES + BLOCK] __attribute__((aligned(64)));
    if (c->holding.count == 0) {
        if (c->others.count < c->lanes)
            take(c, &c->others, column, column);
        return;
    }
    if (c->others.count > 0)
        take(c, &c->others, column, others);
    glint_compact_holding(c, column);
    memcpy(column + c->holding.count, others, c->others.count * sizeof *column);
}
