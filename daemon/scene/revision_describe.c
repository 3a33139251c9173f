// revision_describe.c - what clients are told of a revision and of a patch.
#include "scene/revision_parts.h"

#include <string.h>

#define MAX_EFFECTS 64

static void add_bytes(cJSON *resource, const glint_revision *r)
{
    const struct glint_resident_stats *s = &r->stats;
    const uint64_t poses = atomic_load(&r->pose_bytes), later = atomic_load(&r->later_bytes);
    cJSON_AddNumberToObject(resource, "resident_bytes",
                            (double)(glint_revision_bytes(s) + later + poses));
    cJSON *bytes = cJSON_AddObjectToObject(resource, "bytes");
    cJSON_AddNumberToObject(bytes, "geometry", (double)s->geometry_bytes);
    cJSON_AddNumberToObject(bytes, "bvh", (double)(s->bvh_bytes + later));
    cJSON_AddNumberToObject(bytes, "records", (double)s->record_bytes);
    cJSON_AddNumberToObject(bytes, "textures", (double)s->texture_bytes);
    cJSON_AddNumberToObject(bytes, "lights", (double)s->light_bytes);
    cJSON_AddNumberToObject(bytes, "poses", (double)poses);
}

static void add_seconds(cJSON *resource, const glint_revision *r)
{
    const struct glint_resident_change *change = glint_resident_change(r->rest.resident);
    struct glint_resident_stats now;
    glint_resident_stats(r->rest.resident, &now);
    cJSON *seconds = cJSON_AddObjectToObject(resource, "seconds");
    cJSON_AddNumberToObject(seconds, "import", r->import->seconds);
    cJSON_AddNumberToObject(seconds, "parse", r->parse_seconds);
    cJSON_AddNumberToObject(seconds, "geometry", r->stats.geometry_seconds);
    for (int p = 0; p < GLINT_PARTS; p++)
        if (p != GLINT_PART_TEXTURES && p != GLINT_PART_LIGHTS && p != GLINT_PART_BVH)
            cJSON_AddNumberToObject(seconds, glint_part_name[p], change->seconds[p]);
    cJSON_AddNumberToObject(seconds, "bvh", now.bvh_seconds);
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
    const bool failed =
        atomic_load_explicit(&r->stage, memory_order_acquire) == GLINT_REVISION_FAILED;
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
