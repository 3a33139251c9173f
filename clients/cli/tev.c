#include "tev.h"

#include "tev_packet.h"

#include <errno.h>
#include <linux/sockios.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#define CHANNELS 4
#define RETRY_SECONDS 0.5
#define SOCKET_BYTES (4 << 20) // asked for; the system may give less

static const char *const channel_name[CHANNELS] = {"R", "G", "B", "A"};

struct tile {
    int32_t rect[4];
    bool due; // the viewer does not have it
};

struct glint_tev {
    struct addrinfo *address, *next; // all, and the one to try
    char *name;
    int fd;          // -1: not connected
    bool connecting; // the connection is not there yet
    bool created;    // the viewer has the image
    bool was_there;  // it may still have the one of an earlier connection
    double retry_at;
    struct glint_tev_packet packet;

    uint32_t width, height;
    float *plane[CHANNELS]; // [height][width], NULL before the first tile
    struct tile *tile;
    size_t tiles, capacity;
};

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

// Cuts HOST[:PORT] in place; an IPv6 address stands in brackets. False: it is neither.
static bool cut_address(char *text, char **host, const char **port)
{
    *host = text;
    *port = GLINT_TEV_PORT;
    char *end = text + strcspn(text, ":");
    if (*text == '[') {
        *host = text + 1;
        end = strchr(text, ']');
        if (!end)
            return false;
        *end++ = '\0';
    }
    if (*end && *end != ':')
        return false;
    if (*end) {
        *end = '\0';
        *port = end + 1;
    }
    const size_t digits = strspn(*port, "0123456789");
    return **host && digits >= 1 && digits <= 5 && !(*port)[digits];
}

static glint_status resolve(glint_tev *t, const char *address, struct glint_error *err)
{
    const struct addrinfo hints = {.ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM};
    char *text = strdup(address), *host;
    const char *port;
    glint_status status = GLINT_OK;
    if (!text)
        status = glint_fail(err, GLINT_E_NOMEM, "", "no memory");
    else if (!cut_address(text, &host, &port))
        status = glint_fail(err, GLINT_E_RANGE, "", "'%s' is no HOST or HOST:PORT", address);
    else if (getaddrinfo(host, port, &hints, &t->address))
        status = glint_fail(err, GLINT_E_UNAVAILABLE, "", "'%s' is not known", host);
    free(text);
    return status;
}

glint_status glint_tev_create(glint_tev **out, const char *address, const char *name,
                              struct glint_error *err)
{
    *out = NULL;
    glint_tev *t = calloc(1, sizeof *t);
    if (!t)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for an image");
    t->fd = -1;
    t->name = strdup(name);
    const glint_status status =
        t->name ? resolve(t, address, err) : glint_fail(err, GLINT_E_NOMEM, "", "no memory");
    if (status)
        glint_tev_destroy(&t);
    *out = t;
    return status;
}

static void disconnect(glint_tev *t)
{
    if (t->fd >= 0)
        close(t->fd);
    t->fd = -1;
    t->created = t->connecting = false;
    t->retry_at = now() + RETRY_SECONDS;
}

void glint_tev_destroy(glint_tev **tev)
{
    glint_tev *t = *tev;
    *tev = NULL;
    if (!t)
        return;
    disconnect(t);
    if (t->address)
        freeaddrinfo(t->address);
    glint_tev_packet_finish(&t->packet);
    for (int c = 0; c < CHANNELS; c++)
        free(t->plane[c]);
    free(t->tile);
    free(t->name);
    free(t);
}

// Taking

static bool allocate(glint_tev *t, uint32_t width, uint32_t height)
{
    bool ok = true;
    for (int c = 0; c < CHANNELS; c++)
        ok &= (t->plane[c] = calloc((size_t)width * height, sizeof(float))) != NULL;
    t->width = width;
    t->height = height;
    return ok;
}

static glint_status check(const glint_tev *t, const struct glint_frame *f, struct glint_error *err)
{
    const bool same = f->display_width == t->width && f->display_height == t->height;
    const bool inside = f->x >= 0 && f->y >= 0 && (uint64_t)f->x + f->width <= t->width &&
                        (uint64_t)f->y + f->height <= t->height;
    bool complete = true;
    for (int c = 0; c < CHANNELS; c++)
        complete &= glint_frame_find(f, channel_name[c]) != NULL;
    return same && inside && complete
               ? GLINT_OK
               : glint_fail(err, GLINT_E_RANGE, "", "a tile is not of the image of %ux%u", t->width,
                            t->height);
}

static struct tile *find_tile(glint_tev *t, const struct glint_frame *f)
{
    const int32_t rect[4] = {f->x, f->y, (int32_t)f->width, (int32_t)f->height};
    for (size_t i = 0; i < t->tiles; i++)
        if (!memcmp(t->tile[i].rect, rect, sizeof rect))
            return &t->tile[i];
    if (t->tiles == t->capacity) {
        const size_t capacity = 2 * t->capacity + 64;
        struct tile *grown = realloc(t->tile, capacity * sizeof *grown);
        if (!grown)
            return NULL;
        t->tile = grown;
        t->capacity = capacity;
    }
    struct tile *tile = &t->tile[t->tiles++];
    *tile = (struct tile){.due = true};
    memcpy(tile->rect, rect, sizeof rect);
    return tile;
}

