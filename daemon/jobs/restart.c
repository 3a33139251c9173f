#include "jobs/restart.h"

#include "base/clock.h"
#include "base/log.h"
#include "jobs/look.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static enum glint_job_state state_of(const struct glint_job_row *row)
{
    for (int s = 0; s <= GLINT_JOB_CANCELLED; s++) {
        const enum glint_job_state state = (enum glint_job_state)s;
        if (strcmp(row->state, glint_job_state_name(state)))
            continue;
        if (row->cancelled && !glint_state_ended(state))
            return GLINT_JOB_CANCELLED;
        return state == GLINT_JOB_RENDERING ? GLINT_JOB_QUEUED : state;
    }
    return GLINT_JOB_FAILED;
}

// ---- what a PATCH had changed, and why it failed

static double number(const cJSON *object, const char *name, double low, double high, double other)
{
    const cJSON *v = cJSON_GetObjectItemCaseSensitive(object, name);
    return cJSON_IsNumber(v) && v->valuedouble >= low && v->valuedouble <= high ? v->valuedouble
                                                                                : other;
}

static void recall_problem(struct glint_entry *e, const cJSON *problem)
{
    const cJSON *faults = cJSON_GetObjectItemCaseSensitive(problem, "faults");
    const int status = (int)number(problem, "status", 1, GLINT_STATUS_COUNT - 1, GLINT_E_INTERNAL);
    for (const cJSON *f = faults ? faults->child : NULL; f; f = f->next) {
        const char *pointer = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(f, "pointer"));
        const char *detail = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(f, "detail"));
        glint_fail(&e->problem, (glint_status)status, pointer ? pointer : "", "%s",
                   detail ? detail : "");
    }
    if (e->state == GLINT_JOB_FAILED && !e->problem.status)
        glint_fail(&e->problem, GLINT_E_INTERNAL, "", "it failed before a restart");
}

static void recall_changes(struct glint_entry *e, const char *text)
{
    cJSON *o = cJSON_Parse(text);
    const cJSON *stop = cJSON_GetObjectItemCaseSensitive(o, "stop");
    const cJSON *camera = cJSON_GetObjectItemCaseSensitive(o, "camera");
    e->priority = (int32_t)number(o, "priority", -100, 100, e->job->priority);
    e->stop = e->job->stop;
    e->stop.samples = (uint32_t)number(stop, "samples", 1, GLINT_MAX_SAMPLES, e->stop.samples);
    e->stop.seconds = number(stop, "seconds", 0, 1e9, e->stop.seconds);
    e->stop.error = number(stop, "error", 0, 1e9, e->stop.error);
    e->job->known_bias = number(o, "known_bias", 0, 1e9, 0);
    e->cpu_seconds = number(o, "cpu_seconds", 0, 1e12, 0);
    const char *asked = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(o, "asked"));
    e->asked = asked ? strdup(asked) : NULL;
    e->chosen = cJSON_DetachItemFromObjectCaseSensitive(o, "chosen");
    if (camera && e->job->live)
        glint_look_parse(&e->look, camera, NULL);
    recall_problem(e, cJSON_GetObjectItemCaseSensitive(o, "problem"));
    cJSON_Delete(o);
}

// ---- an entry

static char *take(char **text)
{
    char *out = *text;
    *text = NULL;
    return out;
}

static void recall_progress(struct glint_entry *e, const struct glint_job_row *row)
{
    const double age = fmax(glint_wall_clock() - row->accepted, 0);
    e->submitted = glint_now() - age;
    e->since = NAN;
    e->render_seconds = fmax(row->seconds, 0);
    e->worker_seconds = fmax(row->worker_seconds, 0);
    e->sequence = row->sequence + 1;
    e->need.film = row->film_bytes;
    e->need.scene = row->scene_bytes;
    e->kept.film = row->film;
    e->kept.film_before = row->film_before;
    e->kept.at = glint_now();
    e->kept.worker_seconds = e->worker_seconds;
    glint_job_rendered_read(&e->kept.rendered, row->rendered);
}

// A job whose text cannot be understood stands in the list as one that failed, with what is known of
// it. Its row is not written to, and its films stay, until somebody forgets it.
static glint_status stand_in(struct glint_entry *e, const struct glint_job_row *row,
                             const struct glint_error *why, struct glint_error *err)
{
    cJSON *least = cJSON_CreateObject();
    cJSON_AddStringToObject(least, "scene", row->scene);
    char *text = cJSON_PrintUnformatted(least);
    cJSON_Delete(least);
    const glint_status st = text ? glint_job_parse(&e->job, text, strlen(text), err)
                                 : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a job");
    free(text);
    e->state = GLINT_JOB_FAILED;
    for (size_t i = 0; i < why->count; i++)
        glint_fail(&e->problem, GLINT_E_DAMAGED, why->fault[i].pointer,
                   "what is kept of the job cannot be read: %s", why->fault[i].detail);
    glint_log(GLINT_LOG_ERROR, "jobs", row->id, NULL, "its row and films are left as they are: %s",
              glint_error_text(why));
    return st;
}

