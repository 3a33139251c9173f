// resolve.c - film tiles become frames: normalised planes with the channels and attributes of
// CONVENTIONS b.
#include "kernels/gk_film.h"
#include "kernels/gk_matte.h"
#include "protocol/cryptomatte.h"
#include "render/internal.h"
#include "render/ranking.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_LAYERS 10 // levels / 2

// Planes of the frame being made; NULL where an output is not asked for.
struct planes {
    float *rgba[4], *depth, *normal[3], *albedo[3], *samples, *variance[3], *flow[4];
    float *rank[GLINT_MATTE_LAYERS][MAX_LAYERS][4];
};

static const char *const matte_type[GLINT_MATTE_LAYERS] = {"CryptoObject", "CryptoMaterial",
                                                           "CryptoAsset"};
static const uint32_t matte_output[GLINT_MATTE_LAYERS] = {
    GLINT_OUT_CRYPTO_OBJECT, GLINT_OUT_CRYPTO_MATERIAL, GLINT_OUT_CRYPTO_ASSET};

const char *glint_render_matte_type(enum glint_matte_layer layer)
{
    return matte_type[layer];
}

static bool add_planes(struct glint_frame *f, float **out, const char *const *name, int n,
                       enum glint_pixel_type type)
{
    bool ok = true;
    for (int i = 0; i < n; i++)
        ok &= (out[i] = glint_frame_channel(f, name[i], type)) != NULL;
    return ok;
}

static bool add_ranks(struct glint_frame *f, struct planes *p, uint32_t levels,
                      enum glint_matte_layer layer)
{
    static const char letter[4] = {'R', 'G', 'B', 'A'};
    bool ok = true;
    for (uint32_t l = 0; l < (levels + 1) / 2; l++)
        for (int k = 0; k < 4; k++) {
            char name[32];
            snprintf(name, sizeof name, "%s%02u.%c", matte_type[layer], l, letter[k]);
            ok &= (p->rank[layer][l][k] = glint_frame_channel(f, name, GLINT_PIXEL_FLOAT)) != NULL;
        }
    return ok;
}

static glint_status make_planes(struct glint_frame *f, uint32_t outputs, uint32_t levels,
                                struct planes *p, struct glint_error *err)
{
    static const char *const rgba[] = {"R", "G", "B", "A"}, *const z[] = {"Z"},
                             *const samples[] = {"samples.Y"};
    static const char *const normal[] = {"N.X", "N.Y", "N.Z"};
    static const char *const albedo[] = {"albedo.R", "albedo.G", "albedo.B"};
    static const char *const variance[] = {"variance.R", "variance.G", "variance.B"};
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
    for (int l = 0; l < GLINT_MATTE_LAYERS; l++)
        ok &= !(outputs & matte_output[l]) || add_ranks(f, p, levels, l);
    return ok ? GLINT_OK
              : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a frame of %ux%u", f->width,
                           f->height);
}

// One pixel of a film tile and where it goes.
struct at {
    const float *plane; // of the tile
    bool wide;
    uint32_t i;       // pixel of the tile
    uint32_t samples; // > 0
    size_t out;       // pixel of the frame
};

// The square of a light that single precision holds may lie beyond it.
static float square(double x)
{
    return (float)fmin(x * x, FLT_MAX);
}

static void resolve_colour(const struct at *a, const struct planes *p)
{
    const uint32_t na = glint_half_samples(a->samples, 0), nb = glint_half_samples(a->samples, 1);
    const uint32_t *hits = (const uint32_t *)a->plane + GK_PLANE_HITS * GK_TILE_PIXELS;
    for (int c = 0; c < 3; c++) {
        const double ma = glint_film_mean(a->plane, a->wide, 0, c, a->i, na);
        const double mb = glint_film_mean(a->plane, a->wide, 1, c, a->i, nb);
        if (p->rgba[0])
            p->rgba[c][a->out] = (float)((ma * na + mb * nb) / a->samples);
        if (p->variance[0])
            p->variance[c][a->out] = nb ? square(0.5 * (ma - mb)) : 0.0f;
    }
    if (p->rgba[0])
        p->rgba[3][a->out] = (float)((double)hits[a->i] / a->samples);
}

static float aov_mean(const struct at *a, int plane, int component)
{
    const float *sum = a->plane + (GK_PLANES_BASE + plane + 2 * component) * GK_TILE_PIXELS;
    const double total = a->wide ? ((const double *)(const void *)sum)[a->i]
                                 : (double)sum[a->i] + (double)sum[a->i + GK_TILE_PIXELS];
    return (float)(total / a->samples);
}

