// job.h - a render job as data: what POST /v1/jobs says, checked, with defaults filled in.
//
// Thread-safety: built by one thread, immutable afterwards.
#ifndef GLINT_PROTOCOL_JOB_H
#define GLINT_PROTOCOL_JOB_H

#include "arena.h"
#include "dials.h"
#include "scene.h"
#include "status.h"

#include <stdbool.h>
#include <stdint.h>

#define GLINT_MAX_SIDE 16384u
#define GLINT_DEFAULT_SAMPLES 256u   // of a job that says nothing of when to stop
#define GLINT_PILOT_SAMPLES 16u      // of an adaptive job, thrown away; then passes have as many
#define GLINT_ADAPTIVE_SAMPLES 64u   // fewest that an adaptive job takes
#define GLINT_MAX_LEVELS 20u         // of a Cryptomatte type: readers know layers 00 to 09
#define GLINT_MOST_GIVEN_LEVELS 16u  // that a job may ask for: slots hold twice as many
#define GLINT_DEFAULT_LEVELS 6u      // and the fewest that "auto" writes
#define GLINT_MAX_SAMPLES (1u << 24) // per pixel: matte counters are exact up to here

enum glint_output {
    GLINT_OUT_BEAUTY = 1u << 0,
    GLINT_OUT_CRYPTO_OBJECT = 1u << 1,
    GLINT_OUT_CRYPTO_MATERIAL = 1u << 2,
    GLINT_OUT_CRYPTO_ASSET = 1u << 3,
    GLINT_OUT_DEPTH = 1u << 4,
    GLINT_OUT_NORMAL = 1u << 5,
    GLINT_OUT_ALBEDO = 1u << 6,
    GLINT_OUT_SAMPLES = 1u << 7,
    GLINT_OUT_VARIANCE = 1u << 8,
    GLINT_OUT_MOTION = 1u << 9,      // pixels to the next and previous frame
    GLINT_OUT_MATTE_SUMS = 1u << 10, // coverage kept and lost
};
#define GLINT_OUT_CRYPTO \
    (GLINT_OUT_CRYPTO_OBJECT | GLINT_OUT_CRYPTO_MATERIAL | GLINT_OUT_CRYPTO_ASSET)

// "beauty" <-> GLINT_OUT_BEAUTY and so on; 0 and NULL for what does not exist.
uint32_t glint_output_from_name(const char *name);
const char *glint_output_name(uint32_t bit);

// What a job's own error is estimated from: two halves of the samples, or 16 batches of them. Or it
// does not know it, and its samples are one sequence.
enum glint_estimate_kind { GLINT_ESTIMATE_HALVES, GLINT_ESTIMATE_BATCHES, GLINT_ESTIMATE_NONE };

enum glint_filter_kind { GLINT_FILTER_BOX, GLINT_FILTER_BLACKMAN_HARRIS };

struct glint_job_stop {
    uint32_t samples; // per pixel, 1..GLINT_MAX_SAMPLES; GLINT_MAX_SAMPLES where not asked
    double seconds;   // of rendering, 0: not asked
    double error;     // sqrt(mean(v/(m^2+0.01))), 0: not asked
    uint32_t least;   // samples before which the error does not end it, 0: none
};

// What a job may take or must reach, where the daemon is to pick the settings; at most one is not 0.
struct glint_job_budget {
    double seconds; // of rendering
    double error;   // as in glint_job_stop, bias included
};

struct glint_job {
    struct glint_arena arena;
    char *scene;       // name of the scene
    char *name;        // for people, may be ""
    char *camera_name; // NULL: the scene's first, unless has_camera
    bool has_camera;   // `camera` was given as an object
    struct glint_camera camera;
    uint32_t width, height;         // display window, 1..GLINT_MAX_SIDE; default 1280x720
    uint32_t region[4];             // x y w h inside it; default the whole
    uint32_t outputs;               // glint_output bits; default beauty and the three crypto types
    uint8_t dial[GLINT_DIAL_COUNT]; // setting of each dial, an index into its row of the dial table
    struct glint_job_budget budget;
    uint32_t pinned;        // settings that were given, bits as in accuracy_front.h
    uint32_t matte_slots;   // 4..32
    uint32_t matte_levels;  // 1..16: slots hold twice as many candidates; 0: as many as it takes
    float matte_alpha;      // 0..16, Eq. 7: how far coverage goes; default 0.1
    bool matte_clamp;       // Eq. 6 in the place of Eq. 5; default true
    bool matte_diffuse_cut; // diffuse surfaces keep all of theirs; default true
    bool matte_env_id;      // what leaves the scene covers the background; default true
    bool matte_classes;     // reflection and refraction apart; default false
    uint32_t
        matte_cone_width; // 1..GLINT_MAX_SIDE: cones are of a frame of so many pixels across, so
                          // that frames of any size weigh alike; 0: of this one; default 0
    uint32_t matte_depth_bins; // 0..10: types by octave of the way; default 0: one type
    enum glint_filter_kind filter;
    float filter_width;   // pixels, 0.5..16; default blackman_harris 1.5... box 1
    uint32_t max_bounces; // 0..1024; default 8
    uint32_t frame;       // number of the frame; time is frame / fps
    float fps;            // frames per second, 0: the scene's
    float shutter[2];     // opens and closes, in frames from `frame` on; -16..16, default 0 0
    char *animation;      // id or name; NULL: the scene's first; "none": the scene at rest
    enum glint_estimate_kind estimate;
    bool adaptive; // noisier parts get more samples; stop.samples is their mean
    bool live;     // follows the scene's revisions and camera moves
    uint32_t seed;
    // First index and the one after the last, where only these of a frame's samples are wanted:
    // stop.samples is their number. Both 0: all from the first on, until it stops.
    uint32_t sample_range[2];
    struct glint_job_stop stop; // absent: GLINT_DEFAULT_SAMPLES
    int32_t priority;           // -100..100
    double known_bias; // no member: an error, relative, that no sample takes away, where a front of
                       // the scene knows that of these settings; 0: not known, or none
};

// Reads the JSON of a job. Unknown keys, and settings of methods that do not exist, are faults.
// `camera` and `scene` are not looked up here.
glint_status glint_job_parse(struct glint_job **out, const char *text, size_t length,
                             struct glint_error *err);

// Initialises *out as an equal job with strings of its own, which glint_arena_finish(&out->arena)
// frees. GLINT_E_NOMEM: there is nothing to free.
glint_status glint_job_copy(struct glint_job *out, const struct glint_job *job,
                            struct glint_error *err);

void glint_job_destroy(struct glint_job **job);

// The job with every default spelled out, as one line of JSON (malloc'd), or NULL without memory.
// Parsing it gives an equal job.
char *glint_job_write(const struct glint_job *job);

#endif
