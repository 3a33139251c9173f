// sound.c - what a slice has done against the rules that hold for every sample.
#include "render/wave_parts.h"

#include "kernels/gk_film.h"
#include "kernels/gk_matte.h"
#include "kernels/gk_wave.h"

#include <math.h>

static const float *column(const struct glint_run *r, uint32_t c)
{
    return (const float *)glint_buffer_host(r->wave->columns) + (size_t)c * GLINT_WAVE_STRIDE;
}

static bool between(const float *x, uint32_t n)
{
    int outside = 0;
    for (uint32_t i = 0; i < n; i++)
        outside |= !(x[i] >= 0.0f && x[i] <= GK_SUM_LARGEST);
    return !outside;
}

static enum glint_count kind_of(float r, float g, float b)
{
    if (r == GK_RADIANCE_NESTED)
        return GLINT_COUNT_NESTED;
    if (isnan(r) || isnan(g) || isnan(b))
        return GLINT_COUNT_NAN;
    if (r < 0.0f || g < 0.0f || b < 0.0f)
        return GLINT_COUNT_NEGATIVE;
    return isinf(r) || isinf(g) || isinf(b) ? GLINT_COUNT_INFINITE : GLINT_COUNT_BRIGHT;
}

void glint_run_count_samples(struct glint_run *run)
{
    const float *r = column(run, GK_COL_LR), *g = column(run, GK_COL_LG),
                *b = column(run, GK_COL_LB);
    if (between(r, run->lanes) && between(g, run->lanes) && between(b, run->lanes))
        return; // as good as always
    for (uint32_t i = 0; i < run->lanes; i++)
        if (!between(&r[i], 1) || !between(&g[i], 1) || !between(&b[i], 1))
            run->wave->stats.count[kind_of(r[i], g[i], b[i])]++;
}

static glint_status add_lost(struct glint_run *run, const struct glint_film_tile *at,
                             uint32_t tile_in_block)
{
    (void)tile_in_block;
    const uint32_t slots = run->job->matte_slots,
                   words = gk_matte_words(slots, run->job->matte_policy);
    const uint64_t *table = (const uint64_t *)glint_buffer_host(at->tables) + at->tables_offset;
    for (uint32_t i = 0; i < GK_TILE_PIXELS; i++)
        run->lost += table[i * words + slots + GK_MATTE_LOST_PRIMARY] +
                     table[i * words + slots + GK_MATTE_LOST_BOUNCED];
    return GLINT_OK;
}

uint64_t glint_run_lost(struct glint_run *run)
{
    run->lost = 0;
    if (glint_plan_has(run->job->plan, GLINT_PASS_COVERAGE))
        glint_run_tiles(run, add_lost); // which cannot fail
    return run->lost;
}
