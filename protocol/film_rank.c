// film_rank.c - from the slot table of a pixel to the ranked IDs of one Cryptomatte layer.
#include "protocol/film_parts.h"

#include "kernels/gk_matte.h"
#include "kernels/gk_wave.h"

#include <stdlib.h>

static uint32_t id_of(const struct glint_film_info *info, uint32_t key,
                      enum glint_matte_layer layer)
{
    const uint32_t matte = key & GK_MATTE_BASE_KEY;
    return matte == GK_MATTE_BACKGROUND ? 0 : info->matte[matte].id[layer];
}

glint_status glint_film_ranks_create(struct glint_film_ranks *out,
                                     const struct glint_film_info *info, struct glint_error *err)
{
    out->slots = info->coverage ? glint_film_info_slots(info) : 0;
    out->rank = malloc((out->slots + (size_t)1) * sizeof *out->rank);
    out->amount = malloc((out->slots + (size_t)1) * sizeof *out->amount);
    return out->rank && out->amount
               ? GLINT_OK
               : glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u ranks", out->slots);
}

void glint_film_ranks_finish(struct glint_film_ranks *r)
{
    free(r->rank);
    free(r->amount);
    *r = (struct glint_film_ranks){0};
}

uint32_t glint_film_rank(const struct glint_film_info *info, const uint64_t *table,
                         const struct glint_matte_type *type, uint32_t samples,
                         struct glint_film_ranks *out)
{
    struct glint_cryptomatte_rank *rank = out->rank;
    uint64_t *amount = out->amount;
    uint32_t n = 0;
    for (uint32_t s = 0; s < out->slots; s++) {
        const uint32_t key = gk_matte_key(table[s]);
        if (!key || gk_matte_class(key) != type->class_of_it)
            continue;
        const uint32_t id = id_of(info, key, type->layer);
        uint32_t k = 0;
        while (k < n && rank[k].id != id)
            k++;
        if (k == n) {
            rank[n].id = id;
            amount[n++] = 0;
        }
        amount[k] += gk_matte_amount(table[s]);
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
