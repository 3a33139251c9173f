// render.c - a render's life: made from a job, asked for slices, run by workers, asked how it is.
#include "render/internal.h"

#include "base/clock.h"
#include "kernels/gk_film.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool wide(const struct glint_render *r)
{
    return r->job.dial[GLINT_DIAL_PRECISION] == 0;
}

// Copies what the render needs of the job; strings other than the name are not used again.
static glint_status copy_job(struct glint_render *r, const struct glint_job *job,
                             struct glint_error *err)
{
    r->job = *job;
    r->name = strdup(job->name ? job->name : "");
    r->job.name = r->name;
    if (!r->name)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a render");
    return GLINT_OK;
}

// A wave holds 64x64 pixels once, 32x32 four times, 16x16 sixteen times. A live job's first sample
// comes in quarters of that, so that several workers make the first tile that is seen.
static uint32_t block_size(const struct glint_render *r, uint32_t samples)
{
    if (samples == 1)
        return r->job.live ? 1 : 2;
    return samples <= 4 ? 1 : 0;
}

static void pass_begin(struct glint_render *r, uint32_t sample)
{
    struct glint_pass_state *p = &r->pass;
    const uint32_t wanted = sample == 0 ? 1 : sample < 4 ? 4 - sample : 16 - sample % 16;
    p->sample = sample;
    p->samples = sample + wanted > r->target ? r->target - sample : wanted;
    p->tiles_log2 = block_size(r, p->samples);
    const uint32_t side = 1u << p->tiles_log2;
    p->blocks_wide = (glint_film_columns(r->film) + side - 1) / side;
    p->blocks_high = (glint_film_rows(r->film) + side - 1) / side;
    p->blocks = p->blocks_wide * p->blocks_high;
    p->next = p->done = p->redos = 0;
}

static glint_status prepare(struct glint_render *r, glint_resident *scene,
                            const struct glint_pose *pose, uint64_t force, struct glint_error *err)
{
    glint_status st = glint_view_create(&r->view, r, scene, pose, &r->job, NULL, force, err);
    if (!st)
        st = glint_film_create(&r->film, r->devices, &r->view->plan, &r->job, err);
    if (st)
        return st;
    const size_t tiles = (size_t)glint_film_columns(r->film) * glint_film_rows(r->film);
    r->view->film = r->film;
    r->wave = calloc(glint_devices_workers(r->devices), sizeof *r->wave);
    r->tile_error = calloc(tiles, sizeof *r->tile_error);
    r->pass.redo = calloc(tiles, sizeof *r->pass.redo);
    if (!r->wave || !r->tile_error || !r->pass.redo)
        return glint_fail(err, GLINT_E_NOMEM, "/resolution", "no memory for %zu tiles", tiles);
    r->target = r->job.stop.samples;
    pass_begin(r, 0);
    return GLINT_OK;
}

glint_status glint_render_create_forced(glint_render **out, struct glint_devices *devices,
                                        struct glint_resident *scene, const struct glint_pose *pose,
                                        const struct glint_job *job, uint64_t force,
                                        struct glint_error *err)
{
    *out = NULL;
    struct glint_render *r = calloc(1, sizeof *r);
    if (!r)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a render");
    pthread_mutex_init(&r->mutex, NULL);
    r->devices = devices;
    glint_status st = copy_job(r, job, err);
    if (!st)
        st = prepare(r, scene, pose, force, err);
    if (st)
        glint_render_destroy(&r);
    *out = r;
    return st;
}

glint_status glint_render_create(glint_render **out, struct glint_devices *devices,
                                 struct glint_resident *scene, const struct glint_pose *pose,
                                 const struct glint_job *job, struct glint_error *err)
{
    return glint_render_create_forced(out, devices, scene, pose, job, 0, err);
}

