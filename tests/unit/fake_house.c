#include "fake_house.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SIDE 64
#define MAX_JOBS 64
#define MAX_TILES 256

struct glint_devices {
    int unused;
};

struct glint_revision {
    char id[65];
};

struct glint_store {
    pthread_mutex_t mutex;
    pthread_cond_t opened;
    bool open;
    struct glint_revision revision; // of "room"
    glint_assets *assets;
};

struct glint_render {
    uint32_t tiles;
    _Atomic uint64_t version[MAX_TILES];
    _Atomic uint64_t versions;
    atomic_bool races; // the first tile and then the last change while versions are read
};

struct fake_job {
    char id[GLINT_JOB_ID_BYTES];
    struct glint_job *job;
    enum glint_job_state state;
    bool prepared;
    uint64_t sequence;
    char warning[64];
    struct glint_render render;
};

struct glint_jobs {
    pthread_mutex_t mutex;
    struct fake_job *job[MAX_JOBS]; // live until the house closes, so views need no count
    bool forgotten[MAX_JOBS];
    uint32_t count, tiles;
    void (*changed)(void *user);
    void *user;
};

void fake_house_open(struct fake_house *house, uint32_t tiles)
{
    house->devices = calloc(1, sizeof *house->devices);
    house->store = calloc(1, sizeof *house->store);
    house->jobs = calloc(1, sizeof *house->jobs);
    pthread_mutex_init(&house->store->mutex, NULL);
    pthread_cond_init(&house->store->opened, NULL);
    house->store->open = true;
    glint_assets_create(&house->store->assets, 1000, NULL);
    memset(house->store->revision.id, 'a', 64);
    pthread_mutex_init(&house->jobs->mutex, NULL);
    house->jobs->tiles = tiles;
}

void fake_house_close(struct fake_house *house)
{
    for (uint32_t i = 0; i < house->jobs->count; i++) {
        glint_job_destroy(&house->jobs->job[i]->job);
        free(house->jobs->job[i]);
    }
    pthread_mutex_destroy(&house->jobs->mutex);
    pthread_mutex_destroy(&house->store->mutex);
    pthread_cond_destroy(&house->store->opened);
    free(house->jobs);
    glint_assets_destroy(&house->store->assets);
    free(house->store);
    free(house->devices);
}

// With the mutex.
static struct fake_job *find(glint_jobs *jobs, const char *id)
{
    for (uint32_t i = 0; i < jobs->count; i++)
        if (!jobs->forgotten[i] && !strcmp(jobs->job[i]->id, id))
            return jobs->job[i];
    return NULL;
}

static struct fake_job *lock(glint_jobs *jobs, const char *id)
{
    pthread_mutex_lock(&jobs->mutex);
    return find(jobs, id);
}

// Tells as the scheduler does: after every change, with the table's mutex.
static void unlock_changed(glint_jobs *jobs, struct fake_job *job)
{
    job->sequence++;
    if (jobs->changed)
        jobs->changed(jobs->user);
    pthread_mutex_unlock(&jobs->mutex);
}

void fake_job_last(glint_jobs *jobs, char id[GLINT_JOB_ID_BYTES])
{
    pthread_mutex_lock(&jobs->mutex);
    strcpy(id, jobs->count ? jobs->job[jobs->count - 1]->id : "");
    pthread_mutex_unlock(&jobs->mutex);
}

void fake_job_prepare(glint_jobs *jobs, const char *id)
{
    struct fake_job *job = lock(jobs, id);
    job->prepared = true;
    unlock_changed(jobs, job);
}

static void renew(struct glint_render *r, uint32_t tile)
{
    atomic_store(&r->version[tile], atomic_fetch_add(&r->versions, 1) + 1);
}

void fake_job_render(glint_jobs *jobs, const char *id, uint32_t tile)
{
    struct fake_job *job = lock(jobs, id);
    struct glint_render *r = &job->render;
    for (uint32_t t = 0; t < r->tiles; t++)
        if (tile == UINT32_MAX || tile == t)
            renew(r, t);
    unlock_changed(jobs, job);
}

