#include "base/clock.h"
#include "base/log.h"
#include "jobs/checkpoint_parts.h"

#include <unistd.h>

// Numbers of the newest film and of the one before.
static void newest(struct glint_checkpoints *c, const struct glint_entry *e, uint64_t number[2])
{
    pthread_mutex_lock(&c->table->mutex);
    number[0] = e->kept.film;
    number[1] = e->kept.film_before;
    pthread_mutex_unlock(&c->table->mutex);
}

static void warn_of_film(struct glint_checkpoints *c, struct glint_entry *e, uint64_t number,
                         glint_status st, const char *why)
{
    const struct glint_checkpoint_file file = glint_checkpoints_file(c, e, number);
    const char *suffix = st == GLINT_E_VERSION ? ".newer" : ".torn";
    // A lack of memory or descriptors is no fault of the file, which stays.
    if (st == GLINT_E_SYNTAX || st == GLINT_E_RANGE || st == GLINT_E_VERSION) {
        atomic_fetch_sub(&c->bytes, glint_checkpoint_file_bytes(&file));
        glint_checkpoint_file_put_aside(&file, suffix);
    }
    glint_log(GLINT_LOG_ERROR, "jobs", e->id, e->request,
              "its film %llu cannot be used: %s; the job goes on from an earlier one or anew",
              (unsigned long long)number, why);
    glint_checkpoints_say(c, &e->kept.torn,
                          "what was rendered last was lost in a restart: film %llu: %s",
                          (unsigned long long)number, why);
}

// Has the render go on from the newest film that it can; its number, 0: there is none.
static uint64_t use_film(struct glint_checkpoints *c, struct glint_entry *e, glint_render *render)
{
    uint64_t number[2];
    newest(c, e, number);
    for (int i = 0; i < 2; i++) {
        if (!number[i])
            continue;
        struct glint_error err = {0};
        const struct glint_checkpoint_file file = glint_checkpoints_file(c, e, number[i]);
        const int fd = glint_checkpoint_file_open(&file, &err);
        if (fd >= 0) {
            glint_render_restore(render, fd, &err);
            close(fd);
        }
        if (!err.status)
            return number[i];
        warn_of_film(c, e, number[i], err.status, glint_error_text(&err));
        glint_error_finish(&err);
    }
    return 0;
}

bool glint_checkpoint_exists(struct glint_entry *e)
{
    uint64_t number[2] = {0};
    if (e->keeper && !e->job->live)
        newest(e->keeper, e, number);
    return number[0] || number[1];
}

void glint_checkpoint_restore(struct glint_entry *e, glint_render *render)
{
    glint_checkpoints *c = e->keeper;
    if (!c || e->job->live)
        return;
    const uint64_t film = use_film(c, e, render);
    if (film)
        glint_log(GLINT_LOG_INFO, "jobs", e->id, e->request, "goes on from film %llu",
                  (unsigned long long)film);
    pthread_mutex_lock(&c->table->mutex);
    e->kept.at = glint_now();
    pthread_mutex_unlock(&c->table->mutex);
}

// A newer film may take the place of the one that was the newest a moment ago.
static int open_newest(struct glint_checkpoints *c, struct glint_entry *e, uint64_t number,
                       struct glint_error *err)
{
    for (;;) {
        const struct glint_checkpoint_file file = glint_checkpoints_file(c, e, number);
        const int fd = glint_checkpoint_file_open(&file, NULL);
        uint64_t now[2];
        newest(c, e, now);
        if (fd >= 0 || now[0] == number)
            return fd >= 0 ? fd : glint_checkpoint_file_open(&file, err);
        number = now[0];
    }
}

glint_status glint_checkpoint_open(struct glint_entry *e, glint_render **out,
                                   struct glint_error *err)
{
    uint64_t number[2] = {0};
    *out = NULL;
    if (e->keeper)
        newest(e->keeper, e, number);
    if (!number[0])
        return GLINT_OK;
    const int fd = open_newest(e->keeper, e, number[0], err);
    if (fd < 0)
        return GLINT_E_IO;
    const glint_status st = glint_render_open(out, fd, err);
    close(fd);
    return st;
}
