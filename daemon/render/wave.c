#include "render/wave_parts.h"

#include "base/clock.h"
#include "kernels/gk_film.h"
#include "kernels/gk_scene.h"
#include "kernels/gk_wave.h"
#include "render/hold.h"

#include <pthread.h>
#include <stdlib.h>

#define STRIDE GLINT_WAVE_STRIDE
#define GROUP 64u // items of a work-group: one vectorised loop

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
    w->devices = devices;
    glint_compact_init(&w->compact);
    glint_status st =
        glint_buffer_create(&w->columns, devices, (size_t)GK_COLUMNS * STRIDE * 4, err);
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
    glint_buffer_destroy(&w->tables);
    glint_buffer_destroy(&w->met);
    free(w);
}

const struct glint_wave_stats *glint_wave_stats(const glint_wave *wave)
{
    return &wave->stats;
}

void glint_run_charge(struct glint_run *r, enum glint_pass pass)
{
    const double now = glint_now();
    r->wave->stats.seconds[pass] += now - r->mark;
    r->mark = now;
}

#define BUFFER GLINT_ARG_BUFFER
#define VALUE GLINT_ARG_VALUE

// PoCL specialises a kernel for the largest grid it has seen; if workers were the first to bring a
// larger one, each would compile it.
static size_t grid_of(const struct glint_run *r, uint32_t n)
{
    return r->compiling ? GLINT_WAVE_LANES : (n + GROUP - 1) / GROUP * (size_t)GROUP;
}

glint_status glint_run_launch(struct glint_run *r, const char *kernel, uint32_t n,
                              const struct glint_arg *args, size_t count)
{
    return glint_launch(r->worker, r->job->program, kernel, grid_of(r, n), GROUP, args, count,
                        r->err);
}

static glint_status generate(struct glint_run *r)
{
    const uint32_t stride = STRIDE;
    struct gk_wave_rect *rect = glint_buffer_host(r->wave->rect);
    *rect = (struct gk_wave_rect){r->block->x,
                                  r->block->y,
                                  r->block->x_end,
                                  r->block->y_end,
                                  r->block->tiles_log2,
                                  r->pixels_log2,
                                  r->block->sample,
                                  r->block->spread_log2,
                                  r->block->coarser,
                                  r->job->parts_log2,
                                  {0}};
    const struct glint_arg args[] = {BUFFER(r->wave->columns), VALUE(stride), BUFFER(r->job->frame),
                                     BUFFER(r->wave->rect)};
    const glint_status st = glint_run_launch(r, "generate_camera_rays", r->lanes, args, 4);
    glint_run_charge(r, GLINT_PASS_GENERATE);
    return st;
}

// What the caches of a core hold anyway is not worth asking for.
#define FETCHED_BYTES ((size_t)1 << 20)

// Asks for the shading records of the hits, which lie all over memory: the kernel wants them 16 at a
// time, and waits for each 16.
static void fetch_records(const struct glint_run *r, uint32_t n)
{
    const uint32_t *columns = glint_buffer_host(r->wave->columns);
    const uint32_t *primitive = columns + (size_t)GK_COL_PRIMITIVE * STRIDE;
    const uint32_t *geometry = columns + (size_t)GK_COL_GEOMETRY * STRIDE;
    const uint32_t *instance = columns + (size_t)GK_COL_INSTANCE * STRIDE;
    glint_buffer *rows = glint_resident_table(r->job->scene, GLINT_TABLE_INSTANCES);
    glint_buffer *records = glint_resident_table(r->job->scene, GLINT_TABLE_TRIANGLES);
    const struct gk_instance *row = glint_buffer_host(rows);
    const struct gk_triangle *triangle = glint_buffer_host(records);
    if (glint_buffer_bytes(records) < FETCHED_BYTES)
        return;
    for (uint32_t i = 0; i < n; i++) {
        const uint32_t k = instance[i] != GK_NONE ? instance[i] : geometry[i];
        if (k != GK_NONE)
            __builtin_prefetch(triangle + row[k].triangle + primitive[i]);
    }
}

#define LANE_OF_NOBODY GK_LANE_OF_NOBODY(STRIDE)

