#include "render/wave.h"

#include "base/clock.h"
#include "kernels/gk_film.h"
#include "kernels/gk_wave.h"

#include <pthread.h>
#include <stdlib.h>

// Not a power of two, so that columns do not fall on the same cache sets.
#define STRIDE (GLINT_WAVE_LANES + 16u)
#define GROUP 64u // items of a work-group: one vectorised loop

struct glint_wave {
    glint_buffer *columns; // [GK_COLUMNS][STRIDE]
    glint_buffer *rect;    // struct gk_wave_rect
    uint32_t *survivor;    // [GLINT_WAVE_LANES]
    struct glint_wave_stats stats;
};

static void constant_columns(float *columns)
{
    uint32_t *mask = (uint32_t *)columns + (size_t)GK_COL_MASK * STRIDE;
    for (uint32_t i = 0; i < STRIDE; i++)
        mask[i] = UINT32_MAX;
}

glint_status glint_wave_create(glint_wave **out, glint_devices *devices, struct glint_error *err)
{
    *out = NULL;
    glint_wave *w = calloc(1, sizeof *w);
    if (!w)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a wave");
    w->survivor = malloc(GLINT_WAVE_LANES * sizeof *w->survivor);
    glint_status st =
        w->survivor ? GLINT_OK : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a wave");
    if (!st)
        st = glint_buffer_create(&w->columns, devices, (size_t)GK_COLUMNS * STRIDE * 4, err);
    if (!st)
        st = glint_buffer_create(&w->rect, devices, sizeof(struct gk_wave_rect), err);
    if (st) {
        glint_wave_destroy(&w);
        return st;
    }
    constant_columns(glint_buffer_host(w->columns));
    *out = w;
    return GLINT_OK;
}

void glint_wave_destroy(glint_wave **wave)
{
    glint_wave *w = *wave;
    *wave = NULL;
    if (!w)
        return;
    glint_buffer_destroy(&w->columns);
    glint_buffer_destroy(&w->rect);
    free(w->survivor);
    free(w);
}

const struct glint_wave_stats *glint_wave_stats(const glint_wave *wave)
{
    return &wave->stats;
}

// One run: what the steps of the loop hand on.
struct run {
    glint_wave *wave;
    glint_worker *worker;
    const struct glint_wave_job *job;
    const struct glint_wave_block *block;
    struct glint_error *err;
    uint32_t pixels_log2, lanes;
    double mark;    // when the last pass ended
    bool compiling; // over no item, in the largest grid there will be
};

static void charge(struct run *r, enum glint_pass pass)
{
    const double now = glint_now();
    r->wave->stats.seconds[pass] += now - r->mark;
    r->mark = now;
}

#define BUFFER(b)     \
    {                 \
        .buffer = (b) \
    }
#define VALUE(v)                         \
    {                                    \
        .value = &(v), .size = sizeof(v) \
    }

// Kernels do nothing beyond their n, so a grid may be larger. PoCL specialises a kernel for the
// largest grid it has seen; if workers were the first to bring a larger one, each would compile it.
static size_t grid_of(const struct run *r, uint32_t n)
{
    return r->compiling ? GLINT_WAVE_LANES : (n + GROUP - 1) / GROUP * (size_t)GROUP;
}

static glint_status launch(struct run *r, const char *kernel, uint32_t n,
                           const struct glint_arg *args, size_t count)
{
    return glint_launch(r->worker, r->job->program, kernel, grid_of(r, n), GROUP, args, count,
                        r->err);
}

static glint_status generate(struct run *r)
{
    const uint32_t stride = STRIDE;
    struct gk_wave_rect *rect = glint_buffer_host(r->wave->rect);
    *rect = (struct gk_wave_rect){
        r->block->x,          r->block->y,    r->block->x_end,  r->block->y_end,
        r->block->tiles_log2, r->pixels_log2, r->block->sample, r->lanes};
    const struct glint_arg args[] = {BUFFER(r->wave->columns), VALUE(stride), BUFFER(r->job->frame),
                                     BUFFER(r->wave->rect)};
    const glint_status st = launch(r, "generate_camera_rays", r->lanes, args, 4);
    charge(r, GLINT_PASS_GENERATE);
    return st;
}

