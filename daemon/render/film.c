#include "render/film_parts.h"

#include "kernels/gk_film.h"
#include "kernels/gk_matte.h"

#include <stdlib.h>
#include <string.h>

#define BUFFER_BYTES ((size_t)1 << 30)

static uint32_t smaller(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

// Of a tile whose memory is zero.
static void clear_depth(const glint_film *f, uint32_t tile)
{
    struct glint_film_tile at;
    if (!f->aovs)
        return;
    glint_film_tile(f, tile, &at);
    float *depth = (float *)glint_buffer_host(at.planes) + at.planes_offset +
                   (GK_PLANES_BASE + GK_AOV_DEPTH) * GK_TILE_PIXELS;
    for (int i = 0; i < GK_TILE_PIXELS; i++)
        depth[i] = 1e30f;
}

void glint_film_clear_tile(const glint_film *f, uint32_t tile)
{
    struct glint_film_tile at;
    glint_film_tile(f, tile, &at);
    memset((uint32_t *)glint_buffer_host(at.planes) + at.planes_offset, 0,
           (size_t)f->tile_words * 4);
    if (at.tables)
        memset((uint64_t *)glint_buffer_host(at.tables) + at.tables_offset, 0,
               (size_t)f->tile_slots * 8);
    clear_depth(f, tile);
}

static glint_status allocate(glint_film *f, glint_devices *devices, uint32_t tiles,
                             struct glint_error *err)
{
    glint_status st = GLINT_OK;
    for (uint32_t b = 0; !st && b < f->buffers; b++) {
        const size_t n = smaller(f->tiles_per_buffer, tiles - b * f->tiles_per_buffer);
        st = glint_buffer_create(&f->planes[b], devices, n * f->tile_words * 4, err);
        if (!st && f->tile_slots)
            st = glint_buffer_create(&f->tables[b], devices, n * f->tile_slots * 8, err);
    }
    return st;
}

glint_status glint_film_create(glint_film **out, glint_devices *devices,
                               const struct glint_plan *plan, const struct glint_job *job,
                               uint32_t slots, struct glint_error *err)
{
    *out = NULL;
    glint_film *f = calloc(1, sizeof *f);
    if (!f)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a film");
    const bool aovs = glint_plan_has(plan, GLINT_PASS_AOVS);
    const bool flow = plan->on & glint_effect_bit("motion vectors");
    const bool coverage = glint_plan_has(plan, GLINT_PASS_COVERAGE);
    const bool batches = glint_plan_has(plan, GLINT_PASS_BATCHES);
    f->aovs = aovs;
    f->columns = (job->region[2] + GK_TILE_SIDE - 1) / GK_TILE_SIDE;
    f->rows = (job->region[3] + GK_TILE_SIDE - 1) / GK_TILE_SIDE;
    f->batch_words = (GK_PLANES_BASE + (aovs ? GK_PLANES_AOV : 0) + (flow ? GK_PLANES_FLOW : 0)) *
                     GK_TILE_PIXELS;
    f->tile_words = f->batch_words + (batches ? GK_PLANES_BATCHES * GK_TILE_PIXELS : 0);
    f->tile_slots =
        coverage ? gk_matte_words(slots, job->dial[GLINT_DIAL_EVICTION]) * GK_TILE_PIXELS : 0;
    f->shared_words =
        job->dial[GLINT_DIAL_EVICTION] == GLINT_EVICTION_SPILL ? GK_MATTE_SPILL_WORDS : 0;
    const size_t largest = f->tile_slots * (size_t)8 > f->tile_words * (size_t)4
                               ? f->tile_slots * (size_t)8
                               : f->tile_words * (size_t)4;
    const uint32_t tiles = f->columns * f->rows;
    f->tiles_per_buffer = (uint32_t)(BUFFER_BYTES / largest);
    f->buffers = (tiles + f->tiles_per_buffer - 1) / f->tiles_per_buffer;
    f->planes = calloc(f->buffers, sizeof *f->planes);
    f->tables = calloc(f->buffers, sizeof *f->tables);
    f->tile = calloc(tiles, sizeof *f->tile);
    pthread_mutex_init(&f->mutex, NULL);
    pthread_mutex_init(&f->capture, NULL);
    pthread_cond_init(&f->changed, NULL);
    glint_status st =
        f->planes && f->tables && f->tile
            ? allocate(f, devices, tiles, err)
            : glint_fail(err, GLINT_E_NOMEM, "/resolution", "no memory for %u tiles", tiles);
    if (st) {
        glint_film_destroy(&f);
        return st;
    }
    for (uint32_t t = 0; t < tiles; t++)
        f->tile[t].epoch = GLINT_NO_EPOCH;
    *out = f;
    return GLINT_OK;
}

void glint_film_destroy(glint_film **film)
{
    glint_film *f = *film;
    *film = NULL;
    if (!f)
        return;
    for (uint32_t b = 0; b < f->buffers; b++) {
        if (f->planes)
            glint_buffer_destroy(&f->planes[b]);
        if (f->tables)
            glint_buffer_destroy(&f->tables[b]);
    }
    free(f->planes);
    free(f->tables);
    free(f->tile);
    pthread_cond_destroy(&f->changed);
    pthread_mutex_destroy(&f->capture);
    pthread_mutex_destroy(&f->mutex);
    free(f);
}

uint32_t glint_film_columns(const glint_film *f)
{
    return f->columns;
}

uint32_t glint_film_rows(const glint_film *f)
{
    return f->rows;
}

size_t glint_film_tile_bytes(const glint_film *f)
{
    return (size_t)f->tile_words * 4 + (size_t)f->tile_slots * 8;
}

void glint_film_copy(const glint_film *f, uint32_t tile, uint32_t *out)
{
    struct glint_film_tile at;
    glint_film_tile(f, tile, &at);
    memcpy(out, (uint32_t *)glint_buffer_host(at.planes) + at.planes_offset,
           (size_t)f->tile_words * 4);
    if (at.tables)
        memcpy(out + f->tile_words, (uint64_t *)glint_buffer_host(at.tables) + at.tables_offset,
               (size_t)f->tile_slots * 8);
}

void glint_film_tile(const glint_film *f, uint32_t tile, struct glint_film_tile *out)
{
    const uint32_t b = tile / f->tiles_per_buffer, i = tile % f->tiles_per_buffer;
    out->planes = f->planes[b];
    out->planes_offset = i * f->tile_words;
    out->batches_offset = out->planes_offset + f->batch_words;
    out->tables = f->tables[b];
    out->tables_offset = i * f->tile_slots;
}

void glint_film_hold(glint_film *f, uint32_t column, uint32_t row, uint32_t w, uint32_t h)
{
    const uint32_t right = smaller(column + w, f->columns), bottom = smaller(row + h, f->rows);
    pthread_mutex_lock(&f->mutex);
    for (uint32_t y = row; y < bottom; y++)
        for (uint32_t x = column; x < right; x++) {
            struct glint_tile *t = &f->tile[y * f->columns + x];
            while (t->readers)
                pthread_cond_wait(&f->changed, &f->mutex);
            t->held = true;
        }
    pthread_mutex_unlock(&f->mutex);
}

static void release(glint_film *f, const uint32_t block[4], struct glint_film_state now)
{
    const uint32_t right = smaller(block[0] + block[2], f->columns);
    const uint32_t bottom = smaller(block[1] + block[3], f->rows);
    pthread_mutex_lock(&f->mutex);
    f->sequence += now.samples || now.step;
    for (uint32_t y = block[1]; y < bottom; y++)
        for (uint32_t x = block[0]; x < right; x++) {
            struct glint_tile *t = &f->tile[y * f->columns + x];
            t->held = t->written = false;
            glint_film_capture_late(f, t);
            if (now.samples || now.step) {
                t->samples = now.samples;
                t->step = (uint8_t)now.step;
                t->version = f->sequence;
            }
        }
    pthread_cond_broadcast(&f->changed);
    pthread_mutex_unlock(&f->mutex);
}

void glint_film_release(glint_film *f, uint32_t column, uint32_t row, uint32_t w, uint32_t h,
                        uint32_t samples)
{
    release(f, (const uint32_t[4]){column, row, w, h}, (struct glint_film_state){samples, 0});
}

void glint_film_release_coarse(glint_film *f, uint32_t column, uint32_t row, uint32_t w, uint32_t h,
                               uint32_t step)
{
    release(f, (const uint32_t[4]){column, row, w, h}, (struct glint_film_state){0, step});
}

// Whether the held tile has to be emptied, which the caller does.
static bool outdated(glint_film *f, uint32_t tile)
{
    pthread_mutex_lock(&f->mutex);
    struct glint_tile *t = &f->tile[tile];
    const bool old = t->epoch != f->epoch;
    t->samples = old ? 0 : t->samples;
    t->step = old ? 0 : t->step;
    t->epoch = f->epoch;
    pthread_mutex_unlock(&f->mutex);
    return old;
}

static uint32_t prepare(glint_film *f, const uint32_t block[4], bool empty)
{
    const uint32_t right = smaller(block[0] + block[2], f->columns);
    const uint32_t bottom = smaller(block[1] + block[3], f->rows);
    const uint32_t captures = glint_film_capture_before_write(f, block[0], block[1], right, bottom);
    for (uint32_t y = block[1]; y < bottom; y++)
        for (uint32_t x = block[0]; x < right; x++)
            if (outdated(f, y * f->columns + x) && empty)
                glint_film_clear_tile(f, y * f->columns + x);
    return captures;
}

uint32_t glint_film_prepare(glint_film *f, uint32_t column, uint32_t row, uint32_t w, uint32_t h)
{
    return prepare(f, (const uint32_t[4]){column, row, w, h}, true);
}

uint32_t glint_film_prepare_coarse(glint_film *f, uint32_t column, uint32_t row, uint32_t w,
                                   uint32_t h)
{
    return prepare(f, (const uint32_t[4]){column, row, w, h}, false);
}

void glint_film_put(glint_film *f, uint32_t tile, const uint32_t *memory, uint32_t samples)
{
    struct glint_film_tile at;
    glint_film_tile(f, tile, &at);
    memcpy((uint32_t *)glint_buffer_host(at.planes) + at.planes_offset, memory,
           (size_t)f->tile_words * 4);
    if (at.tables)
        memcpy((uint64_t *)glint_buffer_host(at.tables) + at.tables_offset, memory + f->tile_words,
               (size_t)f->tile_slots * 8);
    pthread_mutex_lock(&f->mutex);
    f->tile[tile].samples = samples;
    f->tile[tile].step = 0;
    f->tile[tile].epoch = f->epoch;
    f->tile[tile].version = ++f->sequence;
    pthread_mutex_unlock(&f->mutex);
}

uint32_t glint_film_restart(glint_film *f)
{
    pthread_mutex_lock(&f->mutex);
    const uint32_t epoch = ++f->epoch;
    pthread_mutex_unlock(&f->mutex);
    return epoch;
}

struct glint_film_state glint_film_read_begin(glint_film *f, uint32_t tile, uint32_t epoch)
{
    pthread_mutex_lock(&f->mutex);
    while (f->tile[tile].held)
        pthread_cond_wait(&f->changed, &f->mutex);
    f->tile[tile].readers++;
    const struct glint_film_state state = glint_tile_state(&f->tile[tile], epoch);
    pthread_mutex_unlock(&f->mutex);
    return state;
}

void glint_film_read_end(glint_film *f, uint32_t tile)
{
    pthread_mutex_lock(&f->mutex);
    f->tile[tile].readers--;
    pthread_cond_broadcast(&f->changed);
    pthread_mutex_unlock(&f->mutex);
}

uint32_t glint_film_samples(glint_film *f, uint32_t tile)
{
    pthread_mutex_lock(&f->mutex);
    const uint32_t samples = glint_tile_state(&f->tile[tile], f->epoch).samples;
    pthread_mutex_unlock(&f->mutex);
    return samples;
}

uint64_t glint_film_newest(glint_film *f)
{
    pthread_mutex_lock(&f->mutex);
    const uint64_t sequence = f->sequence;
    pthread_mutex_unlock(&f->mutex);
    return sequence;
}

uint64_t glint_film_version(glint_film *f, uint32_t column, uint32_t row, uint32_t w, uint32_t h)
{
    const uint32_t right = smaller(column + w, f->columns), bottom = smaller(row + h, f->rows);
    uint64_t newest = 0, coarse = 0;
    bool all = true;
    pthread_mutex_lock(&f->mutex);
    for (uint32_t y = row; y < bottom; y++)
        for (uint32_t x = column; x < right; x++) {
            const struct glint_tile *t = &f->tile[y * f->columns + x];
            const struct glint_film_state state = glint_tile_state(t, f->epoch);
            all &= state.samples || state.step;
            newest = t->version > newest ? t->version : newest;
            coarse = state.step && t->version > coarse ? t->version : coarse;
        }
    pthread_mutex_unlock(&f->mutex);
    return !all ? 0 : coarse ? coarse : newest;
}