// True if any pixel is another.
static bool copy_pixels(glint_tev *t, const struct glint_frame *f)
{
    bool changed = false;
    for (int c = 0; c < CHANNELS; c++) {
        const float *from = glint_frame_find(f, channel_name[c]);
        for (uint32_t y = 0; y < f->height; y++) {
            float *to = t->plane[c] + ((size_t)f->y + y) * t->width + f->x;
            changed |= memcmp(to, from + (size_t)y * f->width, f->width * sizeof *to) != 0;
            memcpy(to, from + (size_t)y * f->width, f->width * sizeof *to);
        }
    }
    return changed;
}

glint_status glint_tev_take(glint_tev *tev, const struct glint_frame *tile, struct glint_error *err)
{
    if (!tev->plane[0] && !allocate(tev, tile->display_width, tile->display_height))
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for an image of %ux%u",
                          tile->display_width, tile->display_height);
    const glint_status status = check(tev, tile, err);
    if (status)
        return status;
    struct tile *kept = find_tile(tev, tile);
    if (!kept)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a tile");
    kept->due |= copy_pixels(tev, tile);
    return GLINT_OK;
}

// Sending

// A name may stand for several addresses, of which one has the viewer.
static void try_next(glint_tev *t)
{
    disconnect(t);
    if (t->next)
        t->retry_at = now();
}

static void start_connecting(glint_tev *t)
{
    const struct addrinfo *a = t->next ? t->next : t->address;
    const int bytes = SOCKET_BYTES, on = 1;
    t->next = a->ai_next;
    t->fd = socket(a->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (t->fd < 0) {
        try_next(t);
        return;
    }
    setsockopt(t->fd, SOL_SOCKET, SO_SNDBUF, &bytes, sizeof bytes);
    setsockopt(t->fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    t->connecting = true;
    if (connect(t->fd, a->ai_addr, a->ai_addrlen) && errno != EINPROGRESS)
        try_next(t);
}

// A new connection: the viewer has nothing of the image yet.
static void finish_connecting(glint_tev *t)
{
    struct pollfd p = {.fd = t->fd, .events = POLLOUT};
    int failure = 0;
    socklen_t size = sizeof failure;
    if (poll(&p, 1, 0) != 1)
        return;
    if (getsockopt(t->fd, SOL_SOCKET, SO_ERROR, &failure, &size) || failure) {
        try_next(t);
        return;
    }
    t->connecting = false;
    t->next = NULL;
    for (size_t i = 0; i < t->tiles; i++)
        t->tile[i].due = true;
}

static bool viewer_left(const glint_tev *t)
{
    char unexpected[256];
    ssize_t n;
    while ((n = recv(t->fd, unexpected, sizeof unexpected, 0)) > 0) {
    }
    return !n || (errno != EAGAIN && errno != EINTR);
}

// Whether a packet of that size surely fits into what the system keeps for the viewer.
static bool has_room(const glint_tev *t, size_t size)
{
    int queued = 0, most = 0;
    socklen_t length = sizeof most;
    if (ioctl(t->fd, SIOCOUTQ, &queued) || getsockopt(t->fd, SOL_SOCKET, SO_SNDBUF, &most, &length))
        return false;
    return !queued || 2 * ((size_t)queued + size) < (size_t)most;
}

// False: not now, or not any more. A packet that was cut cannot be taken back.
static bool send_packet(glint_tev *t)
{
    const struct glint_tev_packet *p = &t->packet;
    if (!has_room(t, p->size))
        return false;
    const ssize_t n = send(t->fd, p->bytes, p->size, MSG_NOSIGNAL);
    if (n == (ssize_t)p->size)
        return true;
    if (n >= 0 || (errno != EAGAIN && errno != EINTR))
        disconnect(t);
    return false;
}

// What the viewer may still show of an earlier connection would stand beside the new image.
static bool create_image(glint_tev *t)
{
    if (t->was_there && !(glint_tev_write_close(&t->packet, t->name) && send_packet(t)))
        return false;
    t->was_there = false;
    t->created = glint_tev_write_create(&t->packet, true, t->name, (int32_t)t->width,
                                        (int32_t)t->height, CHANNELS, channel_name) &&
                 send_packet(t);
    t->was_there = t->created;
    return t->created;
}

static bool send_tile(glint_tev *t, struct tile *tile)
{
    const float *plane[CHANNELS];
    for (int c = 0; c < CHANNELS; c++)
        plane[c] = t->plane[c] + (size_t)tile->rect[1] * t->width + tile->rect[0];
    tile->due = !(glint_tev_write_update(&t->packet, t->name, tile->rect, CHANNELS, channel_name,
                                         plane, t->width) &&
                  send_packet(t));
    return !tile->due;
}

void glint_tev_push(glint_tev *tev)
{
    if (!tev->plane[0])
        return;
    if (tev->fd < 0 && now() >= tev->retry_at)
        start_connecting(tev);
    if (tev->fd >= 0 && tev->connecting)
        finish_connecting(tev);
    if (tev->fd < 0 || tev->connecting)
        return;
    if (viewer_left(tev)) {
        disconnect(tev);
        return;
    }
    if (!tev->created && !create_image(tev))
        return;
    for (size_t i = 0; i < tev->tiles; i++)
        if (tev->tile[i].due && !send_tile(tev, &tev->tile[i]))
            return;
}

bool glint_tev_behind(const glint_tev *tev)
{
    bool due = false;
    for (size_t i = 0; i < tev->tiles; i++)
        due |= tev->tile[i].due;
    return tev->fd >= 0 && !tev->connecting && due;
}
