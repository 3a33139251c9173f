#include "http/stream.h"

#include "base/clock.h"
#include "http/answer.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

#define BLOCK_BYTES 32768
// What the kernel keeps for a slow reader is old by the time it is read.
#define SOCKET_BYTES (128 * 1024)

// With s->mutex held. The stream may be freed as soon as the mutex is released.
static void resume(struct glint_stream *s)
{
    glint_http *h = s->http;
    s->state = GLINT_STREAM_SENDING;
    MHD_resume_connection(s->connection);
    glint_http_leave(h);
}

static void fill(struct glint_task *task)
{
    struct glint_stream *s = (struct glint_stream *)task;
    s->length = s->sent = 0;
    const bool more = s->fill(s);
    if (s->length)
        s->filled_at = glint_now();
    pthread_mutex_lock(&s->mutex);
    s->ended |= !more || glint_http_draining(s->http);
    if (s->length || s->ended || s->gone) {
        resume(s);
    } else if (s->kicked) {
        s->kicked = false;
        glint_offload_push(s->http->lane[GLINT_LANE_STREAM], &s->task);
    } else {
        s->state = GLINT_STREAM_IDLE;
    }
    pthread_mutex_unlock(&s->mutex);
}

// The lane has room for every stream, so a push never fails.
static bool suspend_to_fill(struct glint_stream *s)
{
    if (!glint_http_enter(s->http))
        return false;
    s->state = GLINT_STREAM_FILLING;
    s->kicked = false;
    MHD_suspend_connection(s->connection);
    glint_offload_push(s->http->lane[GLINT_LANE_STREAM], &s->task);
    return true;
}

static ssize_t read_stream(void *user, uint64_t position, char *buffer, size_t size)
{
    (void)position;
    struct glint_stream *s = user;
    pthread_mutex_lock(&s->mutex);
    ssize_t n = (ssize_t)(s->length - s->sent);
    if (s->gone) {
        n = MHD_CONTENT_READER_END_WITH_ERROR;
    } else if (n) {
        n = n < (ssize_t)size ? n : (ssize_t)size;
        memcpy(buffer, s->bytes + s->sent, (size_t)n);
        s->sent += (size_t)n;
    } else if (s->ended || !suspend_to_fill(s)) {
        n = MHD_CONTENT_READER_END_OF_STREAM;
    }
    pthread_mutex_unlock(&s->mutex);
    return n;
}

static void client_left(void *user)
{
    struct glint_stream *s = user;
    pthread_mutex_lock(&s->mutex);
    s->gone = true;
    if (s->state == GLINT_STREAM_IDLE)
        resume(s);
    pthread_mutex_unlock(&s->mutex);
}

static void unlink_stream(struct glint_stream *s)
{
    glint_http *h = s->http;
    pthread_mutex_lock(&h->lists);
    *(s->previous ? &s->previous->next : &h->first_stream) = s->next;
    if (s->next)
        s->next->previous = s->previous;
    h->streams--;
    atomic_fetch_sub(&h->readers, 1);
    pthread_mutex_unlock(&h->lists);
}

// The library is done with the answer; the connection is not suspended.
static void end(void *user)
{
    struct glint_stream *s = user;
    glint_watch_attend(s->http->watch, s->client, NULL, NULL);
    unlink_stream(s);
    // Whoever resumed it may not have released the mutex yet.
    pthread_mutex_lock(&s->mutex);
    pthread_mutex_unlock(&s->mutex);
    pthread_mutex_destroy(&s->mutex);
    free(s->bytes);
    s->destroy(s);
}

static bool link_stream(struct glint_stream *s)
{
    glint_http *h = s->http;
    pthread_mutex_lock(&h->lists);
    const bool room = h->streams < h->limits.streams && !glint_http_draining(h);
    if (room) {
        h->streams++;
        atomic_fetch_add(&h->readers, 1);
        s->next = h->first_stream;
        if (s->next)
            s->next->previous = s;
        h->first_stream = s;
    }
    pthread_mutex_unlock(&h->lists);
    return room;
}

// A peer whose machine vanished answers no probe; then the system ends the connection.
static void set_socket(struct MHD_Connection *connection)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    const int fd = info->connect_fd, buffer = SOCKET_BYTES, on = 1, idle = 30, probes = 3;
    setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &buffer, sizeof buffer);
    setsockopt(fd, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
    setsockopt(fd, IPPROTO_TCP, TCP_KEEPIDLE, &idle, sizeof idle);
    setsockopt(fd, IPPROTO_TCP, TCP_KEEPINTVL, &idle, sizeof idle);
    setsockopt(fd, IPPROTO_TCP, TCP_KEEPCNT, &probes, sizeof probes);
}

// To HEAD the library would send the end of a body of unknown length, as if it had one.
static void answer_head(struct glint_request *r, struct glint_stream *stream, const char *type)
{
    stream->destroy(stream);
    glint_answer_empty(r, MHD_HTTP_OK);
    glint_answer_header(r, "Content-Type", "%s", type);
}

void glint_stream_start(struct glint_request *r, struct glint_stream *stream, const char *type)
{
    stream->task.run = fill;
    stream->http = r->http;
    stream->connection = r->connection;
    stream->client = r->client;
    stream->filled_at = glint_now();
    if (r->head) {
        answer_head(r, stream, type);
        return;
    }
    pthread_mutex_init(&stream->mutex, NULL);
    if (!link_stream(stream)) {
        struct glint_error err = {0};
        glint_fail(&err, GLINT_E_BUSY, "", "too many streams are open, or the server stops");
        glint_answer_error(r, &err);
        pthread_mutex_destroy(&stream->mutex);
        stream->destroy(stream);
        return;
    }
    set_socket(r->connection);
    struct MHD_Response *response =
        MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, BLOCK_BYTES, read_stream, stream, end);
    if (response)
        glint_watch_attend(r->http->watch, r->client, client_left, stream);
    glint_answer_response(r, MHD_HTTP_OK, response);
    if (!response) {
        end(stream);
        return;
    }
    glint_answer_header(r, "Content-Type", "%s", type);
    glint_answer_header(r, "Cache-Control", "no-store");
}

bool glint_stream_add(struct glint_stream *stream, const void *bytes, size_t size)
{
    if (stream->length + size > stream->capacity) {
        const size_t capacity = stream->length + size + BLOCK_BYTES;
        uint8_t *grown = realloc(stream->bytes, capacity);
        if (!grown)
            return false;
        stream->bytes = grown;
        stream->capacity = capacity;
    }
    memcpy(stream->bytes + stream->length, bytes, size);
    stream->length += size;
    return true;
}

void glint_streams_kick(glint_http *http)
{
    pthread_mutex_lock(&http->lists);
    for (struct glint_stream *s = http->first_stream; s; s = s->next) {
        pthread_mutex_lock(&s->mutex);
        if (s->state == GLINT_STREAM_IDLE) {
            s->state = GLINT_STREAM_FILLING;
            glint_offload_push(http->lane[GLINT_LANE_STREAM], &s->task);
        } else {
            s->kicked = true;
        }
        pthread_mutex_unlock(&s->mutex);
    }
    pthread_mutex_unlock(&http->lists);
}
