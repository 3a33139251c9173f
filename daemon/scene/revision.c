#include "scene/revision.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/sha256.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#define MAX_EFFECTS 64

#define MAX_POSES 64u
#define MAX_POSE_BYTES ((uint64_t)1 << 30)

// A pose that a job asked for; the next frame's job may render beside it.
struct cached_pose {
    struct glint_pose_request request;
    struct glint_posed posed; // retained
    uint64_t bytes, used;     // used: the turn in which it was asked for last
};

struct glint_revision {
    atomic_uint references;
    glint_devices *devices;
    struct glint_usage *usage;
    char *name;
    char id[65];
    char created[32];
    struct glint_posed rest;           // owns scene and import
    const struct glint_import *import; // lives as long as `rest`
    glint_keep *keep;                  // NULL: nothing is kept
    char *warnings, *told;             // of a recalled one: JSON as it was told, or NULL
    atomic_int stage;                  // enum stage; what loading fills is read after it
    pthread_mutex_t loading;           // held by who loads
    struct glint_error why;            // FAILED
    double parse_seconds;
    struct glint_resident_stats stats;
    _Atomic uint64_t *resident_bytes;
    pthread_mutex_t mutex; // guards what follows
    struct cached_pose pose[MAX_POSES];
    uint32_t poses;
    uint64_t pose_turns;
    _Atomic uint64_t pose_bytes; // also read without
};

enum stage { RECALLED, LOADED, FAILED };

struct glint_usage *glint_usage_create(void)
{
    struct glint_usage *usage = calloc(1, sizeof *usage);
    if (usage)
        atomic_init(&usage->references, 1);
    return usage;
}

struct glint_usage *glint_usage_retain(struct glint_usage *usage)
{
    // Relaxed: who retains holds a reference already.
    atomic_fetch_add_explicit(&usage->references, 1, memory_order_relaxed);
    return usage;
}

void glint_usage_release(struct glint_usage **usage)
{
    // Acquire and release: the last to leave sees what the others did before they left.
    if (*usage && atomic_fetch_sub_explicit(&(*usage)->references, 1, memory_order_acq_rel) == 1)
        free(*usage);
    *usage = NULL;
}

void glint_revision_hash(const struct glint_import *import, char id[65])
{
    glint_sha256(import->text, import->length, id);
}

static uint64_t total_bytes(const struct glint_resident_stats *s)
{
    return s->geometry_bytes + s->bvh_bytes + s->record_bytes + s->texture_bytes + s->light_bytes;
}

static void free_import(void *import)
{
    struct glint_import *owned = import;
    glint_import_destroy(&owned);
}

// Takes scene and import always.
static glint_status make_resident(glint_revision *r, struct glint_scene *scene,
                                  const glint_revision *from, struct glint_error *err)
{
    struct glint_import *import = (struct glint_import *)r->import;
    const double start = glint_now();
    glint_status st = scene ? GLINT_OK
                            : glint_scene_parse(&scene, import->text, import->length, import->asset,
                                                import->assets, err);
    r->parse_seconds = glint_now() - start;
    const struct glint_resident_order order = {.scene = scene,
                                               .free_assets = free_import,
                                               .assets = import,
                                               .from = from ? from->rest.resident : NULL};
    if (!st)
        st = glint_posed_create(&r->rest, r->devices, &order, err);
    if (st) {
        glint_scene_destroy(&scene);
        glint_import_destroy(&import);
    }
    return st;
}

// Takes usage.
static glint_revision *new_revision(glint_devices *devices, const char *name,
                                    struct glint_usage *usage, _Atomic uint64_t *resident_bytes,
                                    glint_keep *keep)
{
    glint_revision *r = calloc(1, sizeof *r);
    char *copy = strdup(name);
    if (!r || !copy) {
        free(r);
        free(copy);
        glint_usage_release(&usage);
        return NULL;
    }
    r->devices = devices;
    r->usage = usage;
    r->name = copy;
    r->resident_bytes = resident_bytes;
    r->keep = keep;
    atomic_init(&r->references, 1);
    atomic_init(&r->stage, RECALLED);
    pthread_mutex_init(&r->mutex, NULL);
    pthread_mutex_init(&r->loading, NULL);
    return r;
}

