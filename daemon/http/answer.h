// answer.h - what a handler leaves in its request. The last answer given counts.
//
// Threads: the one that holds the request.
#ifndef GLINT_HTTP_ANSWER_H
#define GLINT_HTTP_ANSWER_H

#include "http/blob.h"
#include "http/request.h"

#include <cjson/cJSON.h>

// Takes `json`; NULL answers 507. A GET that is answered 200 gets an ETag and honours
// If-None-Match.
void glint_answer_json(struct glint_request *r, int status, cJSON *json);

// Takes the reference; NULL answers 507. Where the blob has an ETag, honours If-None-Match, Range
// and If-Range.
void glint_answer_blob(struct glint_request *r, int status, const char *type,
                       struct glint_blob *blob);

// Copies the text.
void glint_answer_text(struct glint_request *r, int status, const char *type, const char *text,
                       size_t length);
void glint_answer_empty(struct glint_request *r, int status);

// Takes the response; NULL answers 507.
void glint_answer_response(struct glint_request *r, int status, struct MHD_Response *response);

// application/problem+json with every fault of *err, which is finished.
void glint_answer_error(struct glint_request *r, struct glint_error *err);

// A problem for a status that is none of glint_status, or that has no faults to name.
void glint_answer_problem(struct glint_request *r, int status, const char *title,
                          const char *format, ...) __attribute__((format(printf, 4, 5)));

// Adds a header to the answer that is there.
void glint_answer_header(struct glint_request *r, const char *name, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

// True when If-None-Match holds `etag`: the answer is 304 then.
bool glint_answer_unchanged(struct glint_request *r, const char *etag);

#endif