static void resolve_aovs(const struct at *a, const struct planes *p)
{
    if (p->depth)
        p->depth[a->out] = a->plane[(GK_PLANES_BASE + GK_AOV_DEPTH) * GK_TILE_PIXELS + a->i];
    for (int c = 0; c < 3; c++) {
        if (p->normal[0])
            p->normal[c][a->out] = aov_mean(a, GK_AOV_NORMAL, c);
        if (p->albedo[0])
            p->albedo[c][a->out] = aov_mean(a, GK_AOV_ALBEDO, c);
    }
    for (int c = 0; c < 4 && p->flow[0]; c++)
        p->flow[c][a->out] = aov_mean(a, GK_AOV_FLOW, c);
    if (p->samples)
        p->samples[a->out] = (float)a->samples;
}

static void store_ranks(const struct glint_cryptomatte_rank *rank, uint32_t n, uint32_t levels,
                        float *const plane[MAX_LAYERS][4], size_t out)
{
    for (uint32_t k = 0; k < n && k < levels; k++) {
        memcpy(&plane[k / 2][2 * (k % 2)][out], &rank[k].id, 4); // bits, never arithmetic
        plane[k / 2][2 * (k % 2) + 1][out] = rank[k].coverage;
    }
}

static void resolve_mattes(const struct glint_view *r, const uint64_t *table, const struct at *a,
                           const struct planes *p)
{
    struct glint_cryptomatte_rank rank[GLINT_MAX_SLOTS];
    for (int l = 0; l < GLINT_MATTE_LAYERS; l++) {
        if (!p->rank[l][0][0])
            continue;
        const uint32_t n = glint_ranking(r->scene, table, r->job.matte_slots, l, a->samples, rank);
        store_ranks(rank, n, r->job.matte_levels, p->rank[l], a->out);
    }
}

// The pixels of one film tile that lie in the frame.
static void resolve_tile(const struct glint_view *r, uint32_t tile, uint32_t samples,
                         const struct glint_frame *f, const struct planes *p)
{
    struct glint_film_tile t;
    glint_film_tile(r->film, tile, &t);
    const uint32_t columns = glint_film_columns(r->film);
    const int64_t x0 = r->job.region[0] + (tile % columns) * GK_TILE_SIDE;
    const int64_t y0 = r->job.region[1] + (tile / columns) * GK_TILE_SIDE;
    struct at a = {(const float *)glint_buffer_host(t.planes) + t.planes_offset,
                   r->job.dial[GLINT_DIAL_PRECISION] == 0, 0, samples, 0};
    const uint64_t *tables =
        t.tables ? (const uint64_t *)glint_buffer_host(t.tables) + t.tables_offset : NULL;
    for (a.i = 0; a.i < GK_TILE_PIXELS; a.i++) {
        const int64_t x = x0 + a.i % GK_TILE_SIDE - f->x, y = y0 + a.i / GK_TILE_SIDE - f->y;
        if (x < 0 || y < 0 || x >= f->width || y >= f->height)
            continue;
        a.out = (size_t)y * f->width + (size_t)x;
        resolve_colour(&a, p);
        resolve_aovs(&a, p);
        if (tables)
            resolve_mattes(r, tables + (size_t)a.i * (r->job.matte_slots + 1), &a, p);
    }
}

static void blank_depth(const struct glint_frame *f, const struct planes *p)
{
    for (size_t i = 0; p->depth && i < (size_t)f->width * f->height; i++)
        p->depth[i] = 1e30f;
}

// Returns the fewest samples of the film tiles that the frame touches.
static uint32_t resolve_frame(const struct glint_view *r, const struct glint_frame *f,
                              const struct planes *p)
{
    const uint32_t columns = glint_film_columns(r->film);
    const uint32_t cx0 = ((uint32_t)f->x - r->job.region[0]) / GK_TILE_SIDE;
    const uint32_t cy0 = ((uint32_t)f->y - r->job.region[1]) / GK_TILE_SIDE;
    const uint32_t cx1 = ((uint32_t)f->x + f->width - 1 - r->job.region[0]) / GK_TILE_SIDE;
    const uint32_t cy1 = ((uint32_t)f->y + f->height - 1 - r->job.region[1]) / GK_TILE_SIDE;
    uint32_t fewest = UINT32_MAX;
    blank_depth(f, p);
    for (uint32_t y = cy0; y <= cy1; y++)
        for (uint32_t x = cx0; x <= cx1; x++) {
            const uint32_t tile = y * columns + x;
            const uint32_t samples = glint_film_read_begin(r->film, tile, r->epoch);
            if (samples)
                resolve_tile(r, tile, samples, f, p);
            glint_film_read_end(r->film, tile);
            fewest = samples < fewest ? samples : fewest;
        }
    return fewest;
}

