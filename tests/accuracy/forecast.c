// forecast - what jobs say of their own error and of the samples that they need, beside what is
// true. For tests/accuracy/forecast.py.
//
// usage: forecast measure SCENE.{glb,json} JOB.json SEEDS SAMPLES FIRST
//        forecast predict FIRST < measured
//
// measure renders the job with seeds 1..SEEDS for SAMPLES samples. A seed's reference is the mean of
// the others; how far that is off itself is taken from the others' own estimates and subtracted.
// Writes CSV, each row with its seed:
//   point,SEED,samples,error,spread               of the curve
//   cells,SEED,tail,relative,spread,...           parts of the picture at FIRST samples
//   look,SEED,samples,error,true,linear,true,tone-mapped,true,tail
// predict reads these and writes, for targets 1/2, 1/4 and 1/8 of the error at FIRST samples,
//   forecast,SEED,divisor,rare,samples at which the true error is first that small (0: later),
//            quantiles of the forecast: .5, then .025 .05 .1 .25 .75 .9 .95 .975
#include "kernels/gk_film.h"
#include "tests/render/offline.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define STEP 16 // samples between two looks at the true error
#define MAX_LOOKS 4096

struct look {
    struct glint_estimate estimate;
    float *mean; // [pixels][3]
};

struct run {
    struct offline o;
    struct glint_posed rest;
    struct glint_job *job;
    uint32_t seeds, looks, first;
    size_t values;      // 3 for each pixel
    struct look **seed; // [seeds][looks]
};

static void *room(size_t n, size_t size)
{
    void *p = calloc(n, size);
    if (!p) {
        fprintf(stderr, "no memory\n");
        exit(1);
    }
    return p;
}

// ---- rendering

static void take_tile(const struct run *run, glint_render *r, uint32_t tile, uint32_t samples,
                      float *mean)
{
    struct glint_film_tile at;
    glint_film_tile(r->film, tile, &at);
    const float *planes = (const float *)glint_buffer_host(at.planes) + at.planes_offset;
    const bool wide = run->job->dial[GLINT_DIAL_PRECISION] == 0;
    const uint32_t columns = glint_film_columns(r->film), width = run->job->region[2];
    for (uint32_t i = 0; i < GK_TILE_PIXELS; i++) {
        const uint32_t x = tile % columns * GK_TILE_SIDE + i % GK_TILE_SIDE;
        const uint32_t y = tile / columns * GK_TILE_SIDE + i / GK_TILE_SIDE;
        for (uint32_t c = 0; x < width && y < run->job->region[3] && c < 3; c++)
            mean[3 * ((size_t)y * width + x) + c] =
                0.5f * (glint_film_mean(planes, wide, 0, c, i, samples / 2) +
                        glint_film_mean(planes, wide, 1, c, i, samples / 2));
    }
}

static void take_look(const struct run *run, glint_render *r, uint32_t samples, struct look *out)
{
    out->estimate = r->estimate.whole;
    out->mean = room(run->values, sizeof *out->mean);
    for (uint32_t t = 0; t < glint_film_columns(r->film) * glint_film_rows(r->film); t++)
        take_tile(run, r, t, samples, out->mean);
}

static void print_cells(const struct glint_film_estimate *e, uint32_t seed)
{
    printf("cells,%u,%.6g", seed, e->whole.tail);
    for (uint32_t c = 0; c < e->cells; c++)
        printf(",%.9g,%.9g", e->relative[c], e->spread[c]);
    puts("");
}

static void render_seed(struct run *run, uint32_t seed)
{
    struct glint_error err = {0};
    glint_render *r = NULL;
    run->job->seed = seed + 1;
    run->job->stop = (struct glint_job_stop){.samples = STEP};
    run->seed[seed] = room(run->looks, sizeof **run->seed);
    if (glint_render_create(&r, run->o.devices, run->rest.resident, run->rest.pose, run->job, &err))
        offline_die("render", &err);
    for (uint32_t i = 0; i < run->looks; i++) {
        const uint32_t samples = STEP * (i + 1);
        if (i && !glint_render_extend(r, samples, 0.0))
            offline_die("extend", &err);
        offline_render(&run->o, r);
        take_look(run, r, samples, &run->seed[seed][i]);
        if (samples == run->first)
            print_cells(&r->estimate, seed);
    }
    for (uint32_t i = 0; i < r->points; i++)
        printf("point,%u,%u,%.9g,%.9g\n", seed, r->curve[i].samples, r->curve[i].error,
               r->curve[i].spread);
    glint_render_destroy(&r);
}

