// wave.h - the paths in flight of one worker: columns that stay in its cache, and the loop that
// generates, traces, shades and compacts them until none is left.
//
// Thread-safety: one worker's.
#ifndef GLINT_RENDER_WAVE_H
#define GLINT_RENDER_WAVE_H

#include "kernels/gk_frame.h"
#include "protocol/counts.h"
#include "render/film.h"
#include "render/plan.h"
#include "scene/geometry.h"
#include "scene/resident.h"

#include <stdatomic.h>

#define GLINT_WAVE_LANES 4096u

// What all waves of a job share.
struct glint_wave_job {
    const struct glint_plan *plan;
    glint_program *program;
    const glint_resident *scene;
    const glint_geometry *geometry;
    glint_buffer *frame; // struct gk_frame
    uint32_t matte_slots, matte_policy;
    bool matte_through;  // deposits carried coverage
    bool matte_shared;   // by an item for each path
    uint32_t matte_rows; // of the list of what a path has met, 0: none is kept
    bool watertight;     // rays are closed at vertices
    uint32_t seed;
    uint32_t parts_log2; // 0: samples are one sequence, 1: of two halves, 4: of 16 batches
    const atomic_bool *interrupted; // NULL: never
};

// Counted and measured over the life of a wave.
struct glint_wave_stats {
    double seconds[GLINT_PASSES];
    uint64_t camera_rays, bounce_rays, shadow_rays;
    uint64_t count[GLINT_COUNTS]; // of slices that came to their end
};

typedef struct glint_wave glint_wave;

glint_status glint_wave_create(glint_wave **out, glint_devices *devices, struct glint_error *err);
void glint_wave_destroy(glint_wave **wave);

// Compiles the job's kernels on the spare worker: seconds the first time, then from the cache.
glint_status glint_wave_compile(glint_devices *devices, const struct glint_wave_job *job,
                                struct glint_error *err);

// Traces `samples` samples from index `sample` on, of the block of film tiles whose first is at
// (column, row), 2^tiles_log2 tiles wide and high, and adds them to the film. The block's pixels
// times samples are at most GLINT_WAVE_LANES.
//   GLINT_E_BUSY  interrupted or taken away: the film is as it was, *err too
struct glint_wave_block {
    uint32_t x, y;         // first pixel in the display window
    uint32_t x_end, y_end; // first pixel beyond the region
    uint32_t column, row, tiles_log2;
    uint32_t sample, samples;
    uint32_t spread_log2; // from a pixel to the next in the display window; not in the film
    bool coarser;         // pixels in even columns of even rows have had the sample
    atomic_uint *hold;    // of the slice (hold.h), or NULL
};
glint_status glint_wave_run(glint_wave *wave, glint_worker *worker,
                            const struct glint_wave_job *job, const struct glint_wave_block *block,
                            glint_film *film, struct glint_error *err);

const struct glint_wave_stats *glint_wave_stats(const glint_wave *wave);

#endif
