// cmd_update.c - update: edits a resident scene with a merge patch, or changes a job.
#include "adjust.h"
#include "command.h"
#include "interrupt.h"
#include "problem.h"
#include "table.h"
#include "uri.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MOST_BYTES ((size_t)1 << 30)
#define STEP_BYTES ((size_t)1 << 16)

static bool reserve(struct glint_blob *out, size_t *capacity)
{
    if (out->size < *capacity)
        return true;
    uint8_t *more = realloc(out->bytes, *capacity + *capacity / 2 + STEP_BYTES);
    if (!more)
        return false;
    out->bytes = more;
    *capacity += *capacity / 2 + STEP_BYTES;
    return true;
}

static glint_status read_stdin(struct glint_blob *out, struct glint_error *err)
{
    size_t capacity = 0;
    *out = (struct glint_blob){0};
    for (ssize_t n = 1; n;) {
        if (out->size > MOST_BYTES)
            return glint_fail(err, GLINT_E_TOO_LARGE, "", "more than %zu bytes come in",
                              MOST_BYTES);
        if (!reserve(out, &capacity))
            return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the patch");
        while (!glint_interrupt_wait(STDIN_FILENO, 1000))
            if (glint_interrupt_pending())
                return glint_fail(err, GLINT_E_BUSY, "", "interrupted");
        n = read(STDIN_FILENO, out->bytes + out->size, capacity - out->size);
        if (n < 0 && errno != EINTR)
            return glint_fail(err, GLINT_E_IO, "", "standard input: %s", strerror(errno));
        out->size += n > 0 ? (size_t)n : 0;
    }
    return GLINT_OK;
}

// A strong entity tag, whether the quotes were given or not.
static char *entity_tag(const char *revision)
{
    char *tag = NULL;
    const char *quote = *revision == '"' || strcmp(revision, "*") == 0 ? "" : "\"";
    return asprintf(&tag, "%s%s%s", quote, revision, quote) < 0 ? NULL : tag;
}

static glint_status send_patch(struct glint_session *s, const char *scene, const char *revision,
                               const struct glint_blob *patch, cJSON **out, struct glint_error *err)
{
    char *path = glint_client_path("/v1/scenes/", scene, "");
    char *tag = revision ? entity_tag(revision) : NULL;
    const struct glint_body body = {
        .type = "application/merge-patch+json", .bytes = patch->bytes, .size = patch->size};
    const struct glint_request request = {
        .method = "PATCH", .path = path, .body = &body, .if_match = tag};
    const glint_status status = path && (tag || !revision)
                                    ? glint_client_json(s->client, &request, out, err)
                                    : glint_fail(err, GLINT_E_NOMEM, "", "no memory");
    free(path);
    free(tag);
    return status;
}

// "rebuilt: materials 0.2 ms, lights 1.0 ms", or nothing where no part is.
static void print_parts(const cJSON *changes, const char *fate, bool timed)
{
    const cJSON *part, *list = cJSON_GetObjectItemCaseSensitive(changes, fate);
    const cJSON *times = cJSON_GetObjectItemCaseSensitive(changes, "milliseconds");
    const char *before = ": ";
    if (!cJSON_GetArraySize(list))
        return;
    fputs(fate, stdout);
    cJSON_ArrayForEach(part, list) {
        const char *name = cJSON_IsString(part) ? part->valuestring : "-";
        const cJSON *ms = cJSON_GetObjectItemCaseSensitive(times, name);
        fputs(before, stdout);
        glint_print_plain(stdout, name);
        if (timed && cJSON_IsNumber(ms))
            printf(" %.1f ms", ms->valuedouble);
        before = ", ";
    }
    putchar('\n');
}

static void print_update(const cJSON *scene)
{
    const cJSON *changes = cJSON_GetObjectItemCaseSensitive(scene, "changes");
    const cJSON *times = cJSON_GetObjectItemCaseSensitive(changes, "milliseconds");
    const cJSON *total = cJSON_GetObjectItemCaseSensitive(times, "total");
    const char *revision =
        cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(scene, "revision"));
    fputs("revision: ", stdout);
    glint_print_plain(stdout, revision ? revision : "-");
    putchar('\n');
    print_parts(changes, "rebuilt", true);
    print_parts(changes, "uploaded", true);
    print_parts(changes, "later", false);
    print_parts(changes, "kept", false);
    if (cJSON_IsNumber(total))
        printf("total: %.1f ms\n", total->valuedouble);
}

