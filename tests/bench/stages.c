// stages - what a path vertex costs, by stage: CPU nanoseconds of each pass over the number of
// closest-hit rays, at 1920x1080, for the outputs that a job may have. One scene a call:
// SCENE.{json,glb,gltf}; without one, the scene of 904 K triangles.
//
// Rounds of all variants are interleaved; what is printed is the median over the rounds.
#include "base/clock.h"
#include "tests/bench/bench.h"
#include "tests/bench/waves.h"

#include <stdio.h>
#include <stdlib.h>

enum { ROUNDS = 9 };

#define CRYPTO "\"outputs\":[\"beauty\",\"crypto_object\",\"crypto_material\",\"crypto_asset\"],"
#define ALL                                                                           \
    "\"outputs\":[\"beauty\",\"crypto_object\",\"crypto_material\",\"crypto_asset\"," \
    "\"depth\",\"normal\",\"albedo\",\"samples\",\"variance\"],"

static const struct {
    const char *name, *job;
} variant[] = {{"beauty", "\"outputs\":[\"beauty\"]"},
               {"primary", CRYPTO "\"mattes\":{\"slots\":12}"},
               {"delta", CRYPTO "\"mattes\":{\"slots\":12,\"through\":\"delta\"}"},
               {"glossy", CRYPTO "\"mattes\":{\"slots\":12,\"through\":\"glossy\"}"},
               {"all", ALL "\"mattes\":{\"slots\":12,\"through\":\"glossy\",\"classes\":true}"}};
enum { VARIANTS = sizeof variant / sizeof *variant };

struct bench {
    struct offline o;
    struct glint_posed rest;
    glint_worker *worker;
    struct glint_slice slice[BENCH_WAVES];
    glint_render *render[VARIANTS];
    double ns[VARIANTS][GLINT_PASSES][ROUNDS]; // per vertex
    double vertices;                           // per round
};

// The passes are timed by the thread's CPU clock here: other processes do not count.
double __wrap_glint_now(void);
double __wrap_glint_now(void)
{
    return glint_thread_cpu();
}

static void run_once(struct bench *b, int v, int round)
{
    const struct glint_wave_stats before = b->render[v]->stats;
    bench_waves_run(b->render[v], b->worker, b->slice);
    const struct glint_wave_stats *now = &b->render[v]->stats;
    b->vertices =
        (double)(now->camera_rays - before.camera_rays + now->bounce_rays - before.bounce_rays);
    for (int p = 0; p < GLINT_PASSES; p++)
        b->ns[v][p][round] = (now->seconds[p] - before.seconds[p]) * 1e9 / b->vertices;
}

static void run_rounds(struct bench *b)
{
    for (int v = 0; v < VARIANTS; v++) {
        b->render[v] = bench_waves_render(&b->o, &b->rest, variant[v].job);
        run_once(b, v, 0);
    }
    for (int round = 0; round < ROUNDS; round++)
        for (int i = 0; i < VARIANTS; i++)
            run_once(b, round % 2 ? VARIANTS - 1 - i : i, round);
}

static double of_pass(struct bench *b, int v, int p)
{
    return bench_median(b->ns[v][p], ROUNDS);
}

static void print_table(struct bench *b)
{
    printf("%-28s", "ns per path vertex");
    for (int v = 0; v < VARIANTS; v++)
        printf(" %8s", variant[v].name);
    for (int p = 0; p < GLINT_PASSES; p++) {
        printf("\n%-28s", glint_pass_name[p]);
        for (int v = 0; v < VARIANTS; v++)
            printf(" %8.1f", of_pass(b, v, p));
    }
    puts("");
}

static void print_json(struct bench *b, const char *scene)
{
    printf("{\"bench\":\"stages\",\"scene\":\"%s\",\"rounds\":%d,\"vertices\":%.0f", scene, ROUNDS,
           b->vertices);
    for (int v = 0; v < VARIANTS; v++) {
        double all = 0.0;
        printf(",\"%s\":{", variant[v].name);
        for (int p = 0; p < GLINT_PASSES; p++) {
            all += of_pass(b, v, p);
            printf("\"%s\":%.2f,", glint_pass_name[p], of_pass(b, v, p));
        }
        printf("\"all\":%.2f}", all);
    }
    puts("}");
}

int main(int argc, char **argv)
{
    static struct bench b;
    if (argc > 2)
        return fprintf(stderr, "usage: stages [SCENE]\n"), 64;
    offline_start(&b.o, 1);
    b.rest = bench_waves_scene(&b.o, argc > 1 ? argv[1] : NULL);
    b.worker = glint_devices_worker(b.o.devices, 0);
    glint_worker_enter(b.worker);
    bench_waves_spread(b.slice, BENCH_WIDE, BENCH_HIGH);
    run_rounds(&b);
    print_table(&b);
    print_json(&b, argc > 1 ? argv[1] : "million");
    for (int v = 0; v < VARIANTS; v++)
        glint_render_destroy(&b.render[v]);
    glint_resident_release(&b.rest.resident);
    offline_finish(&b.o);
    return 0;
}
