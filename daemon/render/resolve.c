// resolve.c - the pixels of a render as frames, tiles and mattes.
#include "kernels/gk_film.h"
#include "render/archive.h"
#include "render/capture.h"

#include <stdio.h>

// What a picture is made of: of one moment, or of a file.
struct origin {
    struct glint_capture capture;
    struct glint_film_source source;
};

static glint_status origin_begin(struct origin *o, glint_render *r, struct glint_error *err)
{
    if (r->archive)
        return glint_archive_source(r->archive, &o->source, err);
    const glint_status st = glint_capture_begin(&o->capture, r, err);
    o->source = o->capture.source;
    return st;
}

static void origin_end(struct origin *o, glint_render *r)
{
    if (r->archive)
        glint_archive_release(&o->source);
    else
        glint_capture_end(&o->capture);
}

glint_status glint_render_frame(glint_render *r, uint32_t outputs, struct glint_frame **out,
                                uint32_t *samples, struct glint_error *err)
{
    *out = NULL;
    struct origin o;
    if (outputs == 0 || outputs & ~r->job.outputs)
        return glint_fail(err, GLINT_E_RANGE, "/outputs", "the job does not render that output");
    glint_status st = origin_begin(&o, r, err);
    if (st)
        return st;
    st = glint_film_frame(&o.source, r->job.region, outputs, out, samples, err);
    origin_end(&o, r);
    return st;
}

glint_status glint_render_mattes(glint_render *r, uint32_t layers, struct glint_matte_totals *out,
                                 struct glint_error *err)
{
    struct origin o;
    *out = (struct glint_matte_totals){.lost = {0.0, 0.0}};
    glint_status st = origin_begin(&o, r, err);
    if (st)
        return st;
    st = glint_film_mattes(&o.source, layers, out, err);
    origin_end(&o, r);
    return st;
}

glint_status glint_render_matte(glint_render *r, enum glint_matte_layer layer, uint32_t classes,
                                const char *const *names, size_t count, struct glint_frame **out,
                                struct glint_error *err)
{
    struct origin o;
    *out = NULL;
    glint_status st = origin_begin(&o, r, err);
    if (st)
        return st;
    st = glint_film_matte(&o.source, layer, classes, names, count, out, err);
    origin_end(&o, r);
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

// Of a file: whether all of its film tiles have samples.
static bool tile_has_samples(const glint_render *r, uint32_t tile)
{
    const glint_film_file *file = glint_archive_file(r->archive);
    const struct glint_film_info *info = &glint_film_file_header(file)->info;
    const uint32_t columns = glint_film_info_columns(info), rows = glint_film_info_rows(info);
    const uint32_t side = CLIENT_TILE / GK_TILE_SIDE;
    const uint32_t x0 = tile % client_columns(r) * side, y0 = tile / client_columns(r) * side;
    for (uint32_t y = y0; y < y0 + side && y < rows; y++)
        for (uint32_t x = x0; x < x0 + side && x < columns; x++)
            if (!glint_film_file_samples(file, y * columns + x))
                return false;
    return true;
}

uint64_t glint_render_tile_version(const glint_render *r, uint32_t tile)
{
    const uint32_t side = CLIENT_TILE / GK_TILE_SIDE;
    if (r->archive) // it never changes
        return tile_has_samples(r, tile);
    return glint_film_version(r->film, tile % client_columns(r) * side,
                              tile / client_columns(r) * side, side, side);
}

uint64_t glint_render_newest_version(const glint_render *r)
{
    return r->archive ? 1 : glint_film_newest(r->film);
}

// A tile or less: as it is in the file, or now. Now it is read in place: its film tiles are locked
// one after the other.
struct spot {
    struct glint_view *view; // NULL: of a file
    bool blank;              // one has nothing to show
    struct glint_film_source source;
};

static glint_status lock_tile(void *user, uint32_t tile, struct glint_film_pixels *out,
                              struct glint_error *err)
{
    (void)err; // memory cannot fail
    struct spot *spot = user;
    const struct glint_view *view = spot->view;
    struct glint_film_tile at;
    const struct glint_film_state state = glint_film_read_begin(view->film, tile, view->epoch);
    glint_film_tile(view->film, tile, &at);
    out->planes = (const float *)glint_buffer_host(at.planes) + at.planes_offset;
    if (at.tables)
        out->table = (const uint64_t *)glint_buffer_host(at.tables) + at.tables_offset;
    spot->blank |= !state.samples && !state.step;
    out->step = state.step;
    for (uint32_t h = 0; h < 2; h++)
        out->half[h] =
            glint_film_half(glint_render_first(view->render), state.step ? 1 : state.samples, h);
    return GLINT_OK;
}

static void unlock_tile(void *user, uint32_t tile)
{
    const struct spot *spot = user;
    glint_film_read_end(spot->view->film, tile);
}

static glint_status spot_begin(struct spot *s, glint_render *r, struct glint_error *err)
{
    *s = (struct spot){0};
    if (r->archive)
        return glint_archive_source(r->archive, &s->source, err);
    s->view = glint_view_hold(r);
    s->source = (struct glint_film_source){.info = &s->view->info,
                                           .complete = glint_render_complete(r),
                                           .user = s,
                                           .begin = lock_tile,
                                           .end = unlock_tile};
    return GLINT_OK;
}

static void spot_end(struct spot *s)
{
    if (s->view)
        glint_view_release(&s->view);
    else
        glint_archive_release(&s->source);
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
    struct spot s;
    glint_status st = spot_begin(&s, r, err);
    if (st)
        return st;
    st = glint_film_frame(&s.source, rect, GLINT_OUT_BEAUTY, out, samples, err);
    if (revision)
        snprintf(revision, 65, "%s", s.source.info->revision);
    if (version && s.blank) // a move came in between
        *version = 0;
    spot_end(&s);
    return st;
}

glint_status glint_render_pick(glint_render *r, uint32_t x, uint32_t y,
                               struct glint_matte_found **out, size_t *count,
                               struct glint_error *err)
{
    const uint32_t outputs = r->job.outputs & GLINT_OUT_CRYPTO, *region = r->job.region;
    *out = NULL;
    *count = 0;
    if (!outputs)
        return glint_fail(
            err, GLINT_E_RANGE, "",
            "the job has none of the outputs crypto_object, crypto_material, crypto_asset");
    if (x - region[0] >= region[2] || y - region[1] >= region[3])
        return glint_fail(err, GLINT_E_RANGE, "", "x, y: %u, %u is not in the region", x, y);
    struct spot s;
    glint_status st = spot_begin(&s, r, err);
    if (st)
        return st;
    st = glint_film_pick(&s.source, x, y, outputs, out, count, err);
    spot_end(&s);
    return st;
}
