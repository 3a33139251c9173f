#include "tests/accuracy/scores.h"

#include "kernels/gk_film.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define WITHIN 2.131 // of Student's law of 15 degrees: 95 %

struct value {
    double mean, variance; // of the mean
};

static struct value value_of(const float *batches, bool wide, uint32_t channel, uint32_t i,
                             uint32_t samples)
{
    double mean[GK_BATCHES], sum = 0.0, square = 0.0;
    for (uint32_t k = 0; k < GK_BATCHES; k++) {
        const uint32_t n = glint_film_part(0, samples, GK_BATCHES, k);
        mean[k] = glint_film_batch_mean(batches, wide, k, channel, i, n);
        sum += mean[k] / GK_BATCHES;
    }
    for (uint32_t k = 0; k < GK_BATCHES; k++)
        square += (mean[k] - sum) * (mean[k] - sum);
    return (struct value){sum, square / (GK_BATCHES * (GK_BATCHES - 1.0))};
}

static void take_tile(glint_render *r, uint32_t tile, struct value *out)
{
    struct glint_film_tile at;
    glint_film_tile(r->film, tile, &at);
    const float *batches = (const float *)glint_buffer_host(at.planes) + at.batches_offset;
    const bool wide = r->job.dial[GLINT_DIAL_PRECISION] == 0;
    const uint32_t columns = glint_film_columns(r->film), width = r->job.region[2];
    for (uint32_t i = 0; i < GK_TILE_PIXELS; i++) {
        const uint32_t x = tile % columns * GK_TILE_SIDE + i % GK_TILE_SIDE;
        const uint32_t y = tile / columns * GK_TILE_SIDE + i / GK_TILE_SIDE;
        for (uint32_t c = 0; x < width && y < r->job.region[3] && c < 3; c++)
            out[3 * ((size_t)y * width + x) + c] =
                value_of(batches, wide, c, i, r->job.stop.samples);
    }
}

static void render_seed(const struct offline *o, const struct glint_posed *rest,
                        const struct glint_job *job, struct value *out)
{
    struct glint_error err = {0};
    glint_render *r = NULL;
    if (glint_render_create(&r, o->devices, rest->resident, rest->pose, job, &err))
        offline_die("render", &err);
    offline_render(o, r);
    for (uint32_t t = 0; t < glint_film_columns(r->film) * glint_film_rows(r->film); t++)
        take_tile(r, t, out);
    glint_render_destroy(&r);
}

// One value of all seeds, `stride` apart.
static void add(struct scores *s, const struct value *of, uint32_t seeds, size_t stride)
{
    double mean = 0.0, variance = 0.0;
    const double others = seeds - 1.0;
    for (uint32_t k = 0; k < seeds; k++) {
        mean += of[k * stride].mean;
        variance += of[k * stride].variance;
    }
    for (uint32_t k = 0; k < seeds; k++) {
        const struct value *v = &of[k * stride];
        const double reference = (mean - v->mean) / others;
        const double all = v->variance + (variance - v->variance) / (others * others);
        s->values += all > 0.0;
        s->inside += all > 0.0 && fabs(v->mean - reference) < WITHIN * sqrt(all);
    }
}

struct scores scores_take(const struct offline *o, const struct glint_posed *rest,
                          struct glint_job *job, uint32_t seeds)
{
    const size_t values = (size_t)3 * job->region[2] * job->region[3];
    struct value *of = calloc(values * seeds, sizeof *of);
    struct scores s = {0, 0};
    if (!of) {
        fprintf(stderr, "no memory\n");
        exit(1);
    }
    job->estimate = GLINT_ESTIMATE_BATCHES;
    for (uint32_t k = 0; k < seeds; k++) {
        job->seed = k + 1;
        render_seed(o, rest, job, of + k * values);
    }
    for (size_t i = 0; i < values; i++)
        add(&s, of + i, seeds, values);
    free(of);
    return s;
}
