#include "jobs/checkpoint.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/storage.h"
#include "base/thread.h"
#include "jobs/checkpoint_file.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define RETRY_SECONDS 5.0 // after a disk took nothing

struct glint_checkpoints {
    glint_journal *journal;
    const char *folder;
    struct glint_job_table *table;
    void (*written)(void *user);
    void *user;
    glint_metric *total, *failures, *seconds_each, *written_bytes, *state_bytes;
    _Atomic uint64_t bytes; // of all films
    _Atomic uint64_t share,
        budget; // that they may have: at most half of the disk, or what was said
    pthread_t thread;
    bool started;
    bool unread; // rows that could not be: whose films there are besides, nobody knows

    pthread_mutex_t mutex; // guards what follows; a leaf
    pthread_cond_t changed;
    double seconds; // between films of a job
    bool ended;     // some entry has
    bool now;       // all are wanted
    bool stop;
};

// ---- what is known of an entry

static void say(struct glint_checkpoints *c, char **at, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
// Exchanges a sentence that the entry's description shows.
static void say(struct glint_checkpoints *c, char **at, const char *format, ...)
{
    char *text = NULL;
    va_list args;
    va_start(args, format);
    if (format && vasprintf(&text, format, args) < 0)
        text = NULL;
    va_end(args);
    pthread_mutex_lock(&c->table->mutex);
    char *old = *at;
    *at = text;
    pthread_mutex_unlock(&c->table->mutex);
    free(old);
}

static void not_kept(struct glint_checkpoints *c, struct glint_entry *e, struct glint_error *err)
{
    const bool news = !e->kept.trouble;
    glint_metric_add(c->failures, 1);
    say(c, &e->kept.trouble, "the job is not being kept: %s", glint_error_text(err));
    if (news)
        glint_log(GLINT_LOG_ERROR, "jobs", e->id, e->request, "not kept: %s",
                  glint_error_text(err));
    glint_error_finish(err);
}

static void kept_again(struct glint_checkpoints *c, struct glint_entry *e)
{
    if (!e->kept.trouble)
        return;
    glint_log(GLINT_LOG_INFO, "jobs", e->id, e->request, "kept again");
    char *old;
    pthread_mutex_lock(&c->table->mutex);
    old = e->kept.trouble;
    e->kept.trouble = NULL;
    pthread_mutex_unlock(&c->table->mutex);
    free(old);
}

bool glint_checkpoint_complete(const struct glint_entry *e)
{
    return e->keeper && glint_state_ended(e->state) && e->kept.complete == e->sequence;
}

// The render with a hold that keeps it in the entry, or NULL.
static glint_render *borrow(struct glint_checkpoints *c, struct glint_entry *e)
{
    pthread_mutex_lock(&c->table->mutex);
    glint_render *render = e->render;
    e->views += render != NULL;
    pthread_mutex_unlock(&c->table->mutex);
    return render;
}

static void give_back(struct glint_checkpoints *c, struct glint_entry *e, glint_render *render)
{
    pthread_mutex_lock(&c->table->mutex);
    e->views -= render != NULL;
    pthread_mutex_unlock(&c->table->mutex);
}

// ---- writing

static struct glint_checkpoint_file file_of(const struct glint_checkpoints *c,
                                            const struct glint_entry *e, uint64_t number)
{
    return (struct glint_checkpoint_file){c->folder, e->id, number};
}

static void remove_film(struct glint_checkpoints *c, const struct glint_entry *e, uint64_t number)
{
    const struct glint_checkpoint_file file = file_of(c, e, number);
    if (!number)
        return;
    atomic_fetch_sub(&c->bytes, glint_checkpoint_file_bytes(&file));
    glint_checkpoint_file_remove(&file);
}

static void note(struct glint_checkpoints *c, struct glint_entry *e,
                 const struct glint_job_progress *p, uint64_t bytes, double worker_seconds)
{
    const struct glint_checkpoint_file file = file_of(c, e, p->film);
    char written[sizeof e->kept.written];
    glint_checkpoint_file_time(&file, written);
    atomic_fetch_add(&c->bytes, bytes);
    glint_metric_add(c->written_bytes, (double)bytes);
    pthread_mutex_lock(&c->table->mutex);
    memcpy(e->kept.written, written, sizeof written);
    e->kept.film = p->film;
    e->kept.film_before = p->film_before;
    e->kept.rendered = p->rendered;
    if (glint_state_ended(p->state))
        e->kept.complete = p->sequence;
    const bool removed = e->kept.removed;
    pthread_mutex_unlock(&c->table->mutex);
    e->kept.worker_seconds = worker_seconds;
    if (removed)
        remove_film(c, e, p->film);
}

// Commits a new film, or, without a render, only that the job has ended.
static glint_status keep_film(struct glint_checkpoints *c, struct glint_entry *e,
                              glint_render *render, struct glint_error *err)
{
    struct glint_job_progress p;
    uint64_t bytes = 0;
    const uint64_t old = e->kept.film, older = e->kept.film_before;
    if (!glint_job_progress_take(&p, c->table, e, render))
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory to keep a job");
    const bool ended = glint_state_ended(p.state);
    const double worker_seconds = p.worker_seconds;
    glint_status st = GLINT_OK;
    if (render) {
        p.film = old + 1;
        p.film_before = ended ? 0 : old;
        const struct glint_checkpoint_file file = file_of(c, e, p.film);
        st = glint_checkpoint_file_write(&file, render, &bytes, err);
    }
    if (!st)
        st = glint_job_row_set(c->journal, e->id, &p, err);
    if (!st) {
        note(c, e, &p, bytes, worker_seconds);
        if (render)
            remove_film(c, e, older);
        if (render && ended)
            remove_film(c, e, old);
    }
    glint_job_progress_finish(&p);
    return st;
}

static bool checkpoint(struct glint_checkpoints *c, struct glint_entry *e)
{
    struct glint_error err = {0};
    const double start = glint_now();
    glint_render *render = borrow(c, e);
    const glint_status st = keep_film(c, e, render, &err);
    give_back(c, e, render);
    e->kept.at = glint_now();
    if (st) {
        not_kept(c, e, &err);
        return false;
    }
    kept_again(c, e);
    if (render) {
        glint_metric_add(c->total, 1);
        glint_metric_observe(c->seconds_each, e->kept.at - start);
        glint_log(GLINT_LOG_DEBUG, "jobs", e->id, e->request, "film %llu written in %.3f s",
                  (unsigned long long)e->kept.film, e->kept.at - start);
    }
    return true;
}

// ---- whose turn it is

static struct glint_entry **hold_all(struct glint_job_table *table, size_t *count)
{
    pthread_mutex_lock(&table->mutex);
    *count = table->count;
    struct glint_entry **all = malloc((table->count + 1) * sizeof *all);
    for (size_t i = 0; all && i < table->count; i++)
        all[i] = glint_entry_retain(table->entry[i]);
    pthread_mutex_unlock(&table->mutex);
    if (!all)
        *count = 0;
    return all;
}

struct look {
    bool ended, complete, has_render;
    double worker_seconds;
};

static struct look look_at(struct glint_checkpoints *c, const struct glint_entry *e)
{
    pthread_mutex_lock(&c->table->mutex);
    const struct look l = {glint_state_ended(e->state), glint_checkpoint_complete(e),
                           e->render != NULL, e->worker_seconds};
    pthread_mutex_unlock(&c->table->mutex);
    return l;
}

static bool is_due(const struct glint_entry *e, const struct look *l, double now, double seconds,
                   bool all)
{
    if (l->ended)
        return !l->complete && now >= e->kept.retry;
    if (!l->has_render || e->job->live || l->worker_seconds == e->kept.worker_seconds)
        return false;
    return all || now >= e->kept.at + seconds;
}

// Ended ones come first: they are wanted for good. *next: when something is due again.
static void round_of(struct glint_checkpoints *c, bool ended, bool all, double seconds,
                     double *next)
{
    size_t count;
    struct glint_entry **entry = hold_all(c->table, &count);
    for (size_t i = 0; i < count; i++) {
        struct glint_entry *e = entry[i];
        const struct look l = look_at(c, e);
        if (l.ended == ended && is_due(e, &l, glint_now(), seconds, all)) {
            e->kept.retry = checkpoint(c, e) ? 0 : glint_now() + RETRY_SECONDS;
            if (ended && !e->kept.retry && c->written)
                c->written(c->user);
        }
        if (l.ended && !l.complete && e->kept.retry)
            *next = fmin(*next, e->kept.retry);
        if (!l.ended && l.has_render && !e->job->live)
            *next = fmin(*next, e->kept.at + seconds);
        glint_entry_release(&entry[i]);
    }
    free(entry);
}

static void *run(void *arg)
{
    glint_checkpoints *c = arg;
    double next = 0;
    pthread_mutex_lock(&c->mutex);
    while (!c->stop) {
        if (!c->ended && !c->now && glint_now() < next) {
            // No longer than a second: the interval may be made shorter.
            glint_condition_wait(&c->changed, &c->mutex, fmin(next, glint_now() + 1));
            continue;
        }
        const bool all = c->now;
        const double seconds = c->seconds;
        c->ended = c->now = false;
        pthread_mutex_unlock(&c->mutex);
        next = INFINITY;
        round_of(c, true, all, seconds, &next);
        round_of(c, false, all, seconds, &next);
        next = fmin(next, glint_now() + fmin(seconds, 1)); // for jobs that begin meanwhile
        pthread_mutex_lock(&c->mutex);
    }
    pthread_mutex_unlock(&c->mutex);
    return NULL;
}

// ---- reading back

static void warn_of_film(struct glint_checkpoints *c, struct glint_entry *e, uint64_t number,
                         glint_status st, const char *why)
{
    const struct glint_checkpoint_file file = file_of(c, e, number);
    const char *suffix = st == GLINT_E_VERSION ? ".newer" : ".torn";
    // A lack of memory or descriptors is no fault of the file, which stays.
    if (st == GLINT_E_SYNTAX || st == GLINT_E_RANGE || st == GLINT_E_VERSION) {
        atomic_fetch_sub(&c->bytes, glint_checkpoint_file_bytes(&file));
        glint_checkpoint_file_put_aside(&file, suffix);
    }
    glint_log(GLINT_LOG_ERROR, "jobs", e->id, e->request,
              "its film %llu cannot be used: %s; the job goes on from an earlier one or anew",
              (unsigned long long)number, why);
    say(c, &e->kept.torn, "what was rendered last was lost in a restart: film %llu: %s",
        (unsigned long long)number, why);
}

typedef glint_status use(void *user, int fd, struct glint_error *err);

// Hands the newest film that can be used to `with`; false: there is none.
static bool use_film(struct glint_checkpoints *c, struct glint_entry *e, use *with, void *user)
{
    const uint64_t number[2] = {e->kept.film, e->kept.film_before};
    for (int i = 0; i < 2; i++) {
        if (!number[i])
            continue;
        struct glint_error err = {0};
        const struct glint_checkpoint_file file = file_of(c, e, number[i]);
        const int fd = glint_checkpoint_file_open(&file, &err);
        if (fd >= 0) {
            with(user, fd, &err);
            close(fd);
        }
        if (!err.status)
            return true;
        warn_of_film(c, e, number[i], err.status, glint_error_text(&err));
        glint_error_finish(&err);
    }
    return false;
}

static glint_status restore(void *user, int fd, struct glint_error *err)
{
    return glint_render_restore(user, fd, err);
}

void glint_checkpoint_restore(struct glint_entry *e, glint_render *render)
{
    if (!e->keeper || e->job->live)
        return;
    if (use_film(e->keeper, e, restore, render))
        glint_log(GLINT_LOG_INFO, "jobs", e->id, e->request, "goes on from film %llu",
                  (unsigned long long)e->kept.film);
    e->kept.at = glint_now();
}

static uint64_t newest(struct glint_checkpoints *c, const struct glint_entry *e)
{
    pthread_mutex_lock(&c->table->mutex);
    const uint64_t film = e->kept.film;
    pthread_mutex_unlock(&c->table->mutex);
    return film;
}

// A newer film may take the place of the one that was the newest a moment ago.
static int open_newest(struct glint_checkpoints *c, struct glint_entry *e, uint64_t number,
                       struct glint_error *err)
{
    for (;;) {
        const struct glint_checkpoint_file file = file_of(c, e, number);
        const int fd = glint_checkpoint_file_open(&file, NULL);
        const uint64_t now = newest(c, e);
        if (fd >= 0 || now == number)
            return fd >= 0 ? fd : glint_checkpoint_file_open(&file, err);
        number = now;
    }
}

glint_status glint_checkpoint_open(struct glint_entry *e, glint_render **out,
                                   struct glint_error *err)
{
    const uint64_t number = e->keeper ? newest(e->keeper, e) : 0;
    *out = NULL;
    if (!number)
        return GLINT_OK;
    const int fd = open_newest(e->keeper, e, number, err);
    if (fd < 0)
        return GLINT_E_IO;
    const glint_status st = glint_render_open(out, fd, err);
    close(fd);
    return st;
}

void glint_checkpoint_remove(struct glint_entry *e)
{
    glint_checkpoints *c = e->keeper;
    if (!c)
        return;
    pthread_mutex_lock(&c->table->mutex);
    e->kept.removed = true; // what is being written now goes as soon as it is
    const uint64_t film = e->kept.film, before = e->kept.film_before;
    pthread_mutex_unlock(&c->table->mutex);
    remove_film(c, e, film);
    remove_film(c, e, before);
}

void glint_checkpoint_note(struct glint_entry *e)
{
    glint_checkpoints *c = e->keeper;
    struct glint_job_progress p;
    struct glint_error err = {0};
    if (!c || !glint_job_progress_take(&p, c->table, e, NULL))
        return;
    p.resumed = !glint_state_ended(p.state);
    if (glint_job_row_set(c->journal, e->id, &p, &err))
        not_kept(c, e, &err);
    glint_job_progress_finish(&p);
}

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
    s.entry = hold_all(c->table, &s.count);
    if (s.entry)
        glint_checkpoint_files_list(c->folder, sweep_file, &s);
    for (size_t i = 0; i < s.count; i++)
        glint_entry_release(&s.entry[i]);
    free(s.entry);
    atomic_store(&c->share, (glint_storage_free(c->folder) + atomic_load(&c->bytes)) / 2);
}