// Kernels over paths run whole groups, because to ask each item whether it is a path costs half of their
// time (masked loads). Behind the last path stand copies of the first: what they read there is to be
// read, and what they find goes to a lane that no pixel has.
static void fill_group(const struct glint_run *r, uint32_t n)
{
    float *columns = glint_buffer_host(r->wave->columns);
    const uint32_t end = (n + GROUP - 1) / GROUP * GROUP;
    for (uint32_t k = 0; k < GK_COL_SOX; k++) {
        float *column = columns + (size_t)k * STRIDE;
        for (uint32_t i = n; i < end; i++)
            column[i] = column[0];
    }
    uint32_t *lane = (uint32_t *)columns + (size_t)GK_COL_LANE * STRIDE;
    for (uint32_t i = n; i < end; i++)
        lane[i] = LANE_OF_NOBODY;
}

static glint_status shade(struct glint_run *r, uint32_t n)
{
    fetch_records(r, n);
    fill_group(r, n);
    const uint32_t stride = STRIDE;
    struct glint_arg args[4 + GLINT_TABLES] = {BUFFER(r->wave->columns), VALUE(stride),
                                               BUFFER(r->job->frame), BUFFER(r->wave->rect)};
    for (int t = 0; t < GLINT_TABLES; t++)
        args[4 + t].buffer = glint_resident_table(r->job->scene, t);
    const glint_status st = glint_run_launch(r, "shade_surface", n, args, 4 + GLINT_TABLES);
    glint_run_charge(r, GLINT_PASS_SHADE);
    return st;
}

// What the first n paths hold goes on from the vertices just shaded.
static glint_status carry(struct glint_run *r, const char *kernel, uint32_t n)
{
    const uint32_t stride = STRIDE;
    const struct glint_arg args[] = {BUFFER(r->wave->columns), VALUE(stride),
                                     BUFFER(r->job->frame)};
    const glint_status st = glint_run_launch(r, kernel, n, args, 3);
    glint_run_charge(r, GLINT_PASS_CARRIED);
    return st;
}

static glint_status trace_shadows(struct glint_run *r, uint32_t n)
{
    const uint32_t stride = STRIDE;
    float *columns = glint_buffer_host(r->wave->columns);
    const float *distance = columns + (size_t)GK_COL_ST * STRIDE;
    uint64_t rays = 0;
    for (uint32_t i = 0; i < n; i++)
        rays += distance[i] > 0.0f;
    r->wave->stats.shadow_rays += rays;
    glint_geometry_shadow_wave(r->job->geometry, columns, STRIDE, n);
    if (r->job->watertight)
        glint_geometry_close_shadows(r->job->geometry, columns, STRIDE, n);
    glint_run_charge(r, GLINT_PASS_SHADOW);
    const struct glint_arg args[] = {BUFFER(r->wave->columns), VALUE(stride)};
    const glint_status st = glint_run_launch(r, "add_unoccluded", n, args, 2);
    glint_run_charge(r, GLINT_PASS_UNOCCLUDED);
    return st;
}

static bool of_coverage(uint32_t column)
{
    return column >= GK_COL_HELD && column < GK_COL_MOVED;
}

// Moves the paths that go on to the front. Returns their number.
static uint32_t compact(struct glint_run *r, uint32_t n)
{
    float *columns = glint_buffer_host(r->wave->columns);
    struct glint_compact *c = &r->wave->compact;
    glint_compact_look(c, columns + (size_t)GK_COL_T * STRIDE, n,
                       (uint32_t *)columns + (size_t)GK_COL_HELD * STRIDE, r->holding);
    for (uint32_t k = 0; k < GK_COL_MOVED; k++) {
        float *column = columns + (size_t)k * STRIDE;
        if (k >= GK_COL_TIME && !(r->job->plan->carries >> k & 1))
            continue;
        if (!of_coverage(k))
            glint_compact_column(c, column);
        else if (r->holding > 0)
            glint_compact_holding(c, column);
    }
    r->holding = c->holding.count;
    glint_run_charge(r, GLINT_PASS_COMPACT);
    return c->holding.count + c->others.count;
}

// Relaxed: a bounce sooner or later.
static bool interrupted(const struct glint_run *r)
{
    return r->job->interrupted && atomic_load_explicit(r->job->interrupted, memory_order_relaxed);
}

