// scaling - what a sample costs as pictures, samples, triangles and workers grow.
//
//   scaling [MILLIONS [ROUNDS]]   largest scene in millions of triangles, by default 16; rounds 9
//
// pixels, samples: CPU time of a pixel or sample in whole renders over that in the smallest. triangles: CPU time of the same waves of 4, ... MILLIONS over that of 1
// million, in interleaved pairs. workers: wall time of one worker over that of two, in pairs, and the
// share of the machine that others had meanwhile: above a hundredth the pair of figures says how the
// machine was loaded, not how rendering scales, and "resolved" is false.
#include "tests/bench/bench.h"
#include "tests/bench/waves.h"

#include "base/clock.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

enum { MOST_ROUNDS = 64, STEPS = 3 };

#define LINEAR 0.05     // most that a pixel or a sample may differ in cost
#define MOST_GROWTH 1.6 // of a sample from 1 to 16 million triangles
#define LEAST_SPEEDUP 1.9
#define MOST_OTHERS 0.01

// ---- whole renders

struct cost {
    double user, wall;
};

static double user_seconds(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)usage.ru_utime.tv_sec + 1e-6 * (double)usage.ru_utime.tv_usec;
}

static struct cost whole(const struct offline *o, const struct glint_posed *scene, unsigned width,
                         unsigned height, unsigned samples)
{
    char text[256];
    struct glint_error err = {0};
    glint_render *render = NULL;
    snprintf(text, sizeof text,
             "{\"scene\":\"s\",\"resolution\":[%u,%u],\"outputs\":[\"beauty\"],"
             "\"stop\":{\"samples\":%u}}",
             width, height, samples);
    struct glint_job *job = offline_job(text);
    const double user = user_seconds(), wall = glint_now();
    if (glint_render_create(&render, o->devices, scene->resident, scene->pose, job, &err))
        offline_die("render", &err);
    offline_render(o, render);
    const struct cost c = {user_seconds() - user, glint_now() - wall};
    glint_render_destroy(&render);
    glint_job_destroy(&job);
    return c;
}

struct size {
    unsigned width, height, samples;
};

static double units(const struct size *s)
{
    return (double)s->width * s->height * s->samples;
}

// Cost of a unit at each size over that at the first; prints the member. Returns whether all are
// within LINEAR.
static bool linear(const struct offline *o, const struct glint_posed *scene, const char *name,
                   const struct size size[STEPS], size_t rounds)
{
    double cost[STEPS][MOST_ROUNDS];
    bool holds = true;
    for (size_t r = 0; r < rounds; r++)
        for (size_t k = 0; k < STEPS; k++) {
            const size_t i = r % 2 ? STEPS - 1 - k : k;
            const struct cost c = whole(o, scene, size[i].width, size[i].height, size[i].samples);
            cost[i][r] = c.user / units(&size[i]);
        }
    printf(",\"%s\":[", name);
    for (size_t i = 1; i < STEPS; i++) {
        const struct bench_ratio x = bench_ratio_of(cost[0], cost[i], rounds);
        printf("%s{\"times\":%.0f,\"ratio\":%.4f,\"low\":%.4f,\"high\":%.4f}", i > 1 ? "," : "",
               units(&size[i]) / units(&size[0]), x.median, x.low, x.high);
        holds &= fabs(x.median - 1.0) <= LINEAR;
    }
    printf("]");
    fflush(stdout);
    return holds;
}

// ---- triangles

static glint_render *balls(const struct offline *o, struct glint_posed *rest, double millions)
{
    const unsigned segments = 2 * (unsigned)lrint(sqrt(millions * 1e6 / 18.0) / 2.0);
    *rest = offline_load_posed_text(o, bench_balls_scene(segments));
    return bench_waves_render(o, rest, "\"outputs\":[\"beauty\"]");
}

