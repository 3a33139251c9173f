// render.c - a render's life: made from a job, asked for slices, run by workers, asked how it is.
#include "render/adaptive.h"
#include "render/archive.h"
#include "render/capture.h"
#include "render/hold.h"
#include "render/order.h"

#include "base/clock.h"
#include "kernels/gk_film.h"

#include <stdlib.h>
#include <string.h>

static uint32_t blocks(uint32_t pixels, uint32_t spread_log2)
{
    const uint32_t side = GK_TILE_SIDE << GLINT_COARSE_LOG2 << spread_log2;
    return (pixels + side - 1) / side;
}

static bool make_coarse(struct glint_render *r)
{
    const uint32_t *region = r->job.region;
    bool ok = true;
    for (uint32_t s = 0; s < GLINT_COARSE_STEPS; s++)
        ok &= (r->order[s] = glint_order_create(blocks(region[2], s), blocks(region[3], s))) != 0;
    r->coarse = calloc(glint_devices_workers(r->devices), sizeof *r->coarse);
    return ok && r->coarse;
}

static glint_status prepare(struct glint_render *r, const struct glint_view_order *order,
                            struct glint_error *err)
{
    glint_status st = glint_view_create(&r->view, r, order, err);
    if (!st)
        st = glint_film_create(&r->film, r->devices, &r->view->plan, &r->job,
                               glint_film_info_slots(&r->view->info), err);
    if (st)
        return st;
    const size_t tiles = (size_t)glint_film_columns(r->film) * glint_film_rows(r->film);
    r->view->film = r->film;
    r->wave = calloc(glint_devices_workers(r->devices), sizeof *r->wave);
    r->tile_estimate = calloc(tiles, sizeof *r->tile_estimate);
    const bool coverage = r->view->info.coverage;
    r->tile_excess = coverage ? calloc(tiles, sizeof *r->tile_excess) : NULL;
    r->pass.redo = calloc(tiles, sizeof *r->pass.redo);
    r->pass.list = r->job.adaptive ? calloc(tiles, sizeof *r->pass.list) : NULL;
    r->shares = r->job.adaptive ? calloc(tiles + 1, 1) : NULL;
    if (!r->wave || !r->tile_estimate || (coverage && !r->tile_excess) || !r->pass.redo ||
        ((order->sketch || glint_pass_coarsens(&r->job)) && !make_coarse(r)) ||
        (r->job.adaptive && (!r->pass.list || !r->shares)))
        return glint_fail(err, GLINT_E_NOMEM, "/resolution", "no memory for %zu tiles", tiles);
    r->target = glint_render_first(r) + r->job.stop.samples;
    glint_render_measure_nothing(r);
    glint_pass_begin(r, glint_render_first(r));
    return GLINT_OK;
}

// *order but for its job, which is the render's copy of `job`.
static glint_status create(glint_render **out, struct glint_devices *devices,
                           const struct glint_job *job, struct glint_view_order *order,
                           struct glint_error *err)
{
    *out = NULL;
    struct glint_render *r = calloc(1, sizeof *r);
    if (!r)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a render");
    pthread_mutex_init(&r->mutex, NULL);
    r->devices = devices;
    glint_status st = glint_job_copy(&r->job, job, err);
    order->job = &r->job;
    if (!st)
        st = prepare(r, order, err);
    if (st)
        glint_render_destroy(&r);
    *out = r;
    return st;
}

glint_status glint_render_create_forced(glint_render **out, struct glint_devices *devices,
                                        struct glint_resident *scene, const struct glint_pose *pose,
                                        const struct glint_job *job, uint64_t force,
                                        struct glint_error *err)
{
    struct glint_view_order order = {.scene = scene, .pose = pose, .force = force};
    return create(out, devices, job, &order, err);
}

glint_status glint_render_create(glint_render **out, struct glint_devices *devices,
                                 struct glint_resident *scene, const struct glint_pose *pose,
                                 const struct glint_job *job, struct glint_error *err)
{
    return glint_render_create_forced(out, devices, scene, pose, job, 0, err);
}

