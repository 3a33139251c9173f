#include "protocol/film_merge.h"

#include "kernels/gk_film.h"
#include "kernels/gk_matte.h"
#include "protocol/film_add.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_WARNINGS 3

struct glint_film_sum {
    struct glint_job job;            // as one run would have it; borrows the first part's strings
    struct glint_film_header header; // likewise
    uint32_t columns, tiles;
    uint32_t *memory; // [tiles] planes and tables
    size_t tile_words, plane_words;
    uint32_t (*half)[GK_TILE_PIXELS][2]; // [tiles]
    uint32_t first, end;                 // sample indices
    uint64_t missing;                    // pixels without all of them
    uint64_t lost;                       // pixels with parts of which some coverage found no slot
    struct glint_film_source source;
    const char *warning[MAX_WARNINGS];
    char ranks[256]; // one of them
    size_t warnings;
};

// Pixels and samples of a part.
struct box {
    uint32_t low[3], high[3]; // x, y, sample
};

static struct box box_of(const struct glint_film_part *part)
{
    const struct glint_film_header *h = glint_film_file_header(part->file);
    const uint32_t *r = h->info.job->region;
    return (struct box){{r[0], r[1], h->info.job->sample_range[0]},
                        {r[0] + r[2], r[1] + r[3], h->moment.sample + h->moment.samples}};
}

// ---- what does not fit together

static glint_status check_complete(const struct glint_film_part *part, struct glint_error *err)
{
    const struct glint_film_moment *m = &glint_film_file_header(part->file)->moment;
    const uint32_t first = glint_film_file_header(part->file)->info.job->sample_range[0];
    return m->complete
               ? GLINT_OK
               : glint_fail(err, GLINT_E_RANGE, "", "%s is not complete: it has %u of %u samples",
                            part->name, m->sample - first, m->target - first);
}

static glint_status check_overlap(const struct glint_film_part *a, const struct glint_film_part *b,
                                  struct glint_error *err)
{
    const struct box p = box_of(a), q = box_of(b);
    struct box both;
    for (int k = 0; k < 3; k++) {
        both.low[k] = p.low[k] > q.low[k] ? p.low[k] : q.low[k];
        both.high[k] = p.high[k] < q.high[k] ? p.high[k] : q.high[k];
        if (both.low[k] >= both.high[k])
            return GLINT_OK;
    }
    return glint_fail(err, GLINT_E_RANGE, "",
                      "%s and %s both have samples %u to %u of the %u x %u pixels at %u, %u",
                      a->name, b->name, both.low[2], both.high[2], both.high[0] - both.low[0],
                      both.high[1] - both.low[1], both.low[0], both.low[1]);
}

static glint_status check_parts(const struct glint_film_part *part, size_t count, bool partial,
                                struct glint_error *err)
{
    const struct glint_film_header *first = glint_film_file_header(part[0].file);
    glint_status st = GLINT_OK;
    for (size_t i = 0; i < count; i++) {
        const struct glint_film_header *h = glint_film_file_header(part[i].file);
        if (i && glint_film_same(&first->info, &h->info, true, part[i].name, err))
            st = GLINT_E_RANGE;
        if (!partial && check_complete(&part[i], err))
            st = GLINT_E_RANGE;
        if (h->info.job->adaptive)
            st = glint_fail(err, GLINT_E_RANGE, "",
                            "%s is of an adaptive job: how many samples a pixel has depends on the "
                            "others, so that parts do not add up",
                            part[i].name);
        for (size_t j = 0; j < i; j++)
            if (check_overlap(&part[j], &part[i], err))
                st = GLINT_E_RANGE;
    }
    return st;
}

// ---- the whole

static void describe_job(glint_film_sum *s, const struct glint_film_part *part, size_t count)
{
    struct box whole = box_of(&part[0]);
    for (size_t i = 1; i < count; i++) {
        const struct box b = box_of(&part[i]);
        for (int k = 0; k < 3; k++) {
            whole.low[k] = b.low[k] < whole.low[k] ? b.low[k] : whole.low[k];
            whole.high[k] = b.high[k] > whole.high[k] ? b.high[k] : whole.high[k];
        }
    }
    s->job = *glint_film_file_header(part[0].file)->info.job;
    s->first = whole.low[2];
    s->end = whole.high[2];
    const uint32_t region[4] = {whole.low[0], whole.low[1], whole.high[0] - whole.low[0],
                                whole.high[1] - whole.low[1]};
    memcpy(s->job.region, region, sizeof region);
    s->job.sample_range[0] = s->first;
    s->job.sample_range[1] = s->first ? s->end : 0;
    s->job.stop = (struct glint_job_stop){.samples = s->end - s->first};
}

static void add_moment(struct glint_film_moment *sum, const struct glint_film_moment *m)
{
    sum->worker_seconds += m->worker_seconds;
    sum->camera_rays += m->camera_rays;
    sum->bounce_rays += m->bounce_rays;
    sum->shadow_rays += m->shadow_rays;
    glint_counts_add(sum->count, m->count);
}

