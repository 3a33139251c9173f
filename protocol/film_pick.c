// film_pick.c - what covers one pixel, by name.
#include "protocol/film_levels.h"
#include "protocol/film_parts.h"

#include "kernels/gk_film.h"

#include <stdlib.h>
#include <string.h>

static const char *name_of(const struct glint_film_info *info, enum glint_matte_layer layer,
                           uint32_t id)
{
    for (uint32_t k = 2; id && k < info->mattes; k++)
        if (info->matte[k].id[layer] == id)
            return info->matte[k].name[layer];
    return "";
}

// Appends the ranks of a type. Returns their number.
static size_t add_ranks(const struct glint_film_info *info, uint32_t samples,
                        const struct glint_matte_type *type, struct glint_film_ranks *ranks,
                        struct glint_matte_found *out)
{
    const uint32_t n = glint_film_rank(info, type, samples, ranks);
    const struct glint_cryptomatte_rank *rank = ranks->rank;
    size_t count = 0;
    for (uint32_t k = 0; k < n && k < glint_film_levels(info->job); k++)
        if (rank[k].id && rank[k].coverage > 0.0f)
            out[count++] = (struct glint_matte_found){*type, name_of(info, type->layer, rank[k].id),
                                                      rank[k].id, rank[k].coverage};
    return count;
}

// A copy of the list in one block with its names; NULL without memory.
static struct glint_matte_found *with_names(const struct glint_matte_found *list, size_t count)
{
    size_t bytes = (count + 1) * sizeof *list;
    for (size_t i = 0; i < count; i++)
        bytes += strlen(list[i].name) + 1;
    struct glint_matte_found *out = malloc(bytes);
    char *name = (char *)(out + count + 1);
    for (size_t i = 0; out && i < count; i++) {
        out[i] = list[i];
        out[i].name = name;
        name = stpcpy(name, list[i].name) + 1;
    }
    return out;
}

static struct glint_matte_found *look(const struct glint_film_info *info, uint32_t samples,
                                      uint32_t outputs, struct glint_film_ranks *ranks,
                                      size_t *count)
{
    struct glint_matte_type type[GLINT_MAX_MATTE_TYPES];
    const size_t types = glint_matte_types(info->job, outputs, type);
    const size_t most = types * glint_film_levels(info->job);
    struct glint_matte_found *list = malloc((most + 1) * sizeof *list), *out;
    *count = 0;
    for (size_t t = 0; list && samples && t < types; t++)
        *count += add_ranks(info, samples, &type[t], ranks, list + *count);
    out = list ? with_names(list, *count) : NULL;
    free(list);
    return out;
}

glint_status glint_film_pick(const struct glint_film_source *s, uint32_t x, uint32_t y,
                             uint32_t outputs, struct glint_matte_found **out, size_t *count,
                             struct glint_error *err)
{
    const struct glint_film_info *info = s->info;
    const uint32_t *region = info->job->region;
    const uint32_t column = x - region[0], row = y - region[1];
    const uint32_t tile =
        row / GK_TILE_SIDE * glint_film_info_columns(info) + column / GK_TILE_SIDE;
    const uint32_t at = row % GK_TILE_SIDE * GK_TILE_SIDE + column % GK_TILE_SIDE;
    struct glint_film_pixels pixels = {0};
    struct glint_film_ranks ranks = {0};
    *out = NULL;
    *count = 0;
    glint_status st = glint_film_ranks_create(&ranks, info, err);
    if (!st)
        st = s->begin(s->user, tile, &pixels, err);
    if (st) {
        glint_film_ranks_finish(&ranks);
        return st;
    }
    const uint32_t i = glint_film_shown_as(&pixels, at);
    const uint32_t samples =
        glint_film_samples_of(&pixels, i, 0) + glint_film_samples_of(&pixels, i, 1);
    if (pixels.table)
        glint_film_held_read(info, pixels.table, i, &ranks.held);
    *out = look(info, samples, outputs, &ranks, count);
    s->end(s->user, tile);
    glint_film_ranks_finish(&ranks);
    return *out ? GLINT_OK : glint_fail(err, GLINT_E_NOMEM, "", "no memory for names");
}
