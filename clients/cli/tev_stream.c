#include "tev_stream.h"

#include "interrupt.h"
#include "protocol/exr.h"
#include "protocol/multipart.h"
#include "tev.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_PART_BYTES (1u << 20)
#define STEP_MS 50
#define LAST_STEPS 60 // of them, until a viewer must have taken what is left

struct glint_tev_stream {
    struct glint_session *session;
    glint_tev *tev;
    glint_multipart_reader *reader;
    struct glint_request request;
    char *job, *path; // owned
    uint64_t last;    // sequence of the newest tile
    bool ended;       // the stream, by its last delimiter or for a fault
};

static glint_status take_part(void *user, const struct glint_multipart_head *head,
                              const uint8_t *body)
{
    glint_tev_stream *s = user;
    struct glint_frame *tile;
    struct glint_error err = {0};
    glint_status status = glint_exr_read(&tile, body, head->length, &err);
    if (!status) {
        status = glint_tev_take(s->tev, tile, &err);
        glint_frame_destroy(&tile);
    }
    if (status)
        glint_progress_note(&s->session->progress, "tev: %s", glint_error_text(&err));
    glint_error_finish(&err);
    s->last = head->sequence;
    return status;
}

static bool on_bytes(void *user, const void *bytes, size_t size)
{
    glint_tev_stream *s = user;
    struct glint_error err = {0};
    const glint_status status = glint_multipart_feed(s->reader, bytes, size, &err);
    glint_error_finish(&err);
    s->ended = status || glint_multipart_ended(s->reader);
    glint_tev_push(s->tev);
    return !s->ended;
}

static void on_idle(void *user)
{
    glint_tev_push(((glint_tev_stream *)user)->tev);
}

// From the newest tile on.
static glint_status begin(glint_tev_stream *s, struct glint_error *err)
{
    const struct glint_multipart_params params = {.content_type = GLINT_MULTIPART_TYPE,
                                                  .max_part_bytes = MAX_PART_BYTES,
                                                  .part = take_part,
                                                  .user = s};
    char since[24];
    snprintf(since, sizeof since, "%" PRIu64, s->last);
    glint_client_end(s->session->client);
    glint_multipart_reader_destroy(&s->reader);
    free(s->path);
    s->path = glint_client_query(glint_client_path("/v1/jobs/", s->job, "/tiles"), "since", since);
    if (!s->path)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory");
    const glint_status status = glint_multipart_reader_create(&s->reader, &params, err);
    s->request = (struct glint_request){
        .method = "GET", .path = s->path, .receive = on_bytes, .idle = on_idle, .user = s};
    return status ? status : glint_client_begin(s->session->client, &s->request, err);
}

glint_status glint_tev_stream_create(glint_tev_stream **out, struct glint_session *session,
                                     const char *address, const char *job, const char *name,
                                     struct glint_error *err)
{
    *out = NULL;
    glint_tev_stream *s = calloc(1, sizeof *s);
    if (!s || !(s->job = strdup(job))) {
        free(s);
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory");
    }
    s->session = session;
    glint_status status = glint_tev_create(&s->tev, address, name, err);
    session->usage |= status == GLINT_E_RANGE;
    if (!status)
        status = begin(s, err);
    if (status)
        glint_tev_stream_destroy(&s);
    *out = s;
    return status;
}

void glint_tev_stream_tend(glint_tev_stream *stream)
{
    struct glint_error err = {0};
    if (!stream || stream->ended || glint_client_runs(stream->session->client))
        return;
    stream->ended = begin(stream, &err) != GLINT_OK;
    glint_error_finish(&err);
}

// The stream ends a moment after the job; then the viewer may need another.
static void let_finish(glint_tev_stream *s)
{
    for (int i = 0; i < LAST_STEPS && !glint_interrupt_pending(); i++) {
        const bool runs = glint_client_runs(s->session->client);
        if (!runs && !glint_tev_behind(s->tev))
            break;
        if (runs)
            glint_client_wait(s->session->client, STEP_MS);
        else
            glint_interrupt_wait(-1, STEP_MS);
        glint_tev_push(s->tev);
    }
}

void glint_tev_stream_destroy(glint_tev_stream **stream)
{
    glint_tev_stream *s = *stream;
    *stream = NULL;
    if (!s)
        return;
    if (s->reader)
        let_finish(s);
    glint_client_end(s->session->client);
    glint_multipart_reader_destroy(&s->reader);
    glint_tev_destroy(&s->tev);
    free(s->path);
    free(s->job);
    free(s);
}
