#include "jobs/jobs.h"

#include "base/clock.h"
#include "base/log.h"
#include "jobs/admit.h"
#include "jobs/checkpoint.h"
#include "jobs/choose.h"
#include "jobs/describe.h"
#include "jobs/patch.h"
#include "jobs/restart.h"
#include "jobs/scheduler.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// A submission with a key that is being answered, on the stack of who does.
struct pending {
    const char *key, *client;
    struct pending *next;
};

struct glint_jobs {
    glint_store *store;
    glint_prices *prices;
    glint_checkpoints *checkpoints; // NULL: nothing is kept
    pthread_mutex_t keys;           // guards `pending`; a leaf
    struct pending *pending;
    struct glint_job_table table;
    glint_scheduler *scheduler;
};

// Must not be refused, or a live job would stay behind: a full inbox empties at once.
static void tell(glint_jobs *jobs, struct glint_command *command)
{
    while (glint_scheduler_call(jobs->scheduler, command) == GLINT_E_BUSY) {
    }
}

static void scene_changed(void *user, const char *name)
{
    struct glint_command command = {.kind = GLINT_COMMAND_SCENE, .scene = name};
    tell(user, &command);
}

// The job that ended first, but not the only one; retained.
static struct glint_entry *oldest_ended(glint_jobs *jobs)
{
    struct glint_entry *oldest = NULL;
    size_t ended = 0;
    pthread_mutex_lock(&jobs->table.mutex);
    for (size_t i = 0; i < jobs->table.count; i++) {
        struct glint_entry *e = jobs->table.entry[i];
        if (!glint_checkpoint_complete(e) || !e->kept.film)
            continue;
        if (!ended++)
            oldest = e;
    }
    oldest = ended > 1 ? glint_entry_retain(oldest) : NULL;
    pthread_mutex_unlock(&jobs->table.mutex);
    return oldest;
}

// By the thread that writes films, which holds nothing meanwhile.
static void film_written(void *user)
{
    glint_jobs *jobs = user;
    struct glint_command command = {.kind = GLINT_COMMAND_KEPT};
    tell(jobs, &command);
    struct glint_entry *oldest;
    while (glint_checkpoints_excess(jobs->checkpoints) && (oldest = oldest_ended(jobs))) {
        bool forgotten = false;
        glint_log(GLINT_LOG_INFO, "jobs", oldest->id, oldest->request,
                  "forgotten: films take more of the disk than they may");
        const glint_status st = glint_jobs_delete(jobs, oldest->id, &forgotten, NULL);
        glint_entry_release(&oldest);
        if (st || !forgotten)
            return;
    }
}

// What is kept comes before anybody can ask for it, and before new films are written.
static glint_status start_keeping(glint_jobs *jobs, struct glint_error *err)
{
    if (!jobs->checkpoints)
        return GLINT_OK;
    const glint_status st = glint_jobs_recall(jobs->checkpoints, jobs->store, jobs->scheduler, err);
    if (st)
        return st;
    glint_checkpoints_sweep(jobs->checkpoints);
    return glint_checkpoints_start(jobs->checkpoints, err);
}

glint_status glint_jobs_create(glint_jobs **out, glint_devices *devices, glint_store *store,
                               const struct glint_jobs_limits *limits, glint_keeper *keeper,
                               struct glint_error *err)
{
    *out = NULL;
    glint_jobs *jobs = calloc(1, sizeof *jobs);
    if (!jobs)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the job table");
    jobs->store = store;
    pthread_mutex_init(&jobs->keys, NULL);
    glint_status st = glint_job_table_init(&jobs->table, glint_devices_workers(devices))
                          ? GLINT_OK
                          : glint_fail(err, GLINT_E_NOMEM, "", "no memory for the job table");
    if (!st)
        st = glint_prices_create(&jobs->prices, keeper, err);
    if (!st && keeper)
        st = glint_checkpoints_create(&jobs->checkpoints, keeper, &jobs->table, film_written, jobs,
                                      err);
    if (!st)
        st = glint_scheduler_create(&jobs->scheduler, devices, store, &jobs->table, limits, err);
    if (!st)
        st = start_keeping(jobs, err);
    if (st)
        glint_jobs_destroy(&jobs);
    else
        glint_store_on_publish(store, scene_changed, jobs);
    *out = jobs;
    return st;
}

