// stream.h - an answer that goes on for as long as its job changes.
//
// The library's thread asks for bytes; when there are none it suspends the connection and the
// stream lane fills the buffer, so a slow client costs one buffer and no work, and what changed in
// between is seen once. One mutex per stream guards suspend and resume.
//
// A stream is one of these, in turn:
//   SENDING  the library owns the buffer
//   FILLING  suspended; the lane owns the buffer
//   IDLE     suspended; nothing to send until glint_streams_kick
#ifndef GLINT_HTTP_STREAM_H
#define GLINT_HTTP_STREAM_H

#include "http/request.h"

enum glint_stream_state { GLINT_STREAM_SENDING, GLINT_STREAM_FILLING, GLINT_STREAM_IDLE };

// First member of each kind of stream.
struct glint_stream {
    struct glint_task task;
    glint_http *http;
    struct MHD_Connection *connection;
    uint64_t client;
    struct glint_stream *next, *previous; // guarded by http->lists

    // Adds to the buffer what is new, if anything. Returns false when nothing will ever follow.
    // Called by one thread at a time, without locks.
    bool (*fill)(struct glint_stream *stream);
    void (*destroy)(struct glint_stream *stream); // frees the whole object

    uint8_t *bytes; // the buffer; owner by state
    size_t length, capacity, sent;
    double filled_at; // when bytes were last added, on glint_now()'s clock

    pthread_mutex_t mutex; // guards the rest
    enum glint_stream_state state;
    bool kicked; // while it was being filled
    bool gone;   // the client left
    bool ended;
};

// Starts `stream` as the answer to `r`: the object is zeroed but for fill, destroy and its own
// members. Takes it always. Answers 503 when there are too many.
void glint_stream_start(struct glint_request *r, struct glint_stream *stream, const char *type);

// For `fill`: appends bytes; false without memory.
bool glint_stream_add(struct glint_stream *stream, const void *bytes, size_t size);

// Lets every idle stream look again. Any thread.
void glint_streams_kick(glint_http *http);

#endif
