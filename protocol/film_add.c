#include "protocol/film_add.h"

#include "kernels/gk_film.h"
#include "kernels/gk_matte_spill.h"

static void add_exact(float *to, uint32_t i, const float *from, uint32_t j)
{
    for (int k = 0; k < GK_SUM_PLANES; k++)
        gk_sum_add(to, i, from[j + (uint32_t)k * GK_TILE_PIXELS]);
}

static void add_wide(float *to, uint32_t i, const float *from, uint32_t j)
{
    ((double *)(void *)to)[i] += ((const double *)(const void *)from)[j];
}

static void add_integer(uint32_t *to, uint32_t i, const uint32_t *from, uint32_t j)
{
    const uint64_t sum = ((uint64_t)to[i + GK_TILE_PIXELS] << 32 | to[i]) +
                         ((uint64_t)from[j + GK_TILE_PIXELS] << 32 | from[j]);
    to[i] = (uint32_t)sum;
    to[i + GK_TILE_PIXELS] = (uint32_t)(sum >> 32);
}

static void add_integers(float *to, uint32_t i, const float *from, uint32_t j, int first, int sums)
{
    for (int s = 0; s < sums; s++) {
        const int plane = (GK_PLANES_BASE + first + 2 * s) * GK_TILE_PIXELS;
        add_integer((uint32_t *)to + plane, i, (const uint32_t *)from + plane, j);
    }
}

void glint_film_add_planes(const struct glint_film_info *info, float *to, uint32_t i,
                           const float *from, uint32_t j)
{
    for (int s = 0; s < 6; s++) {
        const int plane = (GK_PLANE_COLOUR + s * GK_SUM_PLANES) * GK_TILE_PIXELS;
        (glint_film_info_wide(info) ? add_wide : add_exact)(to + plane, i, from + plane, j);
    }
    uint32_t *count = (uint32_t *)to;
    const uint32_t *more = (const uint32_t *)from;
    for (int p = GK_PLANE_HITS; p <= GK_PLANE_REJECTED; p++)
        count[p * GK_TILE_PIXELS + (int)i] += more[p * GK_TILE_PIXELS + (int)j];
    const size_t batches = glint_film_info_batch_words(info);
    for (size_t s = 0; info->batches && s < 3 * GK_BATCHES; s++) {
        const size_t plane = batches + s * GK_SUM_PLANES * GK_TILE_PIXELS;
        (glint_film_info_wide(info) ? add_wide : add_exact)(to + plane, i, from + plane, j);
    }
    if (!info->aovs)
        return;
    float *depth = to + (GK_PLANES_BASE + GK_AOV_DEPTH) * GK_TILE_PIXELS + i;
    *depth = gk_min(*depth, from[(GK_PLANES_BASE + GK_AOV_DEPTH) * GK_TILE_PIXELS + j]);
    add_integers(to, i, from, j, GK_AOV_NORMAL, 6);
    if (info->flow)
        add_integers(to, i, from, j, GK_AOV_FLOW, 4);
}

// A pixel that gets what others hold.
struct heir {
    uint64_t *tables; // of its tile
    uint32_t pixel, slots, policy;
    struct gk_matte_lost lost;
    uint64_t homeless;
};

static void inherit(struct heir *h, uint64_t slot, uint32_t salt)
{
    const uint32_t words = gk_matte_words(h->slots, h->policy), key = gk_matte_key(slot);
    uint64_t amount = gk_matte_amount(slot);
    if (!key)
        return;
    if (gk_matte_find(h->tables + (size_t)h->pixel * words, h->slots, key).found ==
        GK_MATTE_NOWHERE) {
        if (h->policy == GK_MATTE_SPILL)
            amount = gk_matte_spill(h->tables, words, h->pixel, key, gk_matte_direct(slot), amount);
        h->homeless += amount;
    }
    gk_matte_deposit_tile(h->tables, h->pixel, h->slots, key, gk_matte_direct(slot), amount,
                          h->policy, gk_mix32(key ^ gk_mix32((uint32_t)amount + salt)), &h->lost);
}

static void inherit_places(struct heir *h, const uint64_t *from, uint32_t words, uint32_t i)
{
    for (uint32_t n = 0; n < GK_MATTE_SPILL_PLACES; n++) {
        const uint64_t place = from[gk_matte_spill_at(words, i, n)];
        if (!place)
            return;
        if (gk_matte_spilled(place, i, gk_matte_key(place)))
            inherit(h, gk_matte_spill_slot(place), h->slots + n);
    }
}

uint64_t glint_film_add_table(const struct glint_film_info *info, uint64_t *to, uint32_t at,
                              const uint64_t *from, uint32_t i)
{
    const uint32_t slots = glint_film_info_slots(info), words = glint_film_info_words(info);
    const uint64_t *table = from + (size_t)i * words;
    uint64_t *lost = to + (size_t)at * words + slots;
    struct heir h = {to,
                     at,
                     slots,
                     info->job->dial[GLINT_DIAL_EVICTION],
                     {table[slots + GK_MATTE_LOST_PRIMARY], table[slots + GK_MATTE_LOST_BOUNCED]},
                     table[slots + GK_MATTE_LOST_PRIMARY] + table[slots + GK_MATTE_LOST_BOUNCED]};
    for (uint32_t s = 0; s < slots; s++)
        inherit(&h, table[s], s);
    if (h.policy == GK_MATTE_SPILL)
        inherit_places(&h, from, words, i);
    lost[GK_MATTE_LOST_PRIMARY] += h.lost.primary;
    lost[GK_MATTE_LOST_BOUNCED] += h.lost.bounced;
    return h.homeless;
}
