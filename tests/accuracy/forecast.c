// forecast - what jobs say of their own error and of the samples that they need, beside what is
// true. For tests/accuracy/forecast.py.
//
// usage: forecast record  FOLDER WIDTH HEIGHT SAMPLES SEED SEEDS SCENE.{glb,json} JOB.json
//        forecast measure FOLDER WIDTH HEIGHT SAMPLES SEED SEEDS
//        forecast predict FIRST DIVISOR... < measured
//        forecast scores  SEEDS SCENE.{glb,json} JOB.json
//
// record renders the job, of that size, with seeds SEED, SEED + 1, ... for SAMPLES samples, and keeps
// their films in FOLDER; seeds that are there are left alone. measure takes these. A seed's reference
// is the mean of the others; its own variance is that of the others among each other and is
// subtracted. Writes CSV, each row with its seed:
//   point,SEED,samples,error,spread               of the curve
//   cells,SEED,samples,tail,lift,relative,spread,...   parts of the picture at each point from 16 on
//   look,SEED,samples,error,true,linear,true,tone-mapped,true,rare events
// scores renders the job with seeds 1..SEEDS and prints how many values of pixels there are, and the
// share that is as near to the truth as it says in 95 of 100 cases; see scores.h.
// predict reads these and writes, for targets that are the error at FIRST samples over each DIVISOR,
//   forecast,SEED,divisor,lower bound,samples at which the true error is first that small (0: later),
//            quantiles of the forecast: .5, then .025 .05 .1 .25 .75 .9 .95 .975
#include "render/forecast.h"
#include "tests/accuracy/forecast_film.h"
#include "tests/accuracy/scores.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FIRST_LOOK 16 // samples
#define MAX_LOOKS 4096
#define MAX_SEEDS 1024 // their numbers

// ---- what a job says

static void print_cells(const struct glint_film_estimate *e, uint32_t seed, uint32_t samples)
{
    printf("cells,%u,%u,%.6g,%.6g", seed, samples, e->whole.tail, e->whole.lift);
    for (uint32_t c = 0; c < e->cells; c++)
        printf(",%.9g,%.9g", e->relative[c], e->spread[c]);
    puts("");
}

static bool is_point(uint32_t samples)
{
    return samples == 12 || (samples & (samples - 1)) == 0;
}

static void print_point(const struct glint_film_estimate *e, uint32_t seed, uint32_t samples)
{
    printf("point,%u,%u,%.9g,%.9g\n", seed, samples, e->whole.error, e->whole.spread);
    if (samples >= FIRST_LOOK)
        print_cells(e, seed, samples);
}

// ---- the truth: squares of errors, as the estimate has them

struct truth {
    const struct forecast_films *films;
    size_t values;    // 3 for each pixel
    float **halves;   // [seeds], of all looks
    float *mean;      // of one look
    float *reference; // of the other seeds
};

static void mean_of(const struct truth *t, uint32_t seed, uint32_t look, float *out)
{
    const float *a = t->halves[seed] + 2 * look * t->values;
    for (size_t i = 0; i < t->values; i++)
        out[i] = 0.5f * (a[i] + a[t->values + i]);
}

static double toned(const float *c, int channel)
{
    return c[channel] / (1.0 + fmax(c[0], fmax(c[1], c[2])));
}

static struct glint_estimate squares(const struct truth *t, const float *mean)
{
    const double values = (double)t->values;
    const float *reference = t->reference;
    struct glint_estimate e = {0};
    for (size_t p = 0; p < t->values; p += 3)
        for (int c = 0; c < 3; c++) {
            const double d = (double)mean[p + c] - reference[p + c], r = reference[p + c];
            const double tone = toned(mean + p, c) - toned(reference + p, c);
            e.error += d * d / (r * r + 0.01) / values;
            e.linear += d * d / values;
            e.tone_mapped += 3.0 * tone * tone / values;
        }
    return e;
}

