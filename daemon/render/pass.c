// pass.c - the samples of a render, given out block by block and pass by pass.
#include "kernels/gk_film.h"
#include "render/adaptive.h"
#include "render/internal.h"
#include "render/order.h"

uint32_t glint_render_first(const glint_render *r)
{
    return r->job.sample_range[0];
}

#define PILOT_FIRST GLINT_MAX_SAMPLES // indices of a pilot's samples

uint32_t glint_pass_count(const glint_render *r, uint32_t end)
{
    return (end > PILOT_FIRST ? end - PILOT_FIRST : end) - glint_render_first(r);
}

// A wave holds 64x64 pixels once, 32x32 four times, 16x16 sixteen times. A live job's first sample
// comes in quarters of that, so that several workers make the first tile that is seen.
static uint32_t block_size(const struct glint_render *r, uint32_t samples)
{
    if (samples == 1)
        return r->job.live || r->pass.coarse ? GLINT_COARSE_LOG2 + r->pass.spread_log2 : 2;
    return samples <= 4 ? 1 : 0;
}

// Films of doubles are for who measures, not for who moves.
bool glint_pass_coarsens(const struct glint_job *job)
{
    return job->live && job->dial[GLINT_DIAL_PRECISION] != 0;
}

static void lay_blocks(struct glint_render *r)
{
    struct glint_pass_state *p = &r->pass;
    const uint32_t side = GK_TILE_SIDE << p->tiles_log2;
    p->blocks_wide = (r->job.region[2] + side - 1) / side;
    p->blocks_high = (r->job.region[3] + side - 1) / side;
    p->blocks = p->blocks_wide * p->blocks_high;
    p->start = p->next = p->done = p->redos = 0;
}

// A view may change so often that its first pass never ends.
void glint_pass_restart(struct glint_render *r)
{
    struct glint_pass_state *p = &r->pass;
    const bool cut_off = p->samples > 0 && p->sample == glint_render_first(r) &&
                         (!p->coarse || p->spread_log2 == GLINT_COARSEST_LOG2);
    const uint32_t reached = (p->start + p->next - p->redos) % p->blocks;
    glint_pass_begin(r, glint_render_first(r));
    p->start = cut_off ? reached : 0;
}

// Whole passes are 16 samples; the first ones end where the curve has its first points, at 2, 4, 8
// and 12.
static uint32_t pass_samples(uint32_t sample)
{
    return sample < 2    ? 1
           : sample < 4  ? 4 - sample
           : sample < 16 ? 4 - sample % 4
                         : 16 - sample % 16;
}

void glint_pass_begin(struct glint_render *r, uint32_t sample)
{
    struct glint_pass_state *p = &r->pass;
    const bool sketches = glint_render_sketches(r);
    const uint32_t wanted = sketches ? 1 : pass_samples(sample);
    p->sample = sample;
    p->samples = sample + wanted > r->target ? r->target - sample : wanted;
    p->coarse = sketches || (glint_pass_coarsens(&r->job) && sample == 0);
    p->spread_log2 = p->coarse ? GLINT_COARSEST_LOG2 : 0;
    p->tiles_log2 = block_size(r, p->samples);
    lay_blocks(r);
    if (glint_adaptive_goes(r) && p->samples)
        glint_adaptive_begin(r, sample);
}

static bool is_pilot(const struct glint_render *r)
{
    return r->job.adaptive && !glint_adaptive_goes(r);
}

// Index of the first sample that this pass takes of a block.
static uint32_t first_sample(const struct glint_render *r, uint32_t column, uint32_t row)
{
    const uint32_t columns = (r->job.region[2] + GK_TILE_SIDE - 1) / GK_TILE_SIDE;
    if (glint_adaptive_goes(r))
        return glint_adaptive_taken(r, row * columns + column, r->pass.sample);
    return r->pass.sample + (is_pilot(r) ? PILOT_FIRST : 0);
}

// The pixels between those of the step before.
static void refine(struct glint_render *r)
{
    struct glint_pass_state *p = &r->pass;
    p->spread_log2--;
    p->tiles_log2--;
    lay_blocks(r);
}

