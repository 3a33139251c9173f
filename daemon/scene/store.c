#include "scene/store_parts.h"

#include "base/clock.h"
#include "base/log.h"

#include <stdlib.h>
#include <string.h>

#define MAX_NAME_BYTES 128

size_t glint_store_find(const glint_store *s, const char *name, bool *found)
{
    size_t low = 0, high = s->scenes;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (strcmp(s->scene[middle].name, name) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    *found = low < s->scenes && !strcmp(s->scene[low].name, name);
    return low;
}

bool glint_store_retain_all(glint_store *s, glint_revision ***out, size_t *count)
{
    pthread_mutex_lock(&s->mutex);
    *count = s->scenes;
    *out = malloc((s->scenes + 1) * sizeof **out);
    for (size_t i = 0; *out && i < s->scenes; i++)
        (*out)[i] = glint_revision_retain(s->scene[i].current);
    pthread_mutex_unlock(&s->mutex);
    return *out != NULL;
}

glint_status glint_store_create(glint_store **out, glint_devices *devices, glint_importer *importer,
                                const struct glint_import_limits *limits, glint_keeper *keeper,
                                struct glint_error *err)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the scene store");
    const glint_status st = glint_assets_create(&(*out)->assets, limits->memory_bytes / 2, err);
    if (st) {
        free(*out);
        *out = NULL;
        return st;
    }
    (*out)->devices = devices;
    (*out)->importer = importer;
    (*out)->limits = *limits;
    pthread_mutex_init(&(*out)->mutex, NULL);
    for (unsigned i = 0; i < GLINT_STORE_EDITORS; i++)
        pthread_mutex_init(&(*out)->editing[i], NULL);
    const glint_status kept = keeper ? glint_store_recall_scenes(*out, keeper, err) : GLINT_OK;
    if (kept)
        glint_store_destroy(out);
    return kept;
}

void glint_store_destroy(glint_store **store)
{
    glint_store *s = *store;
    if (!s)
        return;
    if (s->loading) {
        atomic_store(&s->stop, true);
        pthread_join(s->loader, NULL);
    }
    if (s->keep)
        glint_keep_stop(s->keep);
    for (size_t i = 0; i < s->scenes; i++) {
        glint_revision_release(&s->scene[i].current);
        free(s->scene[i].name);
    }
    pthread_mutex_destroy(&s->mutex);
    for (unsigned i = 0; i < GLINT_STORE_EDITORS; i++)
        pthread_mutex_destroy(&s->editing[i]);
    glint_keep_destroy(&s->keep);
    glint_assets_destroy(&s->assets);
    free(s->recalled);
    free(s);
    *store = NULL;
}

glint_assets *glint_store_assets(glint_store *store)
{
    return store->assets;
}

glint_status glint_store_put_asset(glint_store *s, const struct glint_asset *asset,
                                   glint_memory_ref *memory, bool *created, struct glint_error *err)
{
    glint_status st = glint_assets_put(s->assets, asset, memory, created, err);
    if (st || !s->keep)
        return st;
    // Held first: then it is not collected before it is kept.
    st = glint_keep_asset(s->keep, asset, err);
    if (st && *created)
        glint_assets_unput(s->assets, asset->sha256);
    return st;
}

