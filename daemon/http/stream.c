#include "http/stream.h"

#include "base/clock.h"
#include "http/answer.h"

#include <errno.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/uio.h>

#define BLOCK_BYTES 4096 // for clients that cannot take chunks; to others the library sends more
#define MOST_PARTS 16    // for one client before it is the next one's turn
#define SERVED_AT_ONCE 8 // streams, before others may have the lists
// What the kernel keeps for a slow reader is old by the time it is read.
#define SOCKET_BYTES (64 * 1024)

enum outcome { IDLE, BLOCKED, MORE, OVER };

// With the stream's mutex, up to where it says otherwise.

// The stream may be freed as soon as the mutex is released.
static void resume(struct glint_stream *s)
{
    glint_http *h = s->http;
    s->suspended = false;
    MHD_resume_connection(s->connection);
    glint_http_leave(h);
}

static bool suspend(struct glint_stream *s)
{
    if (!glint_http_enter(s->http))
        return false;
    s->suspended = true;
    s->since = glint_now();
    MHD_suspend_connection(s->connection);
    return true;
}

static enum glint_stream_next next_part(struct glint_stream *s)
{
    if (s->gone)
        return GLINT_STREAM_BROKEN;
    if (s->part)
        return GLINT_STREAM_PART;
    return glint_http_draining(s->http) ? GLINT_STREAM_END : s->read(s, &s->part);
}

// Through the library.

static size_t take_bytes(struct glint_stream *s, char *buffer, size_t size)
{
    const size_t left = s->part->size - s->sent, n = left < size ? left : size;
    memcpy(buffer, s->part->bytes + s->sent, n);
    s->sent += n;
    s->request->sent += n;
    if (n == left) {
        glint_blob_release(&s->part);
        s->sent = 0;
    }
    return n;
}

static ssize_t give_bytes(struct glint_stream *s, char *buffer, size_t size)
{
    enum glint_stream_next next = GLINT_STREAM_NOTHING;
    size_t n = 0;
    while (n < size && (next = next_part(s)) == GLINT_STREAM_PART)
        n += take_bytes(s, buffer + n, size - n);
    if (n) // what else there is shows at the next call
        return (ssize_t)n;
    if (next == GLINT_STREAM_BROKEN)
        return MHD_CONTENT_READER_END_WITH_ERROR;
    return next == GLINT_STREAM_NOTHING && suspend(s) ? 0 : MHD_CONTENT_READER_END_OF_STREAM;
}

// To the socket.

// Sets the chunk's head, or what ends the body. False: there is nothing to send now, *next says why.
static bool begin_chunk(struct glint_stream *s, enum glint_stream_next *next)
{
    *next = s->closing ? GLINT_STREAM_END : next_part(s);
    if (*next == GLINT_STREAM_PART)
        snprintf(s->head, sizeof s->head, "%zx\r\n", s->part->size);
    else if (*next == GLINT_STREAM_END && !s->closing)
        strcpy(s->head, "0\r\n");
    else
        return false;
    s->closing = *next == GLINT_STREAM_END;
    s->sent = 0;
    return true;
}

// What is left of the chunk, whose pieces are head, part and line break.
static size_t list_pieces(const struct glint_stream *s, struct iovec piece[3])
{
    const struct iovec all[3] = {{(void *)s->head, strlen(s->head)},
                                 {s->part ? s->part->bytes : NULL, s->part ? s->part->size : 0},
                                 {(void *)"\r\n", 2}};
    size_t skip = s->sent, n = 0;
    for (int i = 0; i < 3; i++) {
        const size_t step = skip < all[i].iov_len ? skip : all[i].iov_len;
        skip -= step;
        if (step < all[i].iov_len)
            piece[n++] = (struct iovec){(char *)all[i].iov_base + step, all[i].iov_len - step};
    }
    return n;
}

// Sends of the chunk what the socket takes.
static enum outcome send_chunk(struct glint_stream *s)
{
    struct iovec piece[3];
    const size_t pieces = list_pieces(s, piece);
    const struct msghdr message = {.msg_iov = piece, .msg_iovlen = pieces};
    size_t left = 0;
    for (size_t i = 0; i < pieces; i++)
        left += piece[i].iov_len;
    const ssize_t n = sendmsg(s->fd, &message, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n < 0)
        return errno == EAGAIN ? BLOCKED : OVER;
    s->sent += (size_t)n;
    s->request->sent += (size_t)n;
    if ((size_t)n < left)
        return BLOCKED;
    *s->head = 0;
    glint_blob_release(&s->part);
    s->request->whole = s->closing;
    return MORE;
}

