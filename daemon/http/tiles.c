// tiles.c - GET /v1/jobs/{id}/tiles.
//
// A client's cursor is one number, the sequence of the last tile it was sent. What is sent next is
// the smallest sequence above it; those that were superseded in between are never seen.
#include "http/answer.h"
#include "http/board.h"
#include "http/resources.h"
#include "http/stream.h"
#include "protocol/multipart.h"

#include <stdlib.h>
#include <string.h>

struct tiles {
    struct glint_stream stream;
    struct glint_board *board;
    uint64_t cursor;
    bool over; // the last delimiter was given
};

static enum glint_stream_next give_end(struct tiles *s, struct glint_blob **part)
{
    if (s->over)
        return GLINT_STREAM_END;
    uint8_t *text = (uint8_t *)strdup(GLINT_MULTIPART_END);
    *part = text ? glint_blob_take(text, strlen(GLINT_MULTIPART_END)) : NULL;
    s->over = true;
    return *part ? GLINT_STREAM_PART : GLINT_STREAM_BROKEN;
}

static enum glint_stream_next read_tiles(struct glint_stream *stream, struct glint_blob **part)
{
    struct tiles *s = (struct tiles *)stream;
    if (s->over)
        return GLINT_STREAM_END;
    switch (glint_board_read(s->board, &s->cursor, part)) {
    case GLINT_BOARD_PART:
        return GLINT_STREAM_PART;
    case GLINT_BOARD_COMPLETE:
        return give_end(s, part);
    case GLINT_BOARD_GONE:
        return GLINT_STREAM_END;
    case GLINT_BOARD_NOTHING:
        break;
    }
    return GLINT_STREAM_NOTHING;
}

static void destroy(struct glint_stream *stream)
{
    struct tiles *s = (struct tiles *)stream;
    glint_boards_close(s->board);
    free(s);
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

static struct tiles *make(struct glint_request *r, uint64_t since)
{
    struct tiles *s = calloc(1, sizeof *s);
    struct glint_board *board = s ? glint_boards_open(r->http, r->argument[0]) : NULL;
    if (!board) {
        free(s);
        return NULL;
    }
    s->stream.read = read_tiles;
    s->stream.destroy = destroy;
    s->stream.kind = GLINT_STREAM_TILES;
    s->stream.news = glint_board_news(board);
    s->board = board;
    s->cursor = since;
    return s;
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
    struct tiles *s = make(r, since);
    if (s)
        glint_stream_start(r, &s->stream, GLINT_MULTIPART_TYPE);
    else
        glint_answer_response(r, 0, NULL);
}
