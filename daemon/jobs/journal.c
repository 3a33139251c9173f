#include "jobs/journal.h"

#include "base/clock.h"
#include "jobs/outlook.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---- how far it has come

// JSON has no NAN: what is not known is left out.
static void add(cJSON *object, const char *name, double value)
{
    if (isfinite(value))
        cJSON_AddNumberToObject(object, name, value);
}

static double get(const cJSON *object, const char *name, double otherwise)
{
    const cJSON *v = cJSON_GetObjectItemCaseSensitive(object, name);
    return cJSON_IsNumber(v) ? v->valuedouble : otherwise;
}

char *glint_job_rendered_write(const struct glint_render_state *s)
{
    cJSON *o = cJSON_CreateObject();
    add(o, "samples", s->samples);
    add(o, "target_samples", s->target_samples);
    add(o, "progress", s->progress);
    glint_outlook_write(o, s);
    add(o, "camera_rays", (double)s->camera_rays);
    add(o, "bounce_rays", (double)s->bounce_rays);
    add(o, "shadow_rays", (double)s->shadow_rays);
    for (int i = 0; i < GLINT_COUNTS; i++)
        add(o, glint_count_name[i], (double)s->count[i]);
    add(o, "rank_pixels", (double)s->excess.pixels);
    add(o, "ranks_needed", s->excess.needed);
    add(o, "ranks_left_out", s->excess.left_out);
    char *text = cJSON_PrintUnformatted(o);
    cJSON_Delete(o);
    return text;
}

static uint64_t count(const cJSON *object, const char *name)
{
    return (uint64_t)fmin(fmax(get(object, name, 0), 0), 9e15);
}

void glint_job_rendered_read(struct glint_render_state *out, const char *text)
{
    cJSON *o = cJSON_Parse(text);
    *out = (struct glint_render_state){.samples = (uint32_t)fmin(count(o, "samples"), UINT32_MAX),
                                       .progress = get(o, "progress", 0),
                                       .camera_rays = count(o, "camera_rays"),
                                       .bounce_rays = count(o, "bounce_rays"),
                                       .shadow_rays = count(o, "shadow_rays")};
    glint_outlook_read(out, o);
    out->target_samples = (uint32_t)fmin(count(o, "target_samples"), UINT32_MAX);
    for (int i = 0; i < GLINT_COUNTS; i++)
        out->count[i] = count(o, glint_count_name[i]);
    out->excess = (struct glint_matte_excess){count(o, "rank_pixels"),
                                              (uint32_t)fmin(count(o, "ranks_needed"), UINT32_MAX),
                                              get(o, "ranks_left_out", 0)};
    cJSON_Delete(o);
}

static cJSON *write_problem(const struct glint_error *problem)
{
    cJSON *o = cJSON_CreateObject(), *faults = cJSON_AddArrayToObject(o, "faults");
    cJSON_AddNumberToObject(o, "status", problem->status);
    for (size_t i = 0; i < problem->count; i++) {
        cJSON *fault = cJSON_CreateObject();
        cJSON_AddStringToObject(fault, "pointer", problem->fault[i].pointer);
        cJSON_AddStringToObject(fault, "detail", problem->fault[i].detail);
        cJSON_AddItemToArray(faults, fault);
    }
    return o;
}

// With the table's mutex.
static char *write_changes(const struct glint_entry *e)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddNumberToObject(o, "priority", e->priority);
    cJSON *stop = cJSON_AddObjectToObject(o, "stop");
    cJSON_AddNumberToObject(stop, "samples", e->stop.samples);
    cJSON_AddNumberToObject(stop, "seconds", e->stop.seconds);
    cJSON_AddNumberToObject(stop, "error", e->stop.error);
    if (e->look)
        cJSON_AddItemToObject(o, "camera", cJSON_Duplicate(e->look->camera, true));
    if (e->state == GLINT_JOB_FAILED)
        cJSON_AddItemToObject(o, "problem", write_problem(&e->problem));
    cJSON_AddNumberToObject(o, "cpu_seconds", e->cpu_seconds);
    if (e->job->known_bias > 0)
        cJSON_AddNumberToObject(o, "known_bias", e->job->known_bias);
    if (e->chosen)
        cJSON_AddItemToObject(o, "chosen", cJSON_Duplicate(e->chosen, true));
    if (e->asked)
        cJSON_AddStringToObject(o, "asked", e->asked);
    char *text = cJSON_PrintUnformatted(o);
    cJSON_Delete(o);
    return text;
}

