// film.h - the accumulated pixels of one job, in tiles of 16x16.
//
// A tile is held by one worker while a slice renders into it, or read by any number of readers, or
// free. Nobody waits for a render but a reader, and that for at most one slice.
//
// Of a live job's first sample a tile may have every step-th pixel of every step-th row alone, with
// steps of 8, then 4, then 2; until it has all, it has no sample. What lies between is not defined.
//
// A film that starts again is in a new epoch: what its tiles hold of older ones is not seen any
// more, and is cleared by the worker that first renders into them.
//
// A capture is the film at one moment: workers copy a tile before they write to it for the first
// time since, and the reader copies the others. What a worker was writing at that moment is in it
// as it is when the tile is given back: the moment might as well have been that one. The copies
// take at most as much memory as the film.
//
// Threads: hold/release/restart by whoever hands out slices; prepare by the worker that holds the
// tiles; read and capture by any thread.
#ifndef GLINT_RENDER_FILM_H
#define GLINT_RENDER_FILM_H

#include "device/device.h"
#include "protocol/job.h"
#include "render/plan.h"

typedef struct glint_film glint_film;

// Where a tile's planes and slot tables lie.
struct glint_film_tile {
    glint_buffer *planes;
    uint32_t planes_offset;  // words
    uint32_t batches_offset; // words, where the film has batches
    glint_buffer *tables;    // NULL without ID coverage
    uint32_t tables_offset;  // slots
};

// The region comes from the job, planes from the plan; slots: of a pixel, where it has coverage.
glint_status glint_film_create(glint_film **out, glint_devices *devices,
                               const struct glint_plan *plan, const struct glint_job *job,
                               uint32_t slots, struct glint_error *err);
void glint_film_destroy(glint_film **film);

uint32_t glint_film_columns(const glint_film *film); // tiles in a row
uint32_t glint_film_rows(const glint_film *film);
void glint_film_tile(const glint_film *film, uint32_t tile, struct glint_film_tile *out);

// Takes the tiles [column, column + w) x [row, row + h), clipped to the film; none may be held.
// Waits for readers, who finish in microseconds.
void glint_film_hold(glint_film *film, uint32_t column, uint32_t row, uint32_t w, uint32_t h);
// Gives them back; with samples > 0 they now have that many.
void glint_film_release(glint_film *film, uint32_t column, uint32_t row, uint32_t w, uint32_t h,
                        uint32_t samples);

// Gives them back with every step-th pixel of their first sample.
void glint_film_release_coarse(glint_film *film, uint32_t column, uint32_t row, uint32_t w,
                               uint32_t h, uint32_t step);

// Before the first write to the held tiles: copies those that a capture wants as they are, and
// empties those that are new or of an older epoch: until then a film is no memory in use. Returns
// the number of captures begun so far: one that begins later has what is written now.
uint32_t glint_film_prepare(glint_film *film, uint32_t column, uint32_t row, uint32_t w,
                            uint32_t h);
// The same for a first sample that does not come all at once: nothing is emptied.
uint32_t glint_film_prepare_coarse(glint_film *film, uint32_t column, uint32_t row, uint32_t w,
                                   uint32_t h);
// Empties a film that is one thread's.
void glint_film_clear(glint_film *film);
// What a film of two by two tiles has of a first sample is put where it belongs in the held tiles
// from (column, row) on: pixels lie `step` apart there. coarser: not those that a step twice as
// long has brought already. Sums have to be of floats.
void glint_film_spread(glint_film *film, uint32_t column, uint32_t row, const glint_film *from,
                       uint32_t step, bool coarser);

// Begins a new epoch and returns it; the first is 0. No tile may be held.
uint32_t glint_film_restart(glint_film *film);

// What the pixels of a tile have: samples, or if there are none every step-th the first; or nothing.
struct glint_film_state {
    uint32_t samples, step;
};

// Locks a tile for reading: waits while it is held. Nothing where it is of another epoch.
struct glint_film_state glint_film_read_begin(glint_film *film, uint32_t tile, uint32_t epoch);
void glint_film_read_end(glint_film *film, uint32_t tile);

// One capture at a time. begin waits for the one before and keeps others waiting until end, by the
// same thread. mark is the moment, whose epoch is the film's; settle waits for the slices out, no
// longer than one takes; then take copies each tile once, planes and then tables, into `memory`
// (glint_film_tile_bytes()) and returns what it has: no copy where that is nothing.
void glint_film_capture_begin(glint_film *film);
uint32_t glint_film_capture_mark(glint_film *film); // captures begun so far, this one too
void glint_film_capture_settle(glint_film *film);
struct glint_film_state glint_film_capture_take(glint_film *film, uint32_t tile, uint32_t *memory);
void glint_film_capture_end(glint_film *film);

size_t glint_film_tile_bytes(const glint_film *film);

// Puts a tile that was read from a file into the film. No tile may be held, none captured.
void glint_film_put(glint_film *film, uint32_t tile, const uint32_t *memory, uint32_t samples);

uint32_t glint_film_samples(glint_film *film, uint32_t tile);
// Of the last release that added samples: of what the film holds, nothing is newer.
uint64_t glint_film_newest(glint_film *film);
// Of the tiles [column, column + w) x [row, row + h), clipped to the film: grows with every release
// that added samples to one of them, while all have some. While some are coarse it is that of the
// last of those; 0 while one has nothing of the epoch.
uint64_t glint_film_version(glint_film *film, uint32_t column, uint32_t row, uint32_t w,
                            uint32_t h);

#endif