// ---- the truth: squares of errors, as the estimate has them

static double toned(const float *c, int channel)
{
    return c[channel] / (1.0 + fmax(c[0], fmax(c[1], c[2])));
}

static struct glint_estimate squares(const struct run *run, const float *mean,
                                     const float *reference)
{
    const double values = (double)run->values;
    struct glint_estimate e = {0};
    for (size_t p = 0; p < run->values; p += 3)
        for (int c = 0; c < 3; c++) {
            const double d = (double)mean[p + c] - reference[p + c], r = reference[p + c];
            const double t = toned(mean + p, c) - toned(reference + p, c);
            e.error += d * d / (r * r + 0.01) / values;
            e.linear += d * d / values;
            e.tone_mapped += 3.0 * t * t / values;
        }
    return e;
}

// The mean of the other seeds' last looks; *noise: squares of its own errors.
static void make_reference(const struct run *run, uint32_t seed, float *out,
                           struct glint_estimate *noise)
{
    const double others = run->seeds - 1.0;
    memset(out, 0, run->values * sizeof *out);
    *noise = (struct glint_estimate){0};
    for (uint32_t k = 0; k < run->seeds; k++) {
        const struct look *last = &run->seed[k][run->looks - 1];
        const struct glint_estimate *e = &last->estimate;
        if (k == seed)
            continue;
        for (size_t i = 0; i < run->values; i++)
            out[i] += last->mean[i] / (float)others;
        noise->error += e->error * e->error / (others * others);
        noise->linear += e->linear * e->linear / (others * others);
        noise->tone_mapped += e->tone_mapped * e->tone_mapped / (others * others);
    }
}

static double root(double square, double noise)
{
    return sqrt(fmax(square - noise, 0.0));
}

static void print_looks(const struct run *run, uint32_t seed)
{
    struct glint_estimate noise;
    float *reference = room(run->values, sizeof *reference);
    make_reference(run, seed, reference, &noise);
    for (uint32_t i = 0; i < run->looks; i++) {
        const struct look *l = &run->seed[seed][i];
        const struct glint_estimate *e = &l->estimate, s = squares(run, l->mean, reference);
        printf("look,%u,%u,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.4g\n", seed, STEP * (i + 1), e->error,
               root(s.error, noise.error), e->linear, root(s.linear, noise.linear), e->tone_mapped,
               root(s.tone_mapped, noise.tone_mapped), e->tail);
    }
    free(reference);
}

static void measure(struct run *run, char **argument)
{
    size_t length;
    offline_start(&run->o, 1);
    char *text = (char *)offline_read_file(argument[1], &length);
    run->job = offline_job(text);
    run->rest = offline_load_posed(&run->o, argument[0]);
    run->seeds = (uint32_t)atoi(argument[2]);
    run->looks = (uint32_t)atoi(argument[3]) / STEP;
    run->first = (uint32_t)atoi(argument[4]);
    run->values = (size_t)3 * run->job->region[2] * run->job->region[3];
    run->seed = room(run->seeds, sizeof *run->seed);
    for (uint32_t k = 0; k < run->seeds; k++)
        render_seed(run, k);
    for (uint32_t k = 0; k < run->seeds; k++)
        print_looks(run, k);
    for (uint32_t k = 0; k < run->seeds; k++) {
        for (uint32_t i = 0; i < run->looks; i++)
            free(run->seed[k][i].mean);
        free(run->seed[k]);
    }
    free(run->seed);
    free(text);
    glint_resident_release(&run->rest.resident);
    glint_job_destroy(&run->job);
    offline_finish(&run->o);
}

// ---- forecasts from what was measured

