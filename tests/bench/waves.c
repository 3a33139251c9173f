#include "tests/bench/waves.h"

#include "base/clock.h"
#include "clients/cli/bundle.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

// What is sent to a daemon, read back as it reads it.
static struct glint_posed load_gltf(const struct offline *o, const char *path)
{
    struct glint_error err = {0};
    struct glint_bundle bundle;
    if (glint_bundle_gltf(path, &bundle, &err))
        offline_die(path, &err);
    if (bundle.fd < 0) {
        size_t size;
        uint8_t *bytes = offline_read_file(path, &size);
        const struct glint_posed alone = offline_load_posed_source(
            o, path,
            &(struct glint_import_source){.type = GLINT_SCENE_GLTF, .bytes = bytes, .size = size});
        free(bytes);
        return alone;
    }
    const size_t size = (size_t)bundle.size;
    uint8_t *body = mmap(NULL, size, PROT_READ, MAP_PRIVATE, bundle.fd, 0);
    if (body == MAP_FAILED)
        offline_die(path, &err);
    const struct glint_posed posed = offline_load_posed_source(
        o, path,
        &(struct glint_import_source){.type = GLINT_SCENE_MULTIPART,
                                      .bytes = body,
                                      .size = size,
                                      .boundary = strchr(bundle.type, '=') + 1});
    munmap(body, size);
    glint_bundle_finish(&bundle);
    return posed;
}

struct glint_posed bench_waves_scene(const struct offline *o, const char *path)
{
    const size_t length = path ? strlen(path) : 0;
    if (!path)
        return offline_load_posed_text(o, bench_million_scene());
    return length > 5 && !strcmp(path + length - 5, ".gltf") ? load_gltf(o, path)
                                                             : offline_load_posed(o, path);
}

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
