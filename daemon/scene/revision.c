#include "scene/revision_parts.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/sha256.h"

#include <stdlib.h>
#include <string.h>

#define MAX_POSE_BYTES ((uint64_t)1 << 30)

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
    atomic_init(&r->stage, GLINT_REVISION_RECALLED);
    pthread_mutex_init(&r->mutex, NULL);
    pthread_mutex_init(&r->loading, NULL);
    return r;
}

// From here on the revision has everything.
static void become_loaded(glint_revision *r)
{
    glint_resident_set_revision(r->rest.resident, r->id);
    glint_resident_stats(r->rest.resident, &r->stats);
    atomic_fetch_add(r->resident_bytes, glint_revision_bytes(&r->stats));
    // Release: who sees it loaded sees what it consists of.
    atomic_store_explicit(&r->stage, GLINT_REVISION_LOADED, memory_order_release);
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
    return atomic_load_explicit(&r->stage, memory_order_acquire) == GLINT_REVISION_LOADED;
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

// What was let go is a conflict with what is wanted of it; what cannot be read any more is damage.
static glint_status refuse(const glint_revision *r, struct glint_error *err)
{
    const bool gone = r->why.status == GLINT_E_NOT_FOUND;
    return glint_fail(err, gone ? GLINT_E_CONFLICT : GLINT_E_DAMAGED, "",
                      "the scene \"%s\" cannot be loaded: %s", r->name, glint_error_text(&r->why));
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
    atomic_store_explicit(&r->stage, GLINT_REVISION_FAILED, memory_order_release);
    return refuse(r, err);
}

glint_status glint_revision_load(glint_revision *r, struct glint_error *err)
{
    if (glint_revision_loaded(r))
        return GLINT_OK;
    glint_status st = GLINT_OK;
    pthread_mutex_lock(&r->loading);
    const int stage = atomic_load_explicit(&r->stage, memory_order_relaxed);
    if (stage == GLINT_REVISION_FAILED)
        st = refuse(r, err);
    else if (stage == GLINT_REVISION_RECALLED)
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
    while (r->poses == GLINT_MAX_POSES || (r->poses && r->pose_bytes + bytes > MAX_POSE_BYTES)) {
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
    r->pose[r->poses++] =
        (struct glint_cached_pose){*request, *out, weight->bytes, ++r->pose_turns};
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
        atomic_fetch_sub(r->resident_bytes,
                         glint_revision_bytes(&r->stats) + atomic_load(&r->later_bytes));
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

void glint_revision_weigh(glint_revision *r)
{
    struct glint_resident_stats now;
    glint_resident_stats(r->rest.resident, &now);
    const uint64_t later =
        now.bvh_bytes > r->stats.bvh_bytes ? now.bvh_bytes - r->stats.bvh_bytes : 0;
    const uint64_t before = atomic_exchange(&r->later_bytes, later);
    atomic_fetch_add(r->resident_bytes, later - before); // modulo 2^64
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