static glint_status read_job(struct glint_entry *e, const struct glint_job_row *row,
                             struct glint_error *err)
{
    struct glint_error why = {0};
    e->state = state_of(row);
    glint_status st = glint_job_parse(&e->job, row->text, strlen(row->text), &why);
    if (st)
        st = stand_in(e, row, &why, err);
    glint_error_finish(&why);
    return st;
}

static glint_status fill(struct glint_entry *e, struct glint_job_row *row, glint_store *store,
                         struct glint_error *err)
{
    strcpy(e->id, row->id);
    glint_status st = read_job(e, row, err);
    if (st)
        return st;
    const bool needed = !glint_state_ended(e->state);
    st = glint_store_recall(store, row->scene, row->revision, needed, &e->revision, err);
    if (st)
        return st;
    e->warnings = cJSON_Parse(row->warnings);
    if (!cJSON_IsArray(e->warnings)) {
        cJSON_Delete(e->warnings);
        e->warnings = cJSON_CreateArray();
    }
    strncpy(e->created, row->created, sizeof e->created - 1);
    e->text = take(&row->text);
    e->key = take(&row->key);
    e->client = take(&row->client);
    e->request = take(&row->request);
    e->end = GLINT_JOB_QUEUED;
    recall_progress(e, row);
    recall_changes(e, row->changes);
    // What a cancel had asked for is done with the next word of it; all else is on the disk.
    if (!needed && !(row->cancelled && strcmp(row->state, "cancelled")))
        e->kept.complete = e->sequence;
    return e->warnings ? GLINT_OK : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a job");
}

// Several jobs of one revision bring it back once.
static void share_revision(struct glint_entry *e, struct glint_entry *const *before, size_t count)
{
    for (size_t i = count; i--;) {
        const struct glint_entry *other = before[i];
        if (glint_state_ended(other->state) != glint_state_ended(e->state) ||
            strcmp(other->job->scene, e->job->scene) ||
            strcmp(glint_revision_id(other->revision), glint_revision_id(e->revision)))
            continue;
        glint_revision_release(&e->revision);
        e->revision = glint_revision_retain(other->revision);
        return;
    }
}

static struct glint_entry *recall(glint_checkpoints *c, glint_store *store,
                                  struct glint_job_row *row)
{
    struct glint_error err = {0};
    struct glint_entry *e = calloc(1, sizeof *e);
    if (!e)
        return NULL;
    atomic_init(&e->references, 1);
    atomic_init(&e->abandoned, false);
    e->keeper = c;
    if (fill(e, row, store, &err)) {
        glint_log(GLINT_LOG_ERROR, "jobs", row->id, NULL,
                  "its row and films are left as they are: %s", glint_error_text(&err));
        glint_entry_release(&e);
    }
    glint_error_finish(&err);
    return e;
}

static glint_status hand_over(glint_scheduler *scheduler, struct glint_entry *e,
                              struct glint_error *err)
{
    struct glint_command command = {.kind = GLINT_COMMAND_RECALL, .entry = e, .err = err};
    return glint_scheduler_call(scheduler, &command);
}

glint_status glint_jobs_recall(glint_checkpoints *c, glint_store *store, glint_scheduler *scheduler,
                               struct glint_error *err)
{
    struct glint_job_row *row;
    size_t count, recalled = 0, lives = 0;
    glint_status st = glint_job_rows_read(glint_checkpoints_journal(c), &row, &count, err);
    struct glint_entry **entry = st ? NULL : calloc(count + 1, sizeof *entry);
    if (!st && !entry)
        st = glint_fail(err, GLINT_E_NOMEM, "", "no memory for the jobs");
    for (size_t i = 0; i < count && !st; i++) {
        struct glint_entry *e = recall(c, store, &row[i]);
        if (!e) {
            glint_checkpoints_spare(c);
            continue;
        }
        share_revision(e, entry, recalled);
        entry[recalled++] = glint_entry_retain(e); // the scheduler takes the other one
        lives += !glint_state_ended(e->state);
        st = hand_over(scheduler, e, err);
        if (st)
            glint_entry_release(&e);
    }
    for (size_t i = 0; i < recalled; i++)
        glint_entry_release(&entry[i]);
    free(entry);
    glint_job_rows_free(row, count);
    if (!st && recalled)
        glint_log(GLINT_LOG_INFO, "jobs", NULL, NULL, "%zu jobs are known, %zu go on", recalled,
                  lives);
    return st;
}
