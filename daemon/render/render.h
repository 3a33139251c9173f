// render.h - one job's rendering: plan, program variant, film and the slices that fill it.
//
// The scheduler asks for slices and hands them to workers; a worker runs one and returns; whoever
// wants pixels takes an immutable snapshot. Nothing here knows of HTTP or of other jobs.
//
// The first sample of a live job comes coarsely: of one pixel in 8x8, then 4x4, 2x2, then of all. No
// sample is taken twice, and the film is the same afterwards as if it had come at once.
//
// A live job's render moves: to another revision of the scene, another camera. It starts again then
// on the same film; who reads meanwhile gets pixels of one view, never of two.
//
// Threads: create/sketch/destroy by whoever prepares the job (it compiles, seconds in the worst case), and
// moves too; take/give_back/restart by the scheduler only; run by the worker that holds the slice;
// state, frame and matte calls by any thread.
#ifndef GLINT_RENDER_RENDER_H
#define GLINT_RENDER_RENDER_H

#include "device/device.h"
#include "protocol/counts.h"
#include "protocol/film_header.h"
#include "protocol/frame.h"
#include "protocol/job.h"
#include "render/forecast.h"
#include "scene/resident.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdatomic.h>

typedef struct glint_render glint_render;

// A slice: samples [sample, sample + samples) of the film tiles in a block. About 20 ms.
struct glint_slice {
    uint32_t block;           // index of the block in its pass
    uint32_t x, y, w, h;      // pixels in the display window, clipped to the region
    uint32_t sample, samples; // first sample index and their number
    uint32_t tiles_log2;      // the block is 2^n film tiles wide and high
    uint32_t step;            // 0: all pixels; else those that lie so far apart, of a first sample
    atomic_uint *hold;        // of who gives it out and may take it away (hold.h); NULL: nobody
};

// The structure that the job's rays go through.
enum glint_geometry_kind glint_render_structure(const struct glint_job *job, bool *robust);

// Bytes of film that the job will hold, known before anything is spent. Its camera, if named, is in
// the scene.
uint64_t glint_render_film_bytes(const struct glint_resident *scene, const struct glint_job *job);

// Bytes beside the film, while it renders: a wave for each worker.
uint64_t glint_render_wave_bytes(const struct glint_resident *scene, const struct glint_job *job,
                                 uint32_t workers);

// Compiles the job's program variant and allocates its film. Retains `scene`. pose: the one
// that `scene` was made with, which lives as long as it; NULL: everything as the scene has it.
//   GLINT_E_RANGE     the camera is not in the scene, ... (pointers into the job)
//   GLINT_E_CAPACITY  the film does not fit
//   GLINT_E_DEVICE    the program does not build; the log is in *err
glint_status glint_render_create(glint_render **out, struct glint_devices *devices,
                                 struct glint_resident *scene, const struct glint_pose *pose,
                                 const struct glint_job *job, struct glint_error *err);
void glint_render_destroy(glint_render **render);

// The same, but that the structure which the job's rays go through may be one that is soon built,
// where the scene's own is not there: the render is a sketch then, of one pixel in 8x8, then 4x4. It
// has no sample and gives no slices after that, until it is moved and restarted, whereupon it is as
// it would have been.
glint_status glint_render_sketch(glint_render **out, struct glint_devices *devices,
                                 struct glint_resident *scene, const struct glint_pose *pose,
                                 const struct glint_job *job, struct glint_error *err);
bool glint_render_is_sketch(const glint_render *render);

// What a live render, or a sketch, shows next: made while the old view is still refined, with the program where
// that is another. `job` is the render's with another camera.
//   GLINT_E_RANGE, GLINT_E_CAPACITY, GLINT_E_DEVICE  as above; the render is as it was
typedef struct glint_view glint_view;
glint_status glint_render_move(glint_view **out, glint_render *render, struct glint_resident *scene,
                               const struct glint_pose *pose, const struct glint_job *job,
                               struct glint_error *err);
void glint_view_release(glint_view **view);

// Has the slices out given up between two bounces, and those that come: something else is to be
// shown, or nobody waits for them. Until it is told otherwise, or starts again.
void glint_render_interrupt(glint_render *render, bool on);

// Shows *view from now on, from the first sample on. No slice may be out. *view is then the old
// one, the caller's to release: that may free a scene, which takes a while.
void glint_render_restart(glint_render *render, glint_view **view);

// The next slice nobody has, or false: all samples taken, or the pass waits for slices out.
// A job that stops by error takes its decision at fixed sample counts, so it may answer false
// until the last slice of a pass has been given back.
bool glint_render_take(glint_render *render, struct glint_slice *out);

// Runs a taken slice on the calling worker's device; pixels become visible when it is given back.
//   GLINT_E_BUSY  interrupted, or taken away: it was not done; *err is as it was. Of what was taken
//                 away nothing is counted.
glint_status glint_render_run(glint_render *render, struct glint_worker *worker,
                              const struct glint_slice *slice, struct glint_error *err);

// Returns a slice that was run (`done`) or was not (it will be given again).
void glint_render_give_back(glint_render *render, const struct glint_slice *slice, bool done);

// True when every sample that will ever be taken is in the film.
bool glint_render_complete(const glint_render *render);