// Films of doubles are for who measures.
bool glint_render_wants_sketch(const struct glint_resident *scene, const struct glint_job *job)
{
    bool robust;
    const enum glint_geometry_kind kind = glint_render_structure(job, &robust);
    return kind == GLINT_GEOMETRY_FLAT && job->dial[GLINT_DIAL_PRECISION] != 0 &&
           glint_resident_is_large(scene) && !glint_resident_has_geometry(scene, kind, robust);
}

glint_status glint_render_sketch(glint_render **out, struct glint_devices *devices,
                                 struct glint_resident *scene, const struct glint_pose *pose,
                                 const struct glint_job *job, struct glint_error *err)
{
    struct glint_view_order order = {
        .scene = scene, .pose = pose, .sketch = glint_render_wants_sketch(scene, job)};
    return create(out, devices, job, &order, err);
}

bool glint_render_is_sketch(const glint_render *render)
{
    struct glint_render *r = (struct glint_render *)render;
    pthread_mutex_lock(&r->mutex);
    const bool is = glint_render_sketches(r);
    pthread_mutex_unlock(&r->mutex);
    return is;
}

glint_status glint_render_move(glint_view **out, glint_render *r, struct glint_resident *scene,
                               const struct glint_pose *pose, const struct glint_job *job,
                               struct glint_error *err)
{
    struct glint_view *now = glint_view_hold(r);
    const struct glint_view_order order = {.scene = scene, .pose = pose, .job = job, .like = now};
    const glint_status st = glint_view_create(out, r, &order, err);
    if (!st)
        (*out)->film = r->film;
    glint_view_release(&now);
    return st;
}

void glint_render_forget(glint_render *r)
{
    r->view->epoch = glint_film_restart(r->film);
    r->target = glint_render_first(r) + r->job.stop.samples;
    r->stopped = false;
    r->share = NULL;
    glint_render_measure_nothing(r);
    glint_pass_restart(r);
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
    if (old->sketch) // a film's counts are of its own samples
        r->stats = (struct glint_wave_stats){0};
    atomic_store_explicit(&r->interrupted, false, memory_order_relaxed);
    glint_render_forget(r);
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
    for (uint32_t w = 0; r->coarse && w < glint_devices_workers(r->devices); w++)
        glint_film_destroy(&r->coarse[w]);
    free(r->wave);
    free(r->coarse);
    glint_archive_close(&r->archive);
    free(r->tile_estimate);
    free(r->tile_excess);
    free(r->pass.redo);
    for (uint32_t s = 0; s < GLINT_COARSE_STEPS; s++)
        free(r->order[s]);
    free(r->pass.list);
    free(r->shares);
    glint_film_destroy(&r->film);
    glint_view_release(&r->view);
    glint_arena_finish(&r->job.arena);
    pthread_mutex_destroy(&r->mutex);
    free(r);
}

static void measure_block(glint_render *r, const struct glint_wave_block *b)
{
    const uint32_t samples = glint_pass_count(r, b->sample + b->samples);
    const uint32_t columns = glint_film_columns(r->film), rows = glint_film_rows(r->film);
    const uint32_t side = 1u << b->tiles_log2;
    for (uint32_t y = b->row; y < b->row + side && y < rows; y++)
        for (uint32_t x = b->column; x < b->column + side && x < columns; x++) {
            if (samples >= 2)
                glint_render_measure(r, y * columns + x, samples);
            glint_render_measure_ranks(r, y * columns + x, samples);
        }
}

static double add_seconds(double sum[GLINT_PASSES], const struct glint_wave_stats *now,
                          const struct glint_wave_stats *before)
{
    double all = 0.0;
    for (int p = 0; p < GLINT_PASSES; p++) {
        sum[p] += now->seconds[p] - before->seconds[p];
        all += now->seconds[p] - before->seconds[p];
    }
    return all;
}

