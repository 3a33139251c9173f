// film_matte.c - totals of every name, and the union matte of some.
#include "protocol/film_parts.h"

#include "kernels/gk_film.h"
#include "kernels/gk_matte.h"

#include <stdlib.h>
#include <string.h>

static glint_status no_coverage(struct glint_error *err)
{
    return glint_fail(
        err, GLINT_E_RANGE, "",
        "the job has none of the outputs crypto_object, crypto_material, crypto_asset");
}

// One pixel with samples: what it holds and has lost, their number and its place in the region.
struct covered {
    struct glint_film_held held;
    const uint64_t *lost; // [GK_MATTE_LOST_WORDS]
    uint32_t samples;
    size_t out;
};

typedef void visit_pixel(const struct glint_film_info *info, const struct covered *at, void *user);

// slot: room for what a pixel holds.
static uint32_t visit_tile(const struct glint_film_info *info, uint32_t tile,
                           const struct glint_film_pixels *pixels, uint64_t *slot,
                           visit_pixel *visit, void *user)
{
    const uint32_t columns = glint_film_info_columns(info), *region = info->job->region;
    const uint32_t x0 = tile % columns * GK_TILE_SIDE, y0 = tile / columns * GK_TILE_SIDE;
    uint32_t fewest = UINT32_MAX;
    for (uint32_t i = 0; i < GK_TILE_PIXELS; i++) {
        const uint32_t x = x0 + i % GK_TILE_SIDE, y = y0 + i / GK_TILE_SIDE;
        if (x >= region[2] || y >= region[3])
            continue;
        const uint32_t from = glint_film_shown_as(pixels, i);
        struct covered at = {{slot, 0},
                             pixels->table + (size_t)from * glint_film_info_words(info) +
                                 glint_film_info_slots(info),
                             glint_film_samples_of(pixels, from, 0) +
                                 glint_film_samples_of(pixels, from, 1),
                             (size_t)y * region[2] + x};
        const uint32_t own = from == i ? at.samples : 0;
        if (at.samples) {
            glint_film_held_read(info, pixels->table, from, &at.held);
            visit(info, &at, user);
        }
        fewest = own < fewest ? own : fewest;
    }
    return fewest;
}

// *fewest: samples of a pixel.
static glint_status each_pixel(const struct glint_film_source *s, visit_pixel *visit, void *user,
                               uint32_t *fewest, struct glint_error *err)
{
    const uint32_t tiles = glint_film_info_columns(s->info) * glint_film_info_rows(s->info);
    uint64_t *slot = malloc((glint_film_held_room(s->info) + (size_t)1) * sizeof *slot);
    glint_status st =
        slot ? GLINT_OK : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a pixel's mattes");
    *fewest = UINT32_MAX;
    for (uint32_t tile = 0; !st && tile < tiles; tile++) {
        struct glint_film_pixels pixels = {0};
        st = s->begin(s->user, tile, &pixels, err);
        if (st)
            break;
        const uint32_t samples = visit_tile(s->info, tile, &pixels, slot, visit, user);
        s->end(s->user, tile);
        *fewest = samples < *fewest ? samples : *fewest;
    }
    free(slot);
    return st;
}

struct sums {
    double *key[GLINT_MAX_MATTE_CLASSES]; // [mattes], pixels; of the classes that the job has
    double lost[2];
};

static void add_sums(const struct glint_film_info *info, const struct covered *at, void *user)
{
    struct sums *sum = user;
    const double unit = 1.0 / ((double)GK_MATTE_ONE * at->samples);
    (void)info;
    for (uint32_t s = 0; s < at->held.count; s++) {
        const uint32_t key = gk_matte_key(at->held.slot[s]);
        sum->key[gk_matte_class(key)][key & GK_MATTE_BASE_KEY] +=
            (double)gk_matte_amount(at->held.slot[s]) * unit;
    }
    sum->lost[0] += (double)at->lost[GK_MATTE_LOST_PRIMARY] * unit;
    sum->lost[1] += (double)at->lost[GK_MATTE_LOST_BOUNCED] * unit;
}

static int by_name(const void *a, const void *b)
{
    const struct glint_matte_total *p = a, *q = b;
    return strcmp(p->name, q->name);
}

static void add_total(struct glint_matte_total *to, const struct glint_matte_total *from)
{
    for (uint32_t c = 0; c < GLINT_MAX_MATTE_CLASSES; c++)
        to->coverage[c] += from->coverage[c];
}