glint_status glint_render_move(glint_view **out, glint_render *r, struct glint_resident *scene,
                               const struct glint_pose *pose, const struct glint_job *job,
                               struct glint_error *err)
{
    struct glint_view *now = glint_view_hold(r);
    const glint_status st = glint_view_create(out, r, scene, pose, job, now, 0, err);
    if (!st)
        (*out)->film = r->film;
    glint_view_release(&now);
    return st;
}

// What was measured of the old view says nothing of the new one.
static void forget(struct glint_render *r)
{
    const size_t tiles = (size_t)glint_film_columns(r->film) * glint_film_rows(r->film);
    for (size_t t = 0; t < tiles; t++)
        atomic_store_explicit(&r->tile_error[t], 0.0, memory_order_relaxed);
    r->target = r->job.stop.samples;
    r->stopped = false;
    r->points = 0;
}

void glint_render_interrupt(glint_render *r, bool on)
{
    // Relaxed: a hint; nothing depends on when it is seen.
    atomic_store_explicit(&r->interrupted, on, memory_order_relaxed);
}

void glint_render_restart(glint_render *r, glint_view **view)
{
    pthread_mutex_lock(&r->mutex);
    struct glint_view *old = r->view;
    r->view = *view;
    r->view->epoch = glint_film_restart(r->film);
    atomic_store_explicit(&r->interrupted, false, memory_order_relaxed);
    forget(r);
    pass_begin(r, 0);
    pthread_mutex_unlock(&r->mutex);
    *view = old;
}

void glint_render_destroy(glint_render **render)
{
    struct glint_render *r = *render;
    *render = NULL;
    if (!r)
        return;
    for (uint32_t w = 0; r->wave && w < glint_devices_workers(r->devices); w++)
        glint_wave_destroy(&r->wave[w]);
    free(r->wave);
    free(r->tile_error);
    free(r->pass.redo);
    glint_film_destroy(&r->film);
    glint_view_release(&r->view);
    free(r->name);
    pthread_mutex_destroy(&r->mutex);
    free(r);
}

// Blocks go two by two: down, then to the right.
static void block_place(const struct glint_render *r, uint32_t block, uint32_t *column,
                        uint32_t *row)
{
    const struct glint_pass_state *p = &r->pass;
    const uint32_t first = block / (2 * p->blocks_wide) * 2; // of a pair of rows
    const uint32_t high = first + 1 < p->blocks_high ? 2 : 1, i = block - first * p->blocks_wide;
    *column = i / high << p->tiles_log2;
    *row = (first + i % high) << p->tiles_log2;
}

static uint32_t clipped(uint32_t start, uint32_t size, uint32_t end)
{
    return start + size > end ? end - start : size;
}

static void slice_fill(const struct glint_render *r, uint32_t block, struct glint_slice *out)
{
    const uint32_t *region = r->job.region, side = GK_TILE_SIDE << r->pass.tiles_log2;
    uint32_t column, row;
    block_place(r, block, &column, &row);
    out->block = block;
    out->x = region[0] + column * GK_TILE_SIDE;
    out->y = region[1] + row * GK_TILE_SIDE;
    out->w = clipped(out->x, side, region[0] + region[2]);
    out->h = clipped(out->y, side, region[1] + region[3]);
    out->sample = r->pass.sample;
    out->samples = r->pass.samples;
    out->tiles_log2 = r->pass.tiles_log2;
}

bool glint_render_take(glint_render *r, struct glint_slice *out)
{
    pthread_mutex_lock(&r->mutex);
    struct glint_pass_state *p = &r->pass;
    const bool any = p->samples > 0 && (p->redos > 0 || p->next < p->blocks);
    if (any) {
        slice_fill(r, p->redos > 0 ? p->redo[--p->redos] : p->next++, out);
        uint32_t column, row;
        block_place(r, out->block, &column, &row);
        glint_film_hold(r->film, column, row, 1u << p->tiles_log2, 1u << p->tiles_log2);
    }
    pthread_mutex_unlock(&r->mutex);
    return any;
}

