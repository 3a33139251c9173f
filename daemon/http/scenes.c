#include "http/answer.h"
#include "http/media.h"
#include "http/resources.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ETAG_BYTES 80

static void revision_etag(const glint_revision *revision, const char *form, char etag[ETAG_BYTES])
{
    snprintf(etag, ETAG_BYTES, "\"%s%s\"", glint_revision_id(revision), form);
}

void glint_http_scenes_list(struct glint_request *r)
{
    glint_answer_json(r, MHD_HTTP_OK, glint_store_list(r->http->store));
}

// Takes `changes`, a member more, which may be NULL.
static void answer_resource(struct glint_request *r, int status, const glint_revision *revision,
                            cJSON *changes)
{
    char etag[ETAG_BYTES];
    revision_etag(revision, "", etag);
    cJSON *json = glint_revision_resource(revision);
    if (!json || (changes && !cJSON_AddItemToObject(json, "changes", changes)))
        cJSON_Delete(changes);
    char *text = json ? cJSON_PrintUnformatted(json) : NULL;
    cJSON_Delete(json);
    if (!text) {
        glint_answer_response(r, 0, NULL);
        return;
    }
    glint_answer_text(r, status, "application/json", text, strlen(text));
    glint_answer_header(r, "ETag", "%s", etag);
    free(text);
}

static void answer_native(struct glint_request *r, const glint_revision *revision)
{
    size_t length;
    const char *text = glint_revision_native(revision, &length);
    char etag[ETAG_BYTES];
    revision_etag(revision, "-native", etag);
    glint_answer_text(r, MHD_HTTP_OK, "application/json", text, length);
    glint_answer_header(r, "ETag", "%s", etag);
}

void glint_http_scenes_get(struct glint_request *r)
{
    static const char *const formats[] = {"resource", "native", NULL};
    struct glint_error err = {0};
    glint_revision *revision = NULL;
    int format = 0;
    glint_query_check(r, &err);
    glint_query_choice(r, "format", formats, &format, &err);
    if (err.count || glint_store_get(r->http->store, r->argument[0], &revision, &err)) {
        glint_answer_error(r, &err);
        return;
    }
    if (format && glint_revision_load(revision, &err)) {
        glint_revision_release(&revision);
        glint_answer_error(r, &err);
        return;
    }
    char etag[ETAG_BYTES];
    revision_etag(revision, format ? "-native" : "", etag);
    if (!glint_answer_unchanged(r, etag)) {
        if (format)
            answer_native(r, revision);
        else
            answer_resource(r, MHD_HTTP_OK, revision, NULL);
    }
    glint_revision_release(&revision);
}

// What If-Match and If-None-Match ask of the scene as it is. *must: the revision that a change
// has to find, "" for any. False: there is an answer.
static bool check_conditions(struct glint_request *r, char must[ETAG_BYTES])
{
    struct glint_error err = {0};
    glint_revision *revision = NULL;
    char etag[ETAG_BYTES] = "\"\"";
    *must = 0;
    const bool guarded = glint_request_header(r, "If-Match");
    if (!guarded && !glint_request_header(r, "If-None-Match"))
        return true;
    const bool exists = !glint_store_get(r->http->store, r->argument[0], &revision, NULL);
    if (exists)
        revision_etag(revision, "", etag);
    if (guarded && (!exists || !glint_request_matches(r, "If-Match", etag)))
        glint_fail(&err, GLINT_E_STALE, "", "If-Match: the scene's revision is %s",
                   exists ? etag : "none: it does not exist");
    else if (exists && glint_request_matches(r, "If-None-Match", etag))
        glint_fail(&err, GLINT_E_STALE, "", "If-None-Match: the scene exists with revision %s",
                   etag);
    else if (guarded)
        strcpy(must, glint_revision_id(revision)); // whoever changes it meanwhile wins
    if (revision)
        glint_revision_release(&revision);
    if (!err.count)
        return true;
    glint_answer_error(r, &err);
    return false;
}

void glint_http_scenes_put(struct glint_request *r)
{
    struct glint_error err = {0};
    glint_revision *revision = NULL;
    struct glint_import_source source;
    char must[ETAG_BYTES], boundary[GLINT_MAX_BOUNDARY + 1];
    bool created;
    if (!check_conditions(r, must))
        return;
    if (!glint_media_source(r, boundary, &source, &err))
        glint_store_put(r->http->store, r->argument[0], &source, *must ? must : NULL, &revision,
                        &created, &err);
    if (err.count) {
        glint_answer_error(r, &err);
        return;
    }
    answer_resource(r, created ? MHD_HTTP_CREATED : MHD_HTTP_OK, revision, NULL);
    if (created)
        glint_answer_header(r, "Location", "/v1/scenes/%s", r->argument[0]);
    glint_revision_release(&revision);
}

void glint_http_scenes_patch(struct glint_request *r)
{
    struct glint_error err = {0};
    glint_revision *revision = NULL;
    struct glint_patch_report report;
    char must[ETAG_BYTES];
    if (!check_conditions(r, must))
        return;
    glint_store_patch(r->http->store, r->argument[0], glint_body_text(r), r->body.length,
                      *must ? must : NULL, &revision, &report, &err);
    if (err.count)
        glint_answer_error(r, &err);
    else
        answer_resource(r, MHD_HTTP_OK, revision, glint_patch_describe(&report));
    glint_revision_release(&revision);
}

void glint_http_scenes_delete(struct glint_request *r)
{
    static const char *const choices[] = {"false", "true", NULL};
    struct glint_error err = {0};
    char must[ETAG_BYTES];
    int force = 0;
    glint_query_check(r, &err);
    glint_query_choice(r, "force", choices, &force, &err);
    if (!err.count && !check_conditions(r, must))
        return;
    if (!err.count)
        glint_store_delete(r->http->store, r->argument[0], *must ? must : NULL, force, &err);
    if (!err.count)
        glint_jobs_drop_front(r->http->jobs, r->argument[0], &err);
    if (err.count)
        glint_answer_error(r, &err);
    else
        glint_answer_empty(r, MHD_HTTP_NO_CONTENT);
}