// The mean of the other seeds' last looks; returns the squares of its own errors.
static struct glint_estimate make_reference(const struct truth *t, uint32_t seed)
{
    const uint32_t last = forecast_film_looks(t->films) - 1, others = t->films->seeds - 1;
    const double scale = 1.0 / ((double)others * (others - 1.0));
    struct glint_estimate sum = {0};
    memset(t->reference, 0, t->values * sizeof *t->reference);
    for (uint32_t k = 0; k < t->films->seeds; k++) {
        mean_of(t, k, last, t->mean);
        for (size_t i = 0; k != seed && i < t->values; i++)
            t->reference[i] += t->mean[i] / (float)others;
    }
    for (uint32_t k = 0; k < t->films->seeds; k++) {
        mean_of(t, k, last, t->mean);
        const struct glint_estimate e = squares(t, t->mean);
        sum.error += k == seed ? 0.0 : e.error * scale;
        sum.linear += k == seed ? 0.0 : e.linear * scale;
        sum.tone_mapped += k == seed ? 0.0 : e.tone_mapped * scale;
    }
    return sum;
}

static double root(double square, double noise)
{
    return sqrt(fmax(square - noise, 0.0));
}

static void print_look(const struct truth *t, uint32_t seed, uint32_t look,
                       const struct glint_estimate *noise)
{
    struct glint_film_estimate film;
    const uint32_t samples = forecast_film_samples(look), number = t->films->first_seed + seed;
    forecast_film_estimate(t->films, t->halves[seed] + 2 * look * t->values, samples, &film);
    const struct glint_estimate *e = &film.whole;
    if (is_point(samples))
        print_point(&film, number, samples);
    if (samples < FIRST_LOOK)
        return;
    mean_of(t, seed, look, t->mean);
    const struct glint_estimate s = squares(t, t->mean);
    printf("look,%u,%u,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%d\n", number, samples, e->error,
           root(s.error, noise->error), e->linear, root(s.linear, noise->linear), e->tone_mapped,
           root(s.tone_mapped, noise->tone_mapped), glint_estimate_rare(e));
}

static void measure(const struct forecast_films *films)
{
    const size_t values = (size_t)3 * films->width * films->height;
    struct truth t = {films, values, forecast_room(films->seeds, sizeof *t.halves),
                      forecast_room(values, sizeof *t.mean),
                      forecast_room(values, sizeof *t.reference)};
    for (uint32_t k = 0; k < films->seeds; k++)
        t.halves[k] = forecast_film_read(films, films->first_seed + k);
    for (uint32_t k = 0; k < films->seeds; k++) {
        const struct glint_estimate noise = make_reference(&t, k);
        for (uint32_t look = 0; look < forecast_film_looks(films); look++)
            print_look(&t, k, look, &noise);
    }
    for (uint32_t k = 0; k < films->seeds; k++)
        free(t.halves[k]);
    free(t.halves);
    free(t.mean);
    free(t.reference);
}

// ---- forecasts from what was measured

struct seed {
    struct glint_convergence_point curve[GLINT_CURVE_POINTS];
    uint32_t points, looks;
    struct glint_film_estimate now;
    double look[MAX_LOOKS], error[MAX_LOOKS]; // samples, and the true error
};

// Samples at which the true error is first at most `target`, between two looks; 0: later.
static double reached(const struct seed *s, double target)
{
    for (uint32_t i = 0; i < s->looks; i++) {
        const double n = s->look[i];
        if (s->error[i] > target)
            continue;
        if (!i)
            return n;
        const double slope = log(s->error[i - 1] / s->error[i]) / log(n / s->look[i - 1]);
        return n * pow(s->error[i] / target, 1.0 / slope);
    }
    return 0.0;
}