static void measure_tiles(struct glint_render *r, const struct glint_slice *s)
{
    const uint32_t column0 = (s->x - r->job.region[0]) / GK_TILE_SIDE;
    const uint32_t row0 = (s->y - r->job.region[1]) / GK_TILE_SIDE;
    for (uint32_t y = 0; y < s->h; y += GK_TILE_SIDE)
        for (uint32_t x = 0; x < s->w; x += GK_TILE_SIDE) {
            const uint32_t tile = (row0 + y / GK_TILE_SIDE) * glint_film_columns(r->film) +
                                  column0 + x / GK_TILE_SIDE;
            struct glint_film_tile at;
            glint_film_tile(r->film, tile, &at);
            const double sum =
                glint_estimate_tile(&at, wide(r), s->sample + s->samples,
                                    clipped(x, GK_TILE_SIDE, s->w), clipped(y, GK_TILE_SIDE, s->h));
            // Relaxed: a reader wants some recent estimate; decisions are taken when no slice is out.
            atomic_store_explicit(&r->tile_error[tile], sum, memory_order_relaxed);
        }
}

static void add_stats(struct glint_render *r, const struct glint_wave_stats *now,
                      const struct glint_wave_stats *before)
{
    pthread_mutex_lock(&r->mutex);
    for (int p = 0; p < GLINT_PASSES; p++) {
        r->stats.seconds[p] += now->seconds[p] - before->seconds[p];
        r->worker_seconds += now->seconds[p] - before->seconds[p];
    }
    r->stats.camera_rays += now->camera_rays - before->camera_rays;
    r->stats.bounce_rays += now->bounce_rays - before->bounce_rays;
    r->stats.shadow_rays += now->shadow_rays - before->shadow_rays;
    pthread_mutex_unlock(&r->mutex);
}

glint_status glint_render_run(glint_render *r, struct glint_worker *worker,
                              const struct glint_slice *s, struct glint_error *err)
{
    glint_wave **wave = &r->wave[glint_worker_index(worker)];
    glint_status st = *wave ? GLINT_OK : glint_wave_create(wave, r->devices, err);
    if (st)
        return st;
    const uint32_t *region = r->job.region;
    const struct glint_wave_block block = {s->x,
                                           s->y,
                                           region[0] + region[2],
                                           region[1] + region[3],
                                           (s->x - region[0]) / GK_TILE_SIDE,
                                           (s->y - region[1]) / GK_TILE_SIDE,
                                           s->tiles_log2,
                                           s->sample,
                                           s->samples};
    const struct glint_wave_stats before = *glint_wave_stats(*wave);
    const uint32_t side = 1u << block.tiles_log2;
    glint_film_prepare(r->film, block.column, block.row, side, side);
    st = glint_wave_run(*wave, worker, &r->view->wave_job, &block, r->film, err);
    if (!st && s->sample + s->samples >= 2)
        measure_tiles(r, s);
    add_stats(r, glint_wave_stats(*wave), &before);
    return st;
}

static uint64_t pixels_of(const struct glint_render *r)
{
    return (uint64_t)r->job.region[2] * r->job.region[3];
}

// In the order of the tiles, so that a decision does not depend on who rendered them.
static double error_now(const struct glint_render *r)
{
    const size_t tiles = (size_t)glint_film_columns(r->film) * glint_film_rows(r->film);
    double sum = 0.0;
    for (size_t t = 0; t < tiles; t++)
        sum += atomic_load_explicit(&r->tile_error[t], memory_order_relaxed);
    return sqrt(sum / (3.0 * (double)pixels_of(r)));
}

static uint64_t rays_of(const struct glint_render *r)
{
    return r->stats.camera_rays + r->stats.bounce_rays + r->stats.shadow_rays;
}

static void record_point(struct glint_render *r, uint32_t samples)
{
    if (samples < 2 || samples & (samples - 1) || r->points == GLINT_CURVE_POINTS)
        return;
    r->curve[r->points++] =
        (struct glint_convergence_point){samples, r->worker_seconds, error_now(r), rays_of(r)};
}