void glint_jobs_set_checkpoint(glint_jobs *jobs, double seconds)
{
    if (jobs->checkpoints)
        glint_checkpoints_set_seconds(jobs->checkpoints, seconds);
}

void glint_jobs_set_film_disk(glint_jobs *jobs, uint64_t bytes)
{
    if (jobs->checkpoints)
        glint_checkpoints_set_budget(jobs->checkpoints, bytes);
}

void glint_jobs_checkpoint(glint_jobs *jobs)
{
    if (jobs->checkpoints)
        glint_checkpoints_now(jobs->checkpoints);
}

void glint_jobs_set_limits(glint_jobs *jobs, const struct glint_jobs_limits *limits)
{
    struct glint_command command = {.kind = GLINT_COMMAND_LIMITS, .limits = *limits};
    tell(jobs, &command);
}

void glint_jobs_destroy(glint_jobs **jobs)
{
    if (!*jobs)
        return;
    glint_jobs *j = *jobs;
    glint_store_on_publish(j->store, NULL, NULL);
    if (j->checkpoints)
        glint_checkpoints_stop(j->checkpoints);
    glint_scheduler_destroy(&j->scheduler);
    if (j->checkpoints)
        glint_checkpoints_flush(j->checkpoints);
    glint_job_table_finish(&j->table);
    glint_checkpoints_destroy(&j->checkpoints);
    glint_prices_destroy(&j->prices);
    pthread_mutex_destroy(&j->keys);
    free(j);
    *jobs = NULL;
}

void glint_jobs_on_change(glint_jobs *jobs, void (*changed)(void *user), void *user)
{
    struct glint_command command = {.kind = GLINT_COMMAND_WATCH, .changed = changed, .user = user};
    tell(jobs, &command); // who unregisters must not go on before it is done
}

// A repeated submission: `known` has the key. Consumes the hold on it.
static glint_status repeat(struct glint_entry *known, const char *text, char id[GLINT_JOB_ID_BYTES],
                           struct glint_error *err)
{
    const bool equal = !strcmp(known->asked ? known->asked : known->text, text);
    strcpy(id, known->id);
    glint_entry_release(&known);
    return equal ? GLINT_OK
                 : glint_fail(err, GLINT_E_RANGE, "",
                              "the Idempotency-Key belongs to another request, job %s", id);
}

static struct glint_entry *hold_by_key(glint_jobs *jobs, const struct glint_submission *from)
{
    if (!from->key)
        return NULL;
    pthread_mutex_lock(&jobs->table.mutex);
    struct glint_entry *known =
        glint_job_table_find_key(&jobs->table, from->client ? from->client : "", from->key);
    if (known)
        glint_entry_retain(known);
    pthread_mutex_unlock(&jobs->table.mutex);
    return known;
}

// Jobs that were taken out of the table are not known after a restart either.
static void forget_all(glint_jobs *jobs, struct glint_entry *gone)
{
    for (struct glint_entry *e = gone; e && jobs->checkpoints; e = e->next) {
        glint_job_row_remove(glint_checkpoints_journal(jobs->checkpoints), e->id, NULL);
        glint_checkpoint_remove(e);
    }
    glint_entry_release_all(gone);
}

// Sends the entry to the scheduler; it has found a twin with the same key where *repeated is set.
static glint_status add(glint_jobs *jobs, struct glint_entry *entry, char id[GLINT_JOB_ID_BYTES],
                        bool *repeated, struct glint_error *err)
{
    struct glint_command command = {.kind = GLINT_COMMAND_SUBMIT, .entry = entry, .err = err};
    strcpy(id, entry->id);
    glint_status st = glint_scheduler_call(jobs->scheduler, &command);
    forget_all(jobs, command.gone); // here and not by the scheduler: it takes a while
    *repeated = command.repeated != NULL;
    if (*repeated)
        st = repeat(command.repeated, entry->asked ? entry->asked : entry->text, id, err);
    return st;
}

static glint_status submit_again(struct glint_entry *known, struct glint_job *job,
                                 char id[GLINT_JOB_ID_BYTES], struct glint_error *err)
{
    char *text = glint_job_write(job);
    if (!text) {
        glint_entry_release(&known);
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a job");
    }
    const glint_status st = repeat(known, text, id, err);
    free(text);
    if (!st)
        glint_job_destroy(&job);
    return st;
}