void fake_job_race(glint_jobs *jobs, const char *id, uint32_t tile)
{
    struct fake_job *job = lock(jobs, id);
    atomic_store(&job->render.races, true);
    pthread_mutex_unlock(&jobs->mutex);
    fake_job_render(jobs, id, tile);
}

void fake_job_set_state(glint_jobs *jobs, const char *id, enum glint_job_state state)
{
    struct fake_job *job = lock(jobs, id);
    job->state = state;
    unlock_changed(jobs, job);
}

void fake_job_warn(glint_jobs *jobs, const char *id, const char *text)
{
    struct fake_job *job = lock(jobs, id);
    snprintf(job->warning, sizeof job->warning, "%s", text);
    unlock_changed(jobs, job);
}

void fake_store_gate(glint_store *store, bool open)
{
    pthread_mutex_lock(&store->mutex);
    store->open = open;
    pthread_cond_broadcast(&store->opened);
    pthread_mutex_unlock(&store->mutex);
}

// jobs.h

const char *glint_job_state_name(enum glint_job_state state)
{
    static const char *const name[] = {"queued", "rendering", "paused",
                                       "done",   "failed",    "cancelled"};
    return name[state];
}

void glint_jobs_on_change(glint_jobs *jobs, void (*changed)(void *user), void *user)
{
    pthread_mutex_lock(&jobs->mutex);
    jobs->changed = changed;
    jobs->user = user;
    pthread_mutex_unlock(&jobs->mutex);
}

glint_status glint_jobs_submit(glint_jobs *jobs, struct glint_job *job,
                               const struct glint_submission *from, char id[GLINT_JOB_ID_BYTES],
                               bool *repeated, struct glint_error *err)
{
    (void)from;
    struct fake_job *j = calloc(1, sizeof *j);
    pthread_mutex_lock(&jobs->mutex);
    if (!j || jobs->count == MAX_JOBS) {
        pthread_mutex_unlock(&jobs->mutex);
        free(j);
        return glint_fail(err, GLINT_E_CAPACITY, "", "the table is full");
    }
    j->job = job;
    j->render.tiles = jobs->tiles;
    snprintf(j->id, sizeof j->id, "job%u", jobs->count);
    strcpy(id, j->id);
    *repeated = false;
    jobs->job[jobs->count++] = j;
    unlock_changed(jobs, j);
    return GLINT_OK;
}

cJSON *glint_jobs_describe(glint_jobs *jobs, const char *id, struct glint_error *err)
{
    struct fake_job *job = lock(jobs, id);
    cJSON *o = NULL;
    if (job) {
        o = cJSON_CreateObject();
        cJSON_AddStringToObject(o, "id", id);
        cJSON_AddStringToObject(o, "state", glint_job_state_name(job->state));
        cJSON_AddNumberToObject(o, "samples", (double)job->render.versions);
        cJSON_AddNumberToObject(o, "progress", 0);
        cJSON *warnings = cJSON_AddArrayToObject(o, "warnings");
        if (*job->warning)
            cJSON_AddItemToArray(warnings, cJSON_CreateString(job->warning));
    } else {
        glint_fail(err, GLINT_E_NOT_FOUND, "", "there is no job \"%.64s\"", id);
    }
    pthread_mutex_unlock(&jobs->mutex);
    return o;
}

cJSON *glint_jobs_list(glint_jobs *jobs, const struct glint_jobs_filter *filter,
                       struct glint_error *err)
{
    (void)filter;
    (void)err;
    (void)jobs;
    cJSON *o = cJSON_CreateObject();
    cJSON_AddArrayToObject(o, "jobs");
    return o;
}