static void describe(glint_film_sum *s, const struct glint_film_part *part, size_t count)
{
    const struct glint_film_header *first = glint_film_file_header(part[0].file);
    describe_job(s, part, count);
    s->header.info = first->info;
    s->header.info.job = &s->job;
    s->header.plan = first->plan;
    struct glint_film_moment *m = &s->header.moment;
    *m = (struct glint_film_moment){.complete = true,
                                    .sample = s->end,
                                    .target = s->end,
                                    .estimate = {NAN, NAN, NAN, NAN, NAN, NAN}};
    m->biases = first->moment.biases;
    for (size_t i = 0; i < count; i++)
        add_moment(m, &glint_film_file_header(part[i].file)->moment);
}

static glint_status make_room(glint_film_sum *s, struct glint_error *err)
{
    const struct glint_film_info *info = &s->header.info;
    s->columns = glint_film_info_columns(info);
    s->tiles = s->columns * glint_film_info_rows(info);
    s->plane_words = glint_film_info_plane_bytes(info) / 4;
    s->tile_words = s->plane_words + glint_film_info_table_bytes(info) / 4;
    s->memory = calloc(s->tiles, s->tile_words * 4);
    s->half = calloc(s->tiles, sizeof *s->half);
    if (!s->memory || !s->half)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a film of %zu bytes",
                          s->tiles * s->tile_words * 4);
    for (uint32_t t = 0; info->aovs && t < s->tiles; t++) {
        float *depth = (float *)(s->memory + t * s->tile_words) +
                       (GK_PLANES_BASE + GK_AOV_DEPTH) * GK_TILE_PIXELS;
        for (int i = 0; i < GK_TILE_PIXELS; i++)
            depth[i] = 1e30f;
    }
    return GLINT_OK;
}

// ---- adding

// A tile of a part that lies in memory.
struct piece {
    uint32_t x, y; // of its first pixel in the region of the sum
    uint32_t w, h; // inside its own region
    uint32_t *memory;
    uint32_t half[2];
};

static uint64_t *table_at(const glint_film_sum *s, uint32_t *memory, uint32_t pixel)
{
    return (uint64_t *)(void *)(memory + s->plane_words) +
           (size_t)pixel * glint_film_info_words(&s->header.info);
}

static void add_pixel(glint_film_sum *s, uint32_t x, uint32_t y, const struct piece *p, uint32_t j)
{
    const uint32_t t = y / GK_TILE_SIDE * s->columns + x / GK_TILE_SIDE;
    const uint32_t i = y % GK_TILE_SIDE * GK_TILE_SIDE + x % GK_TILE_SIDE;
    uint32_t *memory = s->memory + t * s->tile_words;
    uint32_t *half = s->half[t][i];
    const bool again = half[0] || half[1];
    glint_film_add_planes(&s->header.info, (float *)memory, i, (const float *)p->memory, j);
    if (s->header.info.coverage) {
        const uint64_t *to = table_at(s, memory, i) + glint_film_info_slots(&s->header.info);
        const bool was = to[GK_MATTE_LOST_PRIMARY] || to[GK_MATTE_LOST_BOUNCED];
        const bool lost = glint_film_add_table(&s->header.info, table_at(s, memory, 0), i,
                                               table_at(s, p->memory, 0), j) ||
                          was;
        s->lost += again && lost;
    }
    half[0] += p->half[0];
    half[1] += p->half[1];
}

static void add_piece(glint_film_sum *s, const struct piece *p)
{
    for (uint32_t y = 0; y < p->h; y++)
        for (uint32_t x = 0; x < p->w; x++)
            add_pixel(s, p->x + x, p->y + y, p, y * GK_TILE_SIDE + x);
}