static void pass_end(struct glint_render *r)
{
    const uint32_t samples = r->pass.sample + r->pass.samples;
    record_point(r, samples);
    const double wanted = r->job.stop.error;
    if (wanted > 0.0 && glint_estimate_checkpoint(samples) &&
        glint_estimate_upper(error_now(r), pixels_of(r)) <= wanted) {
        r->target = samples;
        r->stopped = true;
    }
    pass_begin(r, samples);
}

void glint_render_give_back(glint_render *r, const struct glint_slice *s, bool done)
{
    pthread_mutex_lock(&r->mutex);
    uint32_t column, row;
    block_place(r, s->block, &column, &row);
    const uint32_t side = 1u << r->pass.tiles_log2;
    glint_film_release(r->film, column, row, side, side, done ? s->sample + s->samples : 0);
    if (done)
        r->pass.done++;
    else
        r->pass.redo[r->pass.redos++] = s->block;
    if (r->pass.done == r->pass.blocks)
        pass_end(r);
    pthread_mutex_unlock(&r->mutex);
}

bool glint_render_complete(const glint_render *render)
{
    struct glint_render *r = (struct glint_render *)render;
    pthread_mutex_lock(&r->mutex);
    const bool complete = r->pass.samples == 0;
    pthread_mutex_unlock(&r->mutex);
    return complete;
}

// Samples until the error is reached, from the last two points of the curve: error ~ n^-g.
static double predict(const struct glint_render *r)
{
    if (r->job.stop.error <= 0.0 || r->points < 2)
        return NAN;
    const struct glint_convergence_point *a = &r->curve[r->points - 2], *b = a + 1;
    if (!(b->error > 0.0) || !(a->error > b->error))
        return NAN;
    const double slope =
        fmax(log(a->error / b->error) / log((double)b->samples / a->samples), 0.25);
    return b->samples * pow(b->error / r->job.stop.error, 1.0 / slope);
}

void glint_render_state(const glint_render *render, struct glint_render_state *out)
{
    struct glint_render *r = (struct glint_render *)render;
    memset(out, 0, sizeof *out);
    pthread_mutex_lock(&r->mutex);
    const struct glint_pass_state *p = &r->pass;
    out->samples = p->sample;
    out->target_samples = r->target;
    const double partly = p->blocks ? (double)p->done / p->blocks * p->samples : 0.0;
    out->progress = r->target ? (p->sample + partly) / r->target : 1.0;
    out->error = p->sample >= 2 ? error_now(r) : NAN;
    out->worker_seconds = r->worker_seconds;
    out->predicted_samples = predict(r);
    out->camera_rays = r->stats.camera_rays;
    out->bounce_rays = r->stats.bounce_rays;
    out->shadow_rays = r->stats.shadow_rays;
    pthread_mutex_unlock(&r->mutex);
}

size_t glint_render_convergence(const glint_render *render, struct glint_convergence_point *out,
                                size_t capacity)
{
    struct glint_render *r = (struct glint_render *)render;
    pthread_mutex_lock(&r->mutex);
    const size_t n = r->points < capacity ? r->points : capacity;
    memcpy(out, r->curve, n * sizeof *out);
    pthread_mutex_unlock(&r->mutex);
    return n;
}

cJSON *glint_render_plan(const glint_render *render)
{
    struct glint_render *r = (struct glint_render *)render;
    double seconds[GLINT_PASSES];
    pthread_mutex_lock(&r->mutex);
    memcpy(seconds, r->stats.seconds, sizeof seconds);
    pthread_mutex_unlock(&r->mutex);
    struct glint_view *view = glint_view_hold(r);
    const struct glint_plan_use use = {view->scene, &view->job, seconds, pixels_of(r)};
    cJSON *plan = glint_plan_describe(&view->plan, &use);
    glint_view_release(&view);
    return plan;
}