bool glint_job_progress_take(struct glint_job_progress *out, struct glint_job_table *table,
                             const struct glint_entry *e, glint_render *render)
{
    const double now = glint_now();
    pthread_mutex_lock(&table->mutex);
    *out = (struct glint_job_progress){.state = e->state,
                                       .changes = write_changes(e),
                                       .seconds = glint_entry_seconds(e, now),
                                       .worker_seconds = e->worker_seconds,
                                       .rendered = e->kept.rendered,
                                       .sequence = e->sequence,
                                       .film = e->kept.film,
                                       .film_before = e->kept.film_before};
    pthread_mutex_unlock(&table->mutex);
    if (render)
        glint_render_state(render, &out->rendered);
    return out->changes;
}

void glint_job_progress_finish(struct glint_job_progress *progress)
{
    free(progress->changes);
    *progress = (struct glint_job_progress){0};
}

// ---- writing

glint_status glint_job_row_add(glint_journal *journal, const struct glint_entry *e,
                               struct glint_error *err)
{
    char *warnings = cJSON_PrintUnformatted(e->warnings), *changes = write_changes(e);
    if (!warnings || !changes) {
        free(warnings);
        free(changes);
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory to keep a job");
    }
    const struct glint_statement row = {
        .sql =
            "INSERT INTO job(id, text, scene, revision, client, request, key, created, accepted, "
            "film_bytes, scene_bytes, warnings, state, changes) "
            "VALUES(?,?,?,?,?,?,?,?,?,?,?,?,?,?)",
        .value = {glint_value_text(e->id), glint_value_text(e->text),
                  glint_value_text(e->job->scene), glint_value_text(glint_revision_id(e->revision)),
                  glint_value_text(e->client), glint_value_text(e->request),
                  glint_value_text(e->key), glint_value_text(e->created),
                  glint_value_real(glint_wall_clock()), glint_value_integer((int64_t)e->need.film),
                  glint_value_integer((int64_t)e->need.scene), glint_value_text(warnings),
                  glint_value_text(glint_job_state_name(GLINT_JOB_QUEUED)),
                  glint_value_text(changes)},
        .values = 14};
    const glint_status st = glint_journal_commit(journal, &row, 1, err);
    free(warnings);
    free(changes);
    return st;
}

glint_status glint_job_row_set(glint_journal *journal, const char *id,
                               const struct glint_job_progress *p, struct glint_error *err)
{
    char *rendered = glint_job_rendered_write(&p->rendered);
    if (!rendered)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory to keep a job");
    // Films are numbered by one thread alone; all else may be said by several, in any order.
    const struct glint_statement set[3] = {
        {.sql = "UPDATE job SET state=?, changes=?, seconds=?, worker_seconds=?, rendered=?, "
                "sequence=? WHERE id=? AND sequence<=?",
         .value = {glint_value_text(glint_job_state_name(p->state)), glint_value_text(p->changes),
                   glint_value_real(p->seconds), glint_value_real(p->worker_seconds),
                   glint_value_text(rendered), glint_value_integer((int64_t)p->sequence),
                   glint_value_text(id), glint_value_integer((int64_t)p->sequence)},
         .values = 8},
        {.sql = "UPDATE job SET film=?, film_before=? WHERE id=? AND film<=?",
         .value = {glint_value_integer((int64_t)p->film),
                   glint_value_integer((int64_t)p->film_before), glint_value_text(id),
                   glint_value_integer((int64_t)p->film)},
         .values = 4},
        {.sql = "UPDATE job SET cancelled=0 WHERE id=?",
         .value = {glint_value_text(id)},
         .values = 1}};
    const glint_status st = glint_journal_commit(journal, set, p->resumed ? 3 : 2, err);
    free(rendered);
    return st;
}

