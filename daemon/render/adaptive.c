#include "render/adaptive.h"

#include "kernels/gk_film.h"
#include "render/order.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PASS GLINT_PILOT_SAMPLES
#define EVEN 0.25    // of the samples
#define STEEPEST 8.0 // share of a tile, over that of the mean one
#define SHARES 26    // 'a' to 'z'

bool glint_adaptive_goes(const glint_render *r)
{
    return r->share != NULL;
}

static uint32_t columns_of(const glint_render *r)
{
    return (r->job.region[2] + GK_TILE_SIDE - 1) / GK_TILE_SIDE;
}

static uint32_t tiles_of(const glint_render *r)
{
    return columns_of(r) * ((r->job.region[3] + GK_TILE_SIDE - 1) / GK_TILE_SIDE);
}

static double pixels_of(const glint_render *r, uint32_t tile)
{
    const uint32_t x = tile % columns_of(r) * GK_TILE_SIDE, y = tile / columns_of(r) * GK_TILE_SIDE;
    return (double)glint_pass_clip(x, GK_TILE_SIDE, r->job.region[2]) *
           glint_pass_clip(y, GK_TILE_SIDE, r->job.region[3]);
}

// ---- the shares

static double deviation(const glint_render *r, uint32_t tile)
{
    return sqrt(r->tile_estimate[tile].relative / pixels_of(r, tile));
}

static char letter(double part, double mean)
{
    const double wanted = mean > 0.0 ? EVEN + (1.0 - EVEN) * part / mean : 1.0;
    return (char)('a' + (int)fmin(fmax(ceil(SHARES * wanted / STEEPEST), 1.0), SHARES) - 1);
}

static uint32_t share_of(const glint_render *r, uint32_t tile)
{
    return (uint32_t)(r->share[tile] - 'a') + 1;
}

static void find_most(glint_render *r)
{
    r->most = 1;
    for (uint32_t t = 0; t < tiles_of(r); t++)
        r->most = share_of(r, t) > r->most ? share_of(r, t) : r->most;
}

void glint_adaptive_decide(glint_render *r)
{
    const uint32_t tiles = tiles_of(r);
    double sum = 0.0;
    for (uint32_t t = 0; t < tiles; t++)
        sum += deviation(r, t) * pixels_of(r, t);
    for (uint32_t t = 0; t < tiles; t++)
        r->shares[t] = letter(deviation(r, t), sum / (double)glint_render_pixels(r));
    r->share = r->shares;
    find_most(r);
    glint_render_measure_nothing(r);
    r->view->epoch = glint_film_restart(r->film);
    r->target = glint_adaptive_target(r, r->job.stop.samples);
}

glint_status glint_adaptive_take(glint_render *r, const char *shares, struct glint_error *err)
{
    const size_t tiles = tiles_of(r);
    if (strlen(shares) != tiles || strspn(shares, "abcdefghijklmnopqrstuvwxyz") != tiles)
        return glint_fail(err, GLINT_E_RANGE, "/moment/shares",
                          "a letter from a to z for each of %zu tiles is expected", tiles);
    if (!r->shares)
        r->shares = calloc(tiles + 1, 1);
    if (!r->shares)
        return glint_fail(err, GLINT_E_NOMEM, "/moment/shares", "no memory for %zu tiles", tiles);
    memcpy(r->shares, shares, tiles);
    r->share = r->shares;
    find_most(r);
    return GLINT_OK;
}

// ---- the passes

static uint32_t pass_of(uint32_t sample)
{
    return (sample - GLINT_PILOT_SAMPLES) / PASS;
}

uint32_t glint_adaptive_taken(const glint_render *r, uint32_t tile, uint32_t sample)
{
    const uint64_t parts = (uint64_t)pass_of(sample) * share_of(r, tile);
    return (uint32_t)((parts + r->most - 1) / r->most) * PASS;
}

double glint_adaptive_mean(const glint_render *r, uint32_t sample)
{
    double sum = 0.0;
    for (uint32_t t = 0; t < tiles_of(r); t++)
        sum += pixels_of(r, t) * glint_adaptive_taken(r, t, sample);
    return GLINT_PILOT_SAMPLES + sum / (double)glint_render_pixels(r);
}

uint32_t glint_adaptive_target(const glint_render *r, uint32_t samples)
{
    uint32_t low = 0, high = GLINT_MAX_SAMPLES / PASS - 1; // passes
    while (low < high) {
        const uint32_t middle = low + (high - low + 1) / 2;
        if (glint_adaptive_mean(r, GLINT_PILOT_SAMPLES + PASS * middle) <= samples)
            low = middle;
        else
            high = middle - 1;
    }
    return GLINT_PILOT_SAMPLES + PASS * low;
}

void glint_adaptive_begin(glint_render *r, uint32_t sample)
{
    struct glint_pass_state *p = &r->pass;
    const uint32_t all = p->blocks;
    p->blocks = 0;
    for (uint32_t b = 0; b < all; b++) {
        uint32_t column, row;
        glint_order_place(p->blocks_wide, p->blocks_high, b, &column, &row);
        const uint32_t tile = row * columns_of(r) + column;
        if (glint_adaptive_taken(r, tile, sample + PASS) > glint_adaptive_taken(r, tile, sample))
            p->list[p->blocks++] = b;
    }
}
