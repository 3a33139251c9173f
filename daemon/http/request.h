// request.h - one request from its header to its answer.
//
// The HTTP library's thread makes it, checks the header against the route and collects the body;
// the handler then runs on the lane that the route names, with the connection suspended unless the
// lane is GLINT_LANE_NOW, and leaves an answer (answer.h) in the request.
//
// Threads: one at a time, handed over through the lanes' queues.
#ifndef GLINT_HTTP_REQUEST_H
#define GLINT_HTTP_REQUEST_H

#include "base/tokens.h"
#include "http/offload.h"
#include "http/server.h"
#include "http/trace.h"

#include <stdatomic.h>

#define GLINT_MAX_SEGMENTS 6
#define GLINT_MAX_ARGUMENTS 2
#define GLINT_MAX_PARAMETERS 40
#define GLINT_REQUEST_ID_BYTES 65
#define GLINT_BODY_SECONDS 60.0 // until a body is complete, and a second more for each 16 KiB

struct glint_parameter {
    char *name, *value;
}; // of the query, decoded

enum glint_body_kind {
    GLINT_BODY_NONE,
    GLINT_BODY_JOB,
    GLINT_BODY_PATCH,
    GLINT_BODY_SCENE,
    GLINT_BODY_SCENE_PATCH,
    GLINT_BODY_ASSET
};

// The body as it arrives: small ones in memory, scenes in a memfd that is mapped once complete.
struct glint_body {
    uint8_t *bytes;
    size_t length, capacity;
    size_t reserved; // of the server's spool
    int fd;          // -1: in memory
    bool over;       // past the limit; what comes is dropped
};

struct glint_request {
    struct glint_task task;
    glint_http *http;
    struct MHD_Connection *connection;
    uint64_t client;
    const struct glint_route *route; // NULL: none matches
    double started;
    char id[GLINT_REQUEST_ID_BYTES];
    char trace[GLINT_TRACE_BYTES]; // traceparent of this request
    const char *client_name; // who asks, for fairness between clients; never NULL, "": not said
    char client_text[GLINT_CLIENT_BYTES];
    bool bad_client;        // what the header says is no name, and nobody has told yet
    enum glint_scope scope; // what he may
    bool head, http10;

    char method[12]; // as it came, cut
    char *url;       // as it came, without the query; NULL without memory
    char *path;      // cut into decoded segments
    char *segment[GLINT_MAX_SEGMENTS];
    size_t segments;
    const char *argument[GLINT_MAX_ARGUMENTS]; // segments that stand for {}
    struct glint_parameter parameter[GLINT_MAX_PARAMETERS];
    size_t parameters;
    bool bad_query;

    struct glint_body body;
    bool begun; // the handler was called

    int status; // of the answer, 0: none yet
    struct MHD_Response *response;
    bool close;                   // the connection, after the answer
    uint64_t sent;                // bytes of the answer's body
    bool streams;                 // the answer goes on while its job changes
    bool whole;                   // and has been sent to its end
    char job[GLINT_JOB_ID_BYTES]; // that the request has made, "": none

    bool park;        // until the job argument[0] has ended
    atomic_bool left; // the client, while parked; relaxed: only looked at again
    struct glint_request *next_parked;
};

// Makes the request and checks everything that the header tells; an answer may be ready already.
// NULL without memory.
struct glint_request *glint_request_create(glint_http *http, struct MHD_Connection *connection,
                                           const char *url, const char *method,
                                           const char *version);
void glint_request_destroy(struct glint_request **request);

// A header's value, or NULL.
const char *glint_request_header(struct glint_request *r, const char *name);

// True when the list of entity tags in the header holds `etag` (with quotes) or "*".
bool glint_request_matches(struct glint_request *r, const char *header, const char *etag);

// First value of a query parameter, or NULL.
const char *glint_request_query(const struct glint_request *r, const char *name);

// Appends a fault for each parameter that the route does not have or that is given more than once.
// Routes without parameters have been checked; the handler of any other calls this first.
void glint_query_check(const struct glint_request *r, struct glint_error *err);

// Each reads a parameter if it is there and appends a fault if it is malformed.
void glint_query_number(const struct glint_request *r, const char *name, double low, double high,
                        double *out, struct glint_error *err);
void glint_query_integer(const struct glint_request *r, const char *name, uint64_t high,
                         uint64_t *out, struct glint_error *err);
// choices: NULL-terminated; *out: index.
void glint_query_choice(const struct glint_request *r, const char *name, const char *const *choices,
                        int *out, struct glint_error *err);

// Handlers of requests that wait for their job to end return after this; they are called again.
void glint_request_wait(struct glint_request *r);

// body.c: takes the next bytes of the body. False: close the connection without an answer.
bool glint_body_add(struct glint_request *r, const char *bytes, size_t size);
// The body is complete: maps it. False: an answer is ready.
bool glint_body_finish(struct glint_request *r);
void glint_body_free(struct glint_request *r);
static inline const char *glint_body_text(const struct glint_request *r)
{
    return r->body.length ? (const char *)r->body.bytes : "";
}
// Bytes that the route takes, 0: no body.
size_t glint_body_limit(const struct glint_request *r);
// Checks the header of a request that has a body; false: an answer is ready.
bool glint_body_accept(struct glint_request *r);

#endif