glint_status glint_jobs_delete(glint_jobs *jobs, const char *id, bool *forgotten,
                               struct glint_error *err)
{
    struct fake_job *job = lock(jobs, id);
    glint_status st = GLINT_OK;
    if (!job) {
        st = glint_fail(err, GLINT_E_NOT_FOUND, "", "there is no job \"%.64s\"", id);
        pthread_mutex_unlock(&jobs->mutex);
        return st;
    }
    *forgotten = job->state >= GLINT_JOB_DONE;
    for (uint32_t i = 0; i < jobs->count && *forgotten; i++)
        jobs->forgotten[i] |= jobs->job[i] == job;
    job->state = GLINT_JOB_CANCELLED;
    unlock_changed(jobs, job);
    return st;
}

glint_status glint_jobs_patch(glint_jobs *jobs, const char *id, const char *text, size_t length,
                              struct glint_error *err)
{
    (void)jobs, (void)id, (void)text, (void)length;
    return glint_fail(err, GLINT_E_RANGE, "/priority", "a fake job has none");
}

glint_status glint_jobs_view(glint_jobs *jobs, const char *id, struct glint_job_view *out,
                             struct glint_error *err)
{
    struct fake_job *job = lock(jobs, id);
    const glint_status st = !job ? GLINT_E_NOT_FOUND : !job->prepared ? GLINT_E_BUSY : GLINT_OK;
    if (st)
        glint_fail(err, st, "", "no pixels of job \"%.64s\"", id);
    else
        *out = (struct glint_job_view){.render = &job->render,
                                       .state = job->state,
                                       .job = job->job,
                                       .revision = "fake",
                                       .sequence = job->sequence,
                                       .hold = job};
    pthread_mutex_unlock(&jobs->mutex);
    return st;
}

void glint_jobs_release(glint_jobs *jobs, struct glint_job_view *view)
{
    (void)jobs;
    *view = (struct glint_job_view){0};
}

glint_status glint_jobs_put_front(glint_jobs *jobs, const char *scene, const char *text,
                                  size_t length, bool *created, struct glint_error *err)
{
    (void)jobs, (void)text, (void)length;
    *created = false;
    return glint_fail(err, GLINT_E_NOT_FOUND, "", "no scene \"%s\"", scene);
}

glint_status glint_jobs_drop_front(glint_jobs *jobs, const char *scene, struct glint_error *err)
{
    (void)jobs, (void)scene, (void)err;
    return GLINT_OK;
}

cJSON *glint_jobs_front(glint_jobs *jobs, const char *scene, struct glint_error *err)
{
    (void)jobs;
    glint_fail(err, GLINT_E_NOT_FOUND, "", "no scene \"%s\"", scene);
    return NULL;
}

void glint_jobs_stats(glint_jobs *jobs, struct glint_jobs_stats *out)
{
    pthread_mutex_lock(&jobs->mutex);
    *out = (struct glint_jobs_stats){.submitted = jobs->count};
    for (uint32_t i = 0; i < jobs->count; i++)
        out->by_state[jobs->job[i]->state] += !jobs->forgotten[i];
    pthread_mutex_unlock(&jobs->mutex);
}

uint32_t glint_jobs_workers(glint_jobs *jobs, struct glint_worker_use *out, uint32_t capacity)
{
    (void)jobs;
    for (uint32_t w = 0; w < capacity; w++)
        out[w] = (struct glint_worker_use){0};
    return 1;
}

const char *glint_wait_name(enum glint_wait wait)
{
    return wait ? "turn" : NULL;
}

void glint_store_stats(glint_store *store, struct glint_store_stats *out)
{
    (void)store;
    *out = (struct glint_store_stats){.scenes = 1};
}

bool glint_jobs_belongs(glint_jobs *jobs, const char *id, const char *client)
{
    (void)jobs, (void)id, (void)client;
    return true;
}

// render.h

uint32_t glint_render_tiles(const glint_render *render)
{
    return render->tiles;
}

void glint_render_tile_rect(const glint_render *render, uint32_t tile, uint32_t rect[4])
{
    (void)render;
    memcpy(rect, (uint32_t[]){tile * SIDE, 0, SIDE, SIDE}, 4 * sizeof *rect);
}