// From here on the revision has everything.
static void become_loaded(glint_revision *r)
{
    glint_resident_set_revision(r->rest.resident, r->id);
    glint_resident_stats(r->rest.resident, &r->stats);
    atomic_fetch_add(r->resident_bytes, total_bytes(&r->stats));
    // Release: who sees it loaded sees what it consists of.
    atomic_store_explicit(&r->stage, LOADED, memory_order_release);
}

glint_status glint_revision_create(glint_revision **out, glint_devices *devices,
                                   const struct glint_revision_order *order,
                                   struct glint_error *err)
{
    glint_revision *r = *out =
        new_revision(devices, order->name, order->usage, order->resident_bytes, order->keep);
    if (!r) {
        struct glint_scene *scene = order->scene;
        struct glint_import *import = order->import;
        glint_scene_destroy(&scene);
        glint_import_destroy(&import);
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a revision");
    }
    r->import = order->import;
    glint_revision_hash(r->import, r->id);
    glint_utc(r->created);
    const glint_status st = make_resident(r, order->scene, order->from, err);
    if (st) {
        glint_revision_release(out);
        return st;
    }
    if (r->keep)
        glint_keep_hold(r->keep, r->id, 0);
    become_loaded(r);
    return GLINT_OK;
}

// ---- revisions that are read back

static void recall_created(glint_revision *r)
{
    cJSON *told = r->told ? cJSON_Parse(r->told) : NULL;
    const char *created = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(told, "created"));
    if (created && strlen(created) < sizeof r->created)
        strcpy(r->created, created);
    cJSON_Delete(told);
}

glint_status glint_revision_recall(glint_revision **out, glint_devices *devices,
                                   const struct glint_revision_memory *memory,
                                   struct glint_error *err)
{
    glint_revision *r = *out =
        new_revision(devices, memory->name, memory->usage, memory->resident_bytes, memory->keep);
    if (r) {
        memcpy(r->id, memory->id, sizeof r->id);
        r->warnings = memory->warnings ? strdup(memory->warnings) : NULL;
        r->told = memory->resource ? strdup(memory->resource) : NULL;
        recall_created(r);
    }
    if (r && !r->warnings == !memory->warnings && !r->told == !memory->resource)
        return GLINT_OK;
    glint_revision_release(out);
    return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a revision");
}

bool glint_revision_loaded(const glint_revision *r)
{
    return atomic_load_explicit(&r->stage, memory_order_acquire) == LOADED;
}

static glint_status read_back(glint_revision *r, struct glint_error *err)
{
    struct glint_import *import;
    uint32_t depth;
    glint_status st = glint_keep_read(r->keep, r->id, r->warnings, &import, &depth, err);
    if (st)
        return st;
    r->import = import;
    st = make_resident(r, NULL, NULL, err);
    if (st) {
        r->import = NULL;
        return st;
    }
    glint_keep_hold(r->keep, r->id, depth);
    become_loaded(r);
    return GLINT_OK;
}

static glint_status refuse(const glint_revision *r, struct glint_error *err)
{
    return glint_fail(err, GLINT_E_CONFLICT, "", "the scene \"%s\" cannot be loaded: %s", r->name,
                      glint_error_text(&r->why));
}

// A lack of memory passes, other faults stay.
static glint_status load(glint_revision *r, struct glint_error *err)
{
    struct glint_error why = {0};
    const glint_status st = read_back(r, &why);
    if (!st)
        return GLINT_OK;
    if (st == GLINT_E_CAPACITY || st == GLINT_E_NOMEM) {
        glint_fail(err, st, "", "%s", glint_error_text(&why));
        glint_error_finish(&why);
        return st;
    }
    glint_log(GLINT_LOG_ERROR, "scene", NULL, NULL, "revision %.12s of \"%s\" cannot be loaded: %s",
              r->id, r->name, glint_error_text(&why));
    r->why = why;
    atomic_store_explicit(&r->stage, FAILED, memory_order_release);
    return refuse(r, err);
}

glint_status glint_revision_load(glint_revision *r, struct glint_error *err)
{
    if (glint_revision_loaded(r))
        return GLINT_OK;
    glint_status st = GLINT_OK;
    pthread_mutex_lock(&r->loading);
    const int stage = atomic_load_explicit(&r->stage, memory_order_relaxed);
    if (stage == FAILED)
        st = refuse(r, err);
    else if (stage == RECALLED)
        st = load(r, err);
    pthread_mutex_unlock(&r->loading);
    return st;
}

