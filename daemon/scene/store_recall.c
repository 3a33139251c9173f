// store_recall.c - the scenes of the daemon that ran before.
#include "scene/store_parts.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/thread.h"

#include <stdlib.h>
#include <string.h>

static bool recall_scene(void *user, const char *name, const char *revision, const char *warnings,
                         const char *resource)
{
    glint_store *s = user;
    if (s->scenes == GLINT_MAX_SCENES)
        return false;
    struct glint_named *scene = &s->scene[s->scenes];
    struct glint_usage *usage = glint_usage_create();
    scene->name = strdup(name);
    if (!usage || !scene->name ||
        glint_revision_recall(&scene->current, s->devices,
                              &(struct glint_revision_memory){name, revision, warnings, resource,
                                                              usage, &s->resident_bytes, s->keep},
                              NULL)) {
        free(scene->name);
        return false;
    }
    s->scenes++;
    return true;
}

// The names come in the order of the table.
glint_status glint_store_recall_scenes(glint_store *s, glint_keeper *keeper,
                                       struct glint_error *err)
{
    const glint_status st = glint_keep_create(&s->keep, keeper, s->assets, err);
    return st ? st : glint_keep_scenes(s->keep, recall_scene, s, err);
}

static void remember_recall(glint_store *s, const char *id)
{
    char(*more)[65] = realloc(s->recalled, (s->recalls + 1) * sizeof *more);
    if (!more)
        return;
    s->recalled = more;
    memcpy(more[s->recalls++], id, 65);
}

glint_status glint_store_recall(glint_store *s, const char *name, const char *id, bool needed,
                                glint_revision **out, struct glint_error *err)
{
    struct glint_usage *usage = NULL;
    bool found;
    *out = NULL;
    pthread_mutex_lock(&s->mutex);
    const size_t at = glint_store_find(s, name, &found);
    glint_revision *current = found ? s->scene[at].current : NULL;
    if (current && !strcmp(glint_revision_id(current), id))
        *out = glint_revision_retain(current);
    else if (current)
        usage = glint_usage_retain(glint_revision_usage(current));
    pthread_mutex_unlock(&s->mutex);
    if (*out)
        return GLINT_OK;
    if (needed)
        remember_recall(s, id);
    if (!usage && !(usage = glint_usage_create()))
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a revision");
    return glint_revision_recall(
        out, s->devices,
        &(struct glint_revision_memory){.name = name,
                                        .id = id,
                                        .usage = usage,
                                        .resident_bytes = &s->resident_bytes,
                                        .keep = s->keep},
        err);
}

static void *bring_back(void *arg)
{
    glint_store *s = arg;
    glint_revision **all;
    size_t count;
    const double start = glint_now();
    glint_keep_adopt(s->keep);
    for (size_t i = 0; i < s->recalls; i++)
        glint_keep_pin(s->keep, s->recalled[i]);
    if (!glint_store_retain_all(s, &all, &count))
        return NULL;
    for (size_t i = 0; i < count; i++) {
        if (!atomic_load(&s->stop) && glint_revision_load(all[i], NULL))
            glint_keep_pin(s->keep, glint_revision_id(all[i]));
        glint_revision_release(&all[i]);
    }
    free(all);
    if (atomic_load(&s->stop))
        return NULL;
    glint_keep_collect(s->keep);
    if (count)
        glint_log(GLINT_LOG_INFO, "scene", NULL, NULL, "%zu scene%s back after %.3f s", count,
                  count == 1 ? " is" : "s are", glint_now() - start);
    return NULL;
}

glint_status glint_store_begin(glint_store *s, struct glint_error *err)
{
    const glint_status st =
        s->keep ? glint_thread_start(&s->loader, "scenes", bring_back, s, err) : GLINT_OK;
    s->loading = s->keep && !st;
    return st;
}