glint_status glint_job_row_cancel(glint_journal *journal, const char *id, struct glint_error *err)
{
    const struct glint_statement row = {.sql = "UPDATE job SET cancelled=1 WHERE id=?",
                                        .value = {glint_value_text(id)},
                                        .values = 1};
    return glint_journal_commit(journal, &row, 1, err);
}

glint_status glint_job_row_remove(glint_journal *journal, const char *id, struct glint_error *err)
{
    const struct glint_statement row = {
        .sql = "DELETE FROM job WHERE id=?", .value = {glint_value_text(id)}, .values = 1};
    return glint_journal_commit(journal, &row, 1, err);
}

// ---- reading

struct rows {
    struct glint_job_row *row;
    size_t count;
    bool failed;
};

static char *text(const struct glint_row *row, int column)
{
    const char *t = glint_row_text(row, column);
    return t ? strdup(t) : NULL;
}

static void free_row(struct glint_job_row *r)
{
    char *const owned[] = {r->id,  r->text,    r->scene,    r->revision, r->client,  r->request,
                           r->key, r->created, r->warnings, r->state,    r->changes, r->rendered};
    for (size_t i = 0; i < sizeof owned / sizeof *owned; i++)
        free(owned[i]);
}

static bool is_whole(const struct glint_job_row *r)
{
    return r->id && strlen(r->id) < GLINT_JOB_ID_BYTES && r->text && r->scene && r->revision &&
           strlen(r->revision) == 64 && r->client && r->created && r->warnings && r->state &&
           r->changes && r->rendered;
}

static void take(void *user, const struct glint_row *row)
{
    struct rows *rows = user;
    struct glint_job_row *more = realloc(rows->row, (rows->count + 1) * sizeof *more);
    rows->failed |= !more;
    if (!more)
        return;
    rows->row = more;
    struct glint_job_row *r = &more[rows->count];
    *r = (struct glint_job_row){.id = text(row, 0),
                                .text = text(row, 1),
                                .scene = text(row, 2),
                                .revision = text(row, 3),
                                .client = text(row, 4),
                                .request = text(row, 5),
                                .key = text(row, 6),
                                .created = text(row, 7),
                                .accepted = glint_row_real(row, 8),
                                .film_bytes = (uint64_t)glint_row_integer(row, 9),
                                .warnings = text(row, 10),
                                .state = text(row, 11),
                                .cancelled = glint_row_integer(row, 12) != 0,
                                .changes = text(row, 13),
                                .seconds = glint_row_real(row, 14),
                                .worker_seconds = glint_row_real(row, 15),
                                .rendered = text(row, 16),
                                .sequence = (uint64_t)glint_row_integer(row, 17),
                                .film = (uint64_t)glint_row_integer(row, 18),
                                .film_before = (uint64_t)glint_row_integer(row, 19),
                                .scene_bytes = (uint64_t)glint_row_integer(row, 20)};
    if (is_whole(r))
        rows->count++;
    else
        free_row(r);
}

glint_status glint_job_rows_read(glint_journal *journal, struct glint_job_row **out, size_t *n,
                                 struct glint_error *err)
{
    struct rows rows = {0};
    const struct glint_statement all = {
        .sql =
            "SELECT id, text, scene, revision, client, request, key, created, accepted, "
            "film_bytes, warnings, state, cancelled, changes, seconds, worker_seconds, rendered, "
            "sequence, film, film_before, scene_bytes FROM job ORDER BY number"};
    glint_status st = glint_journal_read(journal, &all, take, &rows, err);
    if (!st && rows.failed)
        st = glint_fail(err, GLINT_E_NOMEM, "", "no memory for the jobs");
    if (st) {
        glint_job_rows_free(rows.row, rows.count);
        rows = (struct rows){0};
    }
    *out = rows.row;
    *n = rows.count;
    return st;
}

void glint_job_rows_free(struct glint_job_row *row, size_t n)
{
    for (size_t i = 0; i < n; i++)
        free_row(&row[i]);
    free(row);
}