static glint_status trace_paths(struct glint_run *r)
{
    float *columns = glint_buffer_host(r->wave->columns);
    glint_status st = generate(r);
    uint32_t n = st ? 0 : compact(r, r->lanes);
    r->holding = r->job->matte_through ? n : 0;
    r->wave->stats.camera_rays += n;
    while (!st && n > 0) {
        if (interrupted(r))
            return GLINT_E_BUSY;
        glint_geometry_trace_wave(r->job->geometry, columns, STRIDE, n);
        if (r->job->watertight)
            glint_geometry_close_wave(r->job->geometry, columns, STRIDE, n);
        glint_run_charge(r, GLINT_PASS_TRACE);
        st = shade(r, n);
        if (!st && r->holding > 0)
            st = carry(r, r->bounce == 0 ? "carry_first" : "carry_coverage", r->holding);
        if (!st && glint_plan_has(r->job->plan, GLINT_PASS_SHADOW))
            st = trace_shadows(r, n);
        if (!st)
            st = glint_carried_deposit(r);
        r->bounce++;
        n = compact(r, n);
        r->wave->stats.bounce_rays += n;
    }
    return st;
}

static glint_status accumulate_batch(struct glint_run *r, const struct glint_film_tile *at,
                                     uint32_t n, uint32_t lane, uint32_t sample)
{
    const uint32_t stride = STRIDE, batch = sample % GK_BATCHES;
    const uint32_t words = 3 * GK_SUM_PLANES * GK_TILE_PIXELS;
    const uint32_t offset = at->batches_offset + batch * words;
    const struct glint_arg args[] = {BUFFER(r->wave->columns), VALUE(stride), VALUE(lane),
                                     BUFFER(at->planes), VALUE(offset)};
    const glint_status st = glint_run_launch(r, "accumulate_batch", n, args, 5);
    glint_run_charge(r, GLINT_PASS_BATCHES);
    return st;
}

// last: the half of one sample, or the step between those of four.
static glint_status accumulate_film(struct glint_run *r, const struct glint_film_tile *at,
                                    uint32_t n, uint32_t lane, bool four, uint32_t last)
{
    const uint32_t stride = STRIDE;
    const struct glint_arg args[] = {
        BUFFER(r->wave->columns), VALUE(stride), VALUE(lane), BUFFER(at->planes),
        VALUE(at->planes_offset), VALUE(last)};
    glint_status st =
        glint_run_launch(r, four ? "accumulate_colour_4" : "accumulate_colour", n, args, 6);
    glint_run_charge(r, GLINT_PASS_COLOUR);
    if (!st && glint_plan_has(r->job->plan, GLINT_PASS_AOVS)) {
        st = glint_run_launch(r, four ? "accumulate_aovs_4" : "accumulate_aovs", n, args,
                              four ? 6 : 5);
        glint_run_charge(r, GLINT_PASS_AOVS);
    }
    return st;
}

// The samples of a tile from s on: four of them, if there are and the first is of half 0, or one.
// Returns their number.
static uint32_t samples_at_once(const struct glint_wave_block *b, uint32_t s)
{
    return s + 4 <= b->samples && (b->sample + s) % 2 == 0 ? 4 : 1;
}

static glint_status accumulate_samples(struct glint_run *r, const struct glint_film_tile *at,
                                       uint32_t first)
{
    const uint32_t step = 1u << r->pixels_log2;
    glint_status st = GLINT_OK;
    for (uint32_t s = 0, count; !st && s < r->block->samples; s += count) {
        count = samples_at_once(r->block, s);
        st = accumulate_film(r, at, GK_TILE_PIXELS, s * step + first, count == 4,
                             count == 4 ? step : (r->block->sample + s) & 1);
    }
    const bool batches = glint_plan_has(r->job->plan, GLINT_PASS_BATCHES);
    for (uint32_t s = 0; !st && batches && s < r->block->samples; s++)
        st = accumulate_batch(r, at, GK_TILE_PIXELS, s * step + first, r->block->sample + s);
    return st;
}

static glint_status accumulate_tile(struct glint_run *r, const struct glint_film_tile *at,
                                    uint32_t tile_in_block)
{
    const uint32_t first = tile_in_block * GK_TILE_PIXELS;
    const bool covered = glint_plan_has(r->job->plan, GLINT_PASS_COVERAGE);
    if (covered)
        glint_run_fetch_slots(r, at, first);
    glint_status st = accumulate_samples(r, at, first);
    if (!st && covered) {
        st = glint_run_deposit_pixels(r, "deposit_coverage", at, GK_TILE_PIXELS, first);
        glint_run_charge(r, GLINT_PASS_COVERAGE);
    }
    return st;
}