uint64_t glint_checkpoints_excess(glint_checkpoints *c)
{
    const uint64_t said = atomic_load(&c->budget), bytes = atomic_load(&c->bytes);
    const uint64_t budget = said ? said : atomic_load(&c->share);
    return budget && bytes > budget ? bytes - budget : 0;
}

void glint_checkpoints_set_budget(glint_checkpoints *c, uint64_t bytes)
{
    atomic_store(&c->budget, bytes);
}

// ---- life

static void refresh(void *user)
{
    const glint_checkpoints *c = user;
    glint_metric_set(c->state_bytes, (double)atomic_load(&c->bytes));
}

static void name_metrics(glint_checkpoints *c, glint_metrics *m)
{
    static const double bounds[] = {0.01, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30};
    const struct glint_label done = {"result", "kept"}, failed = {"result", "failed"};
    const struct glint_label films = {"kind", "films"};
    const char *help = "Films of jobs that were written, or could not be.";
    c->total = glint_metrics_counter(m, "checkpoint_total", help, &done, 1);
    c->failures = glint_metrics_counter(m, "checkpoint_total", help, &failed, 1);
    c->seconds_each =
        glint_metrics_histogram(m, "checkpoint_seconds", "Time to write a film and commit it.",
                                bounds, sizeof bounds / sizeof *bounds, NULL, 0);
    c->written_bytes =
        glint_metrics_counter(m, "checkpoint_bytes_total", "Bytes of films written.", NULL, 0);
    c->state_bytes = glint_metrics_gauge(m, "state_bytes", "Bytes in the state folder.", &films, 1);
    glint_metrics_on_read(m, refresh, c);
}

