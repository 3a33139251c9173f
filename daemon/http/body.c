#include "http/answer.h"
#include "http/media.h"
#include "http/routes.h"

#include "base/clock.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define SPOOL_STEP ((size_t)1 << 20)
#define SLOWEST_RATE 16384.0            // bytes per second
#define DROPPED_BYTES ((size_t)1 << 20) // read past the limit so that the answer can be heard

// May be large.
static bool holds_scene(const struct glint_request *r)
{
    const enum glint_body_kind kind = r->route->body;
    return kind == GLINT_BODY_SCENE || kind == GLINT_BODY_SCENE_PATCH || kind == GLINT_BODY_ASSET;
}

size_t glint_body_limit(const struct glint_request *r)
{
    if (!r->route || r->route->body == GLINT_BODY_NONE)
        return 0;
    const struct glint_http_limits l = glint_http_limits(r->http);
    return holds_scene(r) ? l.scene_bytes : l.job_bytes;
}

static const char *const job_types[] = {"application/json", NULL};
static const char *const patch_types[] = {"application/merge-patch+json", "application/json", NULL};

// What the routes take; a scene without a type may tell by itself, an asset is whatever it is.
static const char *const *const accepted[] = {
    [GLINT_BODY_JOB] = job_types,
    [GLINT_BODY_PATCH] = patch_types,
    [GLINT_BODY_SCENE_PATCH] = patch_types,
    [GLINT_BODY_SCENE] = glint_media_scenes,
    [GLINT_BODY_ASSET] = NULL,
};

// Both the value of Accept and words of a sentence.
static void list_accepted(enum glint_body_kind kind, char *out, size_t size)
{
    *out = 0;
    for (int i = 0; accepted[kind][i]; i++) {
        const size_t used = strlen(out);
        snprintf(out + used, size - used, "%s%s", used ? ", " : "", accepted[kind][i]);
    }
}

static bool type_is_accepted(struct glint_request *r, const char *given)
{
    const enum glint_body_kind kind = r->route->body;
    if (!given || kind == GLINT_BODY_ASSET)
        return kind == GLINT_BODY_SCENE || kind == GLINT_BODY_ASSET;
    for (int i = 0; accepted[kind][i]; i++)
        if (glint_media_is(given, accepted[kind][i]))
            return true;
    return false;
}

static bool check_type(struct glint_request *r)
{
    const enum glint_body_kind kind = r->route->body;
    const char *given = glint_request_header(r, "Content-Type");
    const char *coding = glint_request_header(r, "Content-Encoding");
    struct glint_error err = {0};
    if (coding && strcasecmp(coding, "identity")) {
        glint_fail(&err, GLINT_E_MEDIA_TYPE, "", "Content-Encoding: %.40s is not taken", coding);
        glint_answer_error(r, &err);
        return false;
    }
    if (type_is_accepted(r, given))
        return true;
    char types[256];
    list_accepted(kind, types, sizeof types);
    glint_fail(&err, GLINT_E_MEDIA_TYPE, "", "Content-Type: %.80s is not one of %s",
               given ? given : "(none)", types);
    glint_answer_error(r, &err);
    glint_answer_header(r, "Accept", "%s", types);
    return false;
}

// Takes `bytes` from what all bodies together may hold.
static bool reserve(struct glint_request *r, size_t bytes)
{
    glint_http *h = r->http;
    pthread_mutex_lock(&h->mutex);
    const size_t most = h->limits.spool_bytes;
    const bool fits = h->spooled <= most && bytes <= most - h->spooled;
    if (fits) {
        h->spooled += bytes;
        r->body.reserved += bytes;
    }
    pthread_mutex_unlock(&h->mutex);
    return fits;
}

static void refuse(struct glint_request *r, glint_status status, const char *why)
{
    struct glint_error err = {0};
    glint_fail(&err, status, "", "%s", why);
    glint_answer_error(r, &err);
    r->close = true;
}

