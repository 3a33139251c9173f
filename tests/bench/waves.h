// waves.h - whole waves of a render, run in the bench's own thread, whose CPU time is what they cost.
#ifndef GLINT_BENCH_WAVES_H
#define GLINT_BENCH_WAVES_H

#include "tests/render/offline.h"

enum { BENCH_WAVES = 24 };

// Waves of 16 samples of 16x16 pixels, spread over a frame of tiles_wide x tiles_high tiles.
void bench_waves_spread(struct glint_slice slice[BENCH_WAVES], uint32_t tiles_wide,
                        uint32_t tiles_high);

// Renders them. Returns the CPU seconds of the calling thread, which is the worker's; a failure is
// printed and ends the program.
double bench_waves_run(glint_render *render, glint_worker *worker,
                       const struct glint_slice slice[BENCH_WAVES]);

#endif
