#include "scene/revision.h"

#include "base/clock.h"
#include "scene/sha256.h"

#include <stdlib.h>
#include <string.h>

#define MAX_EFFECTS 64

struct glint_revision {
    atomic_uint references;
    struct glint_usage *usage;
    char *name;
    char id[65];
    char created[32];
    glint_resident *resident;          // owns scene and import
    const struct glint_import *import; // lives as long as `resident`
    struct glint_resident_stats stats;
    _Atomic uint64_t *resident_bytes;
};

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

// Takes `import` always.
static glint_status make_resident(glint_resident **out, glint_devices *devices,
                                  struct glint_import *import, struct glint_error *err)
{
    struct glint_scene *scene = NULL;
    glint_status st =
        glint_scene_parse(&scene, import->text, import->length, import->asset, import->assets, err);
    if (!st)
        st = glint_resident_create(
            out, devices, &(struct glint_resident_order){scene, free_import, import, NULL, NULL},
            err);
    if (st) {
        glint_scene_destroy(&scene);
        glint_import_destroy(&import);
    }
    return st;
}

glint_status glint_revision_create(glint_revision **out, glint_devices *devices, const char *name,
                                   struct glint_import *import, struct glint_usage *usage,
                                   _Atomic uint64_t *resident_bytes, struct glint_error *err)
{
    *out = NULL;
    glint_revision *r = calloc(1, sizeof *r);
    char *copy = strdup(name);
    if (!r || !copy) {
        free(r);
        free(copy);
        glint_import_destroy(&import);
        glint_usage_release(&usage);
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a revision");
    }
    r->usage = usage;
    r->name = copy;
    r->import = import;
    r->resident_bytes = resident_bytes;
    atomic_init(&r->references, 1);
    glint_revision_hash(import, r->id);
    glint_utc(r->created);
    const glint_status st = make_resident(&r->resident, devices, import, err);
    if (st) {
        glint_revision_release(&r);
        return st;
    }
    glint_resident_set_revision(r->resident, r->id);
    glint_resident_set_revision(r->resident, r->id);
    glint_resident_stats(r->resident, &r->stats);
    atomic_fetch_add(resident_bytes, total_bytes(&r->stats));
    *out = r;
    return GLINT_OK;
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
    atomic_fetch_sub(r->resident_bytes, total_bytes(&r->stats));
    glint_resident_release(&r->resident);
    glint_usage_release(&r->usage);
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
    return revision->resident;
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

static void add_bytes(cJSON *resource, const struct glint_resident_stats *s)
{
    cJSON_AddNumberToObject(resource, "resident_bytes", (double)total_bytes(s));
    cJSON *bytes = cJSON_AddObjectToObject(resource, "bytes");
    cJSON_AddNumberToObject(bytes, "geometry", (double)s->geometry_bytes);
    cJSON_AddNumberToObject(bytes, "bvh", (double)s->bvh_bytes);
    cJSON_AddNumberToObject(bytes, "records", (double)s->record_bytes);
    cJSON_AddNumberToObject(bytes, "textures", (double)s->texture_bytes);
    cJSON_AddNumberToObject(bytes, "lights", (double)s->light_bytes);
}

static void add_seconds(cJSON *resource, const glint_revision *r)
{
    cJSON *seconds = cJSON_AddObjectToObject(resource, "seconds");
    cJSON_AddNumberToObject(seconds, "import", r->import->seconds);
    cJSON_AddNumberToObject(seconds, "geometry", r->stats.geometry_seconds);
    cJSON_AddNumberToObject(seconds, "bvh", r->stats.bvh_seconds);
    cJSON_AddNumberToObject(seconds, "textures", r->stats.texture_seconds);
    cJSON_AddNumberToObject(seconds, "lights", r->stats.light_seconds);
}

static void add_counts(cJSON *resource, const glint_revision *r)
{
    const struct glint_scene *scene = glint_resident_scene(r->resident);
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
    const struct glint_scene *scene = glint_resident_scene(r->resident);
    cJSON *warnings = cJSON_AddArrayToObject(resource, "warnings");
    for (size_t i = 0; warnings && i < r->import->warnings; i++)
        add_warning(warnings, r->import->warning[i]);
    for (uint32_t i = 0; warnings && i < scene->warnings; i++)
        add_warning(warnings, scene->warning[i]);
}

cJSON *glint_revision_resource(const glint_revision *r)
{
    cJSON *resource = cJSON_CreateObject();
    if (!resource)
        return NULL;
    cJSON_AddStringToObject(resource, "name", r->name);
    cJSON_AddStringToObject(resource, "revision", r->id);
    cJSON_AddStringToObject(resource, "created", r->created);
    add_counts(resource, r);
    add_bytes(resource, &r->stats);
    add_effects(resource, r->resident);
    add_warnings(resource, r);
    add_seconds(resource, r);
    return resource;
}
