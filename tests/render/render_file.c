// render_file - renders a scene file to an EXR without a daemon: for tests and benches.
//
// usage: render_file SCENE.{glb,json} JOB.json OUT.exr [--threads N] [--force EFFECT]... [--stats]
#include "base/clock.h"
#include "protocol/exr.h"
#include "tests/render/offline.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct options {
    const char *scene, *job, *out;
    uint32_t threads;
    uint64_t force;
    bool stats;
};

static void print_stats(const glint_render *render, const glint_resident *scene, double seconds)
{
    struct glint_render_state s;
    struct glint_resident_stats stats;
    glint_render_state(render, &s);
    glint_resident_stats(scene, &stats);
    cJSON *plan = glint_render_plan(render);
    cJSON_AddNumberToObject(plan, "wall_seconds", seconds);
    cJSON_AddNumberToObject(plan, "worker_seconds", s.worker_seconds);
    cJSON_AddNumberToObject(plan, "camera_rays", (double)s.camera_rays);
    cJSON_AddNumberToObject(plan, "bounce_rays", (double)s.bounce_rays);
    cJSON_AddNumberToObject(plan, "shadow_rays", (double)s.shadow_rays);
    cJSON_AddNumberToObject(plan, "error", isnan(s.estimate.error) ? 0.0 : s.estimate.error);
    cJSON_AddNumberToObject(plan, "samples", s.samples);
    cJSON_AddNumberToObject(plan, "ns_per_vertex",
                            s.worker_seconds * 1e9 / (double)(s.camera_rays + s.bounce_rays));
    cJSON_AddNumberToObject(plan, "triangles", (double)stats.instanced_triangles);
    cJSON_AddNumberToObject(plan, "load_seconds",
                            stats.geometry_seconds + stats.bvh_seconds + stats.texture_seconds +
                                stats.light_seconds);
    char *text = cJSON_Print(plan);
    puts(text);
    free(text);
    cJSON_Delete(plan);
}

static void write_frame(glint_render *render, const struct glint_job *job, const char *path)
{
    struct glint_error err = {0};
    struct glint_frame *frame = NULL;
    const struct glint_exr_options options = {.compression = GLINT_EXR_ZIP};
    uint8_t *bytes;
    size_t size;
    if (glint_render_frame(render, job->outputs, &frame, NULL, &err) ||
        glint_exr_write(frame, &options, &bytes, &size, NULL, &err))
        offline_die(path, &err);
    FILE *f = fopen(path, "wb");
    if (!f || fwrite(bytes, 1, size, f) != size || fclose(f)) {
        perror(path);
        exit(1);
    }
    free(bytes);
    glint_frame_destroy(&frame);
}

static void parse_options(int argc, char **argv, struct options *o)
{
    if (argc < 4) {
        fprintf(
            stderr,
            "usage: render_file SCENE JOB.json OUT.exr [--threads N] [--force EFFECT] [--stats]\n");
        exit(64);
    }
    *o = (struct options){argv[1], argv[2], argv[3], 0, 0, false};
    for (int i = 4; i < argc; i++) {
        if (strcmp(argv[i], "--stats") == 0)
            o->stats = true;
        else if (strcmp(argv[i], "--threads") == 0 && i + 1 < argc)
            o->threads = (uint32_t)atoi(argv[++i]);
        else if (strcmp(argv[i], "--force") == 0 && i + 1 < argc)
            o->force |= strcmp(argv[i + 1], "all") == 0 ? (1ull << glint_effect_count) - 1
                                                        : glint_effect_bit(argv[i + 1]),
                i++;
    }
}

int main(int argc, char **argv)
{
    struct options options;
    struct offline o;
    struct glint_error err = {0};
    glint_render *render = NULL;
    size_t length;
    parse_options(argc, argv, &options);
    offline_start(&o, options.threads);
    char *text = (char *)offline_read_file(options.job, &length);
    struct glint_job *job = offline_job(text);
    struct glint_posed rest = offline_load_posed(&o, options.scene), posed;
    if (glint_posed_for(&posed, o.devices, &rest, job, &err) ||
        glint_render_create_forced(&render, o.devices, posed.resident, posed.pose, job,
                                   options.force, &err))
        offline_die("render", &err);
    const double start = glint_now();
    offline_render(&o, render);
    const double seconds = glint_now() - start;
    write_frame(render, job, options.out);
    if (options.stats)
        print_stats(render, posed.resident, seconds);
    glint_render_destroy(&render);
    glint_resident_release(&posed.resident);
    glint_resident_release(&rest.resident);
    glint_job_destroy(&job);
    offline_finish(&o);
    free(text);
    return 0;
}
