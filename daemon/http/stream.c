#include "http/stream.h"

#include "base/clock.h"
#include "http/answer.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

#define BLOCK_BYTES 4096 // for clients that cannot take chunks; to others the library sends more
#define PING_SECONDS 15.0
// What the kernel keeps for a slow reader is old by the time it is read.
#define SOCKET_BYTES (64 * 1024)

// With s->mutex held. The stream may be freed as soon as the mutex is released.
static void resume(struct glint_stream *s)
{
    glint_http *h = s->http;
    s->idle = false;
    MHD_resume_connection(s->connection);
    glint_http_leave(h);
}

static bool suspend(struct glint_stream *s)
{
    if (!glint_http_enter(s->http))
        return false;
    s->idle = true;
    s->idle_since = glint_now();
    MHD_suspend_connection(s->connection);
    return true;
}

static size_t take_bytes(struct glint_stream *s, char *buffer, size_t size)
{
    const size_t left = s->part->size - s->sent, n = left < size ? left : size;
    memcpy(buffer, s->part->bytes + s->sent, n);
    s->sent += n;
    *s->bytes += n;
    if (n == left) {
        glint_blob_release(&s->part);
        s->sent = 0;
    }
    return n;
}

static enum glint_stream_next next_part(struct glint_stream *s)
{
    if (s->gone)
        return GLINT_STREAM_BROKEN;
    if (s->part)
        return GLINT_STREAM_PART;
    return glint_http_draining(s->http) ? GLINT_STREAM_END : s->read(s, &s->part);
}

static ssize_t read_stream(void *user, uint64_t position, char *buffer, size_t size)
{
    (void)position;
    struct glint_stream *s = user;
    enum glint_stream_next next = GLINT_STREAM_NOTHING;
    size_t n = 0;
    pthread_mutex_lock(&s->mutex);
    while (n < size && (next = next_part(s)) == GLINT_STREAM_PART)
        n += take_bytes(s, buffer + n, size - n);
    ssize_t result = (ssize_t)n; // what else there is shows at the next call
    if (!n && next == GLINT_STREAM_BROKEN)
        result = MHD_CONTENT_READER_END_WITH_ERROR;
    else if (!n && (next == GLINT_STREAM_END || !suspend(s)))
        result = MHD_CONTENT_READER_END_OF_STREAM;
    pthread_mutex_unlock(&s->mutex);
    return result;
}

static void client_left(void *user)
{
    struct glint_stream *s = user;
    pthread_mutex_lock(&s->mutex);
    s->gone = true;
    if (s->idle)
        resume(s);
    pthread_mutex_unlock(&s->mutex);
}

// Lists: with http->lists.

static void append(struct glint_stream *s)
{
    glint_http *h = s->http;
    s->next = NULL;
    s->previous = h->last_stream;
    *(h->last_stream ? &h->last_stream->next : &h->first_stream) = s;
    h->last_stream = s;
}

static void take_out(struct glint_stream *s)
{
    glint_http *h = s->http;
    *(s->previous ? &s->previous->next : &h->first_stream) = s->next;
    *(s->next ? &s->next->previous : &h->last_stream) = s->previous;
}

static void unlink_stream(struct glint_stream *s)
{
    glint_http *h = s->http;
    pthread_mutex_lock(&h->lists);
    take_out(s);
    h->streams--;
    atomic_fetch_sub(&h->readers, 1);
    pthread_mutex_unlock(&h->lists);
}

static void free_stream(struct glint_stream *s)
{
    pthread_mutex_destroy(&s->mutex);
    glint_blob_release(&s->part);
    s->destroy(s);
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
    free_stream(s);
}

static bool link_stream(struct glint_stream *s)
{
    glint_http *h = s->http;
    const uint32_t most = glint_http_limits(h).streams;
    pthread_mutex_lock(&h->lists);
    const bool room = h->streams < most && !glint_http_draining(h);
    if (room) {
        h->streams++;
        atomic_fetch_add(&h->readers, 1);
        append(s);
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
    free_stream(stream);
    glint_answer_empty(r, MHD_HTTP_OK);
    glint_answer_header(r, "Content-Type", "%s", type);
}

void glint_stream_start(struct glint_request *r, struct glint_stream *stream, const char *type)
{
    stream->http = r->http;
    stream->connection = r->connection;
    stream->client = r->client;
    pthread_mutex_init(&stream->mutex, NULL);
    if (r->head) {
        answer_head(r, stream, type);
        return;
    }
    if (!link_stream(stream)) {
        struct glint_error err = {0};
        glint_fail(&err, GLINT_E_BUSY, "", "too many streams are open, or the server stops");
        glint_answer_error(r, &err);
        free_stream(stream);
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
    r->streams = true;
    stream->bytes = &r->sent;
    glint_answer_header(r, "Content-Type", "%s", type);
    glint_answer_header(r, "Cache-Control", "no-store");
}

static bool wake(struct glint_stream *s)
{
    pthread_mutex_lock(&s->mutex);
    const bool idle = s->idle;
    if (idle)
        resume(s);
    pthread_mutex_unlock(&s->mutex);
    return idle;
}

// Wakes it unless it was for these news. False: that would be over the budget.
static bool wake_for(struct glint_stream *s, uint64_t news, unsigned *budget)
{
    pthread_mutex_lock(&s->mutex);
    const bool due = s->idle && s->seen != news, woken = due && *budget;
    if (woken) {
        s->seen = news;
        --*budget;
        resume(s);
    }
    pthread_mutex_unlock(&s->mutex);
    if (woken) {
        take_out(s);
        append(s);
    }
    return woken || !due;
}

bool glint_streams_wake(glint_http *http, const void *source, uint64_t news, unsigned *budget)
{
    bool left = false;
    pthread_mutex_lock(&http->lists);
    uint32_t count = http->streams; // those that are woken go to the end
    for (struct glint_stream *s = http->first_stream, *next; count-- && !left; s = next) {
        next = s->next;
        left = s->source == source && !wake_for(s, news, budget);
    }
    pthread_mutex_unlock(&http->lists);
    return left;
}

void glint_streams_wake_all(glint_http *http)
{
    pthread_mutex_lock(&http->lists);
    for (struct glint_stream *s = http->first_stream; s; s = s->next)
        wake(s);
    pthread_mutex_unlock(&http->lists);
}

static void ping(struct glint_stream *s, double now)
{
    pthread_mutex_lock(&s->mutex);
    if (s->idle && s->ping && now > s->idle_since + PING_SECONDS) {
        uint8_t *text = (uint8_t *)strdup(s->ping);
        s->part = text ? glint_blob_take(text, strlen(s->ping)) : NULL;
        resume(s);
    }
    pthread_mutex_unlock(&s->mutex);
}

void glint_streams_ping(glint_http *http)
{
    const double now = glint_now();
    pthread_mutex_lock(&http->lists);
    for (struct glint_stream *s = http->first_stream; s; s = s->next)
        ping(s, now);
    pthread_mutex_unlock(&http->lists);
}
