// cmd_jobs.c - jobs, watch and cancel.
#include "command.h"
#include "follow.h"
#include "interrupt.h"
#include "outlook.h"
#include "problem.h"
#include "table.h"
#include "tev_stream.h"

#include <stdlib.h>

#define MAX_WATCHED 1000

static const struct glint_column row[] = {
    {"JOB", "id", GLINT_COLUMN_TEXT},           {"STATE", "state", GLINT_COLUMN_TEXT},
    {"DONE", "progress", GLINT_COLUMN_PERCENT}, {"SAMPLES", "samples", GLINT_COLUMN_TEXT},
    {"ERROR", "error", GLINT_COLUMN_NUMBER},    {"SOUND", "invariants/sound", GLINT_COLUMN_TEXT},
    {"TIME", "seconds", GLINT_COLUMN_SECONDS},  {"SCENE", "scene", GLINT_COLUMN_TEXT},
    {"NAME", "name", GLINT_COLUMN_TEXT},        {0},
};

static const struct glint_column one[] = {
    {"job", "id", GLINT_COLUMN_TEXT},
    {"state", "state", GLINT_COLUMN_TEXT},
    {"name", "name", GLINT_COLUMN_TEXT},
    {"scene", "scene", GLINT_COLUMN_TEXT},
    {"revision", "revision", GLINT_COLUMN_TEXT},
    {"progress", "progress", GLINT_COLUMN_PERCENT},
    {"samples", "samples", GLINT_COLUMN_TEXT},
    {"error", "error", GLINT_COLUMN_NUMBER},
    {"seconds", "seconds", GLINT_COLUMN_SECONDS},
    {"left", "eta_seconds", GLINT_COLUMN_SECONDS},
    {"sound", "invariants/sound", GLINT_COLUMN_TEXT},
    {"problem", "problem/detail", GLINT_COLUMN_TEXT},
    {0},
};

static void print_job(struct glint_session *s, cJSON *job)
{
    if (s->json) {
        glint_session_print(job);
        return;
    }
    glint_table_print_one(one, job);
    glint_outlook_print(cJSON_GetObjectItemCaseSensitive(job, "estimate"));
    glint_table_print_texts("warning", cJSON_GetObjectItemCaseSensitive(job, "warnings"));
    cJSON_Delete(job);
}

static glint_status run_jobs(struct glint_session *s, const struct glint_arguments *a,
                             struct glint_error *err)
{
    cJSON *list, *job;
    glint_status status = glint_session_open(s, a, false, err);
    if (status)
        return status;
    if (a->count) {
        status = glint_client_get(s->client, "/v1/jobs/", a->text[0], "", &job, err);
        if (!status)
            print_job(s, job);
        return status;
    }
    status = glint_client_get(s->client, "/v1/jobs", NULL, NULL, &list, err);
    if (status)
        return status;
    if (s->json) {
        glint_session_print(list);
    } else {
        glint_table_print(row, cJSON_GetObjectItemCaseSensitive(list, "jobs"));
        cJSON_Delete(list);
    }
    return GLINT_OK;
}

static glint_status watch_one(struct glint_session *s, const struct glint_arguments *a, int number,
                              cJSON **job, struct glint_error *err)
{
    const char *id = a->text[number], *tev = glint_options_text(a, "tev");
    *job = NULL;
    glint_progress_init(&s->progress, glint_options_text(a, "progress"), s->json);
    if (a->count > 1)
        glint_progress_note(&s->progress, "job %s", id);
    glint_status status = tev ? glint_tev_stream_create(&s->tev, s, tev, id, id, err) : GLINT_OK;
    if (!status)
        status = glint_follow_job(s, id, job, err);
    if (!status)
        status = glint_follow_verdict(s, *job, err);
    return status;
}

// The jobs that are done, as one document or one after the other.
static void print_watched(struct glint_session *s, cJSON *done, int watched)
{
    if (s->json && watched > 1) {
        cJSON *document = cJSON_CreateObject();
        cJSON_AddItemToObject(document, "jobs", done);
        glint_session_print(document);
        return;
    }
    for (cJSON *job; (job = cJSON_DetachItemFromArray(done, 0));)
        print_job(s, job);
    cJSON_Delete(done);
}

// One after the other; each is watched to its end, whatever became of those before.
static glint_status run_watch(struct glint_session *s, const struct glint_arguments *a,
                              struct glint_error *err)
{
    if (!glint_progress_init(&s->progress, glint_options_text(a, "progress"), s->json))
        return glint_session_usage(s, err, "--progress wants auto, bar, plain, openjd or none");
    glint_status status = glint_session_open(s, a, false, err);
    if (status)
        return status;
    cJSON *done = cJSON_CreateArray(), *job;
    for (int i = 0; i < a->count && !glint_interrupt_pending(); i++) {
        const glint_status st = watch_one(s, a, i, &job, err);
        if (st)
            cJSON_Delete(job);
        else
            cJSON_AddItemToArray(done, job);
        status = status ? status : st;
    }
    print_watched(s, done, a->count);
    return status;
}

// 202 with the job where it was cancelled, 204 where it had ended and now is forgotten.
static void print_outcome(struct glint_session *s, const char *id,
                          const struct glint_answer *answer)
{
    const char *outcome = answer->http == 204 ? "forgotten" : "cancelled";
    if (s->json) {
        cJSON *document = cJSON_CreateObject();
        cJSON_AddStringToObject(document, "id", id);
        cJSON_AddStringToObject(document, "outcome", outcome);
        glint_session_print(document);
        return;
    }
    glint_print_plain(stdout, id);
    printf(": %s\n", outcome);
}

static glint_status run_cancel(struct glint_session *s, const struct glint_arguments *a,
                               struct glint_error *err)
{
    struct glint_answer answer;
    glint_status status = glint_session_open(s, a, false, err);
    if (status)
        return status;
    char *path = glint_client_path("/v1/jobs/", a->text[0], "");
    const struct glint_request request = {.method = "DELETE", .path = path};
    status = path ? glint_client_send(s->client, &request, &answer, err)
                  : glint_fail(err, GLINT_E_NOMEM, "", "no memory");
    free(path);
    if (status)
        return status;
    print_outcome(s, a->text[0], &answer);
    free(answer.body);
    return GLINT_OK;
}

static const struct glint_option watch_options[] = {
    {"progress", 0, "STYLE", "auto, bar, plain, openjd or none"},
    {"tev", 0, "HOST:PORT", "show the pictures in the viewer tev as they come"},
    {0},
};

const struct glint_command glint_command_jobs = {
    .name = "jobs",
    .operands = "[JOB]",
    .summary = "List the jobs, or describe one",
    .most = 1,
    .run = run_jobs,
};

const struct glint_command glint_command_watch = {
    .name = "watch",
    .operands = "JOB...",
    .summary = "Show the progress of jobs until each has ended",
    .options = watch_options,
    .least = 1,
    .most = MAX_WATCHED,
    .run = run_watch,
};

const struct glint_command glint_command_cancel = {
    .name = "cancel",
    .operands = "JOB",
    .summary = "Cancel a job, or forget one that has ended",
    .detail = "A cancelled job keeps what it has rendered until it is cancelled once more.",
    .least = 1,
    .most = 1,
    .run = run_cancel,
};
