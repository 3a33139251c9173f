#include "base/storage.h"
#include "jobs/checkpoint_parts.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct sweep {
    struct glint_checkpoints *c;
    struct glint_entry **entry;
    size_t count;
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

static void sweep_file(void *user, const char *name)
{
    const struct sweep *s = user;
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
}

void glint_checkpoints_spare(glint_checkpoints *c)
{
    c->unread = true;
}

void glint_checkpoints_sweep(glint_checkpoints *c)
{
    struct sweep s = {.c = c};
    s.entry = glint_checkpoints_hold(c, &s.count);
    if (s.entry)
        glint_checkpoint_files_list(c->folder, sweep_file, &s);
    for (size_t i = 0; i < s.count; i++)
        glint_entry_release(&s.entry[i]);
    free(s.entry);
    atomic_store(&c->share, (glint_storage_free(c->folder) + atomic_load(&c->bytes)) / 2);
}