// Names of the layer with the coverage of their keys; equal names become one. Returns their number.
static size_t collect(const struct glint_film_info *info, enum glint_matte_layer layer,
                      const struct sums *sum, struct glint_matte_total *out)
{
    size_t count = 0, kept = 0;
    for (uint32_t k = 2; k < info->mattes; k++) {
        if (!info->matte[k].id[layer])
            continue;
        struct glint_matte_total *t = &out[count++];
        *t = (struct glint_matte_total){info->matte[k].name[layer], info->matte[k].id[layer], {0}};
        for (uint32_t c = 0; c <= glint_matte_classes(info->job); c++)
            t->coverage[c] = sum->key[c][k];
    }
    qsort(out, count, sizeof *out, by_name);
    for (size_t i = 0; i < count; i++) {
        if (kept && strcmp(out[kept - 1].name, out[i].name) == 0)
            add_total(&out[kept - 1], &out[i]);
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

static bool list_layers(const struct glint_film_info *info, uint32_t layers, const struct sums *sum,
                        struct glint_matte_total *list, struct glint_matte_totals *out)
{
    for (uint32_t l = 0; l < GLINT_MATTE_LAYERS; l++) {
        if (!(layers >> l & 1))
            continue;
        out->count[l] = collect(info, (enum glint_matte_layer)l, sum, list);
        out->of[l] = with_names(list, out->count[l]);
        if (!out->of[l])
            return false;
    }
    memcpy(out->lost, sum->lost, sizeof out->lost);
    return true;
}

static glint_status add_up(const struct glint_film_source *s, uint32_t layers, double *keys,
                           struct glint_matte_total *list, struct glint_matte_totals *out,
                           struct glint_error *err)
{
    uint32_t fewest;
    struct sums sum = {.lost = {0.0, 0.0}};
    for (uint32_t c = 0; c <= glint_matte_classes(s->info->job); c++)
        sum.key[c] = keys + c * (s->info->mattes + (size_t)1);
    const glint_status st = each_pixel(s, add_sums, &sum, &fewest, err);
    if (st)
        return st;
    return list_layers(s->info, layers, &sum, list, out)
               ? GLINT_OK
               : glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u mattes", s->info->mattes);
}

glint_status glint_film_mattes(const struct glint_film_source *s, uint32_t layers,
                               struct glint_matte_totals *out, struct glint_error *err)
{
    *out = (struct glint_matte_totals){.lost = {0.0, 0.0}};
    if (!s->info->coverage)
        return no_coverage(err);
    const size_t n = s->info->mattes + (size_t)1, classes = glint_matte_classes(s->info->job) + 1;
    double *keys = calloc(n * classes, sizeof *keys);
    struct glint_matte_total *list = malloc(n * sizeof *list);
    const glint_status st = keys && list
                                ? add_up(s, layers, keys, list, out, err)
                                : glint_fail(err, GLINT_E_NOMEM, "", "no memory for %zu mattes", n);
    free(keys);
    free(list);
    if (st)
        glint_matte_totals_finish(out);
    return st;
}

void glint_matte_totals_finish(struct glint_matte_totals *totals)
{
    for (uint32_t l = 0; l < GLINT_MATTE_LAYERS; l++)
        free(totals->of[l]);
    *totals = (struct glint_matte_totals){.lost = {0.0, 0.0}};
}

struct selection {
    uint32_t classes;
    bool *key;    // [mattes]
    float *plane; // of the region
};

static void add_selected(const struct glint_film_info *info, const struct covered *at, void *user)
{
    const struct selection *of = user;
    uint64_t direct = 0, bounced = 0;
    for (uint32_t s = 0; s < at->held.count; s++) {
        const uint32_t key = gk_matte_key(at->held.slot[s]);
        if (of->classes >> gk_matte_class(key) & 1 && of->key[key & GK_MATTE_BASE_KEY])
            *(gk_matte_class(key) ? &bounced : &direct) += gk_matte_amount(at->held.slot[s]);
    }
    // Of the class of reflections and that of refractions nothing is seen directly; others hold that.
    const uint64_t larger = direct > bounced ? direct : bounced;
    const uint64_t amount = info->job->matte_classes ? direct + bounced : larger;
    of->plane[at->out] = (float)((double)amount / ((double)GK_MATTE_ONE * at->samples));
}

static glint_status select_names(const struct glint_film_info *info, enum glint_matte_layer layer,
                                 const char *const *names, size_t count, bool *selected,
                                 struct glint_error *err)
{
    glint_status st = GLINT_OK;
    for (size_t i = 0; i < count; i++) {
        bool found = false;
        for (uint32_t k = 2; k < info->mattes; k++)
            if (info->matte[k].id[layer] && strcmp(info->matte[k].name[layer], names[i]) == 0)
                found = selected[k] = true;
        if (!found)
            st = glint_fail(err, GLINT_E_NOT_FOUND, "/name", "no %s is named \"%s\"",
                            glint_matte_layer_type(layer), names[i]);
    }
    return st;
}

static glint_status fill_matte(const struct glint_film_source *s, struct selection *of,
                               struct glint_frame *f, struct glint_error *err)
{
    uint32_t fewest = 0;
    of->plane = glint_frame_channel(f, "A", GLINT_PIXEL_FLOAT);
    if (of->plane) {
        const glint_status st = each_pixel(s, add_selected, of, &fewest, err);
        if (st)
            return st;
    }
    return of->plane && !glint_film_attributes(s, f, fewest)
               ? GLINT_OK
               : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a matte");
}

static glint_status unite(const struct glint_film_source *s, enum glint_matte_layer layer,
                          const char *const *names, size_t count, struct selection *of,
                          struct glint_frame **out, struct glint_error *err)
{
    const struct glint_job *job = s->info->job;
    glint_status st = select_names(s->info, layer, names, count, of->key, err);
    if (!st)
        st = glint_frame_create(out, job->width, job->height, (int32_t)job->region[0],
                                (int32_t)job->region[1], job->region[2], job->region[3], err);
    if (st)
        return st;
    st = fill_matte(s, of, *out, err);
    if (st)
        glint_frame_destroy(out);
    return st;
}

glint_status glint_film_matte(const struct glint_film_source *s, enum glint_matte_layer layer,
                              uint32_t classes, const char *const *names, size_t count,
                              struct glint_frame **out, struct glint_error *err)
{
    *out = NULL;
    if (!s->info->coverage)
        return no_coverage(err);
    struct selection of = {.classes = classes,
                           .key = calloc(s->info->mattes + (size_t)1, sizeof *of.key)};
    const glint_status st = of.key ? unite(s, layer, names, count, &of, out, err)
                                   : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a matte");
    free(of.key);
    return st;
}
