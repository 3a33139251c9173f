// film_frame.c - film tiles become frames: normalised planes with the channels and attributes of
// CONVENTIONS b.
#include "protocol/film_levels.h"
#include "protocol/film_parts.h"

#include "kernels/gk_film.h"
#include "kernels/gk_matte.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_LAYERS (GLINT_MAX_LEVELS / 2)

// Planes of the frame being made; NULL where an output is not asked for.
struct planes {
    float *rgba[4], *depth, *normal[3], *albedo[3], *samples, *variance[3], *flow[4];
    float *sum[4];
    float *rank[GLINT_MAX_MATTE_TYPES][MAX_LAYERS][4];
    struct glint_matte_type type[GLINT_MAX_MATTE_TYPES];
    size_t types;
    uint32_t layers; // of each
};

static bool add_planes(struct glint_frame *f, float **out, const char *const *name, int n,
                       enum glint_pixel_type type)
{
    bool ok = true;
    for (int i = 0; i < n; i++)
        ok &= (out[i] = glint_frame_channel(f, name[i], type)) != NULL;
    return ok;
}

// Those of a type behind the layers that it has.
static bool add_ranks(struct glint_frame *f, struct planes *p, uint32_t levels, size_t type)
{
    static const char letter[4] = {'R', 'G', 'B', 'A'};
    bool ok = true;
    for (uint32_t l = p->layers; l < (levels + 1) / 2; l++)
        for (int k = 0; k < 4; k++) {
            char name[32];
            snprintf(name, sizeof name, "%s%02u.%c", p->type[type].name, l, letter[k]);
            ok &= (p->rank[type][l][k] = glint_frame_channel(f, name, GLINT_PIXEL_FLOAT)) != NULL;
        }
    return ok;
}

static bool add_layers(struct glint_frame *f, struct planes *p, uint32_t levels)
{
    bool ok = true;
    for (size_t t = 0; t < p->types; t++)
        ok &= add_ranks(f, p, levels, t);
    p->layers = (levels + 1) / 2;
    return ok;
}

static glint_status make_planes(struct glint_frame *f, const struct glint_job *job,
                                uint32_t outputs, struct planes *p, struct glint_error *err)
{
    static const char *const rgba[] = {"R", "G", "B", "A"}, *const z[] = {"Z"},
                             *const samples[] = {"samples.Y"};
    static const char *const normal[] = {"N.X", "N.Y", "N.Z"};
    static const char *const albedo[] = {"albedo.R", "albedo.G", "albedo.B"};
    static const char *const variance[] = {"variance.R", "variance.G", "variance.B"};
    static const char *const sum[] = {"sums.primary", "sums.bounced", "sums.lost_primary",
                                      "sums.lost_bounced"};
    static const char *const flow[] = {"forward.u", "forward.v", "backward.u", "backward.v"};
    memset(p, 0, sizeof *p);
    bool ok = !(outputs & GLINT_OUT_BEAUTY) || add_planes(f, p->rgba, rgba, 4, GLINT_PIXEL_HALF);
    ok &= !(outputs & GLINT_OUT_DEPTH) || add_planes(f, &p->depth, z, 1, GLINT_PIXEL_FLOAT);
    ok &= !(outputs & GLINT_OUT_NORMAL) || add_planes(f, p->normal, normal, 3, GLINT_PIXEL_FLOAT);
    ok &= !(outputs & GLINT_OUT_ALBEDO) || add_planes(f, p->albedo, albedo, 3, GLINT_PIXEL_HALF);
    ok &=
        !(outputs & GLINT_OUT_SAMPLES) || add_planes(f, &p->samples, samples, 1, GLINT_PIXEL_FLOAT);
    ok &= !(outputs & GLINT_OUT_VARIANCE) ||
          add_planes(f, p->variance, variance, 3, GLINT_PIXEL_FLOAT);
    ok &= !(outputs & GLINT_OUT_MOTION) || add_planes(f, p->flow, flow, 4, GLINT_PIXEL_FLOAT);
    ok &= !(outputs & GLINT_OUT_MATTE_SUMS) || add_planes(f, p->sum, sum, 4, GLINT_PIXEL_FLOAT);
    p->types = glint_matte_types(job, outputs, p->type);
    ok &= add_layers(f, p, job->matte_levels ? job->matte_levels : GLINT_DEFAULT_LEVELS);
    return ok ? GLINT_OK
              : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a frame of %ux%u", f->width,
                           f->height);
}