glint_status glint_render_attributes(const struct glint_view *r, struct glint_frame *f,
                                     uint32_t samples)
{
    static const float rec709[8] = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};
    float to_camera[16], to_ndc[16];
    glint_render_matrices(r, to_camera, to_ndc);
    glint_status st = glint_frame_chromaticities(f, rec709);
    st = st ? st : glint_frame_matrix(f, "worldToCamera", to_camera);
    st = st ? st : glint_frame_matrix(f, "worldToNDC", to_ndc);
    st = st ? st : glint_frame_string(f, "software", "glint " PACKAGE_VERSION);
    st = st ? st : glint_frame_int(f, "glint/frame", (int32_t)r->job.frame);
    st = st ? st : glint_frame_int(f, "glint/samples", (int32_t)samples);
    st = st ? st : glint_frame_int(f, "glint/seed", (int32_t)r->job.seed);
    st = st ? st : glint_frame_string(f, "glint/sceneHash", glint_resident_revision(r->scene));
    return st ? st : glint_frame_int(f, "glint/complete", glint_render_complete(r->render));
}

static glint_status add_manifests(const struct glint_view *r, struct glint_frame *f,
                                  uint32_t outputs)
{
    glint_status st = GLINT_OK;
    for (int l = 0; !st && l < GLINT_MATTE_LAYERS; l++) {
        if (!(outputs & matte_output[l]))
            continue;
        char *manifest = glint_ranking_manifest(r->scene, l);
        st = manifest ? glint_cryptomatte_header(f, matte_type[l], manifest) : GLINT_E_NOMEM;
        free(manifest);
    }
    return st;
}

// A frame over a rectangle of the display window, inside the region.
static glint_status make_frame(const struct glint_view *r, const uint32_t rect[4], uint32_t outputs,
                               struct glint_frame **out, uint32_t *samples, struct glint_error *err)
{
    struct planes planes;
    uint32_t fewest = 0;
    glint_status st = glint_frame_create(out, r->job.width, r->job.height, (int32_t)rect[0],
                                         (int32_t)rect[1], rect[2], rect[3], err);
    if (!st)
        st = make_planes(*out, outputs, r->job.matte_levels, &planes, err);
    if (!st) {
        fewest = resolve_frame(r, *out, &planes);
        st = glint_render_attributes(r, *out, fewest);
    }
    if (!st)
        st = add_manifests(r, *out, outputs);
    if (st) {
        glint_frame_destroy(out);
        return err && err->count ? st : glint_fail(err, st, "", "no memory for the frame's header");
    }
    if (samples)
        *samples = fewest;
    return GLINT_OK;
}

glint_status glint_render_frame(glint_render *r, uint32_t outputs, struct glint_frame **out,
                                uint32_t *samples, struct glint_error *err)
{
    *out = NULL;
    if (outputs == 0 || outputs & ~r->job.outputs)
        return glint_fail(err, GLINT_E_RANGE, "/outputs", "the job does not render that output");
    struct glint_view *view = glint_view_hold(r);
    const glint_status st = make_frame(view, r->job.region, outputs, out, samples, err);
    glint_view_release(&view);
    return st;
}

#define CLIENT_TILE 64u

static uint32_t client_columns(const struct glint_render *r)
{
    return (r->job.region[2] + CLIENT_TILE - 1) / CLIENT_TILE;
}

uint32_t glint_render_tiles(const glint_render *r)
{
    return client_columns(r) * ((r->job.region[3] + CLIENT_TILE - 1) / CLIENT_TILE);
}

void glint_render_tile_rect(const glint_render *r, uint32_t tile, uint32_t rect[4])
{
    const uint32_t x = tile % client_columns(r) * CLIENT_TILE,
                   y = tile / client_columns(r) * CLIENT_TILE;
    rect[0] = r->job.region[0] + x;
    rect[1] = r->job.region[1] + y;
    rect[2] = r->job.region[2] - x < CLIENT_TILE ? r->job.region[2] - x : CLIENT_TILE;
    rect[3] = r->job.region[3] - y < CLIENT_TILE ? r->job.region[3] - y : CLIENT_TILE;
}

uint64_t glint_render_tile_version(const glint_render *r, uint32_t tile)
{
    const uint32_t side = CLIENT_TILE / GK_TILE_SIDE;
    return glint_film_version(r->film, tile % client_columns(r) * side,
                              tile / client_columns(r) * side, side, side);
}

glint_status glint_render_tile(glint_render *r, uint32_t tile, struct glint_frame **out,
                               uint32_t *samples, uint64_t *version, char revision[65],
                               struct glint_error *err)
{
    *out = NULL;
    if (tile >= glint_render_tiles(r))
        return glint_fail(err, GLINT_E_NOT_FOUND, "", "there is no tile %u", tile);
    uint32_t rect[4];
    glint_render_tile_rect(r, tile, rect);
    if (version) // before the pixels: what arrives in between is sent again, never missed
        *version = glint_render_tile_version(r, tile);
    struct glint_view *view = glint_view_hold(r);
    const glint_status st = make_frame(view, rect, GLINT_OUT_BEAUTY, out, samples, err);
    if (!st && revision)
        snprintf(revision, 65, "%s", glint_resident_revision(view->scene));
    glint_view_release(&view);
    return st;
}