struct seed {
    struct glint_convergence_point curve[GLINT_CURVE_POINTS];
    uint32_t points, looks;
    struct glint_film_estimate now;
    double error[MAX_LOOKS]; // the true one
};

// Samples at which the true error is first at most `target`, between two looks; 0: later.
static double reached(const struct seed *s, double target)
{
    for (uint32_t i = 0; i < s->looks; i++) {
        const double n = STEP * (i + 1.0);
        if (s->error[i] > target)
            continue;
        if (!i)
            return n;
        const double slope = log(s->error[i - 1] / s->error[i]) / log(n / (n - STEP));
        return n * pow(s->error[i] / target, 1.0 / slope);
    }
    return 0.0;
}

static void predict_one(const struct seed *s, uint32_t number, uint32_t first, int divisor)
{
    static const double level[] = {0.5, 0.025, 0.05, 0.1, 0.25, 0.75, 0.9, 0.95, 0.975};
    double draw[GLINT_FORECAST_DRAWS];
    const struct glint_forecast_input in = {.curve = s->curve,
                                            .points = s->points,
                                            .now = &s->now,
                                            .samples = first,
                                            .target = s->now.whole.error / divisor,
                                            .limit = GLINT_MAX_SAMPLES};
    struct glint_forecast f;
    glint_forecast_make(&f, &in);
    if (!glint_forecast_draw(draw, &in))
        return;
    printf("forecast,%u,%d,%d,%.6g", number, divisor, f.lower_bound, reached(s, in.target));
    for (size_t i = 0; i < sizeof level / sizeof *level; i++)
        printf(",%.6g", draw[(int)(level[i] * (GLINT_FORECAST_DRAWS - 1) + 0.5)]);
    puts("");
}

static void predict(const struct seed *s, uint32_t number, uint32_t first)
{
    for (int divisor = 2; divisor <= 8; divisor *= 2)
        predict_one(s, number, first, divisor);
}

static void read_cells(struct seed *s, const char *at)
{
    struct glint_film_estimate *e = &s->now;
    int used = 0;
    sscanf(at, "%lf%n", &e->whole.tail, &used);
    for (at += used;
         sscanf(at, ",%lf,%lf%n", &e->relative[e->cells], &e->spread[e->cells], &used) == 2;
         at += used)
        e->cells++;
}

static void read_point(struct seed *s, const char *at, uint32_t first)
{
    struct glint_convergence_point p = {0};
    if (sscanf(at, "%u,%lf,%lf", &p.samples, &p.error, &p.spread) != 3 || p.samples > first)
        return;
    s->curve[s->points++] = p;
    s->now.whole.error = p.error;
    s->now.whole.spread = p.spread;
}

static void read_line(struct seed *s, const char *line, const char *at, uint32_t first)
{
    if (!strncmp(line, "cells", 5))
        read_cells(s, at);
    else if (!strncmp(line, "point", 5))
        read_point(s, at, first);
    else if (s->looks < MAX_LOOKS && sscanf(at, "%*u,%*f,%lf", &s->error[s->looks]) == 1)
        s->looks++;
}

static void predict_all(uint32_t first)
{
    static struct seed seed[64];
    static char line[1 << 16];
    uint32_t number, seeds = 0;
    while (fgets(line, sizeof line, stdin)) {
        int used = 0;
        if (sscanf(line, "%*[a-z],%u,%n", &number, &used) != 1 || !used || number >= 64)
            continue;
        read_line(&seed[number], line, line + used, first);
        seeds = number >= seeds ? number + 1 : seeds;
    }
    for (number = 0; number < seeds; number++)
        predict(&seed[number], number, first);
}

int main(int argc, char **argv)
{
    static struct run run;
    if (argc == 7 && !strcmp(argv[1], "measure")) {
        measure(&run, argv + 2);
    } else if (argc == 3 && !strcmp(argv[1], "predict")) {
        predict_all((uint32_t)atoi(argv[2]));
    } else {
        fprintf(stderr, "usage: forecast measure SCENE JOB.json SEEDS SAMPLES FIRST\n"
                        "       forecast predict FIRST < measured\n");
        return 64;
    }
    return 0;
}
