#include "http/board.h"

#include "base/clock.h"
#include "base/log.h"
#include "protocol/exr.h"
#include "protocol/multipart.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define ZIP_LEVEL 4
#define COARSE_ZIP_LEVEL 1   // of pixels that others show too, and that the next tile replaces soon
#define DIRECT_READERS 4     // so few are woken for each tile
#define VERSIONS_A_SECOND 12 // as a power of two: more than a render makes
// 2026: so that the sequences of 8K frames fit into the 53 bits of a browser's numbers until 2034.
#define FIRST_SECOND 1767225600

struct tile {
    uint64_t sequence; // 0: never posted
    struct glint_blob *part;
};

struct entry {
    uint64_t sequence; // outdated where the tile has another
    uint32_t tile;
};

struct glint_board {
    struct glint_task task;
    glint_http *http;
    char job[GLINT_JOB_ID_BYTES];
    struct glint_board *next; // guarded by the boards' mutex
    unsigned users;           // so is this: readers, the lane, and a round

    pthread_mutex_t mutex; // guards the rest; a leaf
    uint64_t start;        // of sequences
    uint32_t tiles;        // 0: not known yet
    struct tile *tile;     // [tiles]
    struct entry *log;     // [2 * tiles], ascending sequences
    size_t logged;
    uint64_t newest;        // sequence that is known to exist
    glint_stream_news news; // changed with the mutex
    uint64_t looked_at;     // the job's sequence when it was filled last
    bool hungry;            // a reader found nothing
    bool filling;           // the lane has it
    bool direct;            // readers are so few that each tile is sent at once
    bool complete, gone;
};

struct glint_boards {
    pthread_mutex_t mutex;
    struct glint_board *first;
    uint64_t start;
};

// Later than every version of a daemon before, also of one that ended within this second.
static uint64_t first_version(void)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (now.tv_sec < FIRST_SECOND)
        return 0;
    const uint64_t part = ((uint64_t)now.tv_nsec << VERSIONS_A_SECOND) / 1000000000;
    return ((uint64_t)(now.tv_sec - FIRST_SECOND) << VERSIONS_A_SECOND) + part;
}

glint_status glint_boards_create(glint_boards **out, struct glint_error *err)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for tile streams");
    pthread_mutex_init(&(*out)->mutex, NULL);
    (*out)->start = first_version();
    return GLINT_OK;
}

static void free_board(struct glint_board *b)
{
    for (uint32_t t = 0; t < b->tiles; t++)
        glint_blob_release(&b->tile[t].part);
    pthread_mutex_destroy(&b->mutex);
    free(b->tile);
    free(b->log);
    free(b);
}

void glint_boards_destroy(glint_boards **boards)
{
    glint_boards *all = *boards;
    *boards = NULL;
    if (!all)
        return;
    pthread_mutex_destroy(&all->mutex);
    free(all);
}

// With the boards' mutex.
static struct glint_board *find_or_make(glint_boards *all, glint_http *http, const char *job)
{
    struct glint_board *b = all->first;
    while (b && strcmp(b->job, job))
        b = b->next;
    if (b || !(b = calloc(1, sizeof *b)))
        return b;
    b->http = http;
    b->start = all->start;
    strcpy(b->job, job);
    pthread_mutex_init(&b->mutex, NULL);
    b->next = all->first;
    all->first = b;
    return b;
}

struct glint_board *glint_boards_open(glint_http *http, const char *job)
{
    glint_boards *all = http->boards;
    pthread_mutex_lock(&all->mutex);
    struct glint_board *b = find_or_make(all, http, job);
    if (b)
        b->users++;
    pthread_mutex_unlock(&all->mutex);
    return b;
}

// Returns how many use it now.
static unsigned hold(struct glint_board *b)
{
    glint_boards *all = b->http->boards;
    pthread_mutex_lock(&all->mutex);
    const unsigned users = ++b->users;
    pthread_mutex_unlock(&all->mutex);
    return users;
}

void glint_boards_close(struct glint_board *board)
{
    glint_boards *all = board->http->boards;
    pthread_mutex_lock(&all->mutex);
    const bool last = !--board->users;
    struct glint_board **at = &all->first;
    while (last && *at != board)
        at = &(*at)->next;
    if (last)
        *at = board->next;
    pthread_mutex_unlock(&all->mutex);
    if (last)
        free_board(board);
}