static glint_status update_scene(struct glint_session *s, const struct glint_arguments *a,
                                 struct glint_error *err)
{
    struct glint_blob patch = {0};
    cJSON *scene = NULL;
    glint_status status = strcmp(a->text[1], "-") == 0
                              ? read_stdin(&patch, err)
                              : glint_uri_read_file(a->text[1], &patch, "", err);
    if (!status)
        status = glint_session_open(s, a, false, err);
    if (!status)
        status = send_patch(s, a->text[0], glint_options_text(a, "if-match"), &patch, &scene, err);
    free(patch.bytes);
    if (status)
        return status;
    if (s->json)
        glint_session_print(scene);
    else
        print_update(scene), cJSON_Delete(scene);
    return GLINT_OK;
}

static glint_status send_adjustment(struct glint_session *s, const char *job, const cJSON *patch,
                                    cJSON **out, struct glint_error *err)
{
    char *text = cJSON_PrintUnformatted(patch), *path = glint_client_path("/v1/jobs/", job, "");
    const struct glint_body body = {.type = "application/merge-patch+json",
                                    .bytes = (const uint8_t *)text,
                                    .size = text ? strlen(text) : 0};
    const struct glint_request request = {.method = "PATCH", .path = path, .body = &body};
    const glint_status status = text && path ? glint_client_json(s->client, &request, out, err)
                                             : glint_fail(err, GLINT_E_NOMEM, "", "no memory");
    free(text);
    free(path);
    return status;
}

static const struct glint_column job_columns[] = {
    {"job", "id", GLINT_COLUMN_TEXT},
    {"state", "state", GLINT_COLUMN_TEXT},
    {"priority", "priority", GLINT_COLUMN_TEXT},
    {"samples", "samples", GLINT_COLUMN_TEXT},
    {"stops at", "target_samples", GLINT_COLUMN_TEXT},
    {"seconds", "seconds", GLINT_COLUMN_SECONDS},
    {0},
};

static glint_status update_job(struct glint_session *s, const struct glint_arguments *a,
                               struct glint_error *err)
{
    cJSON *patch = NULL, *job = NULL;
    glint_status status = glint_options_flag(a, "if-match")
                              ? glint_session_usage(s, err, "--if-match is for scenes")
                              : glint_adjust_read(s, a, &patch, err);
    if (!status)
        status = glint_session_open(s, a, false, err);
    if (!status)
        status = send_adjustment(s, a->text[0], patch, &job, err);
    cJSON_Delete(patch);
    if (status)
        return status;
    if (s->json)
        glint_session_print(job);
    else
        glint_table_print_one(job_columns, job), cJSON_Delete(job);
    return GLINT_OK;
}

static glint_status run_update(struct glint_session *s, const struct glint_arguments *a,
                               struct glint_error *err)
{
    if (a->count == 1)
        return update_job(s, a, err);
    if (glint_adjust_is_meant(a))
        return glint_session_usage(s, err, "a PATCH is for scenes, these options are for jobs");
    return update_scene(s, a, err);
}

static const struct glint_option options[] = {
    {"if-match", 0, "REVISION", "of a scene: only if this is its revision"},
    GLINT_ADJUST_OPTIONS,
    {0},
};

const struct glint_command glint_command_update = {
    .name = "update",
    .operands = "SCENE PATCH | JOB",
    .summary = "Edit a scene, or change what a job does",
    .detail = "PATCH is a file with a JSON merge patch of the scene's native form, or - for\n"
              "standard input. What was built anew for it is printed, what will be\n"
              "when a job asks for it, and what was kept.\n"
              "Of a JOB the options say what changes; more samples continue a finished job.",
    .options = options,
    .least = 1,
    .most = 2,
    .run = run_update,
};
