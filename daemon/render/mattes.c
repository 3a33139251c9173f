// mattes.c - totals of every name, and the union matte of some.
#include "kernels/gk_film.h"
#include "kernels/gk_matte.h"
#include "render/internal.h"
#include "render/ranking.h"

#include <stdlib.h>
#include <string.h>

static bool has_coverage(const struct glint_view *r)
{
    return glint_plan_has(&r->plan, GLINT_PASS_COVERAGE);
}

static glint_status no_coverage(struct glint_error *err)
{
    return glint_fail(
        err, GLINT_E_RANGE, "",
        "the job has none of the outputs crypto_object, crypto_material, crypto_asset");
}

// A tile's slot tables while they are locked.
struct tables {
    const uint64_t *table; // [256][slots + 1]
    uint32_t x, y;         // of the tile in the region
    uint32_t w, h;         // of it inside the region
    uint32_t samples;
};

typedef void visit_tables(const struct glint_view *r, const struct tables *t, void *user);

// Returns the fewest samples of a tile.
static uint32_t each_tile(const struct glint_view *r, visit_tables *visit, void *user)
{
    const uint32_t columns = glint_film_columns(r->film), rows = glint_film_rows(r->film);
    uint32_t fewest = UINT32_MAX;
    for (uint32_t tile = 0; tile < columns * rows; tile++) {
        struct glint_film_tile at;
        struct tables t = {.x = tile % columns * GK_TILE_SIDE, .y = tile / columns * GK_TILE_SIDE};
        glint_film_tile(r->film, tile, &at);
        t.table = (const uint64_t *)glint_buffer_host(at.tables) + at.tables_offset;
        t.w = r->job.region[2] - t.x < GK_TILE_SIDE ? r->job.region[2] - t.x : GK_TILE_SIDE;
        t.h = r->job.region[3] - t.y < GK_TILE_SIDE ? r->job.region[3] - t.y : GK_TILE_SIDE;
        t.samples = glint_film_read_begin(r->film, tile, r->epoch);
        if (t.samples)
            visit(r, &t, user);
        glint_film_read_end(r->film, tile);
        fewest = t.samples < fewest ? t.samples : fewest;
    }
    return fewest;
}

struct totals {
    double *key; // [mattes], pixels
    double lost;
};

static void add_totals(const struct glint_view *r, const struct tables *t, void *user)
{
    struct totals *sum = user;
    const uint32_t slots = r->job.matte_slots;
    const double unit = 1.0 / ((double)GK_MATTE_ONE * t->samples);
    for (uint32_t y = 0; y < t->h; y++)
        for (uint32_t x = 0; x < t->w; x++) {
            const uint64_t *table = t->table + (size_t)(y * GK_TILE_SIDE + x) * (slots + 1);
            for (uint32_t s = 0; s < slots; s++)
                sum->key[gk_matte_key(table[s])] += (double)gk_matte_amount(table[s]) * unit;
            sum->lost += (double)table[slots] * unit;
        }
}

static int by_name(const void *a, const void *b)
{
    const struct glint_matte_total *p = a, *q = b;
    return strcmp(p->name, q->name);
}

// Names of the layer with the coverage of their keys; equal names become one. Returns their number.
static size_t collect(const struct glint_resident *scene, enum glint_matte_layer layer,
                      const double *key, struct glint_matte_total *out)
{
    const struct glint_matte_key *keys;
    const uint32_t n = glint_resident_mattes(scene, &keys);
    size_t count = 0, kept = 0;
    for (uint32_t k = 2; k < n; k++)
        if (keys[k].id[layer])
            out[count++] =
                (struct glint_matte_total){keys[k].name[layer], keys[k].id[layer], key[k]};
    qsort(out, count, sizeof *out, by_name);
    for (size_t i = 0; i < count; i++) {
        if (kept && strcmp(out[kept - 1].name, out[i].name) == 0)
            out[kept - 1].coverage += out[i].coverage;
        else
            out[kept++] = out[i];
    }
    return kept;
}

// A copy of the list in one block with its names, which outlives the scene; NULL without memory.
static struct glint_matte_total *with_names(const struct glint_matte_total *list, size_t count)
{
    size_t bytes = (count + 1) * sizeof *list;
    for (size_t i = 0; i < count; i++)
        bytes += strlen(list[i].name) + 1;
    struct glint_matte_total *out = malloc(bytes);
    char *name = (char *)(out + count + 1);
    for (size_t i = 0; out && i < count; i++) {
        out[i] = list[i];
        out[i].name = name;
        name = stpcpy(name, list[i].name) + 1;
    }
    return out;
}