struct glint_render_state {
    uint32_t samples;               // fewest over the frame
    uint32_t target_samples;        // where the job will stop at the latest
    double progress;                // 0..1
    struct glint_estimate estimate; // the job's own, NAN before there are two samples
    struct glint_forecast forecast; // of when stop.error holds
    double worker_seconds;          // spent by workers
    uint32_t biases;                // approximations that it runs under, of protocol/bias.h
    uint64_t camera_rays, bounce_rays, shadow_rays;
    uint64_t count[GLINT_COUNTS];
    struct glint_matte_excess excess; // of the last whole pass
};
#define GLINT_NOTHING_RENDERED                                    \
    (struct glint_render_state)                                   \
    {                                                             \
        .estimate = {NAN, NAN, NAN, NAN, NAN, NAN}, .forecast = { \
            NAN,                                                  \
            {NAN, NAN, NAN},                                      \
            {NAN, NAN, NAN},                                      \
            true,                                                 \
            false                                                 \
        }                                                         \
    }
void glint_render_state(const glint_render *render, struct glint_render_state *out);

// The recorded curve so far; returns the number of its points.
size_t glint_render_convergence(const glint_render *render, struct glint_convergence_point *out,
                                size_t capacity);

// Tiles as clients see them: `tiles` rectangles of at most 64x64, each with a version that grows
// when its pixels change, and is 0 while some of it has nothing to show. A reader keeps its own
// cursor of versions.
uint32_t glint_render_tiles(const glint_render *render);
void glint_render_tile_rect(const glint_render *render, uint32_t tile, uint32_t rect[4]);
uint64_t glint_render_tile_version(const glint_render *render, uint32_t tile);
// No tile's version is above it now; what a tile shows from now on has versions above it.
uint64_t glint_render_newest_version(const glint_render *render);

// The frame, or the tile, as it stands: every pixel consistent, complete with all attributes of
// CONVENTIONS b. `outputs` selects (a subset of the job's). Tiles: beauty as half RGBA.
// *samples (may be NULL): fewest samples among the pixels given: 0 while they come coarsely, where a
// pixel that has none is shown as one that has. *version (may be NULL): of what is given at least.
// revision (may be NULL): of the scene that they show.
glint_status glint_render_frame(glint_render *render, uint32_t outputs, struct glint_frame **out,
                                uint32_t *samples, struct glint_error *err);
glint_status glint_render_tile(glint_render *render, uint32_t tile, struct glint_frame **out,
                               uint32_t *samples, uint64_t *version, char revision[65],
                               struct glint_error *err);

// Every name of the scene in the layers, bits 1 << layer, with its coverage over the frame by each
// class. Whoever calls finishes *out; it is empty where this fails.
glint_status glint_render_mattes(glint_render *render, uint32_t layers,
                                 struct glint_matte_totals *out, struct glint_error *err);
// What covers a pixel of the display window, by types; *out malloc'd, the names in the same block.
// GLINT_E_RANGE where it is not in the region.
glint_status glint_render_pick(glint_render *render, uint32_t x, uint32_t y,
                               struct glint_matte_found **out, size_t *count,
                               struct glint_error *err);
// Union coverage of the named; an unknown name is GLINT_E_NOT_FOUND at /name. One plane "A".
// All three: GLINT_E_RANGE if the job has no Cryptomatte output.
glint_status glint_render_matte(glint_render *render, enum glint_matte_layer layer,
                                uint32_t classes, const char *const *names, size_t count,
                                struct glint_frame **out, struct glint_error *err);

// The film as it stands at one moment, with all that frames and mattes of it need, in the format of
// protocol/film_file.h: written to `fd` from its offset on. Workers go on meanwhile; calls for one
// render follow one another. By any thread but the scheduler and workers.
//   GLINT_E_IO  the file cannot be written; what was written is torn and is known as such when read
glint_status glint_render_film(glint_render *render, int fd, struct glint_error *err);

// Goes on from a film of the same job in the same revision of its scene: from `fd`'s offset on.
// Before the first slice is taken, by whoever made the render. Otherwise the render is as it was:
//   GLINT_E_SYNTAX   torn, or no film
//   GLINT_E_RANGE    another job's or revision's; every difference has its fault
//   GLINT_E_VERSION  of a format that came later
glint_status glint_render_restore(glint_render *render, int fd, struct glint_error *err);

// A render that has ended, without its scene or a device: what any thread may ask answers as it did
// when the film was written; it gives no slices, moves nowhere and is not extended. Reads `fd` from
// its offset on and keeps a descriptor of its own, through which pixels are read when they are
// asked for: the file must not be written to any more, but may be unlinked. Errors as above, and
//   GLINT_E_IO  the file cannot be read; of later calls too
glint_status glint_render_open(glint_render **out, int fd, struct glint_error *err);

// Another end for a job, whether it has come to its old one or not: `samples` as in its `stop`,
// with the same meaning; error 0: none. False where the film has, or slices out bring it, more
// samples than that, and where a sample range or an opened film cannot go on. By the scheduler
// only.
bool glint_render_extend(glint_render *render, uint32_t samples, double error);

// What GET .../plan shows: effects with reason, state, bytes and measured share; a new object.
cJSON *glint_render_plan(const glint_render *render);

#endif
