// cmd_render.c - render: a scene in, frames out, in one command; submit: its first half.
#include "command.h"
#include "download.h"
#include "follow.h"
#include "interrupt.h"
#include "order.h"
#include "problem.h"
#include "tev_stream.h"
#include "upload.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *text_of(const cJSON *object, const char *name)
{
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(object, name));
    return text ? text : "";
}

static void print_warnings(struct glint_session *s, const cJSON *scene)
{
    const cJSON *warning;
    cJSON_ArrayForEach(warning, cJSON_GetObjectItemCaseSensitive(scene, "warnings"))
        if (cJSON_IsString(warning))
            glint_progress_note(&s->progress, "warning: %s", warning->valuestring);
}

// *revision is malloc'd, NULL where nothing was uploaded.
static glint_status upload(struct glint_session *s, const struct glint_order *o, char **revision,
                           struct glint_error *err)
{
    cJSON *scene;
    *revision = NULL;
    if (!o->file)
        return GLINT_OK;
    const glint_status status = glint_upload_scene(s, o->file, o->scene, &scene, err);
    if (status)
        return status;
    print_warnings(s, scene);
    *revision = strdup(text_of(scene, "revision"));
    cJSON_Delete(scene);
    return GLINT_OK;
}

static glint_status submit(struct glint_session *s, const struct glint_order *o, cJSON **job,
                           struct glint_error *err)
{
    *job = NULL;
    char *text = cJSON_PrintUnformatted(o->job);
    if (!text)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory");
    const struct glint_body body = {
        .type = "application/json", .bytes = (const uint8_t *)text, .size = strlen(text)};
    // Steady: a job that was accepted must be known here, or nobody could cancel it.
    const struct glint_request request = {.method = "POST",
                                          .path = "/v1/jobs",
                                          .body = &body,
                                          .idempotency_key = o->key,
                                          .steady = true};
    const glint_status status = glint_client_json(s->client, &request, job, err);
    free(text);
    return status;
}

// A user who stops waiting wants the job stopped.
static void cancel(struct glint_session *s, const char *id)
{
    glint_interrupt_clear();
    struct glint_error ignored = {0};
    char *path = glint_client_path("/v1/jobs/", id, "");
    if (path)
        glint_client_send(s->client, &(struct glint_request){.method = "DELETE", .path = path},
                          NULL, &ignored);
    glint_error_finish(&ignored);
    free(path);
}

static glint_status download(struct glint_session *s, const struct glint_order *o, const char *id,
                             struct glint_error *err)
{
    const struct glint_frame_request frame = {.job = id, .wait = true};
    glint_status status = GLINT_OK;
    for (size_t i = 0; i < o->outputs && !status; i++)
        status = glint_download_frame(s, &frame, o->output[i], NULL, err);
    return status;
}

// What the daemon has picked, where it was to.
static void tell_chosen(struct glint_session *s, const cJSON *job)
{
    const cJSON *chosen = cJSON_GetObjectItemCaseSensitive(job, "chosen");
    const cJSON *error = cJSON_GetObjectItemCaseSensitive(chosen, "expected_error");
    const bool own = strcmp(text_of(chosen, "from"), "scene") == 0;
    const bool current = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(chosen, "current"));
    if (!s->json && cJSON_IsNumber(error))
        glint_progress_note(&s->progress, "picked %s from the front of %s; expected error %.3g",
                            text_of(chosen, "row"),
                            !own      ? "its class"
                            : current ? "this scene"
                                      : "this scene as it was before it changed",
                            error->valuedouble);
}

static void report(struct glint_session *s, const struct glint_order *o, cJSON *job)
{
    if (s->json) {
        cJSON *files = cJSON_AddArrayToObject(job, "files");
        for (size_t i = 0; i < o->outputs; i++)
            cJSON_AddItemToArray(files, cJSON_CreateString(o->output[i]));
        glint_session_print(cJSON_Duplicate(job, true));
        return;
    }
    const cJSON *samples = cJSON_GetObjectItemCaseSensitive(job, "samples");
    const cJSON *error = cJSON_GetObjectItemCaseSensitive(job, "error");
    const cJSON *seconds = cJSON_GetObjectItemCaseSensitive(job, "seconds");
    for (size_t i = 0; i < o->outputs; i++)
        fprintf(stderr, "%s%s", i ? ", " : "", o->output[i]);
    if (cJSON_IsNumber(samples))
        fprintf(stderr, ": %.0f samples", samples->valuedouble);
    if (cJSON_IsNumber(error))
        fprintf(stderr, ", error %.4f", error->valuedouble);
    if (cJSON_IsNumber(seconds))
        fprintf(stderr, ", %.1f s", seconds->valuedouble);
    fputc('\n', stderr);
}