static enum outcome send_some(struct glint_stream *s)
{
    for (int i = 0; i < MOST_PARTS; i++) {
        enum glint_stream_next next;
        if (s->gone)
            return OVER;
        if (!*s->head && !begin_chunk(s, &next))
            return next == GLINT_STREAM_NOTHING ? IDLE : OVER;
        const enum outcome outcome = send_chunk(s);
        if (outcome != MORE)
            return outcome;
    }
    return MORE;
}

// Sends what there is. The stream may be freed as soon as the mutex is released.
static void serve(struct glint_stream *s, uint64_t news)
{
    const enum outcome outcome = send_some(s);
    s->seen = outcome == MORE ? 0 : news;
    s->blocked = outcome == BLOCKED;
    s->since = glint_now();
    if (outcome == OVER) {
        s->gone = true;
        resume(s);
    }
}

// Without the mutex.

// The library's first call comes when the header has been sent, the next ones after the stream is
// over.
static ssize_t take_over(struct glint_stream *s)
{
    const int off = 0, on = 1;
    if (s->gone || !suspend(s))
        return MHD_CONTENT_READER_END_WITH_ERROR;
    setsockopt(s->fd, IPPROTO_TCP, TCP_CORK, &off, sizeof off);
    setsockopt(s->fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    serve(s, 0);
    return 0;
}

static ssize_t read_stream(void *user, uint64_t position, char *buffer, size_t size)
{
    (void)position;
    struct glint_stream *s = user;
    pthread_mutex_lock(&s->mutex);
    const ssize_t result = s->fd < 0 ? give_bytes(s, buffer, size) : take_over(s);
    pthread_mutex_unlock(&s->mutex);
    return result;
}

static void client_left(void *user)
{
    struct glint_stream *s = user;
    pthread_mutex_lock(&s->mutex);
    s->gone = true;
    if (s->suspended)
        resume(s);
    pthread_mutex_unlock(&s->mutex);
}

// The next round serves it in its turn.
static void client_reads(void *user)
{
    struct glint_stream *s = user;
    pthread_mutex_lock(&s->mutex);
    if (s->blocked)
        s->seen = 0;
    s->blocked = false;
    pthread_mutex_unlock(&s->mutex);
}

// Lists: with http->lists.

static void append(struct glint_stream *s)
{
    glint_http *h = s->http;
    struct glint_stream *last = h->streams[s->kind].last;
    s->next = NULL;
    s->previous = last;
    *(last ? &last->next : &h->streams[s->kind].first) = s;
    h->streams[s->kind].last = s;
    h->streams[s->kind].count++;
}

static void take_out(struct glint_stream *s)
{
    glint_http *h = s->http;
    *(s->previous ? &s->previous->next : &h->streams[s->kind].first) = s->next;
    *(s->next ? &s->next->previous : &h->streams[s->kind].last) = s->previous;
    h->streams[s->kind].count--;
}

static void unlink_stream(struct glint_stream *s)
{
    glint_http *h = s->http;
    pthread_mutex_lock(&h->lists);
    take_out(s);
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
    glint_watch_attend(s->http->watch, s->client, NULL, NULL, NULL);
    unlink_stream(s);
    // Whoever resumed it may not have released the mutex yet.
    pthread_mutex_lock(&s->mutex);
    pthread_mutex_unlock(&s->mutex);
    free_stream(s);
}

static bool link_stream(struct glint_stream *s)
{
    glint_http *h = s->http;
    uint32_t count = 0;
    pthread_mutex_lock(&h->lists);
    for (int k = 0; k < GLINT_STREAM_KINDS; k++)
        count += h->streams[k].count;
    const bool room = count < glint_http_limits(h).streams && !glint_http_draining(h);
    if (room) {
        atomic_fetch_add(&h->readers, 1);
        append(s);
    }
    pthread_mutex_unlock(&h->lists);
    return room;
}

// A peer whose machine vanished answers no probe; then the system ends the connection.
static void set_socket(int fd)
{
    const int buffer = SOCKET_BYTES, on = 1, idle = 30, probes = 3;
    setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &buffer, sizeof buffer);
    setsockopt(fd, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
    setsockopt(fd, IPPROTO_TCP, TCP_KEEPIDLE, &idle, sizeof idle);
    setsockopt(fd, IPPROTO_TCP, TCP_KEEPINTVL, &idle, sizeof idle);
    setsockopt(fd, IPPROTO_TCP, TCP_KEEPCNT, &probes, sizeof probes);
}

// The socket, where what is written to it is what the client reads; else -1.
static int choose_socket(struct glint_request *r)
{
    const union MHD_ConnectionInfo *tls =
        MHD_get_connection_info(r->connection, MHD_CONNECTION_INFO_GNUTLS_SESSION);
    const int fd =
        MHD_get_connection_info(r->connection, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd;
    set_socket(fd);
    return tls || r->http10 ? -1 : fd;
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
    stream->fd = choose_socket(r);
    r->close |= stream->fd >= 0;
    struct MHD_Response *response =
        MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, BLOCK_BYTES, read_stream, stream, end);
    if (response)
        glint_watch_attend(r->http->watch, r->client, client_left, client_reads, stream);
    glint_answer_response(r, MHD_HTTP_OK, response);
    if (!response) {
        end(stream);
        return;
    }
    r->streams = true;
    stream->request = r;
    glint_answer_header(r, "Content-Type", "%s", type);
    glint_answer_header(r, "Cache-Control", "no-store");
}

// With the mutex: whether there may be something to send, and somebody who takes it.
static bool due(const struct glint_stream *s, uint64_t news)
{
    return s->suspended && !s->blocked && s->seen != news;
}

// True where it has to be served again.
static bool serve_for(struct glint_stream *s, uint64_t news)
{
    if (s->fd >= 0) {
        serve(s, news);
        return due(s, news);
    }
    s->seen = news;
    resume(s);
    return false;
}

// Serves it if that is due. Returns true if it is still due afterwards.
static bool serve_if_due(struct glint_stream *s)
{
    const uint64_t news = atomic_load_explicit(s->news, memory_order_acquire);
    pthread_mutex_lock(&s->mutex);
    const bool left = due(s, news) && serve_for(s, news);
    pthread_mutex_unlock(&s->mutex);
    return left;
}

// Serves the next few, who live as long as the lists are held, and moves them to the end.
static bool serve_some(glint_http *http, enum glint_stream_kind kind, const glint_stream_news *news,
                       double until, uint32_t count)
{
    bool left = false;
    struct glint_stream *s;
    pthread_mutex_lock(&http->lists);
    while (count-- && (s = http->streams[kind].first) && glint_now() < until) {
        left |= (!news || s->news == news) && serve_if_due(s);
        take_out(s);
        append(s);
    }
    pthread_mutex_unlock(&http->lists);
    return left;
}

bool glint_streams_serve(glint_http *http, enum glint_stream_kind kind,
                         const glint_stream_news *news, double until)
{
    bool left = false;
    pthread_mutex_lock(&http->lists);
    uint32_t count = http->streams[kind].count;
    pthread_mutex_unlock(&http->lists);
    for (uint32_t n; count; count -= n) {
        n = count < SERVED_AT_ONCE ? count : SERVED_AT_ONCE;
        left |= serve_some(http, kind, news, until, n);
        if (glint_now() >= until)
            return true;
    }
    return left;
}

static void call_each(struct glint_stream *s, void (*call)(struct glint_stream *s, double now))
{
    const double now = glint_now();
    for (; s; s = s->next) {
        pthread_mutex_lock(&s->mutex);
        if (s->suspended)
            call(s, now);
        pthread_mutex_unlock(&s->mutex);
    }
}

static void call_all(glint_http *http, void (*call)(struct glint_stream *s, double now))
{
    pthread_mutex_lock(&http->lists);
    for (int k = 0; k < GLINT_STREAM_KINDS; k++)
        call_each(http->streams[k].first, call);
    pthread_mutex_unlock(&http->lists);
}

static void wake(struct glint_stream *s, double now)
{
    (void)now;
    if (s->fd < 0)
        resume(s);
    else if (!s->blocked)
        serve(s, s->seen);
}

void glint_streams_wake_all(glint_http *http)
{
    call_all(http, wake);
}

static void abort_stream(struct glint_stream *s, double now)
{
    (void)now;
    s->gone = true;
    resume(s);
}

void glint_streams_abort(glint_http *http)
{
    call_all(http, abort_stream);
}

static void look_after(struct glint_stream *s, double now)
{
    if (s->blocked && now > s->since + glint_http_limits(s->http).idle_seconds) {
        abort_stream(s, now);
    } else if (!s->blocked && !s->part && s->ping &&
               now > s->since + glint_http_limits(s->http).ping_seconds) {
        uint8_t *text = (uint8_t *)strdup(s->ping);
        s->part = text ? glint_blob_take(text, strlen(s->ping)) : NULL;
        wake(s, now);
    }
}

void glint_streams_look_after(glint_http *http)
{
    call_all(http, look_after);
}
