#include "tests/accuracy/replay.h"

#include "kernels/gk_film.h"
#include "kernels/gk_wave.h"
#include "protocol/matte_types.h"
#include "render/wave_parts.h"

#include <stdlib.h>
#include <string.h>

static struct replay *playing;

glint_status __real_glint_run_deposit_pixels(struct glint_run *r, const char *kernel,
                                             const struct glint_film_tile *at, uint32_t n,
                                             uint32_t lane);
glint_status __wrap_glint_run_deposit_pixels(struct glint_run *r, const char *kernel,
                                             const struct glint_film_tile *at, uint32_t n,
                                             uint32_t lane);
glint_status __real_glint_carried_deposit(struct glint_run *r);
glint_status __wrap_glint_carried_deposit(struct glint_run *r);

uint64_t *replay_table(const struct replay *r, size_t setting, uint32_t pixel)
{
    const struct replay_setting *of = &r->setting[setting];
    return r->table + setting * r->pixels * REPLAY_WORDS +
           (size_t)pixel * gk_matte_words(of->slots, of->policy);
}

static void deposit(struct replay *r, uint32_t pixel, uint32_t waits, uint64_t amount,
                    uint32_t random)
{
    const uint32_t key = waits & GK_WAITS_KEY;
    for (size_t s = 0; s < r->settings; s++) {
        const struct replay_setting *of = &r->setting[s];
        uint64_t *table = replay_table(r, s, pixel), *out = table + of->slots;
        struct gk_matte_lost lost = {0, 0};
        if (of->policy == REPLAY_BEST)
            continue;
        if (of->policy == REPLAY_CHAO)
            replay_chao(table, &r->chao[s * r->pixels + pixel], of->slots, key, amount, random,
                        &lost);
        else
            gk_matte_deposit_tile(replay_table(r, s, pixel - pixel % GK_TILE_PIXELS),
                                  pixel % GK_TILE_PIXELS, of->slots, key, waits >> 31, amount,
                                  of->policy, random, &lost);
        out[GK_MATTE_LOST_PRIMARY] += lost.primary;
        out[GK_MATTE_LOST_BOUNCED] += lost.bounced;
    }
    r->exact[(size_t)pixel * r->keys + gk_matte_class(key) * r->mattes +
             (key & GK_MATTE_BASE_KEY)] += amount;
}

// The first pixel of a tile of the block, in the replay's tables.
static uint32_t pixel_of(const struct glint_run *r, uint32_t tile)
{
    const uint32_t log2 = r->block->tiles_log2;
    const uint32_t column = r->block->column + (tile & ((1u << log2) - 1u));
    const uint32_t row = r->block->row + (tile >> log2);
    return (row * playing->columns + column) * GK_TILE_PIXELS;
}

static uint32_t salt_of(const struct glint_run *r, uint32_t lane)
{
    const struct glint_wave_block *b = r->block;
    const uint32_t place = gk_mix32(b->x + gk_mix32(b->y + gk_mix32(lane + r->job->seed)));
    return gk_mix32(place ^ gk_mix32(b->sample + gk_mix32(r->bounce)));
}

glint_status __wrap_glint_run_deposit_pixels(struct glint_run *r, const char *kernel,
                                             const struct glint_film_tile *at, uint32_t n,
                                             uint32_t lane)
{
    const uint32_t stride = GLINT_WAVE_STRIDE;
    const float *wave = glint_buffer_host(r->wave->columns);
    const bool seen = playing && n && strcmp(kernel, "deposit_coverage") == 0;
    const uint32_t first = seen ? pixel_of(r, lane / GK_TILE_PIXELS) : 0;
    for (uint32_t i = 0; seen && i < n; i++)
        for (uint32_t s = 0; s < r->block->samples; s++) {
            const uint32_t from = lane + i + (s << r->pixels_log2);
            const uint32_t key = GK_LOAD_U32(GK_COL_KEY, from);
            if (key)
                deposit(playing, first + i, key | GK_WAITS_DIRECT, GK_MATTE_ONE, salt_of(r, from));
        }
    return __real_glint_run_deposit_pixels(r, kernel, at, n, lane);
}

glint_status __wrap_glint_carried_deposit(struct glint_run *r)
{
    static const uint32_t column[2][2] = {{GK_COL_DEPOSIT0, GK_COL_AMOUNT0},
                                          {GK_COL_DEPOSIT1, GK_COL_AMOUNT1}};
    const uint32_t stride = GLINT_WAVE_STRIDE;
    const float *wave = glint_buffer_host(r->wave->columns);
    for (uint32_t i = 0; playing && i < r->holding; i++) {
        const uint32_t lane = GK_LOAD_U32(GK_COL_LANE, i);
        const uint32_t at = lane & ((1u << r->pixels_log2) - 1u);
        const uint32_t pixel = pixel_of(r, at / GK_TILE_PIXELS) + at % GK_TILE_PIXELS;
        for (uint32_t k = 0; k < 2; k++) {
            const uint32_t waits = GK_LOAD_U32(column[k][0], i);
            const uint32_t amount = GK_LOAD_U32(column[k][1], i);
            if (waits && amount)
                deposit(playing, pixel, waits, amount, gk_mix32(salt_of(r, 0) ^ (2u * lane + k)));
        }
    }
    return __real_glint_carried_deposit(r);
}