static glint_status shade(struct run *r, uint32_t n)
{
    const uint32_t stride = STRIDE;
    struct glint_arg args[5 + GLINT_TABLES] = {BUFFER(r->wave->columns), VALUE(stride), VALUE(n),
                                               BUFFER(r->job->frame), BUFFER(r->wave->rect)};
    for (int t = 0; t < GLINT_TABLES; t++)
        args[5 + t].buffer = glint_resident_table(r->job->scene, t);
    const glint_status st = launch(r, "shade_surface", n, args, 5 + GLINT_TABLES);
    charge(r, GLINT_PASS_SHADE);
    return st;
}

static glint_status trace_shadows(struct run *r, uint32_t n)
{
    const uint32_t stride = STRIDE;
    float *columns = glint_buffer_host(r->wave->columns);
    const float *distance = columns + (size_t)GK_COL_ST * STRIDE;
    uint64_t rays = 0;
    for (uint32_t i = 0; i < n; i++)
        rays += distance[i] > 0.0f;
    r->wave->stats.shadow_rays += rays;
    glint_geometry_shadow_wave(r->job->geometry, columns, STRIDE, n);
    charge(r, GLINT_PASS_SHADOW);
    const struct glint_arg args[] = {BUFFER(r->wave->columns), VALUE(stride), VALUE(n)};
    const glint_status st = launch(r, "add_unoccluded", n, args, 3);
    charge(r, GLINT_PASS_UNOCCLUDED);
    return st;
}

// Moves the paths that go on to the front, in order. Returns their number.
static uint32_t compact(struct run *r, uint32_t n)
{
    float *columns = glint_buffer_host(r->wave->columns);
    const float *distance = columns + (size_t)GK_COL_T * STRIDE;
    uint32_t *survivor = r->wave->survivor;
    uint32_t kept = 0;
    for (uint32_t i = 0; i < n; i++) {
        survivor[kept] = i;
        kept += distance[i] > 0.0f;
    }
    if (kept < n)
        for (uint32_t c = 0; c < GK_COL_MOVED; c++) {
            float *column = columns + (size_t)c * STRIDE;
            if (c >= GK_COL_TIME && !(r->job->plan->carries >> c & 1))
                continue;
            for (uint32_t k = 0; k < kept; k++)
                column[k] = column[survivor[k]];
        }
    charge(r, GLINT_PASS_COMPACT);
    return kept;
}

// Relaxed: a bounce sooner or later.
static bool interrupted(const struct run *r)
{
    return r->job->interrupted && atomic_load_explicit(r->job->interrupted, memory_order_relaxed);
}

static glint_status trace_paths(struct run *r)
{
    float *columns = glint_buffer_host(r->wave->columns);
    glint_status st = generate(r);
    uint32_t n = st ? 0 : compact(r, r->lanes);
    r->wave->stats.camera_rays += n;
    while (!st && n > 0) {
        if (interrupted(r))
            return GLINT_E_BUSY;
        glint_geometry_trace_wave(r->job->geometry, columns, STRIDE, n);
        charge(r, GLINT_PASS_TRACE);
        st = shade(r, n);
        if (!st && glint_plan_has(r->job->plan, GLINT_PASS_SHADOW))
            st = trace_shadows(r, n);
        n = compact(r, n);
        r->wave->stats.bounce_rays += n;
    }
    return st;
}

static glint_status accumulate_sample(struct run *r, const struct glint_film_tile *at, uint32_t n,
                                      uint32_t lane, uint32_t sample)
{
    const uint32_t stride = STRIDE, half = sample & 1;
    const struct glint_arg args[] = {
        BUFFER(r->wave->columns), VALUE(stride), VALUE(n), VALUE(lane), BUFFER(at->planes),
        VALUE(at->planes_offset), VALUE(half)};
    glint_status st = launch(r, "accumulate_colour", n, args, 7);
    charge(r, GLINT_PASS_COLOUR);
    if (!st && glint_plan_has(r->job->plan, GLINT_PASS_AOVS)) {
        st = launch(r, "accumulate_aovs", n, args, 6);
        charge(r, GLINT_PASS_AOVS);
    }
    return st;
}

