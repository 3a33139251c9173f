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

static void take_scalar(const struct glint_compact *c, const struct glint_lanes *lanes,
                        const float *from, float *to)
{
    for (uint32_t b = 0; b < blocks_of(c); b++, from += BLOCK)
        for (uint32_t mask = lanes->mask[b]; mask; mask &= mask - 1)
            *to++ = from[__builtin_ctz(mask)];
}

#ifdef __x86_64__
#include <immintrin.h>

// ---- 8 at a time

#define EIGHT __attribute__((target("avx2")))

EIGHT static uint16_t alive_eight(const float *distance)
{
    const __m256 none = _mm256_setzero_ps();
    const int low = _mm256_movemask_ps(_mm256_cmp_ps(_mm256_loadu_ps(distance), none, _CMP_GT_OQ));
    const int high =
        _mm256_movemask_ps(_mm256_cmp_ps(_mm256_loadu_ps(distance + 8), none, _CMP_GT_OQ));
    return (uint16_t)(low | high << 8);
}

EIGHT static int empty_eight(const uint32_t *held)
{
    const __m256i all = _mm256_loadu_si256((const __m256i_u *)held);
    return _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(all, _mm256_setzero_si256())));
}

EIGHT static uint16_t held_eight(const uint32_t *held)
{
    return (uint16_t) ~(empty_eight(held) | empty_eight(held + 8) << 8);
}

// A store of eight lanes ends where lanes that have been read end, or before.
EIGHT static void take_eight(const struct glint_compact *c, const struct glint_lanes *lanes,
                             const float *from, float *to)
{
    for (uint32_t half = 0; half < 2 * blocks_of(c); half++, from += 8) {
        const uint32_t mask = lanes->mask[half / 2] >> half % 2 * 8 & 255u;
        const __m128i bytes = _mm_cvtsi64_si128((int64_t)c->order[mask]);
        const __m256 lane = _mm256_loadu_ps(from);
        _mm256_storeu_ps(to, _mm256_permutevar8x32_ps(lane, _mm256_cvtepu8_epi32(bytes)));
        to += __builtin_popcount(mask);
    }
}

// ---- 16 at a time

#define SIXTEEN __attribute__((target("avx512f")))

SIXTEEN static uint16_t alive_sixteen(const float *distance)
{
    return _mm512_cmp_ps_mask(_mm512_loadu_ps(distance), _mm512_setzero_ps(), _CMP_GT_OQ);
}

SIXTEEN static uint16_t held_sixteen(const uint32_t *held)
{
    const __m512i all = _mm512_loadu_si512(held);
    return _mm512_test_epi32_mask(all, all);
}

// A store of a whole block ends where a block that has been read ends, or before.
SIXTEEN static void take_sixteen(const struct glint_compact *c, const struct glint_lanes *lanes,
                                 const float *from, float *to)
{
    for (uint32_t b = 0; b < blocks_of(c); b++, from += BLOCK) {
        const uint32_t mask = lanes->mask[b];
        _mm512_storeu_ps(to, _mm512_maskz_compress_ps((__mmask16)mask, _mm512_loadu_ps(from)));
        to += __builtin_popcount(mask);
    }
}

static uint32_t widest_step(void)
{
    return __builtin_cpu_supports("avx512f") ? 16 : __builtin_cpu_supports("avx2") ? 8 : 1;
}
#else
#define alive_eight(distance) alive_scalar(distance, BLOCK)
#define alive_sixteen alive_eight
#define held_eight(held) held_scalar(held, BLOCK)
#define held_sixteen held_eight
#define take_eight take_scalar
#define take_sixteen take_scalar

static uint32_t widest_step(void)
{
    return 1;
}
#endif

// ---- whatever there is

static uint16_t alive(const struct glint_compact *c, const float *distance, uint32_t n)
{
    return n < BLOCK || c->step == 1 ? alive_scalar(distance, n)
           : c->step == 8            ? alive_eight(distance)
                                     : alive_sixteen(distance);
}

static uint16_t holding(const struct glint_compact *c, const uint32_t *held, uint32_t n)
{
    return n < BLOCK || c->step == 1 ? held_scalar(held, n)
           : c->step == 8            ? held_eight(held)
                                     : held_sixteen(held);
}

static void take(const struct glint_compact *c, const struct glint_lanes *lanes, const float *from,
                 float *to)
{
    (c->step == 1 ? take_scalar : c->step == 8 ? take_eight : take_sixteen)(c, lanes, from, to);
}

static void add(struct glint_lanes *lanes, uint32_t block, uint32_t mask)
{
    lanes->mask[block] = (uint16_t)mask;
    lanes->count += (uint32_t)__builtin_popcount(mask);
}

void glint_compact_init(struct glint_compact *c)
{
    c->step = widest_step();
    for (uint32_t mask = 0; mask < 256; mask++) {
        uint64_t order = 0;
        uint32_t n = 0;
        for (uint64_t k = 0; k < 8; k++)
            if (mask >> k & 1u)
                order |= k << 8 * n++;
        c->order[mask] = order;
    }
}

void glint_compact_look(struct glint_compact *c, const float *distance, uint32_t lanes,
                        const uint32_t *held, uint32_t holders)
{
    c->lanes = lanes;
    c->holding.count = c->others.count = 0;
    for (uint32_t b = 0; b < blocks_of(c); b++) {
        const float *t = distance + b * BLOCK;
        const uint32_t *units = held + b * BLOCK, n = lanes_in(lanes, b), h = lanes_in(holders, b);
        const uint32_t lives = alive(c, t, n), holds = holding(c, units, h);
        add(&c->holding, b, lives & holds);
        add(&c->others, b, lives & ~holds);
    }
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
