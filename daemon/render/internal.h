// internal.h - the inside of a render, shared by the files that schedule, resolve and describe it.
#ifndef GLINT_RENDER_INTERNAL_H
#define GLINT_RENDER_INTERNAL_H

#include "kernels/gk_frame.h"
#include "protocol/film_header.h"
#include "render/film.h"
#include "render/forecast.h"
#include "render/render.h"
#include "render/wave.h"

#include <pthread.h>
#include <stdatomic.h>

#define GLINT_COARSE_LOG2 1   // film tiles along a block of a live job's first sample, log2
#define GLINT_COARSEST_LOG2 3 // its pixels lie so far apart at first
#define GLINT_SKETCH_LOG2 2   // and in the end, of a sketch
#define GLINT_COARSE_STEPS (GLINT_COARSEST_LOG2 + 1)

// The samples being given out: [sample, sample + samples) of every pixel, in blocks of
// 2^tiles_log2 film tiles a side.
struct glint_pass_state {
    uint32_t sample, samples, tiles_log2;
    bool coarse;          // only the pixels that lie 2^spread_log2 apart and have had no sample
    uint32_t spread_log2; // 0: unless coarse
    uint32_t blocks_wide, blocks_high, blocks; // of the whole film
    uint32_t start;                            // the block that is given out first
    uint32_t next;                             // blocks given out, counted from there
    uint32_t done;                             // blocks given back
    uint32_t *list; // [blocks of the finest pass] of an adaptive job: those of this pass
    uint32_t *redo; // [blocks of the finest pass]: returned without being run
    uint32_t redos;
};

// What is rendered, seen from where, by which program. Immutable; counted: a reader holds the one
// that its pixels belong to while the render moves on.
struct glint_view {
    atomic_uint references;
    glint_render *render;          // outlives it
    glint_resident *scene;         // retained
    glint_geometry *sketch;        // owned: what its rays go through, NULL: the scene's structure
    const struct glint_pose *pose; // lives as long as `scene`; NULL: everything as the scene has it
    struct glint_job job;          // a copy
    struct glint_camera camera;
    uint32_t camera_index;       // in the scene, GLINT_NONE: the job's own
    struct glint_film_info info; // borrows from the members above
    struct glint_plan plan;
    glint_program *program;
    glint_buffer *frame;
    struct glint_wave_job wave_job;
    glint_film *film; // the render's
    // Of the film. Another one when the pilot of an adaptive job is thrown away; relaxed: a reader
    // with the old one finds no samples.
    atomic_uint epoch;
};

struct glint_render {
    struct glint_devices *devices;
    struct glint_job job;          // a copy
    struct glint_archive *archive; // where its pixels are, if not in a film; there is no view then
    glint_film *film;
    glint_wave **wave; // [workers], each made and used by its worker alone
    // [film tiles]: written by the worker that holds the tile, read under the mutex when none does.
    struct glint_tile_estimate *tile_estimate;
    struct glint_matte_excess *tile_excess; // likewise, of a film that has coverage; else NULL
    glint_film **coarse; // [workers]: of a live job, 2 x 2 tiles each, made as its wave is
    uint32_t *order[GLINT_COARSE_STEPS]; // of a live job: how blocks go, by the pass's spread_log2
    atomic_bool interrupted;             // slices out are to be given up
    // Replaced under the mutex by whoever hands out slices, while none is out: it and the workers
    // that hold slices read it without.
    struct glint_view *view;

    pthread_mutex_t mutex; // guards what follows
    struct glint_pass_state pass;
    uint32_t target;               // sample index
    bool stopped;                  // by error
    char *shares;                  // [film tiles] of an adaptive job, else NULL
    const char *share;             // the same once they are decided
    uint32_t most;                 // the largest, a is 1
    struct glint_wave_stats stats; // of all workers, added as slices come back
    double worker_seconds;
    struct glint_convergence_point curve[GLINT_CURVE_POINTS];
    uint32_t points;
    struct glint_film_estimate estimate; // when the last pass ended
    uint32_t estimated;                  // samples of that
    struct glint_matte_excess excess;    // when the last pass ended
    struct glint_forecast forecast;      // from then on
    double pace[GLINT_FORECAST_PACES];   // worker seconds for a sample, of the last passes
    double measured;                     // samples of a pixel when the last one ended
    double pass_seconds;                 // worker seconds when the last one ended
    uint32_t paces;                      // so far
    struct glint_capture *late;          // that waits for slices out: it takes their work too
    uint32_t captures;                   // begun so far
};

