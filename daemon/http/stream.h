// stream.h - an answer that goes on for as long as its job changes.
//
// What is sent are parts that all clients of a source share: a client has a cursor and one reference
// to the part that is under way, never a queue. The library's thread asks for bytes; when there are
// none it suspends the connection until the source has news. So a slow client costs no work, and
// what was superseded meanwhile it never sees.
//
// Threads: any, but for what says otherwise.
#ifndef GLINT_HTTP_STREAM_H
#define GLINT_HTTP_STREAM_H

#include "http/blob.h"
#include "http/request.h"

enum glint_stream_next {
    GLINT_STREAM_PART,
    GLINT_STREAM_NOTHING, // until the source has news
    GLINT_STREAM_END,     // also when asked again
    GLINT_STREAM_BROKEN   // the connection is closed without the end of its body
};

// First member of each kind of stream.
struct glint_stream {
    glint_http *http;
    struct MHD_Connection *connection;
    uint64_t client;
    uint64_t *bytes;                      // of the request: what was sent
    const void *source;                   // whose news it waits for
    struct glint_stream *next, *previous; // guarded by http->lists, least lately woken first

    // Gives the part at the cursor with a reference and moves the cursor on. Library's thread,
    // with the stream's mutex.
    enum glint_stream_next (*read)(struct glint_stream *stream, struct glint_blob **part);
    void (*destroy)(struct glint_stream *stream); // frees the whole object
    const char *ping;                             // sent after a long silence; NULL: nothing is

    pthread_mutex_t mutex;   // guards the rest
    struct glint_blob *part; // under way, NULL: none
    size_t sent;             // of it
    uint64_t seen;           // news of the source that it was last woken for
    double idle_since;       // on glint_now()'s clock
    bool idle;               // the connection is suspended
    bool gone;               // the client left
};

// Starts `stream` as the answer to `r`: the object is zeroed but for source, read, destroy, ping,
// perhaps a first part, and what its kind adds. Takes it always. Answers 503 when there are too many.
void glint_stream_start(struct glint_request *r, struct glint_stream *stream, const char *type);

// Wakes idle streams of the source that were not woken for news number `news` yet, at most *budget,
// which is lowered by their number. True when some are left.
bool glint_streams_wake(glint_http *http, const void *source, uint64_t news, unsigned *budget);

// Wakes every idle stream.
void glint_streams_wake_all(glint_http *http);

// Gives each stream that has been silent for long its ping.
void glint_streams_ping(glint_http *http);

#endif