glint_status glint_checkpoints_create(glint_checkpoints **out, glint_keeper *keeper,
                                      struct glint_job_table *table, void (*written)(void *user),
                                      void *user, struct glint_error *err)
{
    glint_checkpoints *c = *out = calloc(1, sizeof *c);
    if (!c)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory to keep jobs");
    c->journal = glint_keeper_journal(keeper);
    c->folder = glint_keeper_films(keeper);
    c->table = table;
    c->written = written;
    c->user = user;
    c->seconds = GLINT_CHECKPOINT_SECONDS;
    pthread_mutex_init(&c->mutex, NULL);
    glint_condition_init(&c->changed);
    if (glint_keeper_metrics(keeper))
        name_metrics(c, glint_keeper_metrics(keeper));
    return GLINT_OK;
}

glint_status glint_checkpoints_start(glint_checkpoints *c, struct glint_error *err)
{
    const glint_status st = glint_thread_start(&c->thread, "checkpoint", run, c, err);
    c->started = !st;
    return st;
}

void glint_checkpoints_stop(glint_checkpoints *c)
{
    if (!c->started)
        return;
    pthread_mutex_lock(&c->mutex);
    c->stop = true;
    pthread_cond_signal(&c->changed);
    pthread_mutex_unlock(&c->mutex);
    pthread_join(c->thread, NULL);
    c->started = false;
}