// One pixel of a film tile and where it goes.
struct at {
    const struct glint_film_info *info;
    const float *plane;     // of the tile
    const uint64_t *tables; // of the tile
    uint32_t i;             // pixel of the tile
    uint32_t half[2];       // its samples
    uint32_t samples;       // both, > 0
    bool in_one_run;        // they follow one another from the job's first on
    size_t out;             // pixel of the frame
};

// The square of a light that single precision holds may lie beyond it.
static float square(double x)
{
    return (float)fmin(x * x, FLT_MAX);
}

// Of the mean, of the batches where each has a sample.
static float variance(const struct at *a, uint32_t c, double ma, double mb)
{
    const bool wide = glint_film_info_wide(a->info);
    const float *batches = a->plane + glint_film_info_batch_words(a->info);
    const double mean = (ma * a->half[0] + mb * a->half[1]) / a->samples;
    double sum = 0.0;
    if (!a->info->batches || !a->in_one_run || a->samples < GK_BATCHES)
        return a->half[0] && a->half[1] ? square(0.5 * (ma - mb)) : 0.0f;
    for (uint32_t k = 0; k < GK_BATCHES; k++) {
        const uint32_t n =
            glint_film_part(a->info->job->sample_range[0], a->samples, GK_BATCHES, k);
        const double d = glint_film_batch_mean(batches, wide, k, c, a->i, n) - mean;
        sum += n * d * d;
    }
    return (float)fmin(sum / ((GK_BATCHES - 1.0) * a->samples), FLT_MAX);
}

static void resolve_colour(const struct at *a, const struct planes *p)
{
    const bool wide = glint_film_info_wide(a->info);
    const uint32_t *hits = (const uint32_t *)a->plane + GK_PLANE_HITS * GK_TILE_PIXELS;
    for (uint32_t c = 0; c < 3; c++) {
        const double ma = glint_film_mean(a->plane, wide, 0, c, a->i, a->half[0]);
        const double mb = glint_film_mean(a->plane, wide, 1, c, a->i, a->half[1]);
        if (p->rgba[0])
            p->rgba[c][a->out] = (float)((ma * a->half[0] + mb * a->half[1]) / a->samples);
        if (p->variance[0])
            p->variance[c][a->out] = variance(a, c, ma, mb);
    }
    if (p->rgba[0])
        p->rgba[3][a->out] = (float)((double)hits[a->i] / a->samples);
}

static float aov_mean(const struct at *a, int plane, int component, int bits)
{
    const uint32_t *low = (const uint32_t *)a->plane +
                          (GK_PLANES_BASE + plane + 2 * component) * GK_TILE_PIXELS + a->i;
    const int64_t sum = (int64_t)((uint64_t)low[GK_TILE_PIXELS] << 32 | *low);
    return (float)(ldexp((double)sum, -bits) / a->samples);
}

static void resolve_aovs(const struct at *a, const struct planes *p)
{
    if (p->depth)
        p->depth[a->out] = a->plane[(GK_PLANES_BASE + GK_AOV_DEPTH) * GK_TILE_PIXELS + a->i];
    for (int c = 0; c < 3; c++) {
        if (p->normal[0])
            p->normal[c][a->out] = aov_mean(a, GK_AOV_NORMAL, c, GK_FIXED_UNIT);
        if (p->albedo[0])
            p->albedo[c][a->out] = aov_mean(a, GK_AOV_ALBEDO, c, GK_FIXED_UNIT);
    }
    for (int c = 0; c < 4 && p->flow[0]; c++)
        p->flow[c][a->out] = aov_mean(a, GK_AOV_FLOW, c, GK_FIXED_FLOW);
}