static glint_status deposit_coverage(struct run *r, const struct glint_film_tile *at, uint32_t n,
                                     uint32_t lane)
{
    const uint32_t stride = STRIDE, step = 1u << r->pixels_log2, samples = r->block->samples;
    const struct glint_arg args[] = {BUFFER(r->wave->columns),
                                     VALUE(stride),
                                     VALUE(n),
                                     VALUE(lane),
                                     VALUE(step),
                                     VALUE(samples),
                                     BUFFER(at->tables),
                                     VALUE(at->tables_offset),
                                     VALUE(r->job->matte_slots),
                                     VALUE(r->job->matte_policy)};
    const glint_status st = launch(r, "deposit_coverage", n, args, 10);
    charge(r, GLINT_PASS_COVERAGE);
    return st;
}

static glint_status accumulate_tile(struct run *r, glint_film *film, uint32_t tile_in_block,
                                    uint32_t tile)
{
    struct glint_film_tile at;
    glint_film_tile(film, tile, &at);
    glint_status st = GLINT_OK;
    for (uint32_t s = 0; !st && s < r->block->samples; s++)
        st = accumulate_sample(r, &at, GK_TILE_PIXELS,
                               (s << r->pixels_log2) + tile_in_block * GK_TILE_PIXELS,
                               r->block->sample + s);
    if (!st && glint_plan_has(r->job->plan, GLINT_PASS_COVERAGE))
        st = deposit_coverage(r, &at, GK_TILE_PIXELS, tile_in_block * GK_TILE_PIXELS);
    return st;
}

glint_status glint_wave_run(glint_wave *wave, glint_worker *worker,
                            const struct glint_wave_job *job, const struct glint_wave_block *block,
                            glint_film *film, struct glint_error *err)
{
    struct run r = {wave, worker,      job,  block, err, 8 + 2 * block->tiles_log2,
                    0,    glint_now(), false};
    r.lanes = block->samples << r.pixels_log2;
    glint_status st = trace_paths(&r);
    const uint32_t side = 1u << block->tiles_log2;
    for (uint32_t y = 0; !st && y < side && block->row + y < glint_film_rows(film); y++)
        for (uint32_t x = 0; !st && x < side && block->column + x < glint_film_columns(film); x++)
            st = accumulate_tile(&r, film, y * side + x,
                                 (block->row + y) * glint_film_columns(film) + block->column + x);
    return st;
}

// Launches every kernel of the plan over no item.
static glint_status launch_all(struct run *r)
{
    const uint32_t stride = STRIDE, none = 0;
    const struct glint_arg args[] = {BUFFER(r->wave->columns), VALUE(stride), VALUE(none)};
    const struct glint_film_tile nowhere = {r->wave->columns, 0, r->wave->columns, 0};
    glint_status st = generate(r);
    if (!st)
        st = shade(r, 0);
    if (!st && glint_plan_has(r->job->plan, GLINT_PASS_UNOCCLUDED))
        st = launch(r, "add_unoccluded", 0, args, 3);
    if (!st)
        st = accumulate_sample(r, &nowhere, 0, 0, 0);
    if (!st && glint_plan_has(r->job->plan, GLINT_PASS_COVERAGE))
        st = deposit_coverage(r, &nowhere, 0, 0);
    return st;
}

glint_status glint_wave_compile(glint_devices *devices, const struct glint_wave_job *job,
                                struct glint_error *err)
{
    static pthread_mutex_t one_at_a_time = PTHREAD_MUTEX_INITIALIZER;
    const struct glint_wave_block nothing = {0};
    glint_wave *wave;
    glint_status st = glint_wave_create(&wave, devices, err);
    if (st)
        return st;
    struct run r = {wave, glint_devices_spare(devices), job, &nothing, err, 0, 0, glint_now(),
                    true};
    pthread_mutex_lock(&one_at_a_time);
    st = launch_all(&r);
    pthread_mutex_unlock(&one_at_a_time);
    glint_wave_destroy(&wave);
    return st;
}