glint_status glint_run_tiles(struct glint_run *r, glint_visit_tile *visit)
{
    const struct glint_wave_block *b = r->block;
    const uint32_t side = 1u << b->tiles_log2, columns = glint_film_columns(r->film);
    glint_status st = GLINT_OK;
    for (uint32_t y = 0; !st && y < side && b->row + y < glint_film_rows(r->film); y++)
        for (uint32_t x = 0; !st && x < side && b->column + x < columns; x++) {
            struct glint_film_tile at;
            glint_film_tile(r->film, (b->row + y) * columns + b->column + x, &at);
            st = visit(r, &at, y * side + x);
        }
    return st;
}

glint_status glint_wave_run(glint_wave *wave, glint_worker *worker,
                            const struct glint_wave_job *job, const struct glint_wave_block *block,
                            glint_film *film, struct glint_error *err)
{
    struct glint_run r = {wave,
                          worker,
                          job,
                          block,
                          film,
                          err,
                          8 + 2 * block->tiles_log2,
                          block->samples << (8 + 2 * block->tiles_log2),
                          0,
                          0,
                          glint_now(),
                          false,
                          0,
                          0};
    const uint64_t lost = glint_run_lost(&r);
    glint_status st = glint_carried_begin(&r);
    glint_hold_begin(block->hold);
    if (!st)
        st = trace_paths(&r);
    if (!st && !glint_hold_keep(block->hold))
        st = GLINT_E_BUSY;
    if (!st)
        st = glint_carried_end(&r);
    if (!st)
        glint_run_count_samples(&r);
    if (!st)
        st = glint_run_tiles(&r, accumulate_tile);
    wave->stats.count[GLINT_COUNT_CLAMPED] += st ? 0 : r.clamped;
    wave->stats.count[GLINT_COUNT_LOST] += st ? 0 : glint_run_lost(&r) - lost;
    return st;
}

// Launches every kernel of the plan: those over paths with camera rays of no pixel that met nothing.
static glint_status launch_all(struct glint_run *r)
{
    const uint32_t stride = STRIDE;
    const struct glint_arg args[] = {BUFFER(r->wave->columns), VALUE(stride)};
    const struct glint_film_tile nowhere = {.planes = r->wave->columns, .tables = r->wave->columns};
    glint_status st = generate(r);
    if (!st)
        st = shade(r, 0);
    if (!st && glint_plan_has(r->job->plan, GLINT_PASS_UNOCCLUDED))
        st = glint_run_launch(r, "add_unoccluded", 0, args, 2);
    if (!st)
        st = accumulate_film(r, &nowhere, 0, 0, false, 0);
    if (!st)
        st = accumulate_film(r, &nowhere, 0, 0, true, 0);
    if (!st && glint_plan_has(r->job->plan, GLINT_PASS_BATCHES))
        st = accumulate_batch(r, &nowhere, 0, 0, 0);
    if (!st && glint_plan_has(r->job->plan, GLINT_PASS_COVERAGE))
        st = glint_run_deposit_pixels(r, "deposit_coverage", &nowhere, 0, 0);
    if (!st && r->job->matte_through)
        st = carry(r, "carry_first", 0);
    if (!st && r->job->matte_through)
        st = carry(r, "carry_coverage", 0);
    if (!st && r->job->matte_through)
        st = glint_run_deposit_pixels(r, "deposit_first", &nowhere, 0, 0);
    if (!st && r->job->matte_through)
        st = glint_run_deposit_paths(r, r->wave->columns, 0);
    if (!st && r->job->matte_rows)
        st = glint_carried_forget(r, r->wave->columns, 0);
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
    struct glint_run r = {wave,        glint_devices_spare(devices),
                          job,         &nothing,
                          NULL,        err,
                          0,           0,
                          0,           0,
                          glint_now(), true,
                          0,           0};
    pthread_mutex_lock(&one_at_a_time);
    st = launch_all(&r);
    pthread_mutex_unlock(&one_at_a_time);
    glint_wave_destroy(&wave);
    return st;
}
