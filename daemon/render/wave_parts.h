// wave_parts.h - the inside of a wave, shared by the file that runs it and the one that sees to the
// coverage its paths carry.
//
// Threads: the worker's.
#ifndef GLINT_RENDER_WAVE_PARTS_H
#define GLINT_RENDER_WAVE_PARTS_H

#include "render/compact.h"

// Not a power of two, so that columns do not fall on the same cache sets.
#define GLINT_WAVE_STRIDE (GLINT_WAVE_LANES + 16u)

struct glint_wave {
    glint_devices *devices;
    glint_buffer *columns; // [GK_COLUMNS][GLINT_WAVE_STRIDE]
    glint_buffer *rect;    // struct gk_wave_rect
    glint_buffer *tables;  // slot tables of the block while its paths are on their way; NULL: none
    glint_buffer *met; // [matte_rows][GLINT_WAVE_STRIDE], what each lane's path has met; NULL: none
    struct glint_compact compact;
    struct glint_wave_stats stats;
};

// One run: what the steps of the loop hand on.
struct glint_run {
    glint_wave *wave;
    glint_worker *worker;
    const struct glint_wave_job *job;
    const struct glint_wave_block *block;
    glint_film *film;
    struct glint_error *err;
    uint32_t pixels_log2, lanes, bounce;
    uint32_t holding; // the first paths, which have coverage to give away
    double mark;      // when the last pass ended
    bool compiling;   // over no item, in the largest grid there will be
    uint64_t lost;    // units of coverage in the block that have no slot
    uint64_t clamped; // units that weights above one were cut by
};

#define GLINT_ARG_BUFFER(b) \
    {                       \
        .buffer = (b)       \
    }
#define GLINT_ARG_VALUE(v)               \
    {                                    \
        .value = &(v), .size = sizeof(v) \
    }

void glint_run_charge(struct glint_run *run, enum glint_pass pass);
glint_status glint_run_launch(struct glint_run *run, const char *kernel, uint32_t n,
                              const struct glint_arg *args, size_t count);

// Calls `visit` with each film tile of the block, its index in the block too, until one fails.
typedef glint_status glint_visit_tile(struct glint_run *run, const struct glint_film_tile *at,
                                      uint32_t tile_in_block);
glint_status glint_run_tiles(struct glint_run *run, glint_visit_tile *visit);

// The tables that a run deposits in are copies until it has come to its end, because one that is
// interrupted leaves the film as it was. None of these does anything where no coverage is carried.
glint_status glint_carried_begin(struct glint_run *run);
glint_status glint_carried_deposit(struct glint_run *run); // of the vertices just shaded
glint_status glint_carried_end(struct glint_run *run);

// Counts what the samples just traced have against them.
void glint_run_count_samples(struct glint_run *run);
// Units of coverage that have found no slot in the tiles of the block.
uint64_t glint_run_lost(struct glint_run *run);
// Takes from the deposits of the first n paths what each of these has met before.
glint_status glint_carried_forget(struct glint_run *run, glint_buffer *list, uint32_t n);

// The kernels that deposit: over `n` pixels of one tile whose first lane is `lane`, all their samples,
// or over the first `n` paths.
glint_status glint_run_deposit_pixels(struct glint_run *run, const char *kernel,
                                      const struct glint_film_tile *at, uint32_t n, uint32_t lane);
glint_status glint_run_deposit_paths(struct glint_run *run, glint_buffer *tables, uint32_t n);

// Asks for the slots at which the pixels of a tile, whose first lane is `lane`, will look first: they are
// all over a table that no cache holds.
void glint_run_fetch_slots(const struct glint_run *run, const struct glint_film_tile *at,
                           uint32_t lane);

#endif
