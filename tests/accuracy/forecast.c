// forecast - one scene, several seeds: what a job says of its own error and of the samples that it
// needs, beside what is true.
//
// usage: forecast SCENE.{glb,json} JOB.json SEEDS SAMPLES FIRST
//
// Renders the job with seeds 1..SEEDS for SAMPLES samples. A seed's reference is the mean of the
// others; how far that is off itself is taken from the others' own estimates, and subtracted. Writes
// CSV to stdout: rows "estimate" at each checkpoint of each seed, rows "forecast" of targets 1/2,
// 1/4 and 1/8 of the error estimated at FIRST samples, with the samples at which the true error is
// first that small, and a row "z" for each seed that has batches.
#include "kernels/gk_film.h"
#include "tests/render/offline.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define STEP 16 // samples between two looks at the true error
#define TARGETS 3

struct look {
    struct glint_estimate estimate;
    float *mean; // [pixels][3]
};

struct seed {
    struct look *look; // [looks]
    bool known[TARGETS];
    double draws[TARGETS][GLINT_FORECAST_DRAWS];
    double target[TARGETS];
    bool rare;
};

struct run {
    struct offline o;
    struct glint_posed rest;
    struct glint_job *job;
    uint32_t seeds, looks, first;
    size_t values; // 3 for each pixel
    struct seed *seed;
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

static void take_forecasts(const struct run *run, const glint_render *r, struct seed *s)
{
    s->rare = glint_estimate_rare(&r->estimate.whole);
    for (int t = 0; t < TARGETS; t++) {
        s->target[t] = r->estimate.whole.error / (2 << t);
        const struct glint_forecast_input in = {.curve = r->curve,
                                                .points = r->points,
                                                .now = &r->estimate,
                                                .samples = run->first,
                                                .target = s->target[t],
                                                .limit = GLINT_MAX_SAMPLES};
        s->known[t] = glint_forecast_draw(s->draws[t], &in);
    }
}

static void print_curve(uint32_t number, const glint_render *r)
{
    for (uint32_t i = 0; i < r->points; i++)
        printf("curve,%u,%u,%.9g,%.9g,%.9g\n", number, r->curve[i].samples, r->curve[i].error,
               r->curve[i].spread, r->curve[i].seconds);
}

static void render_seed(struct run *run, uint32_t number)
{
    struct glint_error err = {0};
    struct seed *s = &run->seed[number];
    glint_render *r = NULL;
    run->job->seed = number + 1;
    run->job->stop = (struct glint_job_stop){.samples = STEP};
    s->look = room(run->looks, sizeof *s->look);
    if (glint_render_create(&r, run->o.devices, run->rest.resident, run->rest.pose, run->job, &err))
        offline_die("render", &err);
    for (uint32_t i = 0; i < run->looks; i++) {
        const uint32_t samples = STEP * (i + 1);
        if (i && !glint_render_extend(r, samples, 0.0))
            offline_die("extend", &err);
        offline_render(&run->o, r);
        take_look(run, r, samples, &s->look[i]);
        if (samples == run->first)
            take_forecasts(run, r, s);
    }
    print_curve(number, r);
    glint_render_destroy(&r);
}

// ---- the truth

// The mean of the other seeds' last looks; returns what its own noise adds to the error's square.
static double reference(const struct run *run, uint32_t number, float *out)
{
    double noise = 0.0;
    memset(out, 0, run->values * sizeof *out);
    for (uint32_t k = 0; k < run->seeds; k++) {
        const struct look *last = &run->seed[k].look[run->looks - 1];
        for (size_t i = 0; k != number && i < run->values; i++)
            out[i] += last->mean[i] / (float)(run->seeds - 1);
        noise += k != number ? last->estimate.error * last->estimate.error : 0.0;
    }
    return noise / ((run->seeds - 1.0) * (run->seeds - 1.0));
}

static double true_error(const struct run *run, const float *mean, const float *reference,
                         double noise)
{
    double sum = 0.0, own = 0, lin = 0, tone = 0, nl = 0, nt = 0;
    for (size_t i = 0; i < run->values; i++) {
        const double d = (double)mean[i] - reference[i], r = reference[i];
        sum += d * d / (r * r + 0.01);
        own += d * d / (mean[i] * (double)mean[i] + 0.01);
        lin += d * d;
    }
    for (size_t p = 0; p < run->values; p += 3) {
        const float *a = mean + p, *b = reference + p;
        double ta = 1 + fmax(a[0], fmax(a[1], a[2])), tb = 1 + fmax(b[0], fmax(b[1], b[2]));
        for (int c = 0; c < 3; c++)
            tone += pow(a[c] / ta - b[c] / tb, 2);
    }
    for (uint32_t k = 0; k < run->seeds; k++) {
        const struct glint_estimate *e = &run->seed[k].look[run->looks - 1].estimate;
        nl += e->linear * e->linear / run->seeds / (run->seeds - 1);
        nt += e->tone_mapped * e->tone_mapped / run->seeds / (run->seeds - 1);
    }
    printf("truth,%.6g,%.6g,%.6g,%.6g\n", sqrt(sum / run->values - noise), sqrt(own / run->values - noise), sqrt(lin / run->values - nl), sqrt(tone * 3 / run->values - nt));
    return sqrt(fmax(own / (double)run->values - noise, 0.0));
}

// Samples at which the error is first at most `target`, between two looks; 0: never.
static double reached(const struct run *run, const double *error, double target)
{
    for (uint32_t i = 0; i < run->looks; i++) {
        if (error[i] > target)
            continue;
        const double n = STEP * (i + 1.0);
        if (!i)
            return n;
        const double slope = log(error[i - 1] / error[i]) / log(n / (n - STEP));
        return n * pow(error[i] / target, 1.0 / slope);
    }
    return 0.0;
}

static void print_forecast(uint32_t number, int t, const struct seed *s, double actual)
{
    static const double level[] = {0.5, 0.025, 0.05, 0.1, 0.25, 0.75, 0.9, 0.95, 0.975};
    printf("forecast,%u,%d,%.9g,%.6g,%d", number, 2 << t, s->target[t], actual, s->rare);
    for (size_t i = 0; i < sizeof level / sizeof *level; i++)
        printf(",%.6g", s->draws[t][(int)(level[i] * (GLINT_FORECAST_DRAWS - 1) + 0.5)]);
    puts("");
}

static void print_seed(const struct run *run, uint32_t number)
{
    const struct seed *s = &run->seed[number];
    float *mean = room(run->values, sizeof *mean);
    double *error = room(run->looks, sizeof *error);
    const double noise = reference(run, number, mean);
    for (uint32_t i = 0; i < run->looks; i++) {
        const struct glint_estimate *e = &s->look[i].estimate;
        error[i] = true_error(run, s->look[i].mean, mean, noise);
        printf("estimate,%u,%u,%.9g,%.9g,%.9g,%.9g,%.9g,%.4g\n", number, STEP * (i + 1), e->error,
               error[i], e->spread, e->linear, e->tone_mapped, e->tail);
    }
    for (int t = 0; t < TARGETS; t++)
        if (s->known[t])
            print_forecast(number, t, s, reached(run, error, s->target[t]));
    fflush(stdout);
    free(error);
    free(mean);
}

int main(int argc, char **argv)
{
    struct run run = {0};
    size_t length;
    if (argc < 6) {
        fprintf(stderr, "usage: forecast SCENE JOB.json SEEDS SAMPLES FIRST\n");
        return 64;
    }
    offline_start(&run.o, 1);
    char *text = (char *)offline_read_file(argv[2], &length);
    run.job = offline_job(text);
    run.rest = offline_load_posed(&run.o, argv[1]);
    run.seeds = (uint32_t)atoi(argv[3]);
    run.looks = (uint32_t)atoi(argv[4]) / STEP;
    run.first = (uint32_t)atoi(argv[5]);
    run.values = (size_t)3 * run.job->region[2] * run.job->region[3];
    run.seed = room(run.seeds, sizeof *run.seed);
    for (uint32_t k = 0; k < run.seeds; k++)
        render_seed(&run, k);
    for (uint32_t k = 0; k < run.seeds; k++)
        print_seed(&run, k);
    for (uint32_t k = 0; k < run.seeds; k++) {
        for (uint32_t i = 0; i < run.looks; i++)
            free(run.seed[k].look[i].mean);
        free(run.seed[k].look);
    }
    free(run.seed);
    free(text);
    glint_resident_release(&run.rest.resident);
    glint_job_destroy(&run.job);
    offline_finish(&run.o);
    return 0;
}