static glint_status add_up(const struct glint_view *r, enum glint_matte_layer layer,
                           struct glint_matte_total **out, size_t *count, double *lost,
                           struct glint_error *err)
{
    if (!has_coverage(r))
        return no_coverage(err);
    const struct glint_matte_key *keys;
    const uint32_t n = glint_resident_mattes(r->scene, &keys);
    struct totals sum = {calloc(n, sizeof *sum.key), 0.0};
    struct glint_matte_total *list = malloc(n * sizeof *list);
    if (!sum.key || !list) {
        free(sum.key);
        free(list);
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u mattes", n);
    }
    each_tile(r, add_totals, &sum);
    *count = collect(r->scene, layer, sum.key, list);
    *lost = sum.lost;
    *out = with_names(list, *count);
    free(sum.key);
    free(list);
    return *out ? GLINT_OK : glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u mattes", n);
}

struct selection {
    const bool *key; // [mattes]
    float *plane;
};

static void add_selected(const struct glint_view *r, const struct tables *t, void *user)
{
    const struct selection *of = user;
    const uint32_t slots = r->job.matte_slots;
    for (uint32_t y = 0; y < t->h; y++)
        for (uint32_t x = 0; x < t->w; x++) {
            const uint64_t *table = t->table + (size_t)(y * GK_TILE_SIDE + x) * (slots + 1);
            uint64_t amount = 0;
            for (uint32_t s = 0; s < slots; s++)
                amount += of->key[gk_matte_key(table[s])] ? gk_matte_amount(table[s]) : 0;
            of->plane[(size_t)(t->y + y) * r->job.region[2] + t->x + x] =
                (float)((double)amount / ((double)GK_MATTE_ONE * t->samples));
        }
}

static glint_status select_names(const struct glint_resident *scene, enum glint_matte_layer layer,
                                 const char *const *names, size_t count, bool *selected,
                                 struct glint_error *err)
{
    const struct glint_matte_key *keys;
    const uint32_t n = glint_resident_mattes(scene, &keys);
    glint_status st = GLINT_OK;
    for (size_t i = 0; i < count; i++) {
        bool found = false;
        for (uint32_t k = 2; k < n; k++)
            if (keys[k].id[layer] && strcmp(keys[k].name[layer], names[i]) == 0)
                found = selected[k] = true;
        if (!found)
            st = glint_fail(err, GLINT_E_NOT_FOUND, "/name", "no %s is named \"%s\"",
                            glint_render_matte_type(layer), names[i]);
    }
    return st;
}

static glint_status fill_matte(const struct glint_view *r, const bool *selected,
                               struct glint_frame *f)
{
    struct selection of = {selected, glint_frame_channel(f, "A", GLINT_PIXEL_FLOAT)};
    if (!of.plane)
        return GLINT_E_NOMEM;
    return glint_render_attributes(r, f, each_tile(r, add_selected, &of));
}

static glint_status unite(const struct glint_view *r, enum glint_matte_layer layer,
                          const char *const *names, size_t count, struct glint_frame **out,
                          struct glint_error *err)
{
    if (!has_coverage(r))
        return no_coverage(err);
    const struct glint_matte_key *keys;
    bool *selected = calloc(glint_resident_mattes(r->scene, &keys), sizeof *selected);
    if (!selected)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a matte");
    const uint32_t *region = r->job.region;
    glint_status st = select_names(r->scene, layer, names, count, selected, err);
    if (!st)
        st = glint_frame_create(out, r->job.width, r->job.height, (int32_t)region[0],
                                (int32_t)region[1], region[2], region[3], err);
    if (!st && fill_matte(r, selected, *out)) {
        st = glint_fail(err, GLINT_E_NOMEM, "", "no memory for a matte");
        glint_frame_destroy(out);
    }
    free(selected);
    return st;
}

glint_status glint_render_mattes(glint_render *render, enum glint_matte_layer layer,
                                 struct glint_matte_total **out, size_t *count, double *lost,
                                 struct glint_error *err)
{
    *out = NULL;
    *count = 0;
    struct glint_view *view = glint_view_hold(render);
    const glint_status st = add_up(view, layer, out, count, lost, err);
    glint_view_release(&view);
    return st;
}

glint_status glint_render_matte(glint_render *render, enum glint_matte_layer layer,
                                const char *const *names, size_t count, struct glint_frame **out,
                                struct glint_error *err)
{
    *out = NULL;
    struct glint_view *view = glint_view_hold(render);
    const glint_status st = unite(view, layer, names, count, out, err);
    glint_view_release(&view);
    return st;
}