// A job is on the disk before anybody is told that it is taken.
static glint_status keep_and_add(glint_jobs *jobs, struct glint_entry *entry,
                                 char id[GLINT_JOB_ID_BYTES], bool *repeated,
                                 struct glint_error *err)
{
    if (!jobs->checkpoints)
        return add(jobs, entry, id, repeated, err);
    glint_journal *journal = glint_checkpoints_journal(jobs->checkpoints);
    char own[GLINT_JOB_ID_BYTES];
    strcpy(own, entry->id);
    entry->keeper = jobs->checkpoints;
    entry->kept.at = glint_now();
    entry->kept.rendered = GLINT_NOTHING_RENDERED;
    glint_status st = glint_job_row_add(journal, entry, err);
    if (st)
        return st;
    st = add(jobs, entry, id, repeated, err);
    if (st || *repeated)
        glint_job_row_remove(journal, own, NULL);
    return st;
}

static glint_status submit_new(glint_jobs *jobs, struct glint_job *job,
                               const struct glint_submission *from, char id[GLINT_JOB_ID_BYTES],
                               bool *repeated, struct glint_error *err)
{
    struct glint_entry *entry;
    const struct glint_admission to = {jobs->store, jobs->prices, jobs->table.workers};
    glint_status st = glint_admit(&entry, &to, job, from, err);
    if (st)
        return st;
    st = keep_and_add(jobs, entry, id, repeated, err);
    if (st)
        entry->job = NULL; // stays the caller's
    if (st || *repeated)
        glint_entry_release(&entry);
    return st;
}

// Enters a submission with a key among those that are being answered; false: its twin is there.
static bool begin_key(glint_jobs *jobs, struct pending *p)
{
    pthread_mutex_lock(&jobs->keys);
    const struct pending *other = jobs->pending;
    while (other && (strcmp(other->key, p->key) || strcmp(other->client, p->client)))
        other = other->next;
    if (!other) {
        p->next = jobs->pending;
        jobs->pending = p;
    }
    pthread_mutex_unlock(&jobs->keys);
    return !other;
}

static void end_key(glint_jobs *jobs, const struct pending *p)
{
    pthread_mutex_lock(&jobs->keys);
    struct pending **at = &jobs->pending;
    while (*at != p)
        at = &(*at)->next;
    *at = p->next;
    pthread_mutex_unlock(&jobs->keys);
}

// Before the scene is looked up: a repeated request is answered even if that has gone.
static glint_status submit_or_repeat(glint_jobs *jobs, struct glint_job *job,
                                     const struct glint_submission *from,
                                     char id[GLINT_JOB_ID_BYTES], bool *repeated,
                                     struct glint_error *err)
{
    struct glint_entry *known = hold_by_key(jobs, from);
    *repeated = known != NULL;
    return known ? submit_again(known, job, id, err)
                 : submit_new(jobs, job, from, id, repeated, err);
}

glint_status glint_jobs_submit(glint_jobs *jobs, struct glint_job *job,
                               const struct glint_submission *from, char id[GLINT_JOB_ID_BYTES],
                               bool *repeated, struct glint_error *err)
{
    struct pending own = {.key = from->key, .client = from->client ? from->client : ""};
    if (own.key && !begin_key(jobs, &own))
        return glint_fail(err, GLINT_E_PENDING, "",
                          "a request with this Idempotency-Key is being answered");
    const glint_status st = submit_or_repeat(jobs, job, from, id, repeated, err);
    if (own.key)
        end_key(jobs, &own);
    return st;
}

glint_status glint_jobs_put_front(glint_jobs *jobs, const char *scene, const char *text,
                                  size_t length, bool *created, struct glint_error *err)
{
    glint_revision *revision;
    glint_status st = glint_store_get(jobs->store, scene, &revision, err);
    if (st)
        return st;
    glint_revision_release(&revision);
    return glint_prices_put(jobs->prices, scene, text, length, created, err);
}

glint_status glint_jobs_drop_front(glint_jobs *jobs, const char *scene, struct glint_error *err)
{
    return glint_prices_remove(jobs->prices, scene, err);
}

cJSON *glint_jobs_front(glint_jobs *jobs, const char *scene, struct glint_error *err)
{
    glint_revision *revision;
    cJSON *object = NULL;
    if (glint_store_get(jobs->store, scene, &revision, err))
        return NULL;
    if (!glint_revision_load(revision, err))
        object = glint_choose_describe(jobs->prices, scene, revision, err);
    glint_revision_release(&revision);
    return object;
}

