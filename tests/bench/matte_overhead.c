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
};

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
    b.rest = bench_waves_scene(&b.o, argv[1]);
    b.worker = glint_devices_worker(b.o.devices, 0);
    glint_worker_enter(b.worker);
    printf("{\"bench\":\"matte-overhead\",\"scene\":\"%s\",\"pairs\":%d", argv[1], PAIRS);
    for (size_t i = 0; i < sizeof variant / sizeof *variant; i++) {
        const struct bench_ratio r = bench_waves_ratio(
            b.worker, bench_waves_render(&b.o, &b.rest, "\"outputs\":[\"beauty\"]"),
            bench_waves_render(&b.o, &b.rest, variant[i].job), BENCH_WIDE, BENCH_HIGH, PAIRS);
        printf(",\"%s\":{\"ratio\":%.4f,\"low\":%.4f,\"high\":%.4f}", variant[i].name, r.median,
               r.low, r.high);
        fflush(stdout);
    }
    puts("}");
    glint_resident_release(&b.rest.resident);
    offline_finish(&b.o);
    return 0;
}
