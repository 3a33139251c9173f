// measure.c - what a render knows of its own error, and of the samples that it still needs.
#include "render/internal.h"

#include "kernels/gk_film.h"
#include "render/adaptive.h"

#include <math.h>
#include <string.h>

void glint_render_measure(glint_render *r, uint32_t tile, uint32_t samples)
{
    const uint32_t *region = r->job.region, columns = glint_film_columns(r->film);
    const uint32_t x = tile % columns * GK_TILE_SIDE, y = tile / columns * GK_TILE_SIDE;
    struct glint_film_tile at;
    if (r->job.estimate == GLINT_ESTIMATE_NONE)
        return;
    glint_film_tile(r->film, tile, &at);
    const float *memory = glint_buffer_host(at.planes);
    const struct glint_estimate_source source = {
        .planes = memory + at.planes_offset,
        .batches = r->job.estimate == GLINT_ESTIMATE_BATCHES ? memory + at.batches_offset : NULL,
        .wide = r->job.dial[GLINT_DIAL_PRECISION] == 0,
        .first = glint_render_first(r),
        .samples = samples};
    glint_estimate_tile(&r->tile_estimate[tile], &source,
                        glint_pass_clip(x, GK_TILE_SIDE, region[2]),
                        glint_pass_clip(y, GK_TILE_SIDE, region[3]));
}

void glint_render_measure_ranks(glint_render *r, uint32_t tile, uint32_t samples)
{
    const struct glint_film_info *info = &r->view->info;
    if (!r->tile_excess)
        return;
    const uint32_t columns = glint_film_columns(r->film), *region = r->job.region;
    const uint32_t x = tile % columns * GK_TILE_SIDE, y = tile / columns * GK_TILE_SIDE;
    const uint32_t size[2] = {glint_pass_clip(x, GK_TILE_SIDE, region[2]),
                              glint_pass_clip(y, GK_TILE_SIDE, region[3])};
    struct glint_film_tile at;
    glint_film_tile(r->film, tile, &at);
    const uint64_t *tables = glint_buffer_host(at.tables);
    const struct glint_film_pixels pixels = {.table = tables + at.tables_offset, .half = {samples}};
    r->tile_excess[tile] = (struct glint_matte_excess){0};
    if (glint_film_excess_add(info, &pixels, size, &r->tile_excess[tile], NULL))
        r->tile_excess[tile] = (struct glint_matte_excess){0}; // without memory nothing is known
}

static struct glint_matte_excess excess_of(const glint_render *r)
{
    struct glint_matte_excess sum = {0};
    const uint32_t tiles = glint_film_columns(r->film) * glint_film_rows(r->film);
    for (uint32_t t = 0; r->tile_excess && t < tiles; t++)
        glint_matte_excess_merge(&sum, &r->tile_excess[t]);
    return sum;
}

// At each power of two, or the first pass that ends behind one, and at 12.
static bool is_checkpoint(const glint_render *r, uint32_t samples)
{
    const uint32_t last = r->points ? r->curve[r->points - 1].samples : 1;
    return samples == 12 || (samples > last && (samples ^ last) > last);
}

static void record_point(glint_render *r, uint32_t samples)
{
    const struct glint_wave_stats *s = &r->stats;
    if (!is_checkpoint(r, samples) || r->points == GLINT_CURVE_POINTS)
        return;
    r->curve[r->points++] =
        (struct glint_convergence_point){.samples = samples,
                                         .seconds = r->worker_seconds,
                                         .error = r->estimate.whole.error,
                                         .spread = r->estimate.whole.spread,
                                         .rays = s->camera_rays + s->bounce_rays + s->shadow_rays};
}

static void record_pace(glint_render *r, double samples)
{
    r->pace[r->paces++ % GLINT_FORECAST_PACES] = (r->worker_seconds - r->pass_seconds) / samples;
    r->pass_seconds = r->worker_seconds;
}

void glint_render_measure_pass(glint_render *r, uint32_t end)
{
    const double now =
        glint_adaptive_goes(r) ? glint_adaptive_mean(r, end) : end - glint_render_first(r);
    const uint32_t samples = (uint32_t)now;
    record_pace(r, now - r->measured);
    r->measured = now;
    r->excess = excess_of(r);
    if (samples < 2 || r->job.estimate == GLINT_ESTIMATE_NONE)
        return;
    glint_estimate_film(&r->estimate, r->tile_estimate, glint_film_columns(r->film),
                        glint_film_rows(r->film), glint_render_pixels(r));
    r->estimated = samples;
    record_point(r, samples);
    glint_render_foresee(r);
}

void glint_render_measure_nothing(glint_render *r)
{
    r->estimate = (struct glint_film_estimate){.whole = {NAN, NAN, NAN, NAN, NAN, NAN}};
    r->forecast = GLINT_NO_FORECAST;
    r->excess = (struct glint_matte_excess){0};
    r->measured = r->job.adaptive && r->share ? GLINT_PILOT_SAMPLES : 0;
    r->points = r->paces = r->estimated = 0;
    r->pass_seconds = r->worker_seconds;
}

// What was chosen by price asks for less than it was asked itself: its noise has the rest.
static double total_wanted(const glint_render *r)
{
    return r->job.budget.error > 0.0 ? hypot(r->job.stop.error, r->job.known_bias)
                                     : r->job.stop.error;
}

double glint_render_noise_wanted(const glint_render *r)
{
    const double total = total_wanted(r), bias = r->job.known_bias;
    return total > bias ? sqrt(total * total - bias * bias) : total;
}

void glint_render_foresee(glint_render *r)
{
    const struct glint_forecast_input in = {
        .curve = r->curve,
        .points = r->points,
        .now = &r->estimate,
        .samples = r->estimated,
        .pace = r->pace,
        .paces = r->paces < GLINT_FORECAST_PACES ? r->paces : GLINT_FORECAST_PACES,
        .target = total_wanted(r),
        .bias = r->job.known_bias,
        .limit = r->job.stop.samples};
    r->forecast = GLINT_NO_FORECAST;
    if (r->job.stop.error > 0.0)
        glint_forecast_make(&r->forecast, &in);
}