uint64_t glint_render_tile_version(const glint_render *render, uint32_t tile)
{
    struct glint_render *r = (struct glint_render *)render;
    const uint64_t version = atomic_load(&r->version[tile]);
    if (tile == 0 && atomic_exchange(&r->races, false)) {
        renew(r, 0);
        renew(r, r->tiles - 1);
    }
    return version;
}

uint64_t glint_render_newest_version(const glint_render *render)
{
    return atomic_load(&render->versions);
}

static glint_status make_frame(glint_render *r, uint32_t first, uint32_t tiles,
                               struct glint_frame **out, struct glint_error *err)
{
    static const char *const name[] = {"R", "G", "B", "A"};
    const glint_status st = glint_frame_create(out, r->tiles * SIDE, SIDE, (int32_t)(first * SIDE),
                                               0, tiles * SIDE, SIDE, err);
    for (int c = 0; !st && c < 4; c++) {
        float *plane = glint_frame_channel(*out, name[c], GLINT_PIXEL_HALF);
        for (uint32_t i = 0; i < tiles * SIDE * SIDE; i++)
            plane[i] = (float)(atomic_load(&r->version[first + i % (tiles * SIDE) / SIDE]) % 1024);
    }
    return st;
}

glint_status glint_render_frame(glint_render *render, uint32_t outputs, struct glint_frame **out,
                                uint32_t *samples, struct glint_error *err)
{
    (void)outputs, (void)samples;
    return make_frame(render, 0, render->tiles, out, err);
}

glint_status glint_render_tile(glint_render *render, uint32_t tile, struct glint_frame **out,
                               uint32_t *samples, uint64_t *version, char revision[65],
                               struct glint_error *err)
{
    memset(revision, 'a', 64);
    revision[64] = '\0';
    *version = atomic_load(&render->version[tile]);
    *samples = (uint32_t)*version;
    return make_frame(render, tile, 1, out, err);
}

glint_status glint_render_mattes(glint_render *render, uint32_t layers,
                                 struct glint_matte_totals *out, struct glint_error *err)
{
    (void)render, (void)err;
    *out = (struct glint_matte_totals){.lost = {0.0, 0.0}};
    for (int l = 0; l < GLINT_MATTE_LAYERS; l++) {
        if (!(layers >> l & 1))
            continue;
        out->of[l] = calloc(1, sizeof *out->of[l]);
        *out->of[l] = (struct glint_matte_total){"torus", 0xf19c73fd, {SIDE * SIDE}};
        out->count[l] = 1;
    }
    return GLINT_OK;
}

void glint_matte_totals_finish(struct glint_matte_totals *totals)
{
    for (int l = 0; l < GLINT_MATTE_LAYERS; l++)
        free(totals->of[l]);
}

glint_status glint_render_pick(glint_render *render, uint32_t x, uint32_t y,
                               struct glint_matte_found **out, size_t *count,
                               struct glint_error *err)
{
    (void)render, (void)x, (void)y, (void)err;
    *out = NULL;
    *count = 0;
    return GLINT_OK;
}

glint_status glint_render_matte(glint_render *render, enum glint_matte_layer layer,
                                uint32_t classes, const char *const *names, size_t count,
                                struct glint_frame **out, struct glint_error *err)
{
    (void)layer, (void)classes;
    for (size_t i = 0; i < count; i++)
        if (strcmp(names[i], "torus"))
            return glint_fail(err, GLINT_E_NOT_FOUND, "/name", "no object \"%s\"", names[i]);
    const glint_status st =
        glint_frame_create(out, render->tiles * SIDE, SIDE, 0, 0, render->tiles * SIDE, SIDE, err);
    if (!st)
        glint_frame_channel(*out, "A", GLINT_PIXEL_FLOAT);
    return st;
}

glint_status glint_render_film(glint_render *render, int fd, struct glint_error *err)
{
    (void)render, (void)fd;
    return glint_fail(err, GLINT_E_IO, "", "a fake render has no film");
}