// The first entry after a cursor.
static size_t seek(const struct glint_board *b, uint64_t cursor)
{
    size_t low = 0, high = b->logged;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if (b->log[middle].sequence > cursor)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

static bool outdated(const struct glint_board *b, const struct entry *e)
{
    return b->tile[e->tile].sequence != e->sequence || !b->tile[e->tile].part;
}

// A reader is given another part; counts it and the versions that it will never see.
static void count(const struct glint_board *b, uint64_t before, uint64_t now)
{
    const uint64_t versions = now / b->tiles - before / b->tiles;
    atomic_fetch_add_explicit(&b->http->tiles_sent, 1, memory_order_relaxed);
    if (before && versions > 1)
        atomic_fetch_add_explicit(&b->http->tiles_skipped, versions - 1, memory_order_relaxed);
}

// A cursor that no board has given yet is from a time that this one does not know.
static enum glint_board_answer read_next(struct glint_board *b, uint64_t *cursor,
                                         struct glint_blob **part)
{
    if (b->newest && *cursor > b->newest)
        *cursor = 0;
    size_t i = seek(b, *cursor);
    while (i < b->logged && outdated(b, &b->log[i]))
        i++;
    if (i == b->logged)
        return b->gone       ? GLINT_BOARD_GONE
               : b->complete ? GLINT_BOARD_COMPLETE
                             : GLINT_BOARD_NOTHING;
    count(b, *cursor, b->log[i].sequence);
    *cursor = b->log[i].sequence;
    *part = glint_blob_retain(b->tile[b->log[i].tile].part);
    return GLINT_BOARD_PART;
}

enum glint_board_answer glint_board_read(struct glint_board *board, uint64_t *cursor,
                                         struct glint_blob **part)
{
    pthread_mutex_lock(&board->mutex);
    const enum glint_board_answer news = read_next(board, cursor, part);
    const bool ask = news == GLINT_BOARD_NOTHING && !board->hungry;
    board->hungry |= ask;
    pthread_mutex_unlock(&board->mutex);
    if (ask)
        glint_watch_wake(board->http->watch);
    return news;
}

const glint_stream_news *glint_board_news(const struct glint_board *board)
{
    return &board->news;
}

// Filling

static glint_status encode(const struct glint_job_view *view, uint32_t tile, uint8_t **bytes,
                           struct glint_multipart_head *head, struct glint_error *err)
{
    struct glint_frame *frame = NULL;
    uint64_t version = 0;
    uint32_t samples = 0;
    size_t size = 0;
    glint_status st =
        glint_render_tile(view->render, tile, &frame, &samples, &version, head->revision, err);
    const struct glint_exr_options options = {.compression = GLINT_EXR_ZIP,
                                              .layout = GLINT_EXR_SINGLE,
                                              .zip_level = samples ? ZIP_LEVEL : COARSE_ZIP_LEVEL};
    if (!st && version)
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

// The part of a tile, NULL where there is nothing to show any more because a live job has just moved.
static glint_status make_part(const struct glint_job_view *view, const struct entry *e,
                              struct glint_blob **out, struct glint_error *err)
{
    struct glint_multipart_head head = {
        .type = "image/x-exr", .has_tile = true, .sequence = e->sequence};
    uint8_t *body = NULL;
    *out = NULL;
    const glint_status st = encode(view, e->tile, &body, &head, err);
    if (st || !head.length)
        return st;
    glint_render_tile_rect(view->render, e->tile, head.tile);
    *out = join(&head, body);
    return *out ? GLINT_OK : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a tile");
}

// With the board's mutex: forgets outdated entries, so that there is room for every tile.
static void tidy_log(struct glint_board *b)
{
    size_t kept = 0;
    for (size_t i = 0; i < b->logged; i++)
        if (!outdated(b, &b->log[i]))
            b->log[kept++] = b->log[i];
    b->logged = kept;
}

// Takes the reference.
static void post(struct glint_board *b, const struct entry *e, struct glint_blob *part)
{
    pthread_mutex_lock(&b->mutex);
    struct glint_blob *old = b->tile[e->tile].part;
    b->tile[e->tile] = (struct tile){e->sequence, part};
    if (b->logged == 2 * (size_t)b->tiles)
        tidy_log(b);
    b->log[b->logged++] = *e;
    b->hungry = false;
    atomic_fetch_add_explicit(&b->news, 1, memory_order_release);
    const bool direct = b->direct;
    pthread_mutex_unlock(&b->mutex);
    glint_blob_release(&old);
    if (direct) // the round serves who is left
        glint_streams_serve(b->http, GLINT_STREAM_TILES, &b->news, INFINITY);
}

static int by_sequence(const void *a, const void *b)
{
    const struct entry *x = a, *y = b;
    return x->sequence < y->sequence ? -1 : x->sequence > y->sequence;
}

// Tiles that changed since they were posted, in order; malloc'd, NULL without memory. What changes
// while they are listed is left for the next list, or that one would have sequences below this one's.
static struct entry *list_changed(const struct glint_board *b, const glint_render *render,
                                  size_t *count)
{
    const uint64_t newest = glint_render_newest_version(render);
    struct entry *changed = malloc(b->tiles * sizeof *changed);
    *count = 0;
    for (uint32_t t = 0; changed && t < b->tiles; t++) {
        const uint64_t version = glint_render_tile_version(render, t);
        const uint64_t sequence = (b->start + version) * b->tiles + t;
        if (version && version <= newest && sequence > b->tile[t].sequence)
            changed[(*count)++] = (struct entry){sequence, t};
    }
    if (changed)
        qsort(changed, *count, sizeof *changed, by_sequence);
    return changed;
}

static glint_status size_board(struct glint_board *b, const glint_render *render,
                               struct glint_error *err)
{
    const uint32_t tiles = glint_render_tiles(render);
    if (b->tiles)
        return GLINT_OK;
    struct tile *tile = calloc(tiles, sizeof *tile);
    struct entry *log = calloc(tiles, 2 * sizeof *log);
    if (!tile || !log) {
        free(tile);
        free(log);
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u tiles", tiles);
    }
    pthread_mutex_lock(&b->mutex);
    b->tile = tile;
    b->log = log;
    b->tiles = tiles;
    pthread_mutex_unlock(&b->mutex);
    return GLINT_OK;
}

// Not the versions that are read: newer ones come in their turn, after the tiles between.
static glint_status post_changed(struct glint_board *b, const struct glint_job_view *view,
                                 struct glint_error *err)
{
    size_t count;
    glint_status st = size_board(b, view->render, err);
    if (st)
        return st;
    struct entry *changed = list_changed(b, view->render, &count);
    if (!changed)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a list of tiles");
    if (count) {
        pthread_mutex_lock(&b->mutex);
        b->newest = changed[count - 1].sequence;
        pthread_mutex_unlock(&b->mutex);
    }
    for (size_t i = 0; !st && i < count; i++) {
        struct glint_blob *part;
        st = make_part(view, &changed[i], &part, err);
        if (!st)
            post(b, &changed[i], part);
    }
    free(changed);
    return st;
}

// Whether all has been posted that ever will be, or nothing will be.
static void conclude(struct glint_board *b, bool complete, bool gone)
{
    pthread_mutex_lock(&b->mutex);
    if ((complete && !b->complete) || (gone && !b->gone))
        atomic_fetch_add_explicit(&b->news, 1, memory_order_release);
    b->complete = complete;
    b->gone = gone;
    b->filling = false;
    pthread_mutex_unlock(&b->mutex);
}

static void fill_from(struct glint_board *b, const struct glint_job_view *view)
{
    const bool ended = view->state >= GLINT_JOB_DONE; // before its tiles are listed
    struct glint_error err = {0};
    const glint_status st = view->render ? post_changed(b, view, &err) : GLINT_OK;
    if (st)
        glint_log(GLINT_LOG_WARNING, "http", b->job, NULL, "tile streams end: %s",
                  glint_error_text(&err));
    glint_error_finish(&err);
    conclude(b, ended && view->render && !st, st || (ended && !view->render));
}

static void fill(struct glint_task *task)
{
    struct glint_board *b = (struct glint_board *)task;
    glint_http *h = b->http;
    struct glint_job_view view;
    const glint_status st = glint_jobs_view(h->jobs, b->job, &view, NULL);
    if (!st)
        fill_from(b, &view);
    else
        conclude(b, false, st != GLINT_E_BUSY);
    if (!st)
        glint_jobs_release(h->jobs, &view);
    glint_boards_close(b);
    glint_watch_wake(h->watch); // for readers that are left, and for what changed meanwhile
}

// Rounds

// The job's sequence; 0: it has no pixels yet, so there is nothing to be done.
static uint64_t job_sequence(struct glint_board *b)
{
    struct glint_job_view view;
    const glint_status st = glint_jobs_view(b->http->jobs, b->job, &view, NULL);
    if (st)
        return st == GLINT_E_BUSY ? 0 : UINT64_MAX; // gone: that shows when it is filled
    const uint64_t sequence = view.sequence;
    glint_jobs_release(b->http->jobs, &view);
    return sequence;
}

static void fill_if_due(struct glint_board *b)
{
    const uint64_t sequence = job_sequence(b);
    pthread_mutex_lock(&b->mutex);
    const bool due = sequence && sequence != b->looked_at && !b->filling && b->hungry;
    if (due) {
        b->looked_at = sequence;
        b->filling = true;
    }
    pthread_mutex_unlock(&b->mutex);
    if (!due)
        return;
    const unsigned users = hold(b) - 2; // but for the lane and this round
    b->direct = users <= DIRECT_READERS;
    b->task.run = fill;
    glint_offload_push(b->http->lane[GLINT_LANE_STREAM], &b->task); // has room for every stream
}

// The board after `b` (NULL: the first), with one user more; `b` has one less.
static struct glint_board *step(glint_boards *all, struct glint_board *b)
{
    pthread_mutex_lock(&all->mutex);
    struct glint_board *next = b ? b->next : all->first;
    if (next)
        next->users++;
    pthread_mutex_unlock(&all->mutex);
    if (b)
        glint_boards_close(b);
    return next;
}

void glint_boards_round(glint_http *http)
{
    for (struct glint_board *b = step(http->boards, NULL); b; b = step(http->boards, b))
        fill_if_due(b);
}
