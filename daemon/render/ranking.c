#include "render/ranking.h"

#include "kernels/gk_matte.h"
#include "kernels/gk_wave.h"

#include <stdlib.h>

static uint32_t id_of(const struct glint_matte_key *keys, uint32_t key,
                      enum glint_matte_layer layer)
{
    return key == GK_MATTE_BACKGROUND ? 0 : keys[key].id[layer];
}

uint32_t glint_ranking(const glint_resident *scene, const uint64_t *table, uint32_t slots,
                       enum glint_matte_layer layer, uint32_t samples,
                       struct glint_cryptomatte_rank *rank)
{
    const struct glint_matte_key *keys;
    glint_resident_mattes(scene, &keys);
    uint64_t amount[GLINT_MAX_SLOTS];
    uint32_t n = 0;
    for (uint32_t s = 0; s < slots; s++) {
        const uint32_t key = gk_matte_key(table[s]);
        if (!key)
            continue;
        const uint32_t id = id_of(keys, key, layer);
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

char *glint_ranking_manifest(const glint_resident *scene, enum glint_matte_layer layer)
{
    const struct glint_matte_key *keys;
    const uint32_t n = glint_resident_mattes(scene, &keys);
    const char **names = malloc(n * sizeof *names);
    if (!names)
        return NULL;
    size_t count = 0;
    for (uint32_t k = 2; k < n; k++)
        if (keys[k].id[layer])
            names[count++] = keys[k].name[layer];
    char *manifest = glint_cryptomatte_manifest(names, count);
    free(names);
    return manifest;
}