static uint32_t smaller(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

static glint_status add_part(glint_film_sum *s, const struct glint_film_part *part,
                             uint32_t *memory, struct glint_error *err)
{
    const struct glint_film_info *info = &glint_film_file_header(part->file)->info;
    const uint32_t columns = glint_film_info_columns(info), *r = info->job->region;
    const uint32_t tiles = columns * glint_film_info_rows(info);
    for (uint32_t t = 0; t < tiles; t++) {
        const uint32_t samples = glint_film_file_samples(part->file, t);
        const uint32_t x = t % columns * GK_TILE_SIDE, y = t / columns * GK_TILE_SIDE;
        struct piece p = {r[0] - s->job.region[0] + x,
                          r[1] - s->job.region[1] + y,
                          smaller(GK_TILE_SIDE, r[2] - x),
                          smaller(GK_TILE_SIDE, r[3] - y),
                          memory,
                          {0, 0}};
        for (uint32_t h = 0; h < 2; h++)
            p.half[h] = glint_film_half(info->job->sample_range[0], samples, h);
        const glint_status st =
            samples ? glint_film_file_tile(part->file, t, memory, err) : GLINT_OK;
        if (st)
            return st;
        if (samples)
            add_piece(s, &p);
    }
    return GLINT_OK;
}

// ---- what is missing

static glint_status check_missing(glint_film_sum *s, bool partial, struct glint_error *err)
{
    const uint32_t *r = s->job.region, wanted = s->end - s->first;
    uint32_t at[2] = {0, 0}, least = 0;
    for (uint32_t y = 0; y < r[3]; y++)
        for (uint32_t x = 0; x < r[2]; x++) {
            const uint32_t t = y / GK_TILE_SIDE * s->columns + x / GK_TILE_SIDE;
            const uint32_t *half = s->half[t][y % GK_TILE_SIDE * GK_TILE_SIDE + x % GK_TILE_SIDE];
            if (half[0] + half[1] == wanted)
                continue;
            if (!s->missing++) {
                at[0] = r[0] + x;
                at[1] = r[1] + y;
                least = half[0] + half[1];
            }
        }
    s->header.moment.complete = !s->missing;
    return partial || !s->missing
               ? GLINT_OK
               : glint_fail(err, GLINT_E_RANGE, "",
                            "%llu of the %u x %u pixels at %u, %u have not all samples from %u to "
                            "%u: the one at %u, %u has %u of %u",
                            (unsigned long long)s->missing, r[2], r[3], r[0], r[1], s->first,
                            s->end, at[0], at[1], least, wanted);
}

static void warn(glint_film_sum *s, bool split)
{
    if (s->lost)
        s->warning[s->warnings++] =
            "slots for coverage were full in pixels whose samples are in several films: which "
            "names were left out there depends on the order of samples";
    if (split && glint_film_info_wide(&s->header.info))
        s->warning[s->warnings++] =
            "sums of double precision round: they depend on how samples were split";
}

// ---- the sum as a source

static glint_status begin_tile(void *user, uint32_t tile, struct glint_film_pixels *out,
                               struct glint_error *err)
{
    (void)err; // memory cannot fail
    const glint_film_sum *s = user;
    uint32_t *memory = s->memory + tile * s->tile_words;
    out->planes = (const float *)memory;
    out->table = s->header.info.coverage ? table_at(s, memory, 0) : NULL;
    out->each = (const uint32_t(*)[2])s->half[tile];
    return GLINT_OK;
}

static void end_tile(void *user, uint32_t tile)
{
    (void)user;
    (void)tile;
}

static glint_status add_all(glint_film_sum *s, const struct glint_film_part *part, size_t count,
                            bool partial, struct glint_error *err)
{
    uint32_t *memory = malloc(s->tile_words * 4);
    bool split = false;
    glint_status st =
        memory ? GLINT_OK : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a tile");
    for (size_t i = 0; !st && i < count; i++) {
        const struct box b = box_of(&part[i]);
        split |= b.low[2] != s->first || b.high[2] != s->end;
        st = add_part(s, &part[i], memory, err);
    }
    free(memory);
    if (!st)
        st = check_missing(s, partial, err);
    if (!st)
        warn(s, split);
    return st;
}

static glint_status count_ranks(glint_film_sum *s, struct glint_error *err)
{
    struct glint_matte_excess *excess = &s->header.moment.excess;
    if (!s->header.info.coverage)
        return GLINT_OK;
    const glint_status st = glint_film_excess(&s->source, excess, err);
    if (!st && glint_matte_excess_tell(excess, &s->job, s->ranks))
        s->warning[s->warnings++] = s->ranks;
    return st;
}

glint_status glint_film_merge(glint_film_sum **out, const struct glint_film_part *part,
                              size_t count, bool partial, struct glint_error *err)
{
    *out = NULL;
    if (check_parts(part, count, partial, err))
        return GLINT_E_RANGE;
    glint_film_sum *s = calloc(1, sizeof *s);
    if (!s)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory to merge films");
    describe(s, part, count);
    glint_status st = make_room(s, err);
    if (!st)
        st = add_all(s, part, count, partial, err);
    s->source = (struct glint_film_source){.info = &s->header.info,
                                           .complete = !s->missing,
                                           .user = s,
                                           .begin = begin_tile,
                                           .end = end_tile};
    if (!st)
        st = count_ranks(s, err);
    if (st)
        glint_film_sum_destroy(&s);
    *out = s;
    return st;
}

void glint_film_sum_destroy(glint_film_sum **sum)
{
    glint_film_sum *s = *sum;
    *sum = NULL;
    if (!s)
        return;
    free(s->memory);
    free(s->half);
    free(s);
}

const struct glint_film_source *glint_film_sum_source(const glint_film_sum *s)
{
    return &s->source;
}

size_t glint_film_sum_warnings(const glint_film_sum *s, const char *const **out)
{
    *out = s->warning;
    return s->warnings;
}

glint_status glint_film_sum_write(const glint_film_sum *s, int fd, struct glint_error *err)
{
    if (s->missing)
        return glint_fail(err, GLINT_E_RANGE, "",
                          "%llu pixels have not all samples: a film has whole tiles only",
                          (unsigned long long)s->missing);
    struct glint_film_writer w = {0};
    glint_status st = glint_film_writer_begin(&w, fd, &s->header, err);
    for (uint32_t t = 0; !st && t < s->tiles; t++)
        st = glint_film_writer_tile(&w, t, s->end - s->first, s->memory + t * s->tile_words, err);
    if (!st)
        st = glint_film_writer_end(&w, err);
    glint_film_writer_finish(&w);
    return st;
}