cJSON *glint_render_plan(const glint_render *render)
{
    (void)render;
    return cJSON_CreateObject();
}

void glint_render_state(const glint_render *render, struct glint_render_state *out)
{
    *out = GLINT_NOTHING_RENDERED;
    out->samples = (uint32_t)render->versions;
}

size_t glint_render_convergence(const glint_render *render, struct glint_convergence_point *out,
                                size_t capacity)
{
    (void)render, (void)capacity;
    *out = (struct glint_convergence_point){1, 0.5, NAN, NAN, 4096};
    return 1;
}

// store.h

glint_status glint_store_put(glint_store *store, const char *name,
                             const struct glint_import_source *source, const char *if_match,
                             glint_revision **out, bool *created, struct glint_error *err)
{
    (void)name, (void)if_match;
    if (source->type == GLINT_SCENE_GLB && (source->size < 12 || memcmp(source->bytes, "glTF", 4)))
        return glint_fail(err, GLINT_E_SYNTAX, "", "not a GLB");
    pthread_mutex_lock(&store->mutex);
    while (!store->open)
        pthread_cond_wait(&store->opened, &store->mutex);
    pthread_mutex_unlock(&store->mutex);
    *out = &store->revision;
    *created = false;
    return GLINT_OK;
}

glint_status glint_store_patch(glint_store *store, const char *name, const char *text,
                               size_t length, const char *if_match, glint_revision **out,
                               struct glint_patch_report *report, struct glint_error *err)
{
    (void)text, (void)length, (void)if_match;
    *report = (struct glint_patch_report){.changed = true};
    return glint_store_get(store, name, out, err);
}

cJSON *glint_patch_describe(const struct glint_patch_report *report)
{
    (void)report;
    return cJSON_CreateObject();
}

glint_assets *glint_store_assets(glint_store *store)
{
    return store->assets;
}

glint_status glint_store_put_asset(glint_store *store, const struct glint_asset *asset,
                                   glint_memory_ref *memory, bool *created, struct glint_error *err)
{
    return glint_assets_put(store->assets, asset, memory, created, err);
}

glint_status glint_store_get(glint_store *store, const char *name, glint_revision **out,
                             struct glint_error *err)
{
    if (strcmp(name, "room"))
        return glint_fail(err, GLINT_E_NOT_FOUND, "", "there is no scene \"%.128s\"", name);
    *out = &store->revision;
    return GLINT_OK;
}

glint_status glint_store_delete(glint_store *store, const char *name, const char *if_match,
                                bool force, struct glint_error *err)
{
    (void)store, (void)name, (void)if_match, (void)force;
    return glint_fail(err, GLINT_E_CONFLICT, "", "a fake scene stays");
}

bool glint_store_imports(const glint_store *store)
{
    (void)store;
    return true;
}

cJSON *glint_store_list(glint_store *store)
{
    (void)store;
    cJSON *o = cJSON_CreateObject();
    cJSON_AddArrayToObject(o, "scenes");
    return o;
}

void glint_revision_release(glint_revision **revision)
{
    *revision = NULL;
}

glint_status glint_revision_load(glint_revision *revision, struct glint_error *err)
{
    (void)revision, (void)err;
    return GLINT_OK;
}

const char *glint_revision_id(const glint_revision *revision)
{
    return revision->id;
}

const char *glint_revision_native(const glint_revision *revision, size_t *length)
{
    (void)revision;
    *length = 2;
    return "{}";
}

cJSON *glint_revision_resource(const glint_revision *revision)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "name", "room");
    cJSON_AddStringToObject(o, "revision", revision->id);
    return o;
}

// device.h

uint32_t glint_devices_workers(const glint_devices *devices)
{
    (void)devices;
    return 1;
}

const char *glint_devices_name(const glint_devices *devices)
{
    (void)devices;
    return "fake";
}

const char *glint_devices_version(const glint_devices *devices)
{
    (void)devices;
    return "0";
}
