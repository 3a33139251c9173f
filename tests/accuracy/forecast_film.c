#include "tests/accuracy/forecast_film.h"

#include "kernels/gk_film.h"
#include "tests/render/offline.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define STEP 16   // samples between two looks
#define LATE 2048 // after these
#define LATE_STEP 256
#define LATE_LOOK (FORECAST_EARLY + LATE / STEP - 1)

void *forecast_room(size_t n, size_t size)
{
    void *p = calloc(n, size);
    if (!p) {
        fprintf(stderr, "no memory\n");
        exit(1);
    }
    return p;
}

uint32_t forecast_film_looks(const struct forecast_films *films)
{
    const uint32_t n = films->samples;
    return n <= LATE ? FORECAST_EARLY + n / STEP : LATE_LOOK + 1 + (n - LATE) / LATE_STEP;
}

uint32_t forecast_film_samples(uint32_t look)
{
    static const uint32_t early[FORECAST_EARLY] = {2, 4, 8, 12};
    if (look < FORECAST_EARLY)
        return early[look];
    return look <= LATE_LOOK ? STEP * (look - FORECAST_EARLY + 1)
                             : LATE + LATE_STEP * (look - LATE_LOOK);
}

static size_t values_of(const struct forecast_films *films)
{
    return (size_t)3 * films->width * films->height;
}

static void name_of(const struct forecast_films *films, uint32_t seed, char out[512])
{
    snprintf(out, 512, "%s/%u.means", films->folder, seed);
}

static void die(const char *path)
{
    perror(path);
    exit(1);
}

// ---- rendering

static void take_tile(const struct forecast_films *films, glint_render *r, uint32_t tile,
                      uint32_t half, uint32_t samples, float *mean)
{
    struct glint_film_tile at;
    glint_film_tile(r->film, tile, &at);
    const float *planes = (const float *)glint_buffer_host(at.planes) + at.planes_offset;
    const bool wide = r->job.dial[GLINT_DIAL_PRECISION] == 0;
    const uint32_t left = tile % glint_film_columns(r->film) * GK_TILE_SIDE;
    const uint32_t top = tile / glint_film_columns(r->film) * GK_TILE_SIDE;
    for (uint32_t i = 0; i < GK_TILE_PIXELS; i++) {
        const uint32_t x = left + i % GK_TILE_SIDE, y = top + i / GK_TILE_SIDE;
        for (uint32_t c = 0; x < films->width && y < films->height && c < 3; c++)
            mean[3 * ((size_t)y * films->width + x) + c] =
                glint_film_mean(planes, wide, half, c, i, samples / 2);
    }
}

static void write_look(const struct forecast_films *films, glint_render *r, uint32_t samples,
                       FILE *out)
{
    const size_t values = values_of(films);
    float *mean = forecast_room(values, sizeof *mean);
    for (uint32_t half = 0; half < 2; half++) {
        for (uint32_t t = 0; t < glint_film_columns(r->film) * glint_film_rows(r->film); t++)
            take_tile(films, r, t, half, samples, mean);
        fwrite(mean, sizeof *mean, values, out);
    }
    free(mean);
}

static void render_seed(const struct forecast_films *films, const struct offline *o,
                        const struct glint_posed *rest, struct glint_job *job, FILE *out)
{
    struct glint_error err = {0};
    glint_render *r = NULL;
    job->stop = (struct glint_job_stop){.samples = forecast_film_samples(0)};
    if (glint_render_create(&r, o->devices, rest->resident, rest->pose, job, &err))
        offline_die("render", &err);
    for (uint32_t i = 0; i < forecast_film_looks(films); i++) {
        const uint32_t samples = forecast_film_samples(i);
        if (i && !glint_render_extend(r, samples, 0.0))
            offline_die("extend", &err);
        offline_render(o, r);
        write_look(films, r, samples, out);
    }
    glint_render_destroy(&r);
}

