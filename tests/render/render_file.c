// render_file - renders a scene file to an EXR without a daemon: for tests and benches.
//
// usage: render_file SCENE.{glb,json} JOB.json OUT.exr [--threads N] [--force EFFECT]... [--stats]
#include "base/clock.h"
#include "protocol/exr.h"
#include "render/internal.h"
#include "scene/import.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct options {
    const char *scene, *job, *out;
    uint32_t threads;
    uint64_t force;
    bool stats;
};

static void die(const char *what, const struct glint_error *err)
{
    fprintf(stderr, "render_file: %s: %s\n", what, glint_error_text(err));
    for (size_t i = 0; i < err->count; i++)
        fprintf(stderr, "  %s: %s\n", err->fault[i].pointer, err->fault[i].detail);
    exit(1);
}

static uint8_t *read_file(const char *path, size_t *size)
{
    FILE *f = fopen(path, "rb");
    if (!f || fseek(f, 0, SEEK_END)) {
        perror(path);
        exit(1);
    }
    const long n = ftell(f);
    uint8_t *bytes = malloc((size_t)n + 1);
    rewind(f);
    if (!bytes || fread(bytes, 1, (size_t)n, f) != (size_t)n) {
        perror(path);
        exit(1);
    }
    fclose(f);
    *size = (size_t)n;
    return bytes;
}

static glint_resident *load(glint_devices *devices, glint_importer *importer, const char *path)
{
    struct glint_error err = {0};
    struct glint_import *import = NULL;
    struct glint_scene *scene = NULL;
    glint_resident *resident = NULL;
    const struct glint_import_limits limits = {(size_t)8 << 30, 60.0};
    const size_t length = strlen(path);
    const bool glb = length > 4 && strcmp(path + length - 4, ".glb") == 0;
    size_t size;
    uint8_t *bytes = read_file(path, &size);
    if (glint_import_run(importer, glb ? GLINT_SCENE_GLB : GLINT_SCENE_NATIVE, bytes, size, &limits, &import, &err)
        || glint_scene_parse(&scene, import->text, import->length, import->asset, import->assets, &err)
        || glint_scene_complete(scene, &err)
        || glint_resident_create(&resident, devices, scene, NULL, NULL, &err))
        die(path, &err);
    for (size_t i = 0; i < import->warnings; i++)
        fprintf(stderr, "warning: %s\n", import->warning[i]);
    free(bytes);
    return resident;
}

// Workers share one lock around the render's bookkeeping, as the scheduler would.
struct crew {
    glint_render *render;
    glint_devices *devices;
    pthread_mutex_t mutex;
    pthread_cond_t given_back;
};

struct hand {
    struct crew *crew;
    uint32_t index;
};

static bool next_slice(struct crew *c, struct glint_slice *slice)
{
    pthread_mutex_lock(&c->mutex);
    bool any = false;
    while (!glint_render_complete(c->render) && !(any = glint_render_take(c->render, slice)))
        pthread_cond_wait(&c->given_back, &c->mutex);
    pthread_mutex_unlock(&c->mutex);
    return any;
}

static void *work(void *user)
{
    const struct hand *hand = user;
    struct crew *c = hand->crew;
    glint_worker *worker = glint_devices_worker(c->devices, hand->index);
    struct glint_error err = {0};
    struct glint_slice slice;
    glint_worker_enter(worker);
    while (next_slice(c, &slice)) {
        if (glint_render_run(c->render, worker, &slice, &err))
            die("slice", &err);
        pthread_mutex_lock(&c->mutex);
        glint_render_give_back(c->render, &slice, true);
        pthread_cond_broadcast(&c->given_back);
        pthread_mutex_unlock(&c->mutex);
    }
    return NULL;
}

static void render_all(glint_render *render, glint_devices *devices)
{
    struct crew crew = {render, devices, PTHREAD_MUTEX_INITIALIZER, PTHREAD_COND_INITIALIZER};
    const uint32_t n = glint_devices_workers(devices);
    pthread_t thread[256];
    struct hand hand[256];
    for (uint32_t i = 0; i < n; i++) {
        hand[i] = (struct hand){&crew, i};
        pthread_create(&thread[i], NULL, work, &hand[i]);
    }
    for (uint32_t i = 0; i < n; i++)
        pthread_join(thread[i], NULL);
}

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
    cJSON_AddNumberToObject(plan, "error", isnan(s.error) ? 0.0 : s.error);
    cJSON_AddNumberToObject(plan, "samples", s.samples);
    cJSON_AddNumberToObject(plan, "ns_per_vertex", s.worker_seconds * 1e9 / (double)(s.camera_rays + s.bounce_rays));
    cJSON_AddNumberToObject(plan, "triangles", (double)stats.instanced_triangles);
    cJSON_AddNumberToObject(plan, "load_seconds", stats.geometry_seconds + stats.bvh_seconds + stats.texture_seconds
                                                      + stats.light_seconds);
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
    if (glint_render_frame(render, job->outputs, &frame, NULL, &err)
        || glint_exr_write(frame, &options, &bytes, &size, NULL, &err))
        die(path, &err);
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
        fprintf(stderr, "usage: render_file SCENE JOB.json OUT.exr [--threads N] [--force EFFECT] [--stats]\n");
        exit(64);
    }
    *o = (struct options){argv[1], argv[2], argv[3], 0, 0, false};
    for (int i = 4; i < argc; i++) {
        if (strcmp(argv[i], "--stats") == 0)
            o->stats = true;
        else if (strcmp(argv[i], "--threads") == 0 && i + 1 < argc)
            o->threads = (uint32_t)atoi(argv[++i]);
        else if (strcmp(argv[i], "--force") == 0 && i + 1 < argc)
            o->force |= strcmp(argv[i + 1], "all") == 0 ? (1ull << glint_effect_count) - 1 : glint_effect_bit(argv[i + 1]), i++;
    }
}

int main(int argc, char **argv)
{
    struct options o;
    struct glint_error err = {0};
    glint_importer *importer = NULL;
    glint_devices *devices = NULL;
    glint_render *render = NULL;
    struct glint_job *job = NULL;
    size_t length;
    parse_options(argc, argv, &o);
    char *text = (char *)read_file(o.job, &length);
    if (glint_importer_create(&importer, &err) || glint_devices_create(&devices, o.threads, NULL, &err)
        || glint_job_parse(&job, text, length, &err))
        die("start", &err);
    glint_resident *scene = load(devices, importer, o.scene);
    if (glint_render_create_forced(&render, devices, scene, job, o.force, &err))
        die("render", &err);
    const double start = glint_now();
    render_all(render, devices);
    const double seconds = glint_now() - start;
    write_frame(render, job, o.out);
    if (o.stats)
        print_stats(render, scene, seconds);
    glint_render_destroy(&render);
    glint_resident_release(&scene);
    glint_devices_destroy(&devices);
    glint_importer_destroy(&importer);
    free(text);
    return 0;
}