static glint_status check_name(const char *name, struct glint_error *err)
{
    static const char allowed[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-";
    const size_t length = strlen(name);
    if (length && length <= MAX_NAME_BYTES && strspn(name, allowed) == length)
        return GLINT_OK;
    return glint_fail(err, GLINT_E_RANGE, "",
                      "scene name \"%.140s\": 1 to %d letters, digits, '.', '_', '-' are allowed",
                      name, MAX_NAME_BYTES);
}

static pthread_mutex_t *editor_of(glint_store *s, const char *name)
{
    unsigned hash = 5381;
    while (*name)
        hash = hash * 33 + (unsigned char)*name++;
    return &s->editing[hash % GLINT_STORE_EDITORS];
}

// With the mutex.
static glint_status check_match(const glint_store *s, const char *name, const char *if_match,
                                struct glint_error *err)
{
    if (!if_match)
        return GLINT_OK;
    bool found;
    const size_t at = glint_store_find(s, name, &found);
    if (!found)
        return glint_fail(err, GLINT_E_STALE, "", "there is no scene \"%s\" to match", name);
    const char *current = glint_revision_id(s->scene[at].current);
    if (strcmp(current, if_match))
        return glint_fail(err, GLINT_E_STALE, "", "the revision is %s by now", current);
    return GLINT_OK;
}

static glint_status check_match_locked(glint_store *s, const char *name, const char *if_match,
                                       struct glint_error *err)
{
    pthread_mutex_lock(&s->mutex);
    const glint_status st = check_match(s, name, if_match, err);
    pthread_mutex_unlock(&s->mutex);
    return st;
}

// What would keep the name from being published, before the journal says that it is.
static glint_status check_room(glint_store *s, const char *name, const char *if_match,
                               struct glint_error *err)
{
    bool found;
    pthread_mutex_lock(&s->mutex);
    glint_store_find(s, name, &found);
    glint_status st = check_match(s, name, if_match, err);
    if (!st && !found && s->scenes == GLINT_MAX_SCENES)
        st = glint_fail(err, GLINT_E_CAPACITY, "", "%d scenes are named already", GLINT_MAX_SCENES);
    pthread_mutex_unlock(&s->mutex);
    return st;
}

// Whether the revision came with the same warnings: equal scenes are made from different files.
static bool warns_alike(const glint_revision *revision, const struct glint_import *import)
{
    struct glint_edit known = {0};
    glint_revision_edit(revision, &known);
    bool same = known.import->warnings == import->warnings;
    for (size_t i = 0; same && i < import->warnings; i++)
        same = !strcmp(known.import->warning[i], import->warning[i]);
    return same;
}

// The scene's revision if it is what `import`, whose hash is `id`, would make; else the usage that
// its next one shares, if any. Both are retained.
static glint_revision *look_up(glint_store *s, const char *name, const char *id,
                               const struct glint_import *import, struct glint_usage **usage)
{
    glint_revision *same = NULL;
    *usage = NULL;
    pthread_mutex_lock(&s->mutex);
    bool found;
    const size_t at = glint_store_find(s, name, &found);
    const glint_revision *current = found ? s->scene[at].current : NULL;
    if (found && glint_revision_loaded(current) && !strcmp(glint_revision_id(current), id) &&
        warns_alike(current, import))
        same = glint_revision_retain(s->scene[at].current);
    else if (found)
        *usage = glint_usage_retain(glint_revision_usage(s->scene[at].current));
    pthread_mutex_unlock(&s->mutex);
    return same;
}

// With the mutex. Makes room for a new name at `at`.
static glint_status insert(glint_store *s, size_t at, const char *name, struct glint_error *err)
{
    if (s->scenes == GLINT_MAX_SCENES)
        return glint_fail(err, GLINT_E_CAPACITY, "", "%d scenes are named already",
                          GLINT_MAX_SCENES);
    char *copy = strdup(name);
    if (!copy)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a scene name");
    memmove(s->scene + at + 1, s->scene + at, (s->scenes - at) * sizeof *s->scene);
    s->scene[at] = (struct glint_named){copy, NULL};
    s->scenes++;
    return GLINT_OK;
}

// Has the journal say what the name stands for; `from` NULL: not made from another.
static glint_status keep_name(glint_store *s, const char *name, const glint_revision *from,
                              const glint_revision *revision, struct glint_error *err)
{
    struct glint_edit of = {0}, before = {0};
    if (!s->keep)
        return GLINT_OK;
    cJSON *resource = glint_revision_resource(revision);
    char *text = resource ? cJSON_PrintUnformatted(resource) : NULL;
    cJSON_Delete(resource);
    if (!text)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory to keep a scene");
    glint_revision_edit(revision, &of);
    if (from)
        glint_revision_edit(from, &before);
    const glint_status st = glint_keep_publish(
        s->keep,
        &(struct glint_kept_scene){.name = name,
                                   .id = glint_revision_id(revision),
                                   .import = of.import,
                                   .parent_id = from ? glint_revision_id(from) : NULL,
                                   .parent = before.import,
                                   .resource = text},
        err);
    free(text);
    return st;
}

// text: the whole text is kept as well, not only what it names.
static glint_status keep_content(glint_store *s, const glint_revision *revision, bool text,
                                 struct glint_error *err)
{
    struct glint_edit of = {0};
    if (!s->keep)
        return GLINT_OK;
    glint_revision_edit(revision, &of);
    return glint_keep_content(s->keep, text ? glint_revision_id(revision) : NULL, of.import, err);
}

// Names the revision, unless If-Match stopped holding while it was made. *replaced, to be released
// by the caller without the mutex: freeing a scene takes a while. With the name's editor.
static glint_status publish(glint_store *s, const char *name, const char *if_match,
                            glint_revision *revision, glint_revision **replaced,
                            struct glint_error *err)
{
    *replaced = NULL;
    pthread_mutex_lock(&s->mutex);
    bool found;
    const size_t at = glint_store_find(s, name, &found);
    glint_status st = check_match(s, name, if_match, err);
    if (!st && !found)
        st = insert(s, at, name, err);
    if (!st) {
        *replaced = s->scene[at].current;
        s->scene[at].current = glint_revision_retain(revision);
    }
    pthread_mutex_unlock(&s->mutex);
    return st;
}

// Takes `import`.
static glint_status load(glint_store *s, const char *name, struct glint_import *import,
                         glint_revision **out, struct glint_error *err)
{
    char id[65];
    struct glint_usage *usage;
    glint_revision_hash(import, id);
    *out = look_up(s, name, id, import, &usage);
    if (*out) {
        glint_import_destroy(&import);
        return GLINT_OK;
    }
    if (!usage)
        usage = glint_usage_create();
    if (!usage) {
        glint_import_destroy(&import);
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a revision");
    }
    struct glint_keeping *beside = s->keep ? glint_keep_begin(s->keep, id, import) : NULL;
    const glint_status st =
        glint_revision_create(out, s->devices,
                              &(struct glint_revision_order){.name = name,
                                                             .import = import,
                                                             .usage = usage,
                                                             .resident_bytes = &s->resident_bytes,
                                                             .keep = s->keep},
                              err);
    glint_keep_end(&beside);
    return st;
}

static glint_status import_and_publish(glint_store *s, const char *name,
                                       const struct glint_import_source *source,
                                       const char *if_match, glint_revision **out, bool *created,
                                       struct glint_error *err)
{
    struct glint_import *import;
    struct glint_import_source with_assets = *source;
    with_assets.assets = s->assets;
    glint_status st = glint_import_run(s->importer, &with_assets, &s->limits, &import, err);
    if (!st)
        st = load(s, name, import, out, err);
    if (st)
        return st;

    glint_revision *replaced = NULL;
    pthread_mutex_t *editor = editor_of(s, name);
    st = keep_content(s, *out, true, err);
    pthread_mutex_lock(editor); // what the journal says last is what is published last
    if (!st)
        st = check_room(s, name, if_match, err);
    if (!st)
        st = keep_name(s, name, NULL, *out, err);
    if (!st)
        st = publish(s, name, if_match, *out, &replaced, err);
    pthread_mutex_unlock(editor);
    *created = !st && !replaced;
    glint_revision_release(&replaced);
    if (st)
        glint_revision_release(out);
    else if (s->published)
        s->published(s->user, name);
    return st;
}

void glint_store_on_publish(glint_store *s, void (*published)(void *user, const char *name),
                            void *user)
{
    s->published = published;
    s->user = user;
}

glint_status glint_store_put(glint_store *s, const char *name,
                             const struct glint_import_source *source, const char *if_match,
                             glint_revision **out, bool *created, struct glint_error *err)
{
    *out = NULL;
    *created = false;
    glint_status st = check_name(name, err);
    if (!st)
        st = check_match_locked(s, name, if_match, err); // before seconds are spent on the import
    if (st)
        return st;
    atomic_fetch_add(&s->imports, 1);
    st = import_and_publish(s, name, source, if_match, out, created, err);
    if (st)
        atomic_fetch_add(&s->import_failures, 1);
    else
        glint_log(GLINT_LOG_INFO, "scene", NULL, NULL, "scene \"%s\" is at revision %.12s", name,
                  glint_revision_id(*out));
    return st;
}

glint_status glint_store_get(glint_store *s, const char *name, glint_revision **out,
                             struct glint_error *err)
{
    *out = NULL;
    pthread_mutex_lock(&s->mutex);
    bool found;
    const size_t at = glint_store_find(s, name, &found);
    if (found)
        *out = glint_revision_retain(s->scene[at].current);
    pthread_mutex_unlock(&s->mutex);
    if (found)
        return GLINT_OK;
    return glint_fail(err, GLINT_E_NOT_FOUND, "", "there is no scene \"%.140s\"", name);
}

// Makes the revision that the patch leads to from `from`; *out is `from` when that is the same.
static glint_status edit(glint_store *s, const char *name, const char *text, size_t length,
                         glint_revision *from, glint_revision **out,
                         struct glint_patch_report *report, struct glint_error *err)
{
    struct glint_edit order = {.importer = s->importer, .limits = &s->limits, .assets = s->assets};
    struct glint_import *import;
    struct glint_scene *scene;
    char id[65];
    glint_revision_edit(from, &order);
    glint_status st = glint_edit_run(&order, text, length, &import, &scene, err);
    if (st)
        return st;
    report->parse_seconds = import->seconds;
    glint_revision_hash(import, id);
    report->changed = strcmp(id, glint_revision_id(from)) != 0;
    if (!report->changed) {
        glint_scene_destroy(&scene);
        glint_import_destroy(&import);
        *out = glint_revision_retain(from);
        return GLINT_OK;
    }
    st = glint_revision_create(
        out, s->devices,
        &(struct glint_revision_order){name, import, scene,
                                       glint_usage_retain(glint_revision_usage(from)), from,
                                       &s->resident_bytes, s->keep},
        err);
    if (!st)
        report->change = *glint_resident_change(glint_revision_resident(*out));
    return st;
}

// Names the revision, unless the scene is not at `from` any more: *lost.
static glint_status exchange(glint_store *s, const char *name, const glint_revision *from,
                             glint_revision *revision, bool *lost, struct glint_error *err)
{
    glint_revision *replaced = NULL;
    bool found;
    pthread_mutex_lock(&s->mutex);
    const size_t at = glint_store_find(s, name, &found);
    *lost = found && s->scene[at].current != from;
    if (found && !*lost) {
        replaced = s->scene[at].current;
        s->scene[at].current = glint_revision_retain(revision);
    }
    pthread_mutex_unlock(&s->mutex);
    glint_revision_release(&replaced);
    return found ? GLINT_OK
                 : glint_fail(err, GLINT_E_NOT_FOUND, "", "the scene \"%.140s\" was removed", name);
}

// One try: *lost when the scene was replaced meanwhile, which a patch does not undo.
static glint_status patch_once(glint_store *s, const char *name, const char *text, size_t length,
                               const char *if_match, glint_revision **out, bool *lost,
                               struct glint_patch_report *report, struct glint_error *err)
{
    glint_revision *from;
    glint_status st = glint_store_get(s, name, &from, err);
    if (st)
        return st;
    if (if_match && strcmp(if_match, glint_revision_id(from)))
        st = glint_fail(err, GLINT_E_STALE, "", "the revision is %s by now",
                        glint_revision_id(from));
    if (!st)
        st = glint_revision_load(from, err);
    if (!st)
        st = edit(s, name, text, length, from, out, report, err);
    if (!st && report->changed)
        st = keep_content(s, *out, false, err);
    if (!st && report->changed)
        st = keep_name(s, name, from, *out, err);
    if (!st)
        st = exchange(s, name, from, *out, lost, err);
    if (st || *lost)
        glint_revision_release(out);
    glint_revision_release(&from);
    return st;
}

glint_status glint_store_patch(glint_store *s, const char *name, const char *text, size_t length,
                               const char *if_match, glint_revision **out,
                               struct glint_patch_report *report, struct glint_error *err)
{
    const double start = glint_now();
    glint_status st;
    bool lost = false;
    pthread_mutex_t *editor = editor_of(s, name);
    pthread_mutex_lock(editor);
    do {
        *out = NULL;
        *report = (struct glint_patch_report){0};
        st = patch_once(s, name, text, length, if_match, out, &lost, report, err);
    } while (!st && lost);
    pthread_mutex_unlock(editor);
    report->total_seconds = glint_now() - start;
    if (st || !report->changed)
        return st;
    if (s->published)
        s->published(s->user, name);
    glint_log(GLINT_LOG_INFO, "scene", NULL, NULL,
              "scene \"%s\" is at revision %.12s after %.1f ms", name, glint_revision_id(*out),
              1e3 * report->total_seconds);
    return GLINT_OK;
}

// With the mutex.
static glint_status check_unused(const struct glint_named *scene, bool force,
                                 struct glint_error *err)
{
    const int jobs = atomic_load(&glint_revision_usage(scene->current)->jobs);
    if (force || jobs <= 0)
        return GLINT_OK;
    return glint_fail(err, GLINT_E_CONFLICT, "", "%d job%s the scene \"%s\"", jobs,
                      jobs == 1 ? " uses" : "s use", scene->name);
}

// With the mutex. Takes the name out of the table; what it held is the caller's.
static struct glint_named cut(glint_store *s, size_t at)
{
    const struct glint_named gone = s->scene[at];
    s->scenes--;
    memmove(s->scene + at, s->scene + at + 1, (s->scenes - at) * sizeof *s->scene);
    return gone;
}

static glint_status check_delete(glint_store *s, const char *name, const char *if_match, bool force,
                                 struct glint_error *err)
{
    pthread_mutex_lock(&s->mutex);
    bool found;
    const size_t at = glint_store_find(s, name, &found);
    glint_status st =
        found ? check_match(s, name, if_match, err)
              : glint_fail(err, GLINT_E_NOT_FOUND, "", "there is no scene \"%.140s\"", name);
    if (!st)
        st = check_unused(&s->scene[at], force, err);
    pthread_mutex_unlock(&s->mutex);
    return st;
}

// With the name's editor: it is still there.
static struct glint_named take_out(glint_store *s, const char *name)
{
    bool found;
    pthread_mutex_lock(&s->mutex);
    const size_t at = glint_store_find(s, name, &found);
    const struct glint_named gone = found ? cut(s, at) : (struct glint_named){NULL, NULL};
    pthread_mutex_unlock(&s->mutex);
    return gone;
}

glint_status glint_store_delete(glint_store *s, const char *name, const char *if_match, bool force,
                                struct glint_error *err)
{
    struct glint_named gone = {NULL, NULL};
    pthread_mutex_t *editor = editor_of(s, name);
    pthread_mutex_lock(editor);
    glint_status st = check_delete(s, name, if_match, force, err);
    if (!st && s->keep)
        st = glint_keep_remove(s->keep, name, err);
    if (!st)
        gone = take_out(s, name);
    pthread_mutex_unlock(editor);
    glint_revision_release(&gone.current);
    free(gone.name);
    return st;
}

cJSON *glint_store_list(glint_store *s)
{
    glint_revision **revision;
    size_t count;
    if (!glint_store_retain_all(s, &revision, &count))
        return NULL;
    cJSON *list = cJSON_CreateObject();
    cJSON *scenes = cJSON_AddArrayToObject(list, "scenes");
    for (size_t i = 0; i < count; i++) {
        cJSON_AddItemToArray(scenes, glint_revision_resource(revision[i]));
        glint_revision_release(&revision[i]);
    }
    free(revision);
    return list;
}

bool glint_store_imports(const glint_store *s)
{
    return glint_importer_lives(s->importer);
}

void glint_store_stats(glint_store *s, struct glint_store_stats *out)
{
    pthread_mutex_lock(&s->mutex);
    out->scenes = (uint32_t)s->scenes;
    pthread_mutex_unlock(&s->mutex);
    out->resident_bytes = atomic_load(&s->resident_bytes);
    out->imports = atomic_load(&s->imports);
    out->import_failures = atomic_load(&s->import_failures);
}
