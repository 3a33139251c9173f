// carried.c - deposits of coverage that paths carry through bounces.
#include "render/wave_parts.h"

#include "kernels/gk_film.h"
#include "kernels/gk_matte.h"
#include "kernels/gk_wave.h"

#include <string.h>

static size_t table_bytes(const struct glint_run *r)
{
    return (size_t)GK_TILE_PIXELS * gk_matte_words(r->job->matte_slots, r->job->matte_policy) * 8;
}

// Different for every launch on every pixel: the draws of unbiased eviction are taken from it.
static uint32_t salt_of(const struct glint_run *r, uint32_t lane)
{
    const struct glint_wave_block *b = r->block;
    const uint32_t place = gk_mix32(b->x + gk_mix32(b->y + gk_mix32(lane + r->job->seed)));
    return gk_mix32(place ^ gk_mix32(b->sample + gk_mix32(r->bounce)));
}

glint_status glint_run_deposit_pixels(struct glint_run *r, const char *kernel,
                                      const struct glint_film_tile *at, uint32_t n, uint32_t lane)
{
    const uint32_t stride = GLINT_WAVE_STRIDE, step = 1u << r->pixels_log2;
    const uint32_t samples = r->block->samples, salt = salt_of(r, lane);
    const struct glint_arg args[] = {GLINT_ARG_BUFFER(r->wave->columns),
                                     GLINT_ARG_VALUE(stride),
                                     GLINT_ARG_VALUE(n),
                                     GLINT_ARG_VALUE(lane),
                                     GLINT_ARG_VALUE(step),
                                     GLINT_ARG_VALUE(samples),
                                     GLINT_ARG_BUFFER(at->tables),
                                     GLINT_ARG_VALUE(at->tables_offset),
                                     GLINT_ARG_VALUE(r->job->matte_slots),
                                     GLINT_ARG_VALUE(r->job->matte_policy),
                                     GLINT_ARG_VALUE(salt)};
    return glint_run_launch(r, kernel, n, args, sizeof args / sizeof *args);
}

glint_status glint_run_deposit_paths(struct glint_run *r, glint_buffer *tables, uint32_t n)
{
    const uint32_t stride = GLINT_WAVE_STRIDE, pixels = 1u << r->pixels_log2;
    const uint32_t salt = salt_of(r, 0);
    const struct glint_arg args[] = {GLINT_ARG_BUFFER(r->wave->columns),
                                     GLINT_ARG_VALUE(stride),
                                     GLINT_ARG_VALUE(n),
                                     GLINT_ARG_VALUE(pixels),
                                     GLINT_ARG_BUFFER(tables),
                                     GLINT_ARG_VALUE(r->job->matte_slots),
                                     GLINT_ARG_VALUE(r->job->matte_policy),
                                     GLINT_ARG_VALUE(salt)};
    return glint_run_launch(r, "deposit_carried", r->job->matte_shared ? n : 1, args,
                            sizeof args / sizeof *args);
}

static uint64_t *film_table(const struct glint_film_tile *at)
{
    return (uint64_t *)glint_buffer_host(at->tables) + at->tables_offset;
}

void glint_run_fetch_slots(const struct glint_run *r, const struct glint_film_tile *at,
                           uint32_t lane)
{
    const uint32_t *key = (const uint32_t *)glint_buffer_host(r->wave->columns) +
                          (size_t)GK_COL_KEY * GLINT_WAVE_STRIDE + lane;
    const uint32_t slots = r->job->matte_slots;
    const uint32_t words = gk_matte_words(slots, r->job->matte_policy);
    const uint64_t *table = film_table(at);
    for (uint32_t i = 0; i < GK_TILE_PIXELS; i++, table += words)
        __builtin_prefetch(table + gk_matte_start(key[i], slots), 1);
}

static char *copy_of(const struct glint_run *r, uint32_t tile_in_block)
{
    return (char *)glint_buffer_host(r->wave->tables) + tile_in_block * table_bytes(r);
}

static glint_status copy_in(struct glint_run *r, const struct glint_film_tile *at,
                            uint32_t tile_in_block)
{
    memcpy(copy_of(r, tile_in_block), film_table(at), table_bytes(r));
    return GLINT_OK;
}

static glint_status copy_out(struct glint_run *r, const struct glint_film_tile *at,
                             uint32_t tile_in_block)
{
    memcpy(film_table(at), copy_of(r, tile_in_block), table_bytes(r));
    return GLINT_OK;
}

static glint_status make_room(struct glint_run *r)
{
    glint_wave *w = r->wave;
    const size_t tiles = GLINT_WAVE_LANES / GK_TILE_PIXELS;
    const size_t rows = r->job->matte_rows;
    glint_status st = GLINT_OK;
    if (!w->tables)
        st = glint_buffer_create(&w->tables, w->devices, tiles * table_bytes(r), r->err);
    if (!st && rows && !w->met)
        st = glint_buffer_create(&w->met, w->devices, rows * GLINT_WAVE_STRIDE * 4, r->err);
    return st;
}

glint_status glint_carried_begin(struct glint_run *r)
{
    if (!r->job->matte_through)
        return GLINT_OK;
    const glint_status st = make_room(r);
    if (st)
        return st;
    if (r->job->matte_rows)
        memset(glint_buffer_host(r->wave->met), 0, r->lanes * 4);
    return glint_run_tiles(r, copy_in);
}

static void count_excess(struct glint_run *r)
{
    const uint32_t *excess = (const uint32_t *)glint_buffer_host(r->wave->columns) +
                             (size_t)GK_COL_EXCESS * GLINT_WAVE_STRIDE;
    uint64_t sum = 0;
    for (uint32_t i = 0; i < r->holding; i++)
        sum += excess[i];
    r->clamped += sum;
}

static glint_status deposit_first(struct glint_run *r, const struct glint_film_tile *at,
                                  uint32_t tile_in_block)
{
    (void)at;
    const struct glint_film_tile copy = {
        .tables = r->wave->tables, .tables_offset = (uint32_t)(tile_in_block * table_bytes(r) / 8)};
    return glint_run_deposit_pixels(r, "deposit_first", &copy, GK_TILE_PIXELS,
                                    tile_in_block * GK_TILE_PIXELS);
}

glint_status glint_carried_forget(struct glint_run *r, glint_buffer *list, uint32_t n)
{
    const uint32_t stride = GLINT_WAVE_STRIDE;
    const struct glint_arg args[] = {GLINT_ARG_BUFFER(r->wave->columns), GLINT_ARG_VALUE(stride),
                                     GLINT_ARG_VALUE(n), GLINT_ARG_BUFFER(list),
                                     GLINT_ARG_VALUE(r->job->matte_rows)};
    return glint_run_launch(r, "forget_repeated", n, args, sizeof args / sizeof *args);
}

glint_status glint_carried_deposit(struct glint_run *r)
{
    if (r->holding == 0)
        return GLINT_OK;
    const bool whole = r->bounce == 0 && r->holding == r->lanes;
    glint_status st = GLINT_OK;
    if (r->job->matte_rows)
        st = glint_carried_forget(r, r->wave->met, r->holding);
    if (!st)
        st = whole ? glint_run_tiles(r, deposit_first)
                   : glint_run_deposit_paths(r, r->wave->tables, r->holding);
    if (r->bounce > 0) // what a camera ray brings has no weight yet
        count_excess(r);
    glint_run_charge(r, GLINT_PASS_CARRIED);
    return st;
}

glint_status glint_carried_end(struct glint_run *r)
{
    return r->job->matte_through ? glint_run_tiles(r, copy_out) : GLINT_OK;
}