double glint_pass_share(const struct glint_pass_state *p)
{
    const double pixels = 1.0 / (double)(1u << 2 * p->spread_log2);
    const double before = p->coarse && p->spread_log2 < GLINT_COARSEST_LOG2 ? pixels / 4 : 0.0;
    const double share = p->blocks ? (double)p->done / p->blocks : 0.0;
    return before + share * (pixels - before);
}

static void block_place(const struct glint_render *r, uint32_t block, uint32_t *column,
                        uint32_t *row)
{
    const struct glint_pass_state *p = &r->pass;
    glint_order_place(p->blocks_wide, p->blocks_high, block, column, row);
    *column <<= p->tiles_log2;
    *row <<= p->tiles_log2;
}

uint32_t glint_pass_clip(uint32_t start, uint32_t size, uint32_t end)
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
    out->w = glint_pass_clip(out->x, side, region[0] + region[2]);
    out->h = glint_pass_clip(out->y, side, region[1] + region[3]);
    out->sample = first_sample(r, column, row);
    out->samples = r->pass.samples;
    out->tiles_log2 = r->pass.tiles_log2;
    out->step = r->pass.coarse ? 1u << r->pass.spread_log2 : 0;
    out->hold = NULL;
}

static uint32_t next_block(struct glint_render *r)
{
    struct glint_pass_state *p = &r->pass;
    if (p->redos > 0)
        return p->redo[--p->redos];
    const uint32_t next = (p->start + p->next++) % p->blocks;
    if (glint_adaptive_goes(r))
        return p->list[next];
    return p->coarse ? r->order[p->spread_log2][next] : next;
}

bool glint_render_take(glint_render *r, struct glint_slice *out)
{
    pthread_mutex_lock(&r->mutex);
    struct glint_pass_state *p = &r->pass;
    const bool any = p->samples > 0 && (p->redos > 0 || p->next < p->blocks);
    if (any) {
        slice_fill(r, next_block(r), out);
        uint32_t column, row;
        block_place(r, out->block, &column, &row);
        glint_film_hold(r->film, column, row, 1u << p->tiles_log2, 1u << p->tiles_log2);
    }
    pthread_mutex_unlock(&r->mutex);
    return any;
}

// The samples of a block of the film that was; GLINT_NONE: its tiles differ.
static uint32_t block_samples(const glint_render *r, uint32_t block, const uint32_t *tile_samples)
{
    const uint32_t columns = (r->job.region[2] + GK_TILE_SIDE - 1) / GK_TILE_SIDE;
    const uint32_t rows = (r->job.region[3] + GK_TILE_SIDE - 1) / GK_TILE_SIDE;
    const uint32_t side = 1u << r->pass.tiles_log2;
    uint32_t column, row;
    block_place(r, block, &column, &row);
    const uint32_t samples = tile_samples[row * columns + column];
    for (uint32_t y = row; y < row + side && y < rows; y++)
        for (uint32_t x = column; x < column + side && x < columns; x++)
            if (tile_samples[y * columns + x] != samples)
                return GLINT_NONE;
    return samples;
}

// Tiles that take part in the pass have what they had before it or what they have after it; a render
// without a device gives nothing out.
static bool resume_adaptive(glint_render *r, const uint32_t *tile_samples)
{
    struct glint_pass_state *p = &r->pass;
    const uint32_t columns = (r->job.region[2] + GK_TILE_SIDE - 1) / GK_TILE_SIDE;
    const uint32_t blocks = p->blocks, end = p->sample + p->samples;
    p->blocks = 0;
    for (uint32_t b = blocks; b-- > 0;) {
        uint32_t column, row;
        block_place(r, b, &column, &row);
        const uint32_t tile = row * columns + column, has = tile_samples[tile];
        const uint32_t before = glint_adaptive_taken(r, tile, p->sample);
        const uint32_t after = glint_adaptive_taken(r, tile, end);
        if (has != before && has != after)
            return false;
        if (after == before)
            continue;
        if (has == before && p->redo)
            p->redo[p->redos++] = b;
        p->done += has == after;
        p->blocks++;
    }
    p->next = p->blocks;
    return true;
}

