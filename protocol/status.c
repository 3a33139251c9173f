// status.c - the table of codes, and the list of faults.
#include "protocol/status.h"

#include "protocol/utf8.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    int http, exit; // exit: sysexits.h, as far as it has a word for it
    const char *title, *problem, *meaning;
} table[GLINT_STATUS_COUNT] = {
    [GLINT_OK] = {200, 0, "OK", "about:blank", NULL},
    [GLINT_E_SYNTAX] = {400, 65, "Malformed request", "/problems/malformed",
                        "What was sent cannot be read at all: it is no HTTP, no JSON, or not the "
                        "file that it says. The detail names the place."},
    [GLINT_E_RANGE] = {422, 65, "Unprocessable content", "/problems/unprocessable",
                       "What was sent can be read, but breaks rules. Each of them is listed with a "
                       "JSON pointer to where."},
    [GLINT_E_UNAUTHORIZED] =
        {401, 77, "Unauthorized", "/problems/unauthorized",
         "The call needs a token: Authorization: Bearer, with one that this daemon knows."},
    [GLINT_E_FORBIDDEN] = {403, 77, "Forbidden", "/problems/forbidden",
                           "The token is known, but its scope does not allow the call."},
    [GLINT_E_NOT_FOUND] =
        {404, 66, "Not found", "/problems/not-found",
         "Nothing of that name is here, or it is somebody else's. GET /calls lists the calls."},
    [GLINT_E_METHOD] = {405, 70, "Method not allowed", "/problems/method-not-allowed",
                        "The resource is here, but not for this method. The header Allow lists "
                        "those that it takes."},
    [GLINT_E_CONFLICT] =
        {409, 65, "Conflict", "/problems/conflict",
         "The call does not fit what the resource is like now. The detail says what that is."},
    [GLINT_E_STALE] =
        {412, 75, "Precondition failed", "/problems/precondition-failed",
         "If-Match does not hold: somebody else was faster. Read the resource and try again."},
    [GLINT_E_TOO_LARGE] = {413, 65, "Content too large", "/problems/too-large",
                           "The body is over the limit. GET /v1 lists the limits."},
    [GLINT_E_MEDIA_TYPE] = {415, 65, "Unsupported media type", "/problems/media-type",
                            "The body is of a type or coding that this call does not take. The "
                            "header Accept lists those that it does."},
    [GLINT_E_BUSY] = {503, 75, "Busy", "/problems/busy",
                      "It cannot be done just now. Try again after the seconds of Retry-After."},
    [GLINT_E_CAPACITY] = {507, 75, "Over present capacity", "/problems/capacity",
                          "The machine has no room for it now, or never will. The detail says how "
                          "much is needed, and how much there is."},
    [GLINT_E_NOMEM] = {507, 71, "Out of memory", "/problems/memory",
                       "There was no memory. Try again when less is going on."},
    [GLINT_E_IO] =
        {500, 74, "Input or output failed", "/problems/io",
         "A disk or the network failed. The daemon's log has the line, by the request's id."},
    [GLINT_E_DEVICE] = {500, 71, "A device failed", "/problems/device",
                        "OpenCL or Embree refused. The detail is what it said."},
    [GLINT_E_UNAVAILABLE] = {503, 69, "No daemon answers", "/problems/unavailable",
                             "No daemon answers at that address."},
    [GLINT_E_VERSION] = {500, 65, "Made by a later version", "/problems/version",
                         "A file was written by a later version of glint. It is left as it is."},
    [GLINT_E_INTERNAL] =
        {500, 70, "Internal error", "/problems/internal",
         "A fault of glint itself. The daemon's log has the line, by the request's id."},
    [GLINT_E_DAMAGED] =
        {500, 74, "Damaged on the disk", "/problems/damaged",
         "What the daemon had kept of it can no longer be read. It is put aside; send it again."},
    [GLINT_E_PENDING] = {409, 75, "Still being answered", "/problems/pending",
                         "A request with the same Idempotency-Key is being answered. Try again "
                         "after the seconds of Retry-After: the answer is then that one's."},
};

static unsigned row(glint_status status)
{
    return (unsigned)status < GLINT_STATUS_COUNT ? (unsigned)status : GLINT_E_INTERNAL;
}

int glint_status_http(glint_status status)
{
    return table[row(status)].http;
}

const char *glint_status_title(glint_status status)
{
    return table[row(status)].title;
}

const char *glint_status_problem(glint_status status)
{
    return table[row(status)].problem;
}

const char *glint_status_meaning(glint_status status)
{
    return table[row(status)].meaning;
}

glint_status glint_status_of_problem(const char *name)
{
    for (int s = GLINT_OK + 1; s < GLINT_STATUS_COUNT; s++)
        if (!strcmp(strrchr(table[s].problem, '/') + 1, name))
            return (glint_status)s;
    return GLINT_OK;
}

int glint_status_exit(glint_status status)
{
    return table[row(status)].exit;
}

// Build logs are the longest details; what a client sent is never repeated beyond this.
#define MAX_DETAIL 16384

static struct glint_fault *append(struct glint_error *err)
{
    if (err->count == err->capacity) {
        const size_t capacity = err->capacity ? 2 * err->capacity : 4;
        struct glint_fault *more = realloc(err->fault, capacity * sizeof *more);
        if (!more)
            return NULL;
        err->fault = more;
        err->capacity = capacity;
    }
    return &err->fault[err->count];
}

static void store(struct glint_error *err, const char *pointer, const char *format, va_list args)
{
    char *detail = NULL;
    if (vasprintf(&detail, format, args) < 0)
        return;
    detail[strnlen(detail, MAX_DETAIL)] = '\0';
    glint_utf8_clean(detail);
    char *where = strdup(pointer);
    struct glint_fault *fault = append(err);
    if (!where || !fault) {
        free(where);
        free(detail);
        return;
    }
    *fault = (struct glint_fault){where, detail};
    err->count++;
}

static void say_there_are_more(struct glint_error *err)
{
    struct glint_fault *last = &err->fault[GLINT_MAX_FAULTS - 1];
    char *detail = strdup("there may be more faults than these");
    char *pointer = strdup("");
    if (detail && pointer) {
        free(last->detail);
        free(last->pointer);
        *last = (struct glint_fault){pointer, detail};
        return;
    }
    free(detail);
    free(pointer);
}

glint_status glint_fail(struct glint_error *err, glint_status status, const char *pointer,
                        const char *format, ...)
{
    if (!err)
        return status;
    if (!err->status)
        err->status = status;
    if (err->count == GLINT_MAX_FAULTS) {
        say_there_are_more(err);
        return status;
    }
    va_list args;
    va_start(args, format);
    store(err, pointer, format, args);
    va_end(args);
    return status;
}

void glint_error_finish(struct glint_error *err)
{
    for (size_t i = 0; i < err->count; i++) {
        free(err->fault[i].pointer);
        free(err->fault[i].detail);
    }
    free(err->fault);
    *err = (struct glint_error){0};
}

const char *glint_error_text(const struct glint_error *err)
{
    return err->count ? err->fault[0].detail : glint_status_title(err->status);
}
