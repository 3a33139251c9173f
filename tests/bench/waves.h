// waves.h - whole waves of a render, run in the bench's own thread, whose CPU time is what they cost.
#ifndef GLINT_BENCH_WAVES_H
#define GLINT_BENCH_WAVES_H

#include "tests/bench/bench.h"
#include "tests/render/offline.h"

enum { BENCH_WAVES = 24, BENCH_WIDE = 120, BENCH_HIGH = 67 }; // tiles of 1920x1080

// A scene at rest, of a .glb, a native .json or a .gltf with the files that it names; NULL: the one of
// 904 K triangles. Released by its resident; a failure is printed and ends the program.
struct glint_posed bench_waves_scene(const struct offline *o, const char *path);

// Waves of 16 samples of 16x16 pixels, spread over a frame of tiles_wide x tiles_high tiles.
void bench_waves_spread(struct glint_slice slice[BENCH_WAVES], uint32_t tiles_wide,
                        uint32_t tiles_high);

// Renders them. Returns the CPU seconds of the calling thread, which is the worker's; a failure is
// printed and ends the program.
double bench_waves_run(glint_render *render, glint_worker *worker,
                       const struct glint_slice slice[BENCH_WAVES]);

// A render of the scene at 1920x1080. members: of the job, but scene, resolution and stop; a failure
// ends the program.
glint_render *bench_waves_render(const struct offline *o, const struct glint_posed *rest,
                                 const char *members);

// CPU time of waves of b over that of a, of frames of so many tiles, in interleaved pairs. Takes both.
struct bench_ratio bench_waves_ratio(glint_worker *worker, glint_render *a, glint_render *b,
                                     uint32_t tiles_wide, uint32_t tiles_high, size_t pairs);

#endif