// What is behind the layers of a frame that has as many ranks as it takes.
struct spare {
    uint32_t at, id; // pixel of the frame
    float coverage;
    uint16_t type, rank;
};
struct spares {
    struct spare *list; // malloc'd
    size_t count, room;
    uint32_t needed; // levels
    bool failed;     // no memory
};

static void store_rank(float *const plane[MAX_LAYERS][4], uint32_t k, size_t out, uint32_t id,
                       float coverage)
{
    memcpy(&plane[k / 2][2 * (k % 2)][out], &id, 4); // bits, never arithmetic
    plane[k / 2][2 * (k % 2) + 1][out] = coverage;
}

static void spare_rank(struct spares *s, const struct spare *one)
{
    if (s->count == s->room) {
        const size_t room = s->room ? 2 * s->room : 1024;
        struct spare *list = realloc(s->list, room * sizeof *list);
        s->failed |= !list;
        if (!list)
            return;
        s->list = list;
        s->room = room;
    }
    s->list[s->count++] = *one;
}

static void store_ranks(const struct glint_cryptomatte_rank *rank, uint32_t n, uint32_t levels,
                        float *const plane[MAX_LAYERS][4], size_t out)
{
    for (uint32_t k = 0; k < n && k < levels; k++)
        store_rank(plane, k, out, rank[k].id, rank[k].coverage);
}

static void spare_ranks(struct spares *s, const struct glint_cryptomatte_rank *rank, uint32_t n,
                        uint32_t type, size_t out)
{
    const uint32_t needed = glint_film_levels_of(rank, n, GLINT_DEFAULT_LEVELS);
    s->needed = needed > s->needed ? needed : s->needed;
    for (uint32_t k = GLINT_DEFAULT_LEVELS; k < n && k < GLINT_MAX_LEVELS; k++)
        spare_rank(s, &(struct spare){(uint32_t)out, rank[k].id, rank[k].coverage, (uint16_t)type,
                                      (uint16_t)k});
}

// What the pixel has of its coverage and what found no slot: Eq. 8 of Yoshimura et al. 2022 gives
// sums that are not 1.
static void resolve_sums(const struct at *a, const struct planes *p,
                         const struct glint_film_held *held)
{
    const uint64_t *lost =
        a->tables + (size_t)a->i * glint_film_info_words(a->info) + glint_film_info_slots(a->info);
    uint64_t sum[4] = {0, 0, lost[GK_MATTE_LOST_PRIMARY], lost[GK_MATTE_LOST_BOUNCED]};
    for (uint32_t s = 0; s < held->count; s++)
        sum[gk_matte_class(gk_matte_key(held->slot[s])) != 0] += gk_matte_amount(held->slot[s]);
    for (int k = 0; k < 4; k++)
        p->sum[k][a->out] = (float)((double)sum[k] / ((double)GK_MATTE_ONE * a->samples));
}

static void resolve_mattes(const struct at *a, const struct planes *p,
                           struct glint_film_ranks *ranks, struct spares *spares)
{
    const uint32_t levels = a->info->job->matte_levels;
    glint_film_held_read(a->info, a->tables, a->i, &ranks->held);
    for (size_t t = 0; t < p->types; t++) {
        const uint32_t n = glint_film_rank(a->info, &p->type[t], a->samples, ranks);
        store_ranks(ranks->rank, n, levels ? levels : GLINT_DEFAULT_LEVELS, p->rank[t], a->out);
        if (!levels)
            spare_ranks(spares, ranks->rank, n, (uint32_t)t, a->out);
    }
    if (p->sum[0])
        resolve_sums(a, p, &ranks->held);
}