static glint_status wait_and_fetch(struct glint_session *s, const struct glint_order *o,
                                   const char *id, struct glint_error *err)
{
    cJSON *job = NULL;
    glint_status status =
        o->tev ? glint_tev_stream_create(&s->tev, s, o->tev, id, id, err) : GLINT_OK;
    if (!status)
        status = glint_follow_job(s, id, &job, err);
    if (!status)
        status = glint_follow_verdict(s, job, err);
    if (!status)
        status = download(s, o, id, err);
    if (!status)
        report(s, o, job);
    cJSON_Delete(job);
    return status;
}

// A live job goes on by itself, and so does one that was only to be submitted.
static glint_status see_through(struct glint_session *s, const struct glint_order *o, cJSON *job,
                                struct glint_error *err)
{
    if (!o->detached)
        return wait_and_fetch(s, o, text_of(job, "id"), err);
    if (s->json) {
        glint_session_print(cJSON_Duplicate(job, true));
    } else {
        glint_print_plain(stdout, text_of(job, "id"));
        putchar('\n');
    }
    return GLINT_OK;
}

// Another user may have replaced the scene between its upload and the job.
static glint_status check_revision(const cJSON *job, const char *uploaded, struct glint_error *err)
{
    const char *used = text_of(job, "revision");
    if (!uploaded || !*used || strcmp(used, uploaded) == 0)
        return GLINT_OK;
    return glint_fail(err, GLINT_E_CONFLICT, "/scene",
                      "the scene was replaced by someone else before the job could use it; "
                      "give it another --scene-name");
}

static glint_status render(struct glint_session *s, const struct glint_order *o,
                           struct glint_error *err)
{
    char *revision;
    cJSON *job = NULL;
    glint_status status = upload(s, o, &revision, err);
    if (!status)
        status = submit(s, o, &job, err);
    if (!status)
        tell_chosen(s, job);
    const char *id = text_of(job, "id");
    const glint_status stale = status ? GLINT_OK : check_revision(job, revision, err);
    if (!status)
        status = stale ? stale : see_through(s, o, job, err);
    if (*id && (stale || (glint_interrupt_seen() && !o->detached)))
        cancel(s, id);
    free(revision);
    cJSON_Delete(job);
    return status;
}

static glint_status run(struct glint_session *s, const struct glint_arguments *a, bool detached,
                        struct glint_error *err)
{
    struct glint_order order = {.detached = detached};
    const bool spawn = !glint_options_flag(a, "no-spawn");
    glint_status status = glint_order_read(&order, s, a, err);
    if (!status) // a private daemon has no scenes yet, and ends with this command
        status = glint_session_open(s, a, spawn && order.file && !order.detached, err);
    if (!status)
        status = render(s, &order, err);
    glint_order_finish(&order);
    return status;
}

static glint_status run_render(struct glint_session *s, const struct glint_arguments *a,
                               struct glint_error *err)
{
    return run(s, a, false, err);
}

static glint_status run_submit(struct glint_session *s, const struct glint_arguments *a,
                               struct glint_error *err)
{
    return run(s, a, true, err);
}

const struct glint_command glint_command_render = {
    .name = "render",
    .operands = "[SCENE]",
    .summary = "Render a scene to an image",
    .detail = "SCENE is a file (.glb, .gltf, .obj, .ply, .stl, .json), which is uploaded, or\n"
              "the name of a scene that the daemon has. Where no daemon answers, a private one\n"
              "is started for the time it takes.",
    .options = glint_order_options,
    .most = 1,
    .run = run_render,
};

const struct glint_command glint_command_submit = {
    .name = "submit",
    .operands = "[SCENE]",
    .summary = "Submit a job and print its id",
    .detail = "As render, without waiting for the job: glint watch, jobs and get tell of it.\n"
              "SCENE is a file, which is uploaded, or the name of a scene that the daemon has.",
    .options = glint_order_options + GLINT_ORDER_DETACHED,
    .most = 1,
    .run = run_submit,
};