void glint_checkpoints_flush(glint_checkpoints *c)
{
    double next = INFINITY;
    c->written = NULL;
    round_of(c, true, true, 0, &next);
    round_of(c, false, true, 0, &next);
}

void glint_checkpoints_destroy(glint_checkpoints **checkpoints)
{
    glint_checkpoints *c = *checkpoints;
    *checkpoints = NULL;
    if (!c)
        return;
    pthread_cond_destroy(&c->changed);
    pthread_mutex_destroy(&c->mutex);
    free(c);
}

glint_journal *glint_checkpoints_journal(glint_checkpoints *c)
{
    return c->journal;
}

void glint_checkpoints_set_seconds(glint_checkpoints *c, double seconds)
{
    pthread_mutex_lock(&c->mutex);
    c->seconds = seconds > 0 ? seconds : GLINT_CHECKPOINT_SECONDS;
    pthread_cond_signal(&c->changed);
    pthread_mutex_unlock(&c->mutex);
}

void glint_checkpoints_now(glint_checkpoints *c)
{
    pthread_mutex_lock(&c->mutex);
    c->now = true;
    pthread_cond_signal(&c->changed);
    pthread_mutex_unlock(&c->mutex);
}

void glint_checkpoint_ended(struct glint_entry *e)
{
    glint_checkpoints *c = e->keeper;
    if (!c)
        return;
    pthread_mutex_lock(&c->mutex);
    c->ended = true;
    pthread_cond_signal(&c->changed);
    pthread_mutex_unlock(&c->mutex);
}
