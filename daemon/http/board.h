// board.h - the tiles of a job that somebody watches, each encoded once for all who do.
//
// A board holds the newest part of every tile, ready to be sent, and the order in which they were
// posted. It is filled while a reader waits; when nobody reads it is gone. Its memory is that of one
// encoded frame, however many clients there are.
//
// A sequence is (start + version) * tiles + index of the tile: versions come from one counter of the
// render, and the index tells apart tiles that changed together. `start` is later in each process,
// so a client that comes back to a daemon that was restarted misses nothing.
//
// Threads: any; posting by the stream lane.
#ifndef GLINT_HTTP_BOARD_H
#define GLINT_HTTP_BOARD_H

#include "http/stream.h"

struct glint_board;

glint_status glint_boards_create(glint_boards **out, struct glint_error *err);
void glint_boards_destroy(glint_boards **boards); // nobody reads, no lane runs

// The board of a job, with one reader more; NULL without memory.
struct glint_board *glint_boards_open(glint_http *http, const char *job);
void glint_boards_close(struct glint_board *board);

// What its readers wait for.
const glint_stream_news *glint_board_news(const struct glint_board *board);

enum glint_board_answer {
    GLINT_BOARD_PART,     // *part, a reference, and *cursor, its sequence
    GLINT_BOARD_NOTHING,  // the board fills itself and wakes its readers
    GLINT_BOARD_COMPLETE, // all tiles of an ended job have been read
    GLINT_BOARD_GONE      // nothing will follow: no such job any more, no pixels, no memory
};

// The part that follows the cursor. One that was superseded since is never given.
enum glint_board_answer glint_board_read(struct glint_board *board, uint64_t *cursor,
                                         struct glint_blob **part);

// Has boards filled whose jobs changed. Watcher's thread.
void glint_boards_round(glint_http *http);

#endif