cJSON *glint_jobs_describe(glint_jobs *jobs, const char *id, struct glint_error *err)
{
    struct glint_entry *entry = glint_job_table_hold(&jobs->table, id, err);
    if (!entry)
        return NULL;
    cJSON *object = glint_entry_describe(&jobs->table, entry);
    glint_entry_release(&entry);
    if (!object)
        glint_fail(err, GLINT_E_NOMEM, "", "no memory to describe a job");
    return object;
}

cJSON *glint_jobs_list(glint_jobs *jobs, const struct glint_jobs_filter *filter,
                       struct glint_error *err)
{
    return glint_entries_describe(&jobs->table, filter, err);
}

// Sends a command about the job named by `id`.
static glint_status command(glint_jobs *jobs, const char *id, struct glint_command *c)
{
    c->entry = glint_job_table_hold(&jobs->table, id, c->err);
    if (!c->entry)
        return GLINT_E_NOT_FOUND;
    const glint_status st = glint_scheduler_call(jobs->scheduler, c);
    forget_all(jobs, c->gone);
    glint_entry_release(&c->entry);
    return st;
}

// A job that has ended leaves the disk before the table, one that has not is cancelled there after
// the scheduler knows of it: either way it is not what it was when the client hears of it.
static glint_status delete_kept(glint_jobs *jobs, struct glint_entry *entry,
                                struct glint_command *c)
{
    glint_journal *journal = glint_checkpoints_journal(jobs->checkpoints);
    pthread_mutex_lock(&jobs->table.mutex);
    const bool ended = glint_state_ended(entry->state);
    pthread_mutex_unlock(&jobs->table.mutex);
    glint_status st = ended ? glint_job_row_remove(journal, entry->id, c->err) : GLINT_OK;
    if (!st)
        st = command(jobs, entry->id, c);
    if (!st && !ended && !c->forgotten && glint_job_row_cancel(journal, entry->id, NULL))
        glint_checkpoint_note(entry); // says why it is not kept
    return st;
}

glint_status glint_jobs_delete(glint_jobs *jobs, const char *id, bool *forgotten,
                               struct glint_error *err)
{
    struct glint_command c = {.kind = GLINT_COMMAND_DELETE, .err = err};
    struct glint_entry *entry = glint_job_table_hold(&jobs->table, id, err);
    if (!entry)
        return GLINT_E_NOT_FOUND;
    const glint_status st =
        jobs->checkpoints ? delete_kept(jobs, entry, &c) : command(jobs, id, &c);
    glint_entry_release(&entry);
    *forgotten = c.forgotten;
    return st;
}

// The revision that the entry is at, retained.
static glint_revision *hold_revision(glint_jobs *jobs, const struct glint_entry *entry)
{
    pthread_mutex_lock(&jobs->table.mutex);
    glint_revision *revision = glint_revision_retain(entry->revision);
    pthread_mutex_unlock(&jobs->table.mutex);
    return revision;
}

static glint_status check_look(glint_jobs *jobs, const struct glint_entry *entry,
                               const struct glint_look *look, struct glint_error *err)
{
    if (!entry->job->live)
        return glint_fail(err, GLINT_E_RANGE, "/camera",
                          "only the camera of a live job can be moved");
    glint_revision *revision = hold_revision(jobs, entry);
    const struct glint_job job = glint_look_apply(look, entry->job);
    glint_status st = glint_revision_load(revision, err);
    if (!st)
        st = glint_admit_camera(revision, &job, err);
    glint_revision_release(&revision);
    return st;
}

// What cannot be asked of this job, though it could of another.
static glint_status check_patch(glint_jobs *jobs, const char *id,
                                const struct glint_job_patch *patch, struct glint_error *err)
{
    struct glint_entry *entry = glint_job_table_hold(&jobs->table, id, err);
    if (!entry)
        return GLINT_E_NOT_FOUND;
    glint_status st = GLINT_OK, looks = GLINT_OK;
    if (entry->job->live && patch->has_error && patch->stop.error > 0)
        st = glint_fail(err, GLINT_E_RANGE, "/stop/error",
                        "a live job stops by samples or seconds, not by its error");
    if (patch->look)
        looks = check_look(jobs, entry, patch->look, err);
    glint_entry_release(&entry);
    return st ? st : looks;
}

