#include "tests/render/offline.h"

#include "tests/odds.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void offline_die(const char *what, const struct glint_error *err)
{
    fprintf(stderr, "render_file: %s: %s\n", what, glint_error_text(err));
    for (size_t i = 0; i < err->count; i++)
        fprintf(stderr, "  %s: %s\n", err->fault[i].pointer, err->fault[i].detail);
    exit(1);
}

uint8_t *offline_read_file(const char *path, size_t *size)
{
    FILE *f = fopen(path, "rb");
    if (!f || fseek(f, 0, SEEK_END)) {
        perror(path);
        exit(1);
    }
    const long n = ftell(f);
    uint8_t *bytes = calloc(1, (size_t)n + 1);
    rewind(f);
    if (!bytes || fread(bytes, 1, (size_t)n, f) != (size_t)n) {
        perror(path);
        exit(1);
    }
    fclose(f);
    *size = (size_t)n;
    return bytes;
}

static void free_import(void *import)
{
    struct glint_import *owned = import;
    glint_import_destroy(&owned);
}

struct glint_posed offline_load_posed_source(const struct offline *o, const char *name,
                                             const struct glint_import_source *source)
{
    struct glint_error err = {0};
    struct glint_import *import = NULL;
    struct glint_scene *scene = NULL;
    struct glint_posed posed;
    const struct glint_import_limits limits = {(size_t)8 << 30, 60.0};
    if (glint_import_run(o->importer, source, &limits, &import, &err) ||
        glint_scene_parse(&scene, import->text, import->length, import->asset, import->assets,
                          &err) ||
        glint_scene_complete(scene, &err) ||
        glint_posed_create(&posed, o->devices,
                           &(struct glint_resident_order){scene, free_import, import, NULL, NULL},
                           &err))
        offline_die(name, &err);
    for (size_t i = 0; i < import->warnings; i++)
        fprintf(stderr, "# warning: %s\n", import->warning[i]);
    return posed;
}

static struct glint_posed load_bytes(const struct offline *o, enum glint_scene_type type,
                                     const char *name, const uint8_t *bytes, size_t size)
{
    return offline_load_posed_source(
        o, name, &(struct glint_import_source){.type = type, .bytes = bytes, .size = size});
}

struct glint_posed offline_load_posed(const struct offline *o, const char *path)
{
    const size_t length = strlen(path);
    const bool glb = length > 4 && strcmp(path + length - 4, ".glb") == 0;
    size_t size;
    uint8_t *bytes = offline_read_file(path, &size);
    const struct glint_posed posed =
        load_bytes(o, glb ? GLINT_SCENE_GLB : GLINT_SCENE_NATIVE, path, bytes, size);
    free(bytes);
    return posed;
}

struct glint_posed offline_load_posed_text(const struct offline *o, const char *text)
{
    return load_bytes(o, GLINT_SCENE_NATIVE, "scene", (const uint8_t *)text, strlen(text));
}

glint_resident *offline_load(const struct offline *o, const char *path)
{
    return offline_load_posed(o, path).resident;
}

glint_resident *offline_load_text(const struct offline *o, const char *text)
{
    return offline_load_posed_text(o, text).resident;
}

struct glint_job *offline_job(const char *text)
{
    struct glint_error err = {0};
    struct glint_job *job = NULL;
    if (glint_job_parse(&job, text, strlen(text), &err))
        offline_die(text, &err);
    job->seed = (uint32_t)odds_seed(job->seed);
    job->stop.samples = odds_samples(job->stop.samples);
    return job;
}

void offline_start(struct offline *o, uint32_t threads)
{
    struct glint_error err = {0};
    if (glint_importer_create(&o->importer, &err) ||
        glint_devices_create(&o->devices, threads, NULL, &err))
        offline_die("start", &err);
}

void offline_finish(struct offline *o)
{
    glint_devices_destroy(&o->devices);
    glint_importer_destroy(&o->importer);
}

struct offline offline_crew;

uint32_t offline_workers(void)
{
    const char *wanted = getenv("GLINT_TEST_WORKERS");
    return wanted && atoi(wanted) > 0 ? (uint32_t)atoi(wanted) : 2;
}

int offline_crew_start(void **state)
{
    (void)state;
    offline_start(&offline_crew, offline_workers());
    return 0;
}

int offline_crew_finish(void **state)
{
    (void)state;
    offline_finish(&offline_crew);
    return 0;
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
            offline_die("slice", &err);
        pthread_mutex_lock(&c->mutex);
        glint_render_give_back(c->render, &slice, true);
        pthread_cond_broadcast(&c->given_back);
        pthread_mutex_unlock(&c->mutex);
    }
    return NULL;
}

void offline_render(const struct offline *o, glint_render *render)
{
    struct crew crew = {render, o->devices, PTHREAD_MUTEX_INITIALIZER, PTHREAD_COND_INITIALIZER};
    const uint32_t n = glint_devices_workers(o->devices);
    pthread_t thread[256];
    struct hand hand[256];
    for (uint32_t i = 0; i < n; i++) {
        hand[i] = (struct hand){&crew, i};
        pthread_create(&thread[i], NULL, work, &hand[i]);
    }
    for (uint32_t i = 0; i < n; i++)
        pthread_join(thread[i], NULL);
}

static struct glint_frame *frame_of(const struct offline *o, const struct glint_posed *posed,
                                    const struct glint_job *job, uint64_t force)
{
    struct glint_error err = {0};
    glint_render *render = NULL;
    struct glint_frame *frame = NULL;
    if (glint_render_create_forced(&render, o->devices, posed->resident, posed->pose, job, force,
                                   &err))
        offline_die("render", &err);
    offline_render(o, render);
    if (glint_render_frame(render, job->outputs, &frame, NULL, &err))
        offline_die("frame", &err);
    glint_render_destroy(&render);
    return frame;
}

struct glint_frame *offline_frame(const struct offline *o, glint_resident *scene, const char *text,
                                  uint64_t force)
{
    struct glint_job *job = offline_job(text);
    const struct glint_posed posed = {scene, NULL};
    struct glint_frame *frame = frame_of(o, &posed, job, force);
    glint_job_destroy(&job);
    return frame;
}

struct glint_frame *offline_frame_posed(const struct offline *o, const struct glint_posed *rest,
                                        const char *text, uint64_t force)
{
    struct glint_error err = {0};
    struct glint_job *job = offline_job(text);
    struct glint_posed posed;
    if (glint_posed_for(&posed, o->devices, rest, job, &err))
        offline_die("pose", &err);
    struct glint_frame *frame = frame_of(o, &posed, job, force);
    glint_resident_release(&posed.resident);
    glint_job_destroy(&job);
    return frame;
}
