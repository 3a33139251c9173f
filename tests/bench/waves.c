#include "tests/bench/waves.h"

#include "base/clock.h"

#include <stdio.h>
#include <stdlib.h>

void bench_waves_spread(struct glint_slice slice[BENCH_WAVES], uint32_t tiles_wide,
                        uint32_t tiles_high)
{
    const uint32_t tiles = tiles_wide * tiles_high;
    for (uint32_t s = 0; s < BENCH_WAVES; s++) {
        const uint32_t tile = (s * 341 + 170) % tiles;
        slice[s] = (struct glint_slice){.block = tile,
                                        .x = tile % tiles_wide * 16,
                                        .y = tile / tiles_wide * 16,
                                        .w = 16,
                                        .h = 16,
                                        .sample = 16,
                                        .samples = 16};
    }
}

double bench_waves_run(glint_render *render, glint_worker *worker,
                       const struct glint_slice slice[BENCH_WAVES])
{
    const double start = glint_thread_cpu();
    struct glint_error err = {0};
    for (int s = 0; s < BENCH_WAVES; s++)
        if (glint_render_run(render, worker, &slice[s], &err))
            offline_die("slice", &err);
    return glint_thread_cpu() - start;
}

glint_render *bench_waves_render(const struct offline *o, const struct glint_posed *rest,
                                 const char *members)
{
    struct glint_error err = {0};
    char text[512];
    glint_render *render = NULL;
    snprintf(text, sizeof text,
             "{\"scene\":\"s\",\"resolution\":[1920,1080],\"stop\":{\"samples\":1024},%s}",
             members);
    struct glint_job *job = offline_job(text);
    if (glint_render_create(&render, o->devices, rest->resident, rest->pose, job, &err))
        offline_die("render", &err);
    glint_job_destroy(&job);
    return render;
}

struct pair {
    glint_worker *worker;
    glint_render *a, *b;
    struct glint_slice slice[BENCH_WAVES];
};

static double run_a(void *user)
{
    const struct pair *p = user;
    return bench_waves_run(p->a, p->worker, p->slice);
}

static double run_b(void *user)
{
    const struct pair *p = user;
    return bench_waves_run(p->b, p->worker, p->slice);
}

struct bench_ratio bench_waves_ratio(glint_worker *worker, glint_render *a, glint_render *b,
                                     uint32_t tiles_wide, uint32_t tiles_high, size_t pairs)
{
    struct pair p = {.worker = worker, .a = a, .b = b};
    double *cost = malloc(2 * pairs * sizeof *cost);
    if (!cost)
        offline_die("memory", &(struct glint_error){0});
    bench_waves_spread(p.slice, tiles_wide, tiles_high);
    run_a(&p); // warms
    run_b(&p);
    bench_pairs(run_a, run_b, &p, cost, cost + pairs, pairs);
    const struct bench_ratio ratio = bench_ratio_of(cost, cost + pairs, pairs);
    free(cost);
    glint_render_destroy(&p.a);
    glint_render_destroy(&p.b);
    return ratio;
}
