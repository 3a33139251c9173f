#include "protocol/film_levels.h"

#include "kernels/gk_matte.h"
#include "protocol/film_parts.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

uint32_t glint_film_levels(const struct glint_job *job)
{
    return job->matte_levels ? job->matte_levels : GLINT_MAX_LEVELS;
}

// Ranks below which nobody asks how many there should be.
static uint32_t fewest(const struct glint_job *job)
{
    return job->matte_levels ? job->matte_levels : GLINT_DEFAULT_LEVELS;
}

static double left_out(const struct glint_cryptomatte_rank *rank, uint32_t n, uint32_t levels)
{
    double sum = 0.0;
    for (uint32_t k = levels; k < n; k++)
        sum += rank[k].coverage;
    return sum;
}

uint32_t glint_film_levels_of(const struct glint_cryptomatte_rank *rank, uint32_t n,
                              uint32_t levels)
{
    double sum = 0.0;
    uint32_t k = n;
    while (k > levels && (sum += rank[k - 1].coverage) <= GLINT_MOST_LEFT_OUT)
        k--;
    k = k > levels ? k : levels;
    return k + k % 2;
}

void glint_matte_excess_merge(struct glint_matte_excess *sum, const struct glint_matte_excess *part)
{
    sum->pixels += part->pixels;
    sum->needed = sum->needed > part->needed ? sum->needed : part->needed;
    sum->left_out = fmax(sum->left_out, part->left_out);
}

// Of one type. Returns whether there are more names than levels.
static bool add_type(const struct glint_film_info *info, const struct glint_matte_type *type,
                     uint32_t samples, struct glint_film_ranks *ranks,
                     struct glint_matte_excess *out)
{
    const uint32_t n = glint_film_rank(info, type, samples, ranks);
    const uint32_t levels = glint_film_levels(info->job);
    const uint32_t needed = glint_film_levels_of(ranks->rank, n, fewest(info->job));
    out->needed = out->needed > needed ? out->needed : needed;
    out->left_out = fmax(out->left_out, left_out(ranks->rank, n, levels));
    return n > levels;
}

// Names are no more than slots: few pixels have enough of these to be looked at.
static void add_pixel(const struct glint_film_info *info, const struct glint_matte_type *type,
                      size_t types, uint32_t samples, struct glint_film_ranks *ranks,
                      struct glint_matte_excess *out)
{
    uint32_t in_class[GLINT_MAX_MATTE_CLASSES] = {0};
    bool more = false;
    for (uint32_t s = 0; s < ranks->held.count; s++)
        in_class[gk_matte_class(gk_matte_key(ranks->held.slot[s]))]++;
    for (size_t t = 0; t < types; t++)
        if (in_class[type[t].class_of_it] > fewest(info->job))
            more |= add_type(info, &type[t], samples, ranks, out);
    out->pixels += more;
}

glint_status glint_film_excess_add(const struct glint_film_info *info,
                                   const struct glint_film_pixels *pixels, const uint32_t size[2],
                                   struct glint_matte_excess *out, struct glint_error *err)
{
    struct glint_matte_type type[GLINT_MAX_MATTE_TYPES];
    const size_t types = glint_matte_types(info->job, info->job->outputs & GLINT_OUT_CRYPTO, type);
    const uint32_t least = fewest(info->job) + fewest(info->job) % 2;
    struct glint_film_ranks ranks = {0};
    const glint_status st = glint_film_ranks_create(&ranks, info, err);
    out->needed = out->needed > least ? out->needed : least;
    for (uint32_t i = 0; !st && i < GK_TILE_PIXELS; i++) {
        const uint32_t samples =
            glint_film_samples_of(pixels, i, 0) + glint_film_samples_of(pixels, i, 1);
        if (!samples || i % GK_TILE_SIDE >= size[0] || i / GK_TILE_SIDE >= size[1])
            continue;
        glint_film_held_read(info, pixels->table, i, &ranks.held);
        if (ranks.held.count > fewest(info->job))
            add_pixel(info, type, types, samples, &ranks, out);
    }
    glint_film_ranks_finish(&ranks);
    return st;
}

static uint32_t part_of(uint32_t whole, uint32_t tile)
{
    const uint32_t left = whole - tile * GK_TILE_SIDE;
    return left < GK_TILE_SIDE ? left : GK_TILE_SIDE;
}

glint_status glint_film_excess(const struct glint_film_source *s, struct glint_matte_excess *out,
                               struct glint_error *err)
{
    const struct glint_film_info *info = s->info;
    const uint32_t columns = glint_film_info_columns(info), rows = glint_film_info_rows(info);
    glint_status st = GLINT_OK;
    *out = (struct glint_matte_excess){0};
    for (uint32_t tile = 0; !st && tile < columns * rows; tile++) {
        const uint32_t size[2] = {part_of(info->job->region[2], tile % columns),
                                  part_of(info->job->region[3], tile / columns)};
        struct glint_film_pixels pixels = {0};
        st = s->begin(s->user, tile, &pixels, err);
        if (st)
            break;
        st = glint_film_excess_add(info, &pixels, size, out, err);
        s->end(s->user, tile);
    }
    return st;
}

bool glint_matte_excess_tell(const struct glint_matte_excess *x, const struct glint_job *job,
                             char text[256])
{
    char remedy[64] = "that is all that a file can have";
    if (!(x->left_out > GLINT_MOST_LEFT_OUT))
        return false;
    if (job->matte_levels && x->needed <= GLINT_MOST_GIVEN_LEVELS)
        snprintf(remedy, sizeof remedy, "\"levels\": %u, or \"auto\", would do", x->needed);
    else if (job->matte_levels)
        snprintf(remedy, sizeof remedy, "\"levels\": \"auto\" writes up to %u", GLINT_MAX_LEVELS);
    snprintf(text, 256,
             "%" PRIu64 " pixels have more names than the %u ranks of a file, which leave out %.2g "
             "of a pixel at worst where %g is little: %s",
             x->pixels, glint_film_levels(job), x->left_out, GLINT_MOST_LEFT_OUT, remedy);
    return true;
}
