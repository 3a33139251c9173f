// stream.h - an answer that goes on for as long as its job changes.
//
// What is sent are parts that all clients of a source share: a client has a cursor and one reference
// to the part that is under way, never a queue. So a slow client costs no work, and what was
// superseded meanwhile it never sees.
//
// Once the header of the answer is out the connection stays suspended until the stream ends, and the
// chunks of the body are written to its socket from here, from the shared bytes. Through the library
// each part would cost two more system calls, two wake-ups and a copy: measured with 500 clients of
// events, 54 us of CPU for each instead of 29. TLS and HTTP/1.0 do go through the library: it suspends the
// connection whenever there is nothing to send.
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

// What streams wait for: a number that is another after each change, never 0 after the first.
// Release by who changes it, acquire by who serves: the change is seen then.
typedef _Atomic uint64_t glint_stream_news;

// First member of each kind of stream.
struct glint_stream {
    glint_http *http;
    struct MHD_Connection *connection;
    uint64_t client;
    struct glint_request *request; // which outlives it
    enum glint_stream_kind kind;
    const glint_stream_news *news;        // of its source, which outlives it
    struct glint_stream *next, *previous; // guarded by http->lists, least lately served first

    // Gives the part at the cursor with a reference and moves the cursor on. Library's thread,
    // with the stream's mutex.
    enum glint_stream_next (*read)(struct glint_stream *stream, struct glint_blob **part);
    void (*destroy)(struct glint_stream *stream); // frees the whole object
    const char *ping;                             // sent after a long silence; NULL: nothing is

    int fd; // written to from here; -1: through the library

    pthread_mutex_t mutex;   // guards the rest
    struct glint_blob *part; // under way, NULL: none
    char head[20];           // of its chunk
    size_t sent;             // of head, part and line break; through the library: of the part
    uint64_t seen;           // news that it was last served for; 0: there was more to do
    double since;            // it has been idle or blocked, on glint_now()'s clock
    bool suspended;          // the connection is
    bool blocked;            // the socket takes no more
    bool closing;            // the end of the body is under way
    bool gone;               // the client left, or dawdles
};

// Starts `stream` as the answer to `r`: the object is zeroed but for kind, news, read, destroy,
// ping, perhaps a first part, and what its kind adds. Takes it always. Answers 503 when there are too many.
void glint_stream_start(struct glint_request *r, struct glint_stream *stream, const char *type);

// Serves the streams of a kind whose source has news, or only those that wait for `news` (NULL: all),
// until the time is `until` on glint_now()'s clock. True when some may be left.
bool glint_streams_serve(glint_http *http, enum glint_stream_kind kind,
                         const glint_stream_news *news, double until);

// Serves every stream that waits: the server drains.
void glint_streams_wake_all(glint_http *http);

// Ends every stream, whatever its client does.
void glint_streams_abort(glint_http *http);

// Gives each stream that has been silent for long its ping, and ends those whose clients have not
// read for the server's idle_seconds.
void glint_streams_look_after(glint_http *http);

#endif