static void make_room(struct replay *r, const struct glint_render *render)
{
    const struct glint_film_info *info = &render->view->info;
    replay_finish(r);
    r->columns = glint_film_info_columns(info);
    r->pixels = r->columns * glint_film_info_rows(info) * GK_TILE_PIXELS;
    r->mattes = info->mattes;
    r->keys = glint_film_info_slots(info);
    r->table = calloc(r->settings * r->pixels, REPLAY_WORDS * sizeof *r->table);
    r->exact = calloc((size_t)r->pixels * r->keys, 8);
    r->chao = calloc(r->settings * r->pixels, 8);
    if (!r->table || !r->exact || !r->chao)
        abort();
}

glint_render *replay_render(struct replay *r, const struct offline *o,
                            const struct glint_posed *scene, const struct glint_job *job)
{
    struct glint_error err = {0};
    glint_render *render;
    if (glint_render_create(&render, o->devices, scene->resident, scene->pose, job, &err))
        offline_die("render", &err);
    make_room(r, render);
    playing = r;
    offline_render(o, render);
    playing = NULL;
    return render;
}

void replay_finish(struct replay *r)
{
    free(r->table);
    free(r->exact);
    free(r->chao);
    r->table = r->exact = r->chao = NULL;
}

// What is seen directly, and of the rest those with most.
static void keep_best(const struct replay *r, uint32_t slots, uint32_t pixel, double *out)
{
    const uint64_t *exact = r->exact + (size_t)pixel * r->keys;
    for (uint32_t k = 0; k < r->mattes; k++) {
        out[k] = (double)exact[k];
        slots -= exact[k] && slots;
    }
    for (; slots > 0; slots--) {
        uint32_t most = r->mattes;
        for (uint32_t k = r->mattes; k < r->keys; k++)
            if (!out[k] && (out[most] || exact[k] > exact[most]))
                most = k;
        if (most == r->keys || out[most])
            break;
        out[most] = (double)exact[most];
    }
    for (uint32_t k = r->mattes; k < r->keys; k++)
        out[r->keys + GK_MATTE_LOST_BOUNCED] += (double)exact[k] - out[k];
}

// What a pixel has in the places of its tile.
static void add_places(const struct replay *r, size_t setting, uint32_t pixel, double *out)
{
    const uint32_t words = gk_matte_words(r->setting[setting].slots, GK_MATTE_SPILL);
    const uint32_t i = pixel % GK_TILE_PIXELS;
    const uint64_t *tables = replay_table(r, setting, pixel - i);
    for (uint32_t n = 0; n < GK_MATTE_SPILL_PLACES; n++) {
        const uint64_t place = tables[gk_matte_spill_at(words, i, n)];
        const uint32_t key = gk_matte_key(place);
        if (place && gk_matte_spilled(place, i, key))
            out[gk_matte_class(key) * r->mattes + (key & GK_MATTE_BASE_KEY)] +=
                (double)gk_matte_amount(gk_matte_spill_slot(place));
    }
}

void replay_kept(const struct replay *r, size_t setting, uint32_t pixel, double *out)
{
    const struct replay_setting *of = &r->setting[setting];
    const uint64_t *table = replay_table(r, setting, pixel);
    uint32_t places = 0;
    memset(out, 0, (r->keys + GK_MATTE_LOST_WORDS) * sizeof *out);
    if (of->policy == REPLAY_BEST) {
        keep_best(r, of->slots, pixel, out);
        return;
    }
    for (uint32_t s = 0; s < of->slots; s++)
        places += !gk_matte_primary(gk_matte_key(table[s]));
    for (uint32_t s = 0; s < of->slots; s++) {
        const uint32_t key = gk_matte_key(table[s]);
        double amount = (double)gk_matte_amount(table[s]);
        if (of->policy == REPLAY_CHAO && !gk_matte_primary(key))
            amount = (double)r->chao[setting * r->pixels + pixel] / places;
        out[gk_matte_class(key) * r->mattes + (key & GK_MATTE_BASE_KEY)] += amount;
    }
    for (uint32_t k = 0; k < GK_MATTE_LOST_WORDS; k++)
        out[r->keys + k] = (double)table[of->slots + k];
    if (of->policy == GK_MATTE_SPILL)
        add_places(r, setting, pixel, out);
}
