#include "base/clock.h"
#include "base/log.h"
#include "base/thread.h"
#include "jobs/checkpoint_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define RETRY_SECONDS 5.0 // after a disk took nothing

// ---- trouble

static void not_kept(struct glint_checkpoints *c, struct glint_entry *e, struct glint_error *err)
{
    glint_metric_add(c->failures, 1);
    if (!glint_checkpoints_say(c, &e->kept.trouble, "the job is not being kept: %s",
                               glint_error_text(err)))
        glint_log(GLINT_LOG_ERROR, "jobs", e->id, e->request, "not kept: %s",
                  glint_error_text(err));
    glint_error_finish(err);
}

static void kept_again(struct glint_checkpoints *c, struct glint_entry *e)
{
    if (glint_checkpoints_say(c, &e->kept.trouble, NULL))
        glint_log(GLINT_LOG_INFO, "jobs", e->id, e->request, "kept again");
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

static void give_back(struct glint_checkpoints *c, struct glint_entry *e, glint_render *render,
                      double now)
{
    pthread_mutex_lock(&c->table->mutex);
    e->views -= render != NULL;
    e->kept.at = now;
    pthread_mutex_unlock(&c->table->mutex);
}

// ---- writing

static void remove_film(struct glint_checkpoints *c, const struct glint_entry *e, uint64_t number)
{
    const struct glint_checkpoint_file file = glint_checkpoints_file(c, e, number);
    if (!number)
        return;
    atomic_fetch_sub(&c->bytes, glint_checkpoint_file_bytes(&file));
    glint_checkpoint_file_remove(&file);
}

static void note(struct glint_checkpoints *c, struct glint_entry *e,
                 const struct glint_job_progress *p, uint64_t bytes)
{
    const struct glint_checkpoint_file file = glint_checkpoints_file(c, e, p->film);
    char written[sizeof e->kept.written];
    glint_checkpoint_file_time(&file, written);
    atomic_fetch_add(&c->bytes, bytes);
    glint_metric_add(c->written_bytes, (double)bytes);
    pthread_mutex_lock(&c->table->mutex);
    memcpy(e->kept.written, written, sizeof written);
    e->kept.film = p->film;
    e->kept.film_before = p->film_before;
    e->kept.rendered = p->rendered;
    e->kept.worker_seconds = p->worker_seconds;
    if (glint_state_ended(p->state))
        e->kept.complete = p->sequence;
    const bool removed = e->kept.removed;
    pthread_mutex_unlock(&c->table->mutex);
    if (removed)
        remove_film(c, e, p->film);
}

// Commits a new film, or, without a render, only that the job has ended.
static glint_status keep_film(struct glint_checkpoints *c, struct glint_entry *e,
                              glint_render *render, struct glint_error *err)
{
    struct glint_job_progress p;
    uint64_t bytes = 0;
    if (!glint_job_progress_take(&p, c->table, e, render))
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory to keep a job");
    const uint64_t old = p.film, older = p.film_before;
    const bool ended = glint_state_ended(p.state);
    glint_status st = GLINT_OK;
    if (render) {
        p.film = old + 1;
        p.film_before = ended ? 0 : old;
        const struct glint_checkpoint_file file = glint_checkpoints_file(c, e, p.film);
        st = glint_checkpoint_file_write(&file, render, &bytes, err);
    }
    if (!st)
        st = glint_job_row_set(c->journal, e->id, &p, err);
    if (!st) {
        note(c, e, &p, bytes);
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
    const double end = glint_now();
    give_back(c, e, render, end);
    if (st) {
        not_kept(c, e, &err);
        return false;
    }
    kept_again(c, e);
    if (render) {
        glint_metric_add(c->total, 1);
        glint_metric_observe(c->seconds_each, end - start);
        glint_log(GLINT_LOG_DEBUG, "jobs", e->id, e->request, "film written in %.3f s",
                  end - start);
    }
    return true;
}

// ---- whose turn it is

struct look {
    bool ended, complete, can; // can: has a render whose film is worth keeping before its end
    bool news;                 // has rendered since its newest film
    double at, retry;
};

static struct look look_at(struct glint_checkpoints *c, const struct glint_entry *e)
{
    pthread_mutex_lock(&c->table->mutex);
    const struct look l = {.ended = glint_state_ended(e->state),
                           .complete = glint_checkpoint_complete(e),
                           .can = e->render && !e->job->live && !glint_render_is_sketch(e->render),
                           .news = e->worker_seconds != e->kept.worker_seconds,
                           .at = e->kept.at,
                           .retry = e->kept.retry};
    pthread_mutex_unlock(&c->table->mutex);
    return l;
}

static bool is_due(const struct look *l, double now, double seconds, bool all)
{
    if (l->ended)
        return !l->complete && now >= l->retry;
    return l->can && l->news && (all || now >= l->at + seconds);
}

// Writes what is due of an entry; when something is due again, INFINITY: nothing is.
static double visit(struct glint_checkpoints *c, struct glint_entry *e, const struct look *l,
                    bool all, double seconds)
{
    if (!is_due(l, glint_now(), seconds, all))
        return l->ended ? (l->complete ? INFINITY : l->retry) : l->can ? l->at + seconds : INFINITY;
    const bool kept = checkpoint(c, e);
    const double retry = kept ? 0 : glint_now() + RETRY_SECONDS;
    pthread_mutex_lock(&c->table->mutex);
    e->kept.retry = retry;
    pthread_mutex_unlock(&c->table->mutex);
    if (l->ended && kept && c->written)
        c->written(c->user);
    if (l->ended)
        return kept ? INFINITY : retry;
    return glint_now() + seconds;
}

// Ended ones come first: they are wanted for good. *next: when something is due again.
static void round_of(struct glint_checkpoints *c, bool ended, bool all, double seconds,
                     double *next)
{
    size_t count;
    struct glint_entry **entry = glint_checkpoints_hold(c, &count);
    for (size_t i = 0; i < count; i++) {
        const struct look l = look_at(c, entry[i]);
        if (l.ended == ended)
            *next = fmin(*next, visit(c, entry[i], &l, all, seconds));
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

// ---- what others ask for

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
    else
        kept_again(c, e);
    glint_job_progress_finish(&p);
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
