#include "tests/bench/waves.h"

#include "base/clock.h"

void bench_waves_spread(struct glint_slice slice[BENCH_WAVES], uint32_t tiles_wide,
                        uint32_t tiles_high)
{
    const uint32_t tiles = tiles_wide * tiles_high;
    for (uint32_t s = 0; s < BENCH_WAVES; s++) {
        const uint32_t tile = (s * 341 + 170) % tiles;
        slice[s] = (struct glint_slice){.block = tile,
                                        .x = tile % tiles_wide * 16,
                                        .y = tile / tiles_wide * 16,
                                        .w = 16,
                                        .h = 16,
                                        .sample = 16,
                                        .samples = 16};
    }
}

double bench_waves_run(glint_render *render, glint_worker *worker,
                       const struct glint_slice slice[BENCH_WAVES])
{
    const double start = glint_thread_cpu();
    struct glint_error err = {0};
    for (int s = 0; s < BENCH_WAVES; s++)
        if (glint_render_run(render, worker, &slice[s], &err))
            offline_die("slice", &err);
    return glint_thread_cpu() - start;
}
