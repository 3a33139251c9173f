// film.c - how large tiles are, and what their sums mean.
#include "protocol/film.h"

#include "kernels/gk_film.h"
#include "kernels/gk_matte.h"

uint32_t glint_film_info_columns(const struct glint_film_info *info)
{
    return (info->job->region[2] + GK_TILE_SIDE - 1) / GK_TILE_SIDE;
}

uint32_t glint_film_info_rows(const struct glint_film_info *info)
{
    return (info->job->region[3] + GK_TILE_SIDE - 1) / GK_TILE_SIDE;
}

size_t glint_film_info_plane_bytes(const struct glint_film_info *info)
{
    const size_t batches = info->batches ? GK_PLANES_BATCHES * GK_TILE_PIXELS : 0;
    return (glint_film_info_batch_words(info) + batches) * 4;
}

size_t glint_film_info_batch_words(const struct glint_film_info *info)
{
    const size_t planes =
        GK_PLANES_BASE + (info->aovs ? GK_PLANES_AOV : 0) + (info->flow ? GK_PLANES_FLOW : 0);
    return planes * GK_TILE_PIXELS;
}

size_t glint_film_info_table_bytes(const struct glint_film_info *info)
{
    return info->coverage ? (size_t)glint_film_info_words(info) * GK_TILE_PIXELS * 8 : 0;
}

uint32_t glint_film_info_slots(const struct glint_film_info *info)
{
    return glint_matte_slots(info->job, info->mattes);
}

uint32_t glint_film_info_words(const struct glint_film_info *info)
{
    return gk_matte_words(glint_film_info_slots(info), info->job->dial[GLINT_DIAL_EVICTION]);
}

bool glint_film_info_wide(const struct glint_film_info *info)
{
    return info->job->dial[GLINT_DIAL_PRECISION] == 0;
}

uint32_t glint_film_half(uint32_t first, uint32_t samples, uint32_t half)
{
    return glint_film_part(first, samples, 2, half);
}

uint32_t glint_film_part(uint32_t first, uint32_t samples, uint32_t parts, uint32_t part)
{
    const uint32_t more = parts - 1 - part;
    return (first + samples + more) / parts - (first + more) / parts;
}

static float mean_of(const float *sum, bool wide, uint32_t i, uint32_t n)
{
    const double total =
        wide ? ((const double *)(const void *)sum)[i]
             : (double)sum[i] + ((double)sum[i + GK_TILE_PIXELS] + sum[i + 2 * GK_TILE_PIXELS]);
    return n ? (float)(total / n) : 0.0f;
}

float glint_film_mean(const float *planes, bool wide, uint32_t half, uint32_t channel, uint32_t i,
                      uint32_t n)
{
    const uint32_t plane = GK_PLANE_COLOUR + (half * 3 + channel) * GK_SUM_PLANES;
    return mean_of(planes + plane * GK_TILE_PIXELS, wide, i, n);
}

float glint_film_batch_mean(const float *batches, bool wide, uint32_t batch, uint32_t channel,
                            uint32_t i, uint32_t n)
{
    const uint32_t plane = (batch * 3 + channel) * GK_SUM_PLANES;
    return mean_of(batches + plane * GK_TILE_PIXELS, wide, i, n);
}
