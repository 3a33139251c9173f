#include "http/answer.h"

#include "base/log.h"
#include "http/range.h"
#include "http/routes.h"
#include "protocol/problem.h"

#include <assert.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void glint_answer_response(struct glint_request *r, int status, struct MHD_Response *response)
{
    if (r->response)
        MHD_destroy_response(r->response);
    r->response = response;
    r->status = status;
    r->sent = 0;
    if (!response) { // nothing can be said about it without memory
        r->status = glint_status_http(GLINT_E_NOMEM);
        r->response = MHD_create_response_from_buffer(0, NULL, MHD_RESPMEM_PERSISTENT);
    }
    glint_answer_header(r, "X-Request-Id", "%s", r->id);
    glint_answer_header(r, "traceparent", "%s", r->trace);
    glint_answer_header(r, "X-Content-Type-Options", "nosniff");
}

void glint_answer_header(struct glint_request *r, const char *name, const char *format, ...)
{
    char value[512];
    va_list args;
    va_start(args, format);
    vsnprintf(value, sizeof value, format, args);
    va_end(args);
    if (r->response)
        MHD_add_response_header(r->response, name, value);
}

// The text is taken.
static void answer_owned(struct glint_request *r, int status, const char *type, char *text,
                         size_t length)
{
    struct MHD_Response *response =
        text ? MHD_create_response_from_buffer(length, text, MHD_RESPMEM_MUST_FREE) : NULL;
    if (!response)
        free(text);
    glint_answer_response(r, status, response);
    if (!response)
        return;
    r->sent = r->head ? 0 : length;
    glint_answer_header(r, "Content-Type", "%s", type);
}

void glint_answer_text(struct glint_request *r, int status, const char *type, const char *text,
                       size_t length)
{
    char *copy = malloc(length + 1);
    if (copy)
        memcpy(copy, text, length);
    answer_owned(r, status, type, copy, length);
}

void glint_answer_empty(struct glint_request *r, int status)
{
    glint_answer_response(r, status,
                          MHD_create_response_from_buffer(0, NULL, MHD_RESPMEM_PERSISTENT));
}

bool glint_answer_unchanged(struct glint_request *r, const char *etag)
{
    if (!glint_request_matches(r, "If-None-Match", etag))
        return false;
    glint_answer_empty(r, MHD_HTTP_NOT_MODIFIED);
    glint_answer_header(r, "ETag", "%s", etag);
    return true;
}

void glint_answer_json(struct glint_request *r, int status, cJSON *json)
{
    char *text = json ? cJSON_PrintUnformatted(json) : NULL;
    cJSON_Delete(json);
    const size_t length = text ? strlen(text) : 0;
    if (text && status == MHD_HTTP_OK && !strcmp(r->route->method, "GET"))
        glint_answer_blob(r, status, "application/json",
                          glint_blob_digest((uint8_t *)text, length));
    else
        answer_owned(r, status, "application/json", text, length);
}

static void release_blob(void *blob)
{
    struct glint_blob *b = blob;
    glint_blob_release(&b);
}

// Takes the reference, which the response holds until it has been sent.
static void answer_part(struct glint_request *r, int status, struct glint_blob *blob,
                        struct glint_range part)
{
    struct MHD_Response *response = MHD_create_response_from_buffer_with_free_callback_cls(
        part.length, blob->bytes + part.first, release_blob, blob);
    if (!response)
        glint_blob_release(&blob);
    glint_answer_response(r, status, response);
    r->sent = response && !r->head ? part.length : 0;
}

static struct glint_range choose_part(struct glint_request *r, int *status,
                                      const struct glint_blob *blob)
{
    struct glint_range part = {0, blob->size};
    const char *range = glint_request_header(r, "Range");
    const char *if_range = glint_request_header(r, "If-Range");
    if (!range || !*blob->etag || *status != MHD_HTTP_OK)
        return part;
    if (if_range && strcmp(if_range, blob->etag))
        return part;
    switch (glint_range_parse(range, blob->size, &part)) {
    case GLINT_RANGE_WHOLE:
        break;
    case GLINT_RANGE_PART:
        *status = MHD_HTTP_PARTIAL_CONTENT;
        break;
    case GLINT_RANGE_OUTSIDE:
        *status = MHD_HTTP_RANGE_NOT_SATISFIABLE;
    }
    return part;
}

void glint_answer_blob(struct glint_request *r, int status, const char *type,
                       struct glint_blob *blob)
{
    if (!blob || (*blob->etag && glint_answer_unchanged(r, blob->etag))) {
        if (!blob)
            glint_answer_response(r, status, NULL);
        glint_blob_release(&blob);
        return;
    }
    char etag[sizeof blob->etag], digest[sizeof blob->digest];
    strcpy(etag, blob->etag);
    strcpy(digest, blob->digest);
    const size_t size = blob->size;
    const struct glint_range part = choose_part(r, &status, blob);
    if (status == MHD_HTTP_RANGE_NOT_SATISFIABLE) {
        glint_blob_release(&blob);
        glint_answer_problem(r, status, "Range not satisfiable", "there are %zu bytes", size);
        glint_answer_header(r, "Content-Range", "bytes */%zu", size);
        return;
    }
    answer_part(r, status, blob, part);
    glint_answer_header(r, "Content-Type", "%s", type);
    if (!*etag)
        return;
    glint_answer_header(r, "ETag", "%s", etag);
    glint_answer_header(r, "Repr-Digest", "%s", digest);
    glint_answer_header(r, "Accept-Ranges", "bytes");
    if (status == MHD_HTTP_PARTIAL_CONTENT)
        glint_answer_header(r, "Content-Range", "bytes %zu-%zu/%zu", part.first,
                            part.first + part.length - 1, size);
}

// Takes `text`.
static void answer_problem(struct glint_request *r, int status, bool later, char *text)
{
    answer_owned(r, status, "application/problem+json", text, text ? strlen(text) : 0);
    if (later)
        glint_answer_header(r, "Retry-After", "1");
}

void glint_answer_error(struct glint_request *r, struct glint_error *err)
{
    assert(err->count);
    const int status = glint_status_http(err->status);
    if (status >= 500 && err->status != GLINT_E_BUSY)
        glint_log(GLINT_LOG_WARNING, "http", NULL, r->id, "%s: %s", r->url ? r->url : "",
                  glint_error_text(err));
    const bool later = status == MHD_HTTP_SERVICE_UNAVAILABLE || err->status == GLINT_E_PENDING;
    answer_problem(r, status, later, glint_problem_text(err, r->url, r->id));
    glint_error_finish(err);
}

void glint_answer_problem(struct glint_request *r, int status, const char *title,
                          const char *format, ...)
{
    char detail[512];
    va_list args;
    va_start(args, format);
    vsnprintf(detail, sizeof detail, format, args);
    va_end(args);
    struct glint_error err = {0};
    glint_fail(&err, GLINT_E_RANGE, "", "%s", detail);
    cJSON *o = glint_problem_object(&err, r->url, r->id);
    glint_error_finish(&err);
    cJSON_ReplaceItemInObjectCaseSensitive(o, "type", cJSON_CreateString("about:blank"));
    cJSON_ReplaceItemInObjectCaseSensitive(o, "title", cJSON_CreateString(title));
    cJSON_ReplaceItemInObjectCaseSensitive(o, "status", cJSON_CreateNumber(status));
    answer_problem(r, status, status == MHD_HTTP_SERVICE_UNAVAILABLE,
                   o ? cJSON_PrintUnformatted(o) : NULL);
    cJSON_Delete(o);
}
