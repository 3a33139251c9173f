// compact.h - moves the paths of a wave that go on to its front.
//
// Of those, the ones that hold coverage come first: what belongs to coverage is then done for them
// alone. Within each of the two parts the order stays as it was.
//
// Threads: the worker's.
#ifndef GLINT_RENDER_COMPACT_H
#define GLINT_RENDER_COMPACT_H

#include "render/wave.h"

enum { GLINT_COMPACT_BLOCK = 16 };

// Some lanes of a wave, in blocks of 16: bit k of mask[b] is lane 16 b + k.
struct glint_lanes {
    uint32_t count;
    uint16_t mask[GLINT_WAVE_LANES / GLINT_COMPACT_BLOCK];
};

struct glint_compact {
    uint32_t step;       // lanes that move at a time: 16 with AVX-512, 8 with AVX2, else 1
    uint64_t order[256]; // for a mask of 8: the lanes that it names, a byte each, in their order
    uint32_t lanes;      // that are looked at
    struct glint_lanes holding, others;
};

void glint_compact_init(struct glint_compact *c);

// Columns are aligned for vectors and have room for a block beyond `lanes`, 0..GLINT_WAVE_LANES.
// distance: > 0 in the lanes that go on. held: not 0 in those that hold coverage, of the first
// `holders` lanes; beyond, nobody does.
void glint_compact_look(struct glint_compact *c, const float *distance, uint32_t lanes,
                        const uint32_t *held, uint32_t holders);

// Moves what the lanes have in `column`, or only those that hold coverage. Lanes after them are
// left with anything.
void glint_compact_column(const struct glint_compact *c, float *column);
void glint_compact_holding(const struct glint_compact *c, float *column);

#endif