void glint_revision_edit(const glint_revision *revision, struct glint_edit *out)
{
    out->import = revision->import;
    out->scene = glint_resident_scene(revision->rest.resident);
}

// ---- poses

// Counts the bytes of a pose while it lives, in the cache or only in a render.
struct weight {
    _Atomic uint64_t *resident_bytes;
    uint64_t bytes;
};

static void lighten(void *user)
{
    struct weight *w = user;
    atomic_fetch_sub(w->resident_bytes, w->bytes);
    free(w);
}

static bool same_request(const struct glint_pose_request *a, const struct glint_pose_request *b)
{
    return a->animation == b->animation && a->open == b->open && a->close == b->close &&
           a->before == b->before && a->after == b->after && a->flow == b->flow;
}

static void forget_pose(glint_revision *r, uint32_t i)
{
    glint_resident_release(&r->pose[i].posed.resident);
    r->pose_bytes -= r->pose[i].bytes;
    r->pose[i] = r->pose[--r->poses];
}

// Lets the poses that were asked for longest ago go, until `bytes` more are within the bound. What
// a render holds lives on there.
static void make_room(glint_revision *r, uint64_t bytes)
{
    while (r->poses == MAX_POSES || (r->poses && r->pose_bytes + bytes > MAX_POSE_BYTES)) {
        uint32_t oldest = 0;
        for (uint32_t i = 1; i < r->poses; i++)
            if (r->pose[i].used < r->pose[oldest].used)
                oldest = i;
        forget_pose(r, oldest);
    }
}

static uint64_t pose_bytes(const struct glint_posed *posed)
{
    struct glint_resident_stats s;
    glint_resident_stats(posed->resident, &s);
    return posed->pose->bytes + s.bvh_bytes + s.record_bytes;
}

static glint_status add_pose(glint_revision *r, const struct glint_pose_request *request,
                             struct glint_posed *out, struct glint_error *err)
{
    struct weight *weight = malloc(sizeof *weight);
    if (!weight)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a pose");
    *weight = (struct weight){r->resident_bytes, 0};
    const glint_status st =
        glint_posed_move(out, r->devices, &r->rest, request, lighten, weight, err);
    if (st) {
        free(weight);
        return st;
    }
    weight->bytes = pose_bytes(out);
    atomic_fetch_add(r->resident_bytes, weight->bytes);
    make_room(r, weight->bytes);
    r->pose[r->poses++] = (struct cached_pose){*request, *out, weight->bytes, ++r->pose_turns};
    r->pose_bytes += weight->bytes;
    return GLINT_OK;
}

// With the mutex: who wants the same pose meanwhile waits for it.
static glint_status find_pose(glint_revision *r, const struct glint_pose_request *request,
                              struct glint_posed *out, struct glint_error *err)
{
    for (uint32_t i = 0; i < r->poses; i++)
        if (same_request(&r->pose[i].request, request)) {
            r->pose[i].used = ++r->pose_turns;
            *out = r->pose[i].posed;
            return GLINT_OK;
        }
    return add_pose(r, request, out, err);
}

glint_status glint_revision_pose(glint_revision *r, const struct glint_job *job,
                                 struct glint_posed *out, struct glint_error *err)
{
    struct glint_pose_request request;
    *out = (struct glint_posed){0};
    glint_status st = glint_revision_load(r, err);
    if (st)
        return st;
    const struct glint_scene *scene = glint_resident_scene(r->rest.resident);
    *out = r->rest;
    st = glint_posed_request(&request, scene, job, err);
    if (st)
        return st;
    pthread_mutex_lock(&r->mutex);
    if (glint_pose_wanted(scene, &request))
        st = find_pose(r, &request, out, err);
    if (!st)
        glint_resident_retain(out->resident);
    pthread_mutex_unlock(&r->mutex);
    return st;
}

glint_revision *glint_revision_retain(glint_revision *revision)
{
    atomic_fetch_add_explicit(&revision->references, 1, memory_order_relaxed);
    return revision;
}