// What a frame is being made of.
struct making {
    const struct glint_film_source *source;
    const struct glint_frame *frame;
    struct planes planes;
    struct glint_film_ranks ranks;
    struct spares spares;
    uint32_t fewest; // samples so far
};

static void resolve_pixel(struct making *m, struct at *a, const struct glint_film_pixels *from)
{
    a->half[0] = glint_film_samples_of(from, a->i, 0);
    a->half[1] = glint_film_samples_of(from, a->i, 1);
    a->samples = a->half[0] + a->half[1];
    m->fewest = a->samples < m->fewest ? a->samples : m->fewest;
    if (!a->samples)
        return;
    resolve_colour(a, &m->planes);
    resolve_aovs(a, &m->planes);
    if (m->planes.samples)
        m->planes.samples[a->out] = (float)a->samples;
    if (!from->table || !(m->planes.types || m->planes.sum[0]))
        return;
    a->tables = from->table;
    resolve_mattes(a, &m->planes, &m->ranks, &m->spares);
}

// A pixel without a sample of its own looks like another of its tile, but has none.
static void repeat_pixel(struct making *m, size_t shown, size_t out)
{
    for (uint32_t c = 0; c < m->frame->channels; c++)
        m->frame->channel[c].plane[out] = m->frame->channel[c].plane[shown];
    if (m->planes.samples)
        m->planes.samples[out] = 0.0f;
    m->fewest = 0;
}

static bool is_inside(const struct glint_frame *f, int64_t x, int64_t y)
{
    return x >= 0 && y >= 0 && x < f->width && y < f->height;
}

static size_t place(const struct glint_frame *f, int64_t x, int64_t y)
{
    return (size_t)y * f->width + (size_t)x;
}

// The pixels of one film tile that lie in the frame.
static void resolve_tile(struct making *m, uint32_t tile, const struct glint_film_pixels *from)
{
    const struct glint_film_info *info = m->source->info;
    const uint32_t columns = glint_film_info_columns(info), *region = info->job->region;
    const int64_t x0 = (int64_t)region[0] + tile % columns * GK_TILE_SIDE - m->frame->x;
    const int64_t y0 = (int64_t)region[1] + tile / columns * GK_TILE_SIDE - m->frame->y;
    struct at a = {
        .info = info, .plane = from->planes, .in_one_run = !from->each || m->source->complete};
    for (uint32_t i = 0; i < GK_TILE_PIXELS; i++) {
        const int64_t x = x0 + i % GK_TILE_SIDE, y = y0 + i / GK_TILE_SIDE;
        if (!is_inside(m->frame, x, y))
            continue;
        a.i = glint_film_shown_as(from, i);
        a.out = place(m->frame, x, y);
        if (a.i == i)
            resolve_pixel(m, &a, from);
        else
            repeat_pixel(m, place(m->frame, x0 + a.i % GK_TILE_SIDE, y0 + a.i / GK_TILE_SIDE),
                         a.out);
    }
}

static void blank_depth(struct making *m)
{
    float *depth = m->planes.depth;
    for (size_t i = 0; depth && i < (size_t)m->frame->width * m->frame->height; i++)
        depth[i] = 1e30f;
}

static glint_status resolve_frame(struct making *m, struct glint_error *err)
{
    const struct glint_film_source *s = m->source;
    const struct glint_frame *f = m->frame;
    const uint32_t *region = s->info->job->region, columns = glint_film_info_columns(s->info);
    const uint32_t x0 = ((uint32_t)f->x - region[0]) / GK_TILE_SIDE;
    const uint32_t y0 = ((uint32_t)f->y - region[1]) / GK_TILE_SIDE;
    const uint32_t x1 = ((uint32_t)f->x + f->width - 1 - region[0]) / GK_TILE_SIDE;
    const uint32_t y1 = ((uint32_t)f->y + f->height - 1 - region[1]) / GK_TILE_SIDE;
    glint_status st = GLINT_OK;
    blank_depth(m);
    for (uint32_t y = y0; !st && y <= y1; y++)
        for (uint32_t x = x0; !st && x <= x1; x++) {
            struct glint_film_pixels pixels = {0};
            st = s->begin(s->user, y * columns + x, &pixels, err);
            if (st)
                break;
            resolve_tile(m, y * columns + x, &pixels);
            s->end(s->user, y * columns + x);
        }
    return st;
}