// What a view is made for.
struct glint_view_order {
    glint_resident *scene;
    const struct glint_pose *pose;
    const struct glint_job *job;
    const struct glint_view *like; // NULL, or one that may have the same program
    uint64_t force;                // rows of the effects table
    bool sketch;
};
// Plan, program and constants; the film is added by the render.
glint_status glint_view_create(struct glint_view **out, glint_render *render,
                               const struct glint_view_order *order, struct glint_error *err);
// The render's view now, retained.
struct glint_view *glint_view_hold(glint_render *render);

// As glint_render_create(), with rows of the effects table forced on: for tests and benches.
glint_status glint_render_create_forced(glint_render **out, struct glint_devices *devices,
                                        struct glint_resident *scene, const struct glint_pose *pose,
                                        const struct glint_job *job, uint64_t force,
                                        struct glint_error *err);

// Fills the members that say which solids the camera is in; its origin and wave_job.geometry are
// set.
glint_status glint_render_inside(const struct glint_view *v, struct gk_frame *f,
                                 struct glint_error *err);

// Whether the camera moves while the shutter is open.
bool glint_render_camera_moves(const struct glint_view *v);

// Fills the frame constants from the camera, the job and the scene's lighting.
void glint_render_constants(const struct glint_view *r, struct gk_frame *out);

// worldToCamera and worldToNDC of CONVENTIONS b, row-major.
void glint_render_matrices(const struct glint_view *r, float world_to_camera[16],
                           float world_to_ndc[16]);

// Index of the first sample that the job takes.
uint32_t glint_render_first(const glint_render *r);
// Samples of a tile that has those before index `end`.
uint32_t glint_pass_count(const glint_render *r, uint32_t end);

uint64_t glint_render_pixels(const glint_render *r);

// Whether the job begins with a sketch.
bool glint_render_wants_sketch(const struct glint_resident *scene, const struct glint_job *job);
// Whether what it shows is thrown away.
static inline bool glint_render_sketches(const glint_render *r)
{
    return r->view && r->view->sketch;
}

// The passes, under the mutex. begin: with the samples from `sample` on; end: all blocks are back.
void glint_pass_begin(glint_render *r, uint32_t sample);
void glint_pass_end(glint_render *r);
// The share of its samples that a pass has brought.
double glint_pass_share(const struct glint_pass_state *p);
// Whether the first sample of the job comes coarsely.
bool glint_pass_coarsens(const struct glint_job *job);
// Begins with the first sample again. A first pass that was cut off goes on where it was: with the
// blocks that have waited for longest.
void glint_pass_restart(glint_render *r);
// Takes the decision of a job that stops by error, with the samples up to `end`: whether it does.
bool glint_pass_stops(glint_render *r, uint32_t end);
// The part of [start, start + size) that lies before `end`.
uint32_t glint_pass_clip(uint32_t start, uint32_t size, uint32_t end);
// Lays out the blocks of a pass that was under way when tiles had these samples. False where those
// of a block differ.
bool glint_pass_resume(glint_render *r, const struct glint_film_moment *was,
                       const uint32_t *tile_samples);

// Empties the film and all that was measured, under the mutex; no slice may be out.
void glint_render_forget(glint_render *r);

// measure.c: the job's own estimate of its error. Of a tile which has so many samples, 2 or more: by
// whoever holds it.
void glint_render_measure(glint_render *r, uint32_t tile, uint32_t samples);
// The same of its ranks, of a tile which has any samples.
void glint_render_measure_ranks(glint_render *r, uint32_t tile, uint32_t samples);
// Under the mutex, when the pass up to index `end` has ended: of the film, with a point of the curve where one is due.
void glint_render_measure_pass(glint_render *r, uint32_t end);
// Forgets all that was measured.
void glint_render_measure_nothing(glint_render *r);
// The error of its own at which the job ends, 0: none. A bias known of its settings has its part of
// what was asked; where it has all of that, more samples are of no use once the rest is as small.
double glint_render_noise_wanted(const glint_render *r);

// Under the mutex, where what was measured or asked for has changed: sets the forecast.
void glint_render_foresee(glint_render *r);

// Under the mutex: how far it is.
void glint_render_moment(const glint_render *r, struct glint_film_moment *out);

#endif