static void note_patched(glint_jobs *jobs, const char *id)
{
    struct glint_entry *entry = glint_job_table_hold(&jobs->table, id, NULL);
    if (!entry)
        return;
    glint_checkpoint_note(entry);
    glint_entry_release(&entry);
}

// A job that ended before a restart needs its scene again to go on.
static glint_status load_scene(glint_jobs *jobs, const char *id, struct glint_error *err)
{
    struct glint_entry *entry = glint_job_table_hold(&jobs->table, id, err);
    if (!entry)
        return GLINT_E_NOT_FOUND;
    glint_revision *revision = hold_revision(jobs, entry);
    const glint_status st = glint_revision_load(revision, err);
    glint_revision_release(&revision);
    glint_entry_release(&entry);
    return st;
}

glint_status glint_jobs_patch(glint_jobs *jobs, const char *id, const char *text, size_t length,
                              struct glint_error *err)
{
    struct glint_command c = {.kind = GLINT_COMMAND_PATCH, .err = err};
    glint_status st = glint_job_patch_parse(&c.patch, text, length, err);
    if (!st)
        st = check_patch(jobs, id, &c.patch, err);
    if (!st && glint_job_patch_stops(&c.patch))
        st = load_scene(jobs, id, err);
    if (!st)
        st = command(jobs, id, &c);
    glint_job_patch_finish(&c.patch);
    if (!st)
        note_patched(jobs, id);
    return st;
}

// Of who is not in memory, but on the disk.
static glint_status open_view(struct glint_entry *entry, struct glint_job_view *out,
                              struct glint_error *err)
{
    struct glint_error why = {0};
    glint_checkpoint_open(entry, &out->render, &why);
    const glint_status st = why.status;
    out->opened = out->render != NULL;
    if (st && glint_state_ended(out->state))
        glint_fail(err, GLINT_E_IO, "", "its film cannot be read: %s", glint_error_text(&why));
    glint_error_finish(&why);
    if (glint_state_ended(out->state))
        return st ? GLINT_E_IO : GLINT_OK;
    return out->render ? GLINT_OK
                       : glint_fail(err, GLINT_E_BUSY, "", "the job is still being prepared");
}

glint_status glint_jobs_view(glint_jobs *jobs, const char *id, struct glint_job_view *out,
                             struct glint_error *err)
{
    *out = (struct glint_job_view){0};
    struct glint_entry *entry = glint_job_table_hold(&jobs->table, id, err);
    if (!entry)
        return GLINT_E_NOT_FOUND;
    const double now = glint_now();
    pthread_mutex_lock(&jobs->table.mutex);
    *out =
        (struct glint_job_view){.render = entry->render,
                                .parallel = glint_entry_seconds(entry, now) / entry->worker_seconds,
                                .state = entry->state,
                                .job = entry->job,
                                .stop = entry->stop,
                                .sequence = entry->sequence,
                                .hold = entry};
    entry->views += entry->render != NULL;
    strcpy(out->revision, glint_revision_id(entry->revision));
    pthread_mutex_unlock(&jobs->table.mutex);
    const glint_status st = out->render ? GLINT_OK : open_view(entry, out, err);
    if (st)
        glint_jobs_release(jobs, out);
    return st;
}

void glint_jobs_release(glint_jobs *jobs, struct glint_job_view *view)
{
    struct glint_entry *entry = view->hold;
    if (view->opened)
        glint_render_destroy(&view->render);
    pthread_mutex_lock(&jobs->table.mutex);
    entry->views -= view->render != NULL;
    pthread_mutex_unlock(&jobs->table.mutex);
    glint_entry_release(&entry);
    *view = (struct glint_job_view){0};
}

bool glint_jobs_belongs(glint_jobs *jobs, const char *id, const char *client)
{
    struct glint_entry *entry = glint_job_table_hold(&jobs->table, id, NULL);
    const bool belongs = entry && !strcmp(entry->client, client);
    if (entry)
        glint_entry_release(&entry);
    return belongs;
}

void glint_jobs_ping(glint_jobs *jobs)
{
    struct glint_command command = {.kind = GLINT_COMMAND_PING};
    tell(jobs, &command);
}

void glint_jobs_stats(glint_jobs *jobs, struct glint_jobs_stats *out)
{
    glint_job_table_stats(&jobs->table, out);
}

uint32_t glint_jobs_workers(glint_jobs *jobs, struct glint_worker_use *out, uint32_t capacity)
{
    return glint_job_table_workers(&jobs->table, out, capacity);
}
