// film_parts.h - the inside of a film: what holding, reading and capturing its tiles share.
#ifndef GLINT_RENDER_FILM_PARTS_H
#define GLINT_RENDER_FILM_PARTS_H

#include "render/film.h"

#include <pthread.h>

// Of a tile that nobody has written to: its memory is not touched before.
#define GLINT_NO_EPOCH UINT32_MAX

struct glint_tile {
    uint32_t samples, epoch;
    uint16_t readers;
    uint8_t step; // of a first sample that only every step-th pixel has, while samples is 0; else 0
    bool held;
    bool written; // by a worker that holds it, from glint_film_prepare() on
    // While a capture is under way:
    bool wanted;    // as it is: not captured yet
    bool late;      // was being written when the capture began: its new state is wanted
    bool copying;   // a worker copies it
    uint32_t *copy; // its memory then; NULL: it has not been written to since, or holds nothing
    struct glint_film_state copied; // what was captured
    uint64_t version;
};

struct glint_film {
    uint32_t columns, rows;
    uint32_t tile_words;  // of planes
    uint32_t batch_words; // of those before the batches
    bool aovs;
    uint32_t tile_slots;   // of tables, 0 without coverage
    uint32_t shared_words; // of a pixel's table that all pixels of the tile use
    uint32_t tiles_per_buffer, buffers;
    glint_buffer **planes, **tables; // [buffers]
    pthread_mutex_t mutex;           // guards `tile` and what follows; no call is made under it
    pthread_cond_t changed;          // of a tile
    struct glint_tile *tile;
    uint64_t sequence;
    uint32_t epoch;
    pthread_mutex_t capture;           // held by whoever captures
    uint32_t captures, captured_epoch; // begun so far; epoch of the last
    uint32_t late;                     // tiles
};

// The memory of a tile, its planes and then its tables.
void glint_film_copy(const glint_film *film, uint32_t tile, uint32_t *out);

// Of a tile that nobody else has.
void glint_film_clear_tile(const glint_film *film, uint32_t tile);

// Under the mutex: what a reader of the epoch sees.
static inline struct glint_film_state glint_tile_state(const struct glint_tile *t, uint32_t epoch)
{
    const struct glint_film_state nothing = {0};
    return t->epoch == epoch ? (struct glint_film_state){t->samples, t->step} : nothing;
}

// Under the mutex, before a tile that is late is free again.
void glint_film_capture_late(glint_film *film, struct glint_tile *t);

// Copies those of the held tiles whose present state a capture still wants. Returns once none of
// them is wanted any more; they are then marked as written. The captures begun so far.
uint32_t glint_film_capture_before_write(glint_film *film, uint32_t column, uint32_t row,
                                         uint32_t right, uint32_t bottom);

#endif