static bool triangles(const struct offline *o, double millions, size_t rounds)
{
    bool holds = true;
    glint_worker *worker = glint_devices_worker(o->devices, 0);
    glint_worker_enter(worker);
    printf(",\"triangles\":[");
    for (double m = 4; m <= millions; m *= 4) {
        struct glint_posed few, many;
        struct glint_resident_stats stats;
        glint_render *a = balls(o, &few, 1), *b = balls(o, &many, m);
        glint_resident_stats(many.resident, &stats);
        const struct bench_ratio x =
            bench_waves_ratio(worker, a, b, BENCH_WIDE, BENCH_HIGH, rounds);
        printf("%s{\"triangles\":%.0f,\"ratio\":%.4f,\"low\":%.4f,\"high\":%.4f}", m > 4 ? "," : "",
               (double)stats.triangles, x.median, x.low, x.high);
        fflush(stdout);
        glint_resident_release(&few.resident);
        glint_resident_release(&many.resident);
        holds &= x.median <= MOST_GROWTH;
    }
    printf("]");
    return holds;
}

// ---- workers

// CPU seconds of the whole machine that were not idle.
static double machine_seconds(void)
{
    unsigned long long user, nice, kernel;
    FILE *f = fopen("/proc/stat", "r");
    if (!f || fscanf(f, "cpu %llu %llu %llu", &user, &nice, &kernel) != 3)
        user = nice = kernel = 0;
    if (f)
        fclose(f);
    return (double)(user + nice + kernel) / (double)sysconf(_SC_CLK_TCK);
}

static double own_seconds(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return user_seconds() + (double)usage.ru_stime.tv_sec + 1e-6 * (double)usage.ru_stime.tv_usec;
}

static bool workers(const struct offline *one, const struct glint_posed *scene, size_t rounds)
{
    struct offline two = {one->importer, NULL};
    struct glint_error err = {0};
    double single[MOST_ROUNDS], pair[MOST_ROUNDS];
    if (glint_devices_create(&two.devices, 2, NULL, &err))
        offline_die("devices", &err);
    struct glint_posed again = offline_load_posed_text(&two, bench_million_scene());
    const double start = glint_now(), machine = machine_seconds(), own = own_seconds();
    for (size_t r = 0; r < rounds; r++)
        for (size_t k = 0; k < 2; k++)
            if (k == r % 2)
                single[r] = whole(one, scene, 512, 256, 8).wall;
            else
                pair[r] = whole(&two, &again, 512, 256, 8).wall;
    const double others = fmax(0.0, machine_seconds() - machine - own_seconds() + own) /
                          ((glint_now() - start) * (double)sysconf(_SC_NPROCESSORS_ONLN));
    const struct bench_ratio x = bench_ratio_of(pair, single, rounds);
    const bool resolved = others <= MOST_OTHERS;
    printf(",\"workers\":{\"ratio\":%.4f,\"low\":%.4f,\"high\":%.4f,\"others\":%.4f,"
           "\"resolved\":%s}",
           x.median, x.low, x.high, others, resolved ? "true" : "false");
    fflush(stdout);
    glint_resident_release(&again.resident);
    glint_devices_destroy(&two.devices);
    return !resolved || x.median >= LEAST_SPEEDUP;
}

int main(int argc, char **argv)
{
    static const struct size pixels[STEPS] = {{256, 128, 4}, {512, 256, 4}, {1024, 512, 4}},
                             samples[STEPS] = {{128, 128, 8}, {128, 128, 16}, {128, 128, 64}};
    const double millions = argc > 1 ? strtod(argv[1], NULL) : 16;
    const unsigned long asked = argc > 2 ? strtoul(argv[2], NULL, 10) : 9;
    const size_t rounds = asked < 1 ? 1 : asked > MOST_ROUNDS ? MOST_ROUNDS : asked;
    struct offline o;
    offline_start(&o, 1);
    struct glint_posed rest = offline_load_posed_text(&o, bench_million_scene());
    whole(&o, &rest, 64, 64, 1); // compiles
    printf("{\"bench\":\"scaling\",\"rounds\":%zu", rounds);
    fflush(stdout);
    bool holds = linear(&o, &rest, "pixels", pixels, rounds);
    holds &= linear(&o, &rest, "samples", samples, rounds);
    holds &= workers(&o, &rest, rounds);
    glint_resident_release(&rest.resident);
    holds &= triangles(&o, millions, rounds);
    printf(",\"holds\":%s}\n", holds ? "true" : "false");
    offline_finish(&o);
    return holds ? 0 : 1;
}