bool glint_pass_resume(glint_render *r, const struct glint_film_moment *was,
                       const uint32_t *tile_samples)
{
    struct glint_pass_state *p = &r->pass;
    const uint32_t done = was->sample + was->samples - glint_render_first(r);
    p->sample = was->sample;
    p->samples = was->samples;
    p->tiles_log2 = was->tiles_log2;
    p->coarse = false;
    p->spread_log2 = 0;
    lay_blocks(r);
    if (glint_adaptive_goes(r))
        return resume_adaptive(r, tile_samples);
    for (uint32_t b = p->blocks; b-- > 0;) { // the last to be redone comes first
        const uint32_t samples = block_samples(r, b, tile_samples);
        if (samples == GLINT_NONE)
            return false;
        if (samples != done && p->redo)
            p->redo[p->redos++] = b;
        p->done += samples == done;
    }
    p->next = p->blocks;
    return true;
}

uint64_t glint_render_pixels(const struct glint_render *r)
{
    return (uint64_t)r->job.region[2] * r->job.region[3];
}

bool glint_pass_stops(struct glint_render *r, uint32_t end)
{
    const double wanted = glint_render_noise_wanted(r);
    const uint32_t samples = end - glint_render_first(r), look = glint_estimate_look(samples);
    if (wanted > 0.0 && look && samples >= r->job.stop.least &&
        glint_estimate_upper(&r->estimate.whole, look) <= wanted) {
        r->target = end;
        r->stopped = true;
    }
    return r->stopped;
}

void glint_pass_end(struct glint_render *r)
{
    if (r->pass.spread_log2) {
        if (!glint_render_sketches(r) || r->pass.spread_log2 > GLINT_SKETCH_LOG2)
            refine(r);
        return;
    }
    const uint32_t end = r->pass.sample + r->pass.samples;
    const bool decides = is_pilot(r) && end == GLINT_PILOT_SAMPLES;
    glint_render_measure_pass(r, end);
    if (decides)
        glint_adaptive_decide(r);
    else
        glint_pass_stops(r, end);
    glint_pass_begin(r, end);
}

void glint_render_give_back(glint_render *r, const struct glint_slice *s, bool done)
{
    pthread_mutex_lock(&r->mutex);
    uint32_t column, row;
    block_place(r, s->block, &column, &row);
    const uint32_t side = 1u << r->pass.tiles_log2;
    if (done && s->step > 1)
        glint_film_release_coarse(r->film, column, row, side, side, s->step);
    else
        glint_film_release(r->film, column, row, side, side,
                           done ? glint_pass_count(r, s->sample + s->samples) : 0);
    if (done)
        r->pass.done++;
    else
        r->pass.redo[r->pass.redos++] = s->block;
    if (r->pass.done == r->pass.blocks)
        glint_pass_end(r);
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

// Samples of a pixel, in the mean, when the slices out are back.
static double reached(const glint_render *r)
{
    const uint32_t end = r->pass.sample + r->pass.samples;
    return glint_adaptive_goes(r) ? glint_adaptive_mean(r, end) : end;
}

// A decision to stop is taken again where the wanted error is another.
bool glint_render_extend(glint_render *r, uint32_t samples, double error)
{
    pthread_mutex_lock(&r->mutex);
    struct glint_pass_state *p = &r->pass;
    const bool fits = !r->archive && !r->job.sample_range[1] && reached(r) <= samples;
    if (fits) {
        r->job.stop.samples = samples;
        r->job.stop.error = error;
        r->target = glint_adaptive_goes(r) ? glint_adaptive_target(r, samples) : samples;
        r->stopped = false;
        glint_render_foresee(r);
        if (p->samples == 0 && !glint_pass_stops(r, p->sample))
            glint_pass_begin(r, p->sample);
    }
    pthread_mutex_unlock(&r->mutex);
    return fits;
}
