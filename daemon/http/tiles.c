// tiles.c - GET /v1/jobs/{id}/tiles.
//
// A client's cursor is one number, the sequence of the last tile it was sent. A tile's sequence is
// version * tiles + index: versions come from one counter of the render, and the index tells apart
// tiles that changed together. What is sent next is the smallest sequence above the cursor; those
// that were superseded in between are never seen.
#include "base/log.h"
#include "http/answer.h"
#include "http/frames.h"
#include "http/resources.h"
#include "http/stream.h"
#include "protocol/exr.h"
#include "protocol/multipart.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BATCH_BYTES 65536 // what a slow reader may find outdated
#define ZIP_LEVEL 4

struct tiles {
    struct glint_stream stream;
    char job[GLINT_JOB_ID_BYTES];
    uint64_t cursor;
};

static int by_value(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return x < y ? -1 : x > y;
}

// Sequences above the cursor, ascending; malloc'd, NULL without memory.
static uint64_t *list_news(const glint_render *render, uint64_t cursor, size_t *count)
{
    const uint32_t tiles = glint_render_tiles(render);
    uint64_t *news = malloc((tiles + 1) * sizeof *news);
    *count = 0;
    for (uint32_t t = 0; news && t < tiles; t++) {
        const uint64_t version = glint_render_tile_version(render, t);
        if (version && version * tiles + t > cursor)
            news[(*count)++] = version * tiles + t;
    }
    if (news)
        qsort(news, *count, sizeof *news, by_value);
    return news;
}

static glint_status encode_tile(const struct glint_job_view *view, uint32_t tile, uint8_t **bytes,
                                struct glint_multipart_head *head, struct glint_error *err)
{
    static const struct glint_exr_options options = {
        .compression = GLINT_EXR_ZIP, .layout = GLINT_EXR_SINGLE, .zip_level = ZIP_LEVEL};
    struct glint_frame *frame = NULL;
    uint64_t version;
    uint32_t samples = 0;
    size_t size = 0;
    glint_status st =
        glint_render_tile(view->render, tile, &frame, &samples, &version, head->revision, err);
    if (!st)
        st = glint_exr_write(frame, &options, bytes, &size, NULL, err);
    head->length = size;
    head->samples = samples;
    glint_frame_destroy(&frame);
    return st;
}

// Head and body as one. Takes `body`; NULL without memory.
static struct glint_blob *join(const struct glint_multipart_head *head, uint8_t *body)
{
    char text[GLINT_MULTIPART_HEAD_BYTES];
    const size_t length = glint_multipart_write_head(text, head);
    uint8_t *bytes = realloc(body, length + head->length);
    if (!bytes) {
        free(body);
        return NULL;
    }
    memmove(bytes + length, bytes, head->length);
    memcpy(bytes, text, length);
    return glint_blob_take(bytes, length + head->length);
}

// The part at the cursor, NULL where the tile has no samples any more, because a live job has just
// moved. False: the stream has to end.
static bool make_part(struct tiles *s, const struct glint_job_view *view, struct glint_blob **out)
{
    const uint32_t tile = (uint32_t)(s->cursor % glint_render_tiles(view->render));
    struct glint_multipart_head head = {
        .type = "image/x-exr", .has_tile = true, .sequence = s->cursor};
    struct glint_error err = {0};
    uint8_t *body = NULL;
    if (encode_tile(view, tile, &body, &head, &err)) {
        glint_log(GLINT_LOG_WARNING, "http", s->job, NULL, "tile stream ends: %s",
                  glint_error_text(&err));
        glint_error_finish(&err);
        return false;
    }
    if (!head.samples) {
        free(body);
        return true;
    }
    glint_render_tile_rect(view->render, tile, head.tile);
    *out = join(&head, body);
    return *out;
}

// Several clients of one job are sent the same parts: each is made once.
static bool add_part(struct tiles *s, const struct glint_job_view *view)
{
    glint_frames *parts = s->stream.http->parts;
    char key[64];
    snprintf(key, sizeof key, "%s %llu", s->job, (unsigned long long)s->cursor);
    struct glint_blob *part = glint_frames_find(parts, key);
    bool more = true;
    if (!part && (more = make_part(s, view, &part)) && part)
        glint_frames_keep(parts, key, part);
    if (part)
        more = glint_stream_add(&s->stream, part->bytes, part->size);
    glint_blob_release(&part);
    return more;
}

// False: the stream ends.
static bool add_tiles(struct tiles *s, const struct glint_job_view *view)
{
    size_t count, sent = 0;
    uint64_t *news = list_news(view->render, s->cursor, &count);
    bool more = news;
    while (more && sent < count && s->stream.length < BATCH_BYTES) {
        // Not the version that is read: a newer one comes in its turn, after the tiles between.
        s->cursor = news[sent++];
        more = add_part(s, view);
    }
    free(news);
    if (!more || sent < count || view->state < GLINT_JOB_DONE)
        return more;
    glint_stream_add(&s->stream, GLINT_MULTIPART_END, strlen(GLINT_MULTIPART_END));
    return false;
}

static bool fill(struct glint_stream *stream)
{
    struct tiles *s = (struct tiles *)stream;
    struct glint_job_view view;
    const glint_status st = glint_jobs_view(stream->http->jobs, s->job, &view, NULL);
    if (st)
        return st == GLINT_E_BUSY;
    const bool more = view.render ? add_tiles(s, &view) : view.state < GLINT_JOB_DONE;
    glint_jobs_release(stream->http->jobs, &view);
    return more;
}

static void destroy(struct glint_stream *stream)
{
    free(stream);
}

// Whether there is such a job, with or without pixels yet.
static bool check_job(struct glint_request *r, struct glint_error *err)
{
    struct glint_job_view view;
    const glint_status st = glint_jobs_view(r->http->jobs, r->argument[0], &view, err);
    if (!st)
        glint_jobs_release(r->http->jobs, &view);
    if (st == GLINT_E_BUSY)
        glint_error_finish(err);
    return !st || st == GLINT_E_BUSY;
}

void glint_http_tiles_stream(struct glint_request *r)
{
    struct glint_error err = {0};
    uint64_t since = 0;
    glint_query_check(r, &err);
    glint_query_integer(r, "since", UINT64_MAX, &since, &err);
    if (err.count || !check_job(r, &err)) {
        glint_answer_error(r, &err);
        return;
    }
    struct tiles *s = calloc(1, sizeof *s);
    if (!s) {
        glint_answer_response(r, 0, NULL);
        return;
    }
    s->stream.fill = fill;
    s->stream.destroy = destroy;
    s->cursor = since;
    strcpy(s->job, r->argument[0]); // it is a job's
    glint_stream_start(r, &s->stream, GLINT_MULTIPART_TYPE);
}