// A seed's file has its name once it is whole.
static void record_seed(const struct forecast_films *films, const struct offline *o,
                        const struct glint_posed *rest, struct glint_job *job)
{
    char path[512], partly[520];
    name_of(films, job->seed, path);
    snprintf(partly, sizeof partly, "%s.part", path);
    if (access(path, R_OK) == 0)
        return;
    FILE *out = fopen(partly, "wb");
    if (!out)
        die(partly);
    render_seed(films, o, rest, job, out);
    if (fclose(out) || rename(partly, path))
        die(path);
}

void forecast_film_record(const char *scene, const char *job_path,
                          const struct forecast_films *films)
{
    struct offline o;
    size_t length;
    offline_start(&o, 1);
    char *text = (char *)offline_read_file(job_path, &length);
    struct glint_job *job = offline_job(text);
    struct glint_posed rest = offline_load_posed(&o, scene);
    for (uint32_t k = 0; k < films->seeds; k++) {
        job->seed = films->first_seed + k;
        record_seed(films, &o, &rest, job);
    }
    free(text);
    glint_resident_release(&rest.resident);
    glint_job_destroy(&job);
    offline_finish(&o);
}

// ---- what was kept

float *forecast_film_read(const struct forecast_films *films, uint32_t seed)
{
    char path[512];
    const size_t count = forecast_film_looks(films) * 2 * values_of(films);
    float *halves = forecast_room(count, sizeof *halves);
    name_of(films, seed, path);
    FILE *in = fopen(path, "rb");
    if (!in || fread(halves, sizeof *halves, count, in) != count)
        die(path);
    fclose(in);
    return halves;
}

// Sums of a tile's halves, as wide films have them.
static void fill_tile(const struct forecast_films *films, const float *halves, uint32_t left,
                      uint32_t top, uint32_t n, float *planes)
{
    for (uint32_t half = 0; half < 2; half++)
        for (uint32_t i = 0; i < GK_TILE_PIXELS; i++) {
            const uint32_t x = left + i % GK_TILE_SIDE, y = top + i / GK_TILE_SIDE;
            const size_t at = half * values_of(films) + 3 * ((size_t)y * films->width + x);
            for (uint32_t c = 0; x < films->width && y < films->height && c < 3; c++) {
                const uint32_t plane = GK_PLANE_COLOUR + (half * 3 + c) * GK_SUM_PLANES;
                double *sum = (double *)(void *)(planes + plane * GK_TILE_PIXELS);
                sum[i] = (double)halves[at + c] * n;
            }
        }
}

static uint32_t clip(uint32_t from, uint32_t side)
{
    return side - from < GK_TILE_SIDE ? side - from : GK_TILE_SIDE;
}

void forecast_film_estimate(const struct forecast_films *films, const float *halves,
                            uint32_t samples, struct glint_film_estimate *out)
{
    const uint32_t columns = (films->width + GK_TILE_SIDE - 1) / GK_TILE_SIDE;
    const uint32_t rows = (films->height + GK_TILE_SIDE - 1) / GK_TILE_SIDE;
    struct glint_tile_estimate *tile = forecast_room((size_t)columns * rows, sizeof *tile);
    float *planes = forecast_room((size_t)GK_PLANES_BASE * GK_TILE_PIXELS, sizeof *planes);
    const struct glint_estimate_source source = {
        .planes = planes, .wide = true, .samples = samples};
    for (uint32_t t = 0; t < columns * rows; t++) {
        const uint32_t left = t % columns * GK_TILE_SIDE, top = t / columns * GK_TILE_SIDE;
        fill_tile(films, halves, left, top, samples / 2, planes);
        glint_estimate_tile(&tile[t], &source, clip(left, films->width), clip(top, films->height));
    }
    glint_estimate_film(out, tile, columns, rows, (uint64_t)films->width * films->height);
    free(planes);
    free(tile);
}
