// http.h - the daemon's HTTP interface: PROTOCOL's calls under /v1, streams, health and metrics.
//
// The only folder that names MHD_*. Two threads of the HTTP library move bytes and nothing else:
// what imports, encodes or takes a snapshot runs on a few threads of its own while the connection
// is suspended, and one watcher wakes streams, notices clients that left and ends those that dawdle.
//
// Every error is application/problem+json. A query parameter has no JSON pointer, so its fault
// carries the pointer "" and a detail that starts with the parameter's name.
//
// Threads: create, drain and destroy by main. One more takes connections (accept.h).
#ifndef GLINT_HTTP_HTTP_H
#define GLINT_HTTP_HTTP_H

#include "base/metrics.h"
#include "base/tokens.h"
#include "device/device.h"
#include "http/tls.h"
#include "jobs/jobs.h"
#include "scene/store.h"

typedef struct glint_http glint_http;

#define GLINT_MAX_STREAMS 65536u

struct glint_http_limits {
    size_t job_bytes;      // a job's JSON, 0: 1 MiB
    size_t scene_bytes;    // a scene's body, 0: 2 GiB
    size_t spool_bytes;    // all bodies under way together, 0: twice scene_bytes
    uint32_t connections;  // 0: 2048; more are answered 503
    uint32_t streams;      // tiles and events together, 0: 1024, at most GLINT_MAX_STREAMS; more
                           // are answered 503
    double header_seconds; // for a request's header to be complete, 0: 10
    double idle_seconds;   // without a byte either way, 0: 60
    double ping_seconds;   // of silence until a client of events is sent a comment, 0: 15
};

struct glint_http_params {
    int listen_fd; // listening TCP socket; taken on success
    glint_jobs *jobs;
    glint_store *store;
    glint_devices *devices;
    glint_metrics *metrics; // what GET /metrics writes; requests are counted into it
    glint_tokens *tokens;   // what clients must bear, NULL: nothing
    glint_tls *tls;         // NULL: plain HTTP
    const char *version;    // of the program, for GET /v1; outlives the server
    struct glint_http_limits limits;
};

// Serves from now on. Registers itself with glint_jobs_on_change.
//   GLINT_E_IO     threads or descriptors are not to be had
glint_status glint_http_create(glint_http **out, const struct glint_http_params *params,
                               struct glint_error *err);

// From the next connection and request on. Any thread.
void glint_http_set_limits(glint_http *http, const struct glint_http_limits *limits);

// Sends itself a request, each time to the next of the library's threads. True when an answer comes
// within `seconds`. One thread at a time, not once it drains.
bool glint_http_beats(glint_http *http, double seconds);

// Stops accepting, turns /readyz to 503, ends streams and waiting requests, and gives the requests
// under way up to `seconds` to finish. Returns true when none is left.
bool glint_http_drain(glint_http *http, double seconds);

// Stops and frees *http and stores NULL; drains for a moment if nobody did. Jobs, store and devices
// must still live.
void glint_http_destroy(glint_http **http);

#endif