static void add_counts(uint64_t sum[GLINT_COUNTS], const struct glint_wave_stats *now,
                       const struct glint_wave_stats *before)
{
    for (int i = 0; i < GLINT_COUNTS; i++)
        sum[i] += now->count[i] - before->count[i];
}

// captures: those begun when the slice's pixels were about to change. What has begun since has
// them.
static void add_stats(struct glint_render *r, const struct glint_wave_stats *now,
                      const struct glint_wave_stats *before, uint32_t captures)
{
    pthread_mutex_lock(&r->mutex);
    r->worker_seconds += add_seconds(r->stats.seconds, now, before);
    r->stats.camera_rays += now->camera_rays - before->camera_rays;
    r->stats.bounce_rays += now->bounce_rays - before->bounce_rays;
    r->stats.shadow_rays += now->shadow_rays - before->shadow_rays;
    add_counts(r->stats.count, now, before);
    if (r->late && captures < r->captures) {
        struct glint_film_moment *m = &r->late->moment;
        m->worker_seconds += add_seconds(r->late->seconds, now, before);
        m->camera_rays += now->camera_rays - before->camera_rays;
        m->bounce_rays += now->bounce_rays - before->bounce_rays;
        m->shadow_rays += now->shadow_rays - before->shadow_rays;
        add_counts(m->count, now, before);
    }
    pthread_mutex_unlock(&r->mutex);
}

static struct glint_wave_block block_of(const glint_render *r, const struct glint_slice *s)
{
    const uint32_t *region = r->job.region;
    return (struct glint_wave_block){.x = s->x,
                                     .y = s->y,
                                     .x_end = region[0] + region[2],
                                     .y_end = region[1] + region[3],
                                     .column = (s->x - region[0]) / GK_TILE_SIDE,
                                     .row = (s->y - region[1]) / GK_TILE_SIDE,
                                     .tiles_log2 = s->tiles_log2,
                                     .sample = s->sample,
                                     .samples = s->samples,
                                     .hold = s->hold};
}

static glint_status run_whole(glint_render *r, struct glint_worker *worker,
                              const struct glint_slice *s, uint32_t *captures,
                              struct glint_error *err)
{
    const struct glint_wave_block block = block_of(r, s);
    const uint32_t side = 1u << block.tiles_log2;
    *captures = glint_film_prepare(r->film, block.column, block.row, side, side);
    const glint_status st = glint_wave_run(r->wave[glint_worker_index(worker)], worker,
                                           &r->view->wave_job, &block, r->film, err);
    if (!st)
        measure_block(r, &block);
    return st;
}

static glint_status get_coarse(glint_render *r, glint_film **film, struct glint_error *err)
{
    struct glint_job small = r->job; // borrows
    small.region[2] = small.region[3] = GK_TILE_SIDE << GLINT_COARSE_LOG2;
    glint_status st = GLINT_OK;
    if (!*film)
        st = glint_film_create(film, r->devices, &r->view->plan, &small,
                               glint_film_info_slots(&r->view->info), err);
    if (!st)
        glint_film_clear(*film);
    return st;
}

static glint_status run_coarse(glint_render *r, struct glint_worker *worker,
                               const struct glint_slice *s, uint32_t *captures,
                               struct glint_error *err)
{
    const uint32_t w = glint_worker_index(worker), side = 1u << s->tiles_log2;
    const struct glint_wave_block block = block_of(r, s);
    const bool coarser = s->step < 1u << GLINT_COARSEST_LOG2;
    struct glint_wave_block small = block;
    small.column = small.row = 0;
    small.tiles_log2 = GLINT_COARSE_LOG2;
    small.spread_log2 = s->tiles_log2 - GLINT_COARSE_LOG2;
    small.coarser = coarser;
    *captures = glint_film_prepare_coarse(r->film, block.column, block.row, side, side);
    glint_status st = get_coarse(r, &r->coarse[w], err);
    if (!st)
        st = glint_wave_run(r->wave[w], worker, &r->view->wave_job, &small, r->coarse[w], err);
    if (!st)
        glint_film_spread(r->film, block.column, block.row, r->coarse[w], s->step, coarser);
    return st;
}