glint_status glint_film_attributes(const struct glint_film_source *s, struct glint_frame *f,
                                   uint32_t samples)
{
    static const float rec709[8] = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};
    const struct glint_film_info *info = s->info;
    glint_status st = glint_frame_chromaticities(f, rec709);
    st = st ? st : glint_frame_matrix(f, "worldToCamera", info->to_camera);
    st = st ? st : glint_frame_matrix(f, "worldToNDC", info->to_ndc);
    st = st ? st : glint_frame_string(f, "software", info->software);
    st = st ? st : glint_frame_int(f, "glint/frame", (int32_t)info->job->frame);
    st = st ? st : glint_frame_int(f, "glint/samples", (int32_t)samples);
    st = st ? st : glint_frame_int(f, "glint/seed", (int32_t)info->job->seed);
    st = st ? st : glint_frame_string(f, "glint/sceneHash", info->revision);
    return st ? st : glint_frame_int(f, "glint/complete", s->complete);
}

static glint_status add_manifests(const struct glint_film_info *info, struct glint_frame *f,
                                  const struct planes *p)
{
    glint_status st = GLINT_OK;
    for (size_t t = 0; !st && t < p->types; t++) {
        char *manifest = glint_film_manifest(info, p->type[t].layer);
        st = manifest ? glint_cryptomatte_header(f, p->type[t].name, manifest) : GLINT_E_NOMEM;
        free(manifest);
    }
    return st;
}

// The layers that it takes, with what belongs there.
static glint_status add_spares(struct making *m, struct glint_frame *f, struct glint_error *err)
{
    const struct spares *s = &m->spares;
    const uint32_t levels = s->needed < GLINT_MAX_LEVELS ? s->needed : GLINT_MAX_LEVELS;
    if (s->failed || (levels > 2 * m->planes.layers && !add_layers(f, &m->planes, levels)))
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u ranks of %ux%u", levels,
                          f->width, f->height);
    for (size_t i = 0; i < s->count; i++) {
        const struct spare *r = &s->list[i];
        if (r->rank < levels)
            store_rank(m->planes.rank[r->type], r->rank, r->at, r->id, r->coverage);
    }
    return GLINT_OK;
}

static glint_status fill(struct making *m, struct glint_frame *f, uint32_t outputs,
                         struct glint_error *err)
{
    glint_status st = make_planes(f, m->source->info->job, outputs, &m->planes, err);
    if (!st)
        st = glint_film_ranks_create(&m->ranks, m->source->info, err);
    if (!st)
        st = resolve_frame(m, err);
    if (!st)
        st = add_spares(m, f, err);
    glint_film_ranks_finish(&m->ranks);
    free(m->spares.list);
    if (st)
        return st;
    st = glint_film_attributes(m->source, f, m->fewest);
    st = st ? st : add_manifests(m->source->info, f, &m->planes);
    return st ? glint_fail(err, st, "", "no memory for the frame's header") : GLINT_OK;
}

glint_status glint_film_frame(const struct glint_film_source *source, const uint32_t rect[4],
                              uint32_t outputs, struct glint_frame **out, uint32_t *samples,
                              struct glint_error *err)
{
    const struct glint_job *job = source->info->job;
    glint_status st = glint_frame_create(out, job->width, job->height, (int32_t)rect[0],
                                         (int32_t)rect[1], rect[2], rect[3], err);
    if (st)
        return st;
    struct making m = {.source = source, .frame = *out, .fewest = UINT32_MAX};
    st = fill(&m, *out, outputs, err);
    if (st)
        glint_frame_destroy(out);
    else if (samples)
        *samples = m.fewest;
    return st;
}