static void refuse_length(struct glint_request *r)
{
    struct glint_error err = {0};
    const size_t limit = glint_body_limit(r);
    if (limit)
        glint_fail(&err, GLINT_E_TOO_LARGE, "", "the body is over %zu bytes", limit);
    else
        glint_fail(&err, GLINT_E_TOO_LARGE, "", "this call takes no body");
    glint_answer_error(r, &err);
    r->close = true;
}

bool glint_body_accept(struct glint_request *r)
{
    const char *length = glint_request_header(r, "Content-Length");
    const unsigned long long bytes = length ? strtoull(length, NULL, 10) : 0;
    if (bytes > glint_body_limit(r)) {
        refuse_length(r);
        return false;
    }
    if (r->route->body == GLINT_BODY_NONE)
        return true;
    if (!check_type(r))
        return false;
    if (!reserve(r, bytes)) {
        refuse(r, GLINT_E_BUSY, "too many bodies are under way");
        return false;
    }
    if (holds_scene(r))
        r->body.fd = memfd_create("glint-body", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    if (holds_scene(r) && r->body.fd < 0)
        refuse(r, GLINT_E_CAPACITY, "no descriptor for the body");
    return !r->status;
}

static bool write_spool(struct glint_body *b, const char *bytes, size_t size)
{
    while (size) {
        const ssize_t n = write(b->fd, bytes, size);
        if (n < 0 && errno != EINTR)
            return false;
        if (n > 0) {
            bytes += n;
            size -= (size_t)n;
            b->length += (size_t)n;
        }
    }
    return true;
}

static bool append(struct glint_body *b, const char *bytes, size_t size)
{
    if (b->fd >= 0)
        return write_spool(b, bytes, size);
    if (b->length + size > b->capacity) {
        const size_t capacity = 2 * (b->length + size);
        uint8_t *grown = realloc(b->bytes, capacity);
        if (!grown)
            return false;
        b->bytes = grown;
        b->capacity = capacity;
    }
    memcpy(b->bytes + b->length, bytes, size);
    b->length += size;
    return true;
}

// A body that is refused while it arrives can be answered only at its end: a little of the rest is
// read for that, then the connection is closed.
static bool drop(struct glint_request *r, size_t size)
{
    r->body.over = true;
    r->body.length += size;
    return r->body.length < glint_body_limit(r) + DROPPED_BYTES;
}

bool glint_body_add(struct glint_request *r, const char *bytes, size_t size)
{
    struct glint_body *b = &r->body;
    const double patience = GLINT_BODY_SECONDS + (double)(b->length + size) / SLOWEST_RATE;
    glint_watch_deadline(r->http->watch, r->client, r->started + patience - glint_now());
    if (b->over)
        return drop(r, size);
    if (b->length + size > glint_body_limit(r)) {
        refuse_length(r);
        return drop(r, size);
    }
    const size_t total = b->length + size, ahead = total + SPOOL_STEP, limit = glint_body_limit(r);
    if (total > b->reserved && !reserve(r, (ahead < limit ? ahead : limit) - b->reserved)) {
        refuse(r, GLINT_E_BUSY, "too many bodies are under way");
        return drop(r, size);
    }
    if (append(b, bytes, size))
        return true;
    refuse(r, GLINT_E_NOMEM, "no memory for the body");
    return drop(r, size);
}

bool glint_body_finish(struct glint_request *r)
{
    struct glint_body *b = &r->body;
    if (b->over || b->fd < 0 || !b->length)
        return !b->over;
    void *map = mmap(NULL, b->length, PROT_READ, MAP_PRIVATE, b->fd, 0);
    if (map == MAP_FAILED) {
        refuse(r, GLINT_E_NOMEM, "no address space for the body");
        return false;
    }
    b->bytes = map;
    return true;
}

void glint_body_free(struct glint_request *r)
{
    struct glint_body *b = &r->body;
    if (b->fd >= 0 && b->bytes)
        munmap(b->bytes, b->length);
    else
        free(b->bytes);
    if (b->fd >= 0)
        close(b->fd);
    pthread_mutex_lock(&r->http->mutex);
    r->http->spooled -= b->reserved;
    pthread_mutex_unlock(&r->http->mutex);
    *b = (struct glint_body){.fd = -1};
}