glint_status glint_render_run(glint_render *r, struct glint_worker *worker,
                              const struct glint_slice *s, struct glint_error *err)
{
    glint_wave **wave = &r->wave[glint_worker_index(worker)];
    if (!glint_hold_take(s->hold))
        return GLINT_E_BUSY;
    glint_status st = *wave ? GLINT_OK : glint_wave_create(wave, r->devices, err);
    if (st)
        return st;
    const struct glint_wave_stats before = *glint_wave_stats(*wave);
    uint32_t captures;
    st = s->step ? run_coarse(r, worker, s, &captures, err)
                 : run_whole(r, worker, s, &captures, err);
    if (!glint_hold_is_revoked(s->hold))
        add_stats(r, glint_wave_stats(*wave), &before, captures);
    return st;
}

void glint_render_moment(const glint_render *r, struct glint_film_moment *out)
{
    memset(out, 0, sizeof *out);
    out->complete = r->pass.samples == 0;
    out->stopped = r->stopped;
    out->sample = r->pass.sample;
    out->samples = r->pass.samples;
    out->tiles_log2 = r->pass.tiles_log2 - r->pass.spread_log2; // films hold whole samples
    out->target = r->target;
    out->estimate = r->estimate.whole;
    out->worker_seconds = r->worker_seconds;
    out->camera_rays = r->stats.camera_rays;
    out->bounce_rays = r->stats.bounce_rays;
    out->shadow_rays = r->stats.shadow_rays;
    out->biases = r->view ? r->view->plan.biases : glint_archive_biases(r->archive);
    memcpy(out->count, r->stats.count, sizeof out->count);
    out->excess = r->excess;
    out->shares = r->share;
    out->points = r->points;
    memcpy(out->curve, r->curve, sizeof out->curve);
}

// Samples of a pixel before those of the pass from `sample` on, of an adaptive job in the mean.
static double samples_before(const glint_render *r, uint32_t sample)
{
    return glint_adaptive_goes(r) ? glint_adaptive_mean(r, sample) : sample - glint_render_first(r);
}

void glint_render_state(const glint_render *render, struct glint_render_state *out)
{
    struct glint_render *r = (struct glint_render *)render;
    struct glint_film_moment now;
    pthread_mutex_lock(&r->mutex);
    const struct glint_pass_state *p = &r->pass;
    const double partly = p->blocks && !glint_render_sketches(r) ? glint_pass_share(p) : 0.0;
    const double before = samples_before(r, p->sample);
    const double after = samples_before(r, p->sample + p->samples);
    glint_render_moment(r, &now);
    const struct glint_forecast forecast = r->forecast;
    pthread_mutex_unlock(&r->mutex);
    const double spent = before + partly * (after - before);
    const uint32_t target =
        r->job.adaptive ? r->job.stop.samples : now.target - glint_render_first(r);
    *out = (struct glint_render_state){.samples = (uint32_t)before,
                                       .target_samples = target,
                                       .progress = now.complete || !target ? 1.0 : spent / target,
                                       .estimate = now.estimate,
                                       .forecast = forecast,
                                       .worker_seconds = now.worker_seconds,
                                       .biases = now.biases,
                                       .camera_rays = now.camera_rays,
                                       .bounce_rays = now.bounce_rays,
                                       .shadow_rays = now.shadow_rays,
                                       .excess = now.excess};
    memcpy(out->count, now.count, sizeof out->count);
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
    if (r->archive)
        return glint_archive_plan(r->archive);
    pthread_mutex_lock(&r->mutex);
    memcpy(seconds, r->stats.seconds, sizeof seconds);
    pthread_mutex_unlock(&r->mutex);
    struct glint_view *view = glint_view_hold(r);
    const struct glint_plan_use use = {view->scene, &view->job, seconds, glint_render_pixels(r)};
    cJSON *plan = glint_plan_describe(&view->plan, &use);
    glint_view_release(&view);
    return plan;
}
