// matte_overhead - what ID coverage costs: CPU time of the same slices with it over without, at
// 1920x1080 with 12 slots, in interleaved pairs. One scene a call: SCENE.{json,glb,gltf}.
#include "tests/bench/bench.h"
#include "tests/bench/waves.h"

#include <stdio.h>
#include <stdlib.h>

enum { PAIRS = 25 };

struct bench {
    struct offline o;
    struct glint_posed rest;
    glint_worker *worker;
    struct glint_slice slice[BENCH_WAVES];
    glint_render *a, *b;
};

static glint_render *make(struct bench *b, const char *rest_of_job)
{
    struct glint_error err = {0};
    char text[512];
    glint_render *render = NULL;
    snprintf(text, sizeof text,
             "{\"scene\":\"s\",\"resolution\":[1920,1080],\"stop\":{\"samples\":1024},%s}",
             rest_of_job);
    struct glint_job *job = offline_job(text);
    if (glint_render_create(&render, b->o.devices, b->rest.resident, b->rest.pose, job, &err))
        offline_die("render", &err);
    glint_job_destroy(&job);
    return render;
}

static double run_a(void *user)
{
    struct bench *b = user;
    return bench_waves_run(b->a, b->worker, b->slice);
}

static double run_b(void *user)
{
    struct bench *b = user;
    return bench_waves_run(b->b, b->worker, b->slice);
}

static struct bench_ratio compare(struct bench *b, const char *with)
{
    double without_cost[PAIRS], with_cost[PAIRS];
    b->a = make(b, "\"outputs\":[\"beauty\"]");
    b->b = make(b, with);
    run_a(b);
    run_b(b);
    bench_pairs(run_a, run_b, b, without_cost, with_cost, PAIRS);
    glint_render_destroy(&b->a);
    glint_render_destroy(&b->b);
    return bench_ratio_of(without_cost, with_cost, PAIRS);
}

#define CRYPTO "\"outputs\":[\"beauty\",\"crypto_object\",\"crypto_material\",\"crypto_asset\"],"

int main(int argc, char **argv)
{
    static const struct {
        const char *name, *job;
    } variant[] = {
        {"primary", CRYPTO "\"mattes\":{\"slots\":12}"},
        {"delta", CRYPTO "\"mattes\":{\"slots\":12,\"through\":\"delta\"}"},
        {"glossy", CRYPTO "\"mattes\":{\"slots\":12,\"through\":\"glossy\"}"},
        {"classes", CRYPTO "\"mattes\":{\"slots\":12,\"through\":\"glossy\",\"classes\":true}"}};
    if (argc != 2)
        return fprintf(stderr, "usage: matte_overhead SCENE\n"), 64;
    struct bench b = {0};
    offline_start(&b.o, 1);
    b.rest = offline_load_posed(&b.o, argv[1]);
    b.worker = glint_devices_worker(b.o.devices, 0);
    glint_worker_enter(b.worker);
    bench_waves_spread(b.slice, 120, 67);
    printf("{\"bench\":\"matte-overhead\",\"scene\":\"%s\",\"pairs\":%d", argv[1], PAIRS);
    for (size_t i = 0; i < sizeof variant / sizeof *variant; i++) {
        const struct bench_ratio r = compare(&b, variant[i].job);
        printf(",\"%s\":{\"ratio\":%.4f,\"low\":%.4f,\"high\":%.4f}", variant[i].name, r.median,
               r.low, r.high);
        fflush(stdout);
    }
    puts("}");
    glint_resident_release(&b.rest.resident);
    offline_finish(&b.o);
    return 0;
}