void glint_revision_release(glint_revision **revision)
{
    glint_revision *r = *revision;
    *revision = NULL;
    if (!r || atomic_fetch_sub_explicit(&r->references, 1, memory_order_acq_rel) != 1)
        return;
    if (glint_revision_loaded(r)) {
        atomic_fetch_sub(r->resident_bytes, total_bytes(&r->stats));
        while (r->poses)
            forget_pose(r, r->poses - 1);
        glint_resident_release(&r->rest.resident);
        if (r->keep) // after its assets: what it alone used goes in the same round
            glint_keep_release(r->keep, r->id);
    }
    glint_usage_release(&r->usage);
    glint_error_finish(&r->why);
    pthread_mutex_destroy(&r->loading);
    pthread_mutex_destroy(&r->mutex);
    free(r->warnings);
    free(r->told);
    free(r->name);
    free(r);
}

void glint_revision_use(glint_revision *revision, int delta)
{
    atomic_fetch_add(&revision->usage->jobs, delta);
}

struct glint_usage *glint_revision_usage(const glint_revision *revision)
{
    return revision->usage;
}

struct glint_resident *glint_revision_resident(const glint_revision *revision)
{
    return revision->rest.resident;
}

const char *glint_revision_id(const glint_revision *revision)
{
    return revision->id;
}

const char *glint_revision_native(const glint_revision *revision, size_t *length)
{
    if (length)
        *length = revision->import->length;
    return revision->import->text;
}

static void add_bytes(cJSON *resource, const glint_revision *r)
{
    const struct glint_resident_stats *s = &r->stats;
    const uint64_t poses = atomic_load(&r->pose_bytes);
    cJSON_AddNumberToObject(resource, "resident_bytes", (double)(total_bytes(s) + poses));
    cJSON *bytes = cJSON_AddObjectToObject(resource, "bytes");
    cJSON_AddNumberToObject(bytes, "geometry", (double)s->geometry_bytes);
    cJSON_AddNumberToObject(bytes, "bvh", (double)s->bvh_bytes);
    cJSON_AddNumberToObject(bytes, "records", (double)s->record_bytes);
    cJSON_AddNumberToObject(bytes, "textures", (double)s->texture_bytes);
    cJSON_AddNumberToObject(bytes, "lights", (double)s->light_bytes);
    cJSON_AddNumberToObject(bytes, "poses", (double)poses);
}

static void add_seconds(cJSON *resource, const glint_revision *r)
{
    const struct glint_resident_change *change = glint_resident_change(r->rest.resident);
    cJSON *seconds = cJSON_AddObjectToObject(resource, "seconds");
    cJSON_AddNumberToObject(seconds, "import", r->import->seconds);
    cJSON_AddNumberToObject(seconds, "parse", r->parse_seconds);
    cJSON_AddNumberToObject(seconds, "geometry", r->stats.geometry_seconds);
    for (int p = 0; p < GLINT_PARTS; p++)
        if (p != GLINT_PART_TEXTURES && p != GLINT_PART_LIGHTS && p != GLINT_PART_BVH)
            cJSON_AddNumberToObject(seconds, glint_part_name[p], change->seconds[p]);
    cJSON_AddNumberToObject(seconds, "bvh", r->stats.bvh_seconds);
    cJSON_AddNumberToObject(seconds, "textures", r->stats.texture_seconds);
    cJSON_AddNumberToObject(seconds, "lights", r->stats.light_seconds);
}

static void add_counts(cJSON *resource, const glint_revision *r)
{
    const struct glint_scene *scene = glint_resident_scene(r->rest.resident);
    cJSON_AddNumberToObject(resource, "triangles", (double)r->stats.triangles);
    cJSON_AddNumberToObject(resource, "instanced_triangles", (double)r->stats.instanced_triangles);
    cJSON_AddNumberToObject(resource, "dropped_triangles", r->stats.dropped);
    cJSON_AddNumberToObject(resource, "instances", scene->instances);
    cJSON_AddNumberToObject(resource, "objects", scene->objects);
    cJSON_AddNumberToObject(resource, "materials", scene->materials);
    cJSON_AddNumberToObject(resource, "lights", r->stats.lights);
    cJSON *names = cJSON_AddArrayToObject(resource, "cameras");
    for (uint32_t i = 0; i < scene->cameras; i++)
        cJSON_AddItemToArray(names, cJSON_CreateString(scene->camera[i].name));
    cJSON *animations = cJSON_AddArrayToObject(resource, "animations");
    for (uint32_t i = 0; i < scene->animations; i++)
        cJSON_AddItemToArray(animations, cJSON_CreateString(scene->animation[i].name));
    cJSON_AddNumberToObject(resource, "fps", scene->fps);
}