static void predict_one(const struct seed *s, uint32_t number, uint32_t first, double divisor)
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
    printf("forecast,%u,%g,%d,%.6g", number, divisor, f.lower_bound, reached(s, in.target));
    for (size_t i = 0; i < sizeof level / sizeof *level; i++)
        printf(",%.6g", draw[(int)(level[i] * (GLINT_FORECAST_DRAWS - 1) + 0.5)]);
    puts("");
}

static void read_cells(struct seed *s, const char *at, uint32_t first)
{
    struct glint_film_estimate *e = &s->now;
    uint32_t samples;
    int used = 0;
    if (sscanf(at, "%u%n", &samples, &used) != 1 || samples != first)
        return;
    at += used;
    if (sscanf(at, ",%lf,%lf%n", &e->whole.tail, &e->whole.lift, &used) != 2)
        return;
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
        read_cells(s, at, first);
    else if (!strncmp(line, "point", 5))
        read_point(s, at, first);
    else if (s->looks < MAX_LOOKS &&
             sscanf(at, "%lf,%*f,%lf", &s->look[s->looks], &s->error[s->looks]) == 2)
        s->looks++;
}

static void predict(uint32_t first, char **divisor)
{
    static struct seed seed[MAX_SEEDS];
    static char line[1 << 16];
    uint32_t number, seeds = 0;
    while (fgets(line, sizeof line, stdin)) {
        int used = 0;
        if (sscanf(line, "%*[a-z],%u,%n", &number, &used) != 1 || !used || number >= MAX_SEEDS)
            continue;
        read_line(&seed[number], line, line + used, first);
        seeds = number >= seeds ? number + 1 : seeds;
    }
    for (number = 0; number < seeds; number++)
        for (char **d = divisor; seed[number].looks && *d; d++)
            predict_one(&seed[number], number, first, atof(*d));
}

// ---- pixels

static void score(uint32_t seeds, const char *scene, const char *job_path)
{
    struct offline o;
    size_t length;
    offline_start(&o, 1);
    char *text = (char *)offline_read_file(job_path, &length);
    struct glint_job *job = offline_job(text);
    struct glint_posed rest = offline_load_posed(&o, scene);
    const struct scores s = scores_take(&o, &rest, job, seeds);
    printf("%llu,%.4f\n", (unsigned long long)s.values, (double)s.inside / (double)s.values);
    free(text);
    glint_resident_release(&rest.resident);
    glint_job_destroy(&job);
    offline_finish(&o);
}

static struct forecast_films films_of(char **argument)
{
    return (struct forecast_films){.folder = argument[0],
                                   .width = (uint32_t)atoi(argument[1]),
                                   .height = (uint32_t)atoi(argument[2]),
                                   .samples = (uint32_t)atoi(argument[3]),
                                   .first_seed = (uint32_t)atoi(argument[4]),
                                   .seeds = (uint32_t)atoi(argument[5])};
}

static int usage(void)
{
    fprintf(stderr,
            "usage: forecast record  FOLDER WIDTH HEIGHT SAMPLES SEED SEEDS SCENE JOB.json\n"
            "       forecast measure FOLDER WIDTH HEIGHT SAMPLES SEED SEEDS\n"
            "       forecast predict FIRST DIVISOR... < measured\n"
            "       forecast scores  SEEDS SCENE JOB.json\n");
    return 64;
}

int main(int argc, char **argv)
{
    struct forecast_films films;
    if (argc >= 8)
        films = films_of(argv + 2);
    if (argc == 10 && !strcmp(argv[1], "record"))
        forecast_film_record(argv[8], argv[9], &films);
    else if (argc == 8 && !strcmp(argv[1], "measure"))
        measure(&films);
    else if (argc > 3 && !strcmp(argv[1], "predict"))
        predict((uint32_t)atoi(argv[2]), argv + 3);
    else if (argc == 5 && !strcmp(argv[1], "scores"))
        score((uint32_t)atoi(argv[2]), argv[3], argv[4]);
    else
        return usage();
    return 0;
}
