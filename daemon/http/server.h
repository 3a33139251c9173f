// server.h - what the files of this folder share about the running server.
#ifndef GLINT_HTTP_SERVER_H
#define GLINT_HTTP_SERVER_H

#include "base/metrics.h"
#include "base/tokens.h"
#include "http/http.h"
#include "http/offload.h"
#include "http/watch.h"

#include <microhttpd.h>
#include <pthread.h>
#include <stdatomic.h>

#define GLINT_HTTP_THREADS 2u // of the library

// Where a handler runs. A lane's threads may wait for what they do, never for one another.
enum glint_lane {
    GLINT_LANE_NOW,    // in the library's thread: looks something up, no more
    GLINT_LANE_CALL,   // asks other threads and waits for their answer
    GLINT_LANE_LOAD,   // imports and deletes scenes
    GLINT_LANE_EDIT,   // patches scenes: not behind an import
    GLINT_LANE_FRAME,  // snapshots and encodes
    GLINT_LANE_STREAM, // fills streams
    GLINT_LANES
};

enum glint_stream_kind { GLINT_STREAM_EVENTS, GLINT_STREAM_TILES, GLINT_STREAM_KINDS };

struct glint_request;
struct glint_stream;
typedef struct glint_boards glint_boards;
typedef struct glint_topics glint_topics;

struct glint_http {
    struct MHD_Daemon *mhd;
    struct glint_accept *accept; // until it drains
    glint_jobs *jobs;
    glint_store *store;
    glint_devices *devices;
    glint_tokens *tokens; // NULL: whoever reaches the server may everything
    const char *version;
    bool loopback; // only this machine can connect

    glint_watch *watch;
    glint_offload *lane[GLINT_LANES];
    struct glint_frames *frames; // of ended jobs
    struct glint_boards *boards; // tiles of jobs that somebody watches
    struct glint_topics *topics; // events of such jobs

    pthread_mutex_t lists; // guards these; taken before any stream's mutex
    struct {
        struct glint_stream *first, *last;
        uint32_t count;
    } streams[GLINT_STREAM_KINDS];
    struct glint_request *first_parked; // they wait for their jobs to end

    atomic_uint readers; // streams and parked requests; changed before a reader looks at its job
    // When the next round's news began, on the clock of events' ids; 0: there are none.
    _Atomic uint64_t cause_us;
    double cared_at;                            // the watcher's
    _Atomic uint64_t tiles_sent, tiles_skipped; // relaxed: they are only shown

    pthread_mutex_t mutex; // guards these; nothing is called under it
    pthread_cond_t changed;
    struct glint_http_limits limits;
    uint32_t requests;  // from header to end
    uint32_t suspended; // connections
    size_t spooled;     // bytes of bodies under way
    bool draining;      // no new work
    bool stopping;      // no new suspensions

    glint_metrics *metrics;
    struct glint_record *record;
    glint_metric *waiting[GLINT_LANES];
    glint_metric *received, *open_connections, *open_streams, *sent, *skipped;
};

// Every suspension enters this gate and leaves it once resumed, because the library must not be
// stopped while a connection is suspended. False: the server stops, do not suspend.
bool glint_http_enter(glint_http *http);
void glint_http_leave(glint_http *http);

bool glint_http_draining(glint_http *http);
struct glint_http_limits glint_http_limits(glint_http *http); // as they are now

// The job has ended, or is not there.
bool glint_http_job_ended(glint_http *http, const char *job);

#endif
