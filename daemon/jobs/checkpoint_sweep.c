#include "base/clock.h"
#include "base/storage.h"
#include "jobs/checkpoint_parts.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

// Films that could not be used are kept for who wants to know why: the newest few, for a while.
#define ASIDE_FILMS 16
#define ASIDE_SECONDS (30 * 86400.0)

struct aside {
    char path[4096];
    double written; // seconds since 1970
};

struct sweep {
    struct glint_checkpoints *c;
    struct glint_entry **entry;
    size_t count;
    struct aside aside[ASIDE_FILMS]; // the newest first
    size_t asides;
};

// The entry that has this film, or NULL.
static struct glint_entry *owner_of(const struct sweep *s, const struct glint_checkpoint_file *file)
{
    for (size_t i = 0; i < s->count; i++) {
        const struct glint_job_kept *kept = &s->entry[i]->kept;
        if (!strcmp(s->entry[i]->id, file->job))
            return file->number && (kept->film == file->number || kept->film_before == file->number)
                       ? s->entry[i]
                       : NULL;
    }
    return NULL;
}

static void count_film(const struct sweep *s, struct glint_entry *e,
                       const struct glint_checkpoint_file *file)
{
    atomic_fetch_add(&s->c->bytes, glint_checkpoint_file_bytes(file));
    char written[sizeof e->kept.written];
    glint_checkpoint_file_time(file, written);
    pthread_mutex_lock(&s->c->table->mutex);
    if (e->kept.film == file->number)
        memcpy(e->kept.written, written, sizeof written);
    pthread_mutex_unlock(&s->c->table->mutex);
}

static bool ends_with(const char *name, const char *suffix)
{
    const size_t n = strlen(name), m = strlen(suffix);
    return n > m && !strcmp(name + n - m, suffix);
}

// Takes it up where it is among the newest; what is too much then goes.
static void put_aside(struct sweep *s, const char *path)
{
    struct stat file;
    if (stat(path, &file))
        return;
    struct aside own = {.written = (double)file.st_mtime};
    snprintf(own.path, sizeof own.path, "%s", path);
    size_t at = s->asides;
    while (at && s->aside[at - 1].written < own.written)
        at--;
    if (at == ASIDE_FILMS || glint_wall_clock() - own.written > ASIDE_SECONDS) {
        unlink(path);
        return;
    }
    if (s->asides == ASIDE_FILMS)
        unlink(s->aside[--s->asides].path);
    memmove(&s->aside[at + 1], &s->aside[at], (s->asides++ - at) * sizeof own);
    s->aside[at] = own;
}

static void sweep_file(void *user, const char *name)
{
    struct sweep *s = user;
    char job[33], path[4096];
    uint64_t number = 0;
    const bool film = glint_checkpoint_file_parse(name, job, &number);
    const struct glint_checkpoint_file file = {s->c->folder, job, number};
    snprintf(path, sizeof path, "%s/%s", s->c->folder, name);
    struct glint_entry *owner = film ? owner_of(s, &file) : NULL;
    if (owner)
        count_film(s, owner, &file);
    else if ((film && !s->c->unread) || ends_with(name, ".new"))
        unlink(path);
    else if (ends_with(name, ".torn") || ends_with(name, ".newer"))
        put_aside(s, path);
}

void glint_checkpoints_spare(glint_checkpoints *c)
{
    c->unread = true;
}

void glint_checkpoints_sweep(glint_checkpoints *c)
{
    struct sweep *s = calloc(1, sizeof *s);
    if (!s)
        return;
    s->c = c;
    s->entry = glint_checkpoints_hold(c, &s->count);
    if (s->entry)
        glint_checkpoint_files_list(c->folder, sweep_file, s);
    for (size_t i = 0; i < s->count; i++)
        glint_entry_release(&s->entry[i]);
    free(s->entry);
    free(s);
    atomic_store(&c->share, (glint_storage_free(c->folder) + atomic_load(&c->bytes)) / 2);
}