static void add_effects(cJSON *resource, const glint_resident *resident)
{
    const char *effect[MAX_EFFECTS];
    const size_t count = glint_facts_effects(glint_resident_facts(resident), effect, MAX_EFFECTS);
    cJSON *effects = cJSON_AddArrayToObject(resource, "effects");
    for (size_t i = 0; i < count && i < MAX_EFFECTS; i++)
        cJSON_AddItemToArray(effects, cJSON_CreateString(effect[i]));
}

static void add_warning(cJSON *warnings, const char *text)
{
    for (const cJSON *w = warnings->child; w; w = w->next)
        if (!strcmp(w->valuestring, text))
            return;
    cJSON_AddItemToArray(warnings, cJSON_CreateString(text));
}

static void add_warnings(cJSON *resource, const glint_revision *r)
{
    // The import warns of what a file has and a scene has not, the parse of what it added.
    const struct glint_scene *scene = glint_resident_scene(r->rest.resident);
    cJSON *warnings = cJSON_AddArrayToObject(resource, "warnings");
    for (size_t i = 0; warnings && i < r->import->warnings; i++)
        add_warning(warnings, r->import->warning[i]);
    for (uint32_t i = 0; warnings && i < scene->warnings; i++)
        add_warning(warnings, scene->warning[i]);
}

// As it was told when it was made; what it holds in memory now is nothing.
static cJSON *recalled_resource(const glint_revision *r)
{
    cJSON *resource = r->told ? cJSON_Parse(r->told) : cJSON_CreateObject();
    const bool failed = atomic_load_explicit(&r->stage, memory_order_acquire) == FAILED;
    cJSON_DeleteItemFromObjectCaseSensitive(resource, "state");
    cJSON_AddStringToObject(resource, "state", failed ? "failed" : "loading");
    cJSON *bytes = cJSON_GetObjectItemCaseSensitive(resource, "resident_bytes");
    if (bytes)
        cJSON_SetNumberValue(bytes, 0);
    if (failed)
        cJSON_AddStringToObject(resource, "problem", glint_error_text(&r->why));
    return resource;
}

cJSON *glint_revision_resource(const glint_revision *r)
{
    if (!glint_revision_loaded(r))
        return recalled_resource(r);
    cJSON *resource = cJSON_CreateObject();
    if (!resource)
        return NULL;
    cJSON_AddStringToObject(resource, "name", r->name);
    cJSON_AddStringToObject(resource, "revision", r->id);
    cJSON_AddStringToObject(resource, "created", r->created);
    cJSON_AddStringToObject(resource, "state", "resident");
    add_counts(resource, r);
    add_bytes(resource, r);
    add_effects(resource, r->rest.resident);
    add_warnings(resource, r);
    add_seconds(resource, r);
    return resource;
}

static void add_parts(cJSON *object, const struct glint_resident_change *c,
                      enum glint_part_fate fate, const char *name)
{
    cJSON *list = cJSON_AddArrayToObject(object, name);
    for (int p = 0; p < GLINT_PARTS; p++)
        if (c->fate[p] == fate)
            cJSON_AddItemToArray(list, cJSON_CreateString(glint_part_name[p]));
}

cJSON *glint_patch_describe(const struct glint_patch_report *report)
{
    const struct glint_resident_change *c = &report->change;
    cJSON *object = cJSON_CreateObject();
    add_parts(object, c, GLINT_REBUILT, "rebuilt");
    add_parts(object, c, GLINT_UPLOADED, "uploaded");
    cJSON_AddArrayToObject(object, "refitted"); // never: an older revision may be tracing it
    add_parts(object, c, GLINT_LATER, "later");
    add_parts(object, c, GLINT_KEPT, "kept");
    cJSON *items = cJSON_AddObjectToObject(object, "items");
    cJSON *milliseconds = cJSON_AddObjectToObject(object, "milliseconds");
    for (int p = 0; p < GLINT_PARTS; p++) {
        cJSON_AddNumberToObject(items, glint_part_name[p], c->items[p]);
        cJSON_AddNumberToObject(milliseconds, glint_part_name[p], 1e3 * c->seconds[p]);
    }
    cJSON_AddNumberToObject(milliseconds, "parse", 1e3 * report->parse_seconds);
    cJSON_AddNumberToObject(milliseconds, "total", 1e3 * report->total_seconds);
    return object;
}
