// film_rank.c - from the slot table of a pixel to the ranked IDs of one Cryptomatte layer.
#include "protocol/film_parts.h"

#include "kernels/gk_matte_spill.h"
#include "kernels/gk_wave.h"

#include <stdlib.h>

static uint32_t id_of(const struct glint_film_info *info, uint32_t key,
                      enum glint_matte_layer layer)
{
    const uint32_t matte = key & GK_MATTE_BASE_KEY;
    return matte == GK_MATTE_BACKGROUND ? 0 : info->matte[matte].id[layer];
}

uint32_t glint_film_held_room(const struct glint_film_info *info)
{
    const bool spill = info->job->dial[GLINT_DIAL_EVICTION] == GLINT_EVICTION_SPILL;
    return glint_film_info_slots(info) + (spill ? GK_MATTE_SPILL_PLACES : 0);
}

// Places up to the first that is empty.
static void read_places(const uint64_t *tables, uint32_t words, uint32_t pixel,
                        struct glint_film_held *out)
{
    for (uint32_t n = 0; n < GK_MATTE_SPILL_PLACES; n++) {
        const uint64_t place = tables[gk_matte_spill_at(words, pixel, n)];
        if (!place)
            return;
        if (gk_matte_spilled(place, pixel, gk_matte_key(place)))
            out->slot[out->count++] = gk_matte_spill_slot(place);
    }
}

void glint_film_held_read(const struct glint_film_info *info, const uint64_t *tables,
                          uint32_t pixel, struct glint_film_held *out)
{
    const uint32_t slots = glint_film_info_slots(info), words = glint_film_info_words(info);
    const uint64_t *table = tables + (size_t)pixel * words;
    out->count = 0;
    for (uint32_t s = 0; s < slots; s++) { // without a branch: one slot more has room
        out->slot[out->count] = table[s];
        out->count += gk_matte_key(table[s]) != 0;
    }
    const bool full = out->count == slots; // or it has no place, and no slot is ever emptied
    if (full && info->job->dial[GLINT_DIAL_EVICTION] == GLINT_EVICTION_SPILL)
        read_places(tables, words, pixel, out);
}

glint_status glint_film_ranks_create(struct glint_film_ranks *out,
                                     const struct glint_film_info *info, struct glint_error *err)
{
    const size_t room = info->coverage ? glint_film_held_room(info) : 0;
    out->held = (struct glint_film_held){malloc((room + 1) * sizeof *out->held.slot), 0};
    out->rank = malloc((room + 1) * sizeof *out->rank);
    out->amount = malloc((room + 1) * sizeof *out->amount);
    return out->held.slot && out->rank && out->amount
               ? GLINT_OK
               : glint_fail(err, GLINT_E_NOMEM, "", "no memory for %zu ranks", room);
}

void glint_film_ranks_finish(struct glint_film_ranks *r)
{
    free(r->held.slot);
    free(r->rank);
    free(r->amount);
    *r = (struct glint_film_ranks){0};
}

uint32_t glint_film_rank(const struct glint_film_info *info, const struct glint_matte_type *type,
                         uint32_t samples, struct glint_film_ranks *r)
{
    struct glint_cryptomatte_rank *rank = r->rank;
    uint64_t *amount = r->amount;
    uint32_t n = 0;
    for (uint32_t s = 0; s < r->held.count; s++) {
        const uint64_t slot = r->held.slot[s];
        if (gk_matte_class(gk_matte_key(slot)) != type->class_of_it)
            continue;
        const uint32_t id = id_of(info, gk_matte_key(slot), type->layer);
        uint32_t k = 0;
        while (k < n && rank[k].id != id)
            k++;
        if (k == n) {
            rank[n].id = id;
            amount[n++] = 0;
        }
        amount[k] += gk_matte_amount(slot);
    }
    for (uint32_t k = 0; k < n; k++)
        rank[k].coverage = (float)((double)amount[k] / ((double)GK_MATTE_ONE * samples));
    glint_cryptomatte_sort(rank, n);
    return n;
}

char *glint_film_manifest(const struct glint_film_info *info, enum glint_matte_layer layer)
{
    const char **names = malloc((info->mattes + 1) * sizeof *names);
    if (!names)
        return NULL;
    size_t count = 0;
    for (uint32_t k = 2; k < info->mattes; k++)
        if (info->matte[k].id[layer])
            names[count++] = info->matte[k].name[layer];
    char *manifest = glint_cryptomatte_manifest(names, count);
    free(names);
    return manifest;
}
