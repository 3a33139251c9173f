// film_header.h - the JSON at the head of a film's file: whose film it is, and how far it was.
//
// Thread-safety: reentrant.
#ifndef GLINT_PROTOCOL_FILM_HEADER_H
#define GLINT_PROTOCOL_FILM_HEADER_H

#include "counts.h"
#include "film.h"
#include "film_levels.h"

#include <cjson/cJSON.h>

#define GLINT_MAX_FILM_HEADER ((size_t)1 << 28) // bytes of JSON
#define GLINT_CURVE_POINTS 26                   // powers of two up to GLINT_MAX_SAMPLES, and 12

// One point of the recorded curve at each power of two (samples) since the start, and at 12, so
// that at 16 there are five.
struct glint_convergence_point {
    uint32_t samples;
    double seconds, error;
    double spread; // standard deviation of the logarithm of the error's square, NAN: not known
    uint64_t rays;
};

// A job's own estimate of its error; NAN where not known. v: variance of a pixel's mean, m: what that
// mean is taken for.
struct glint_estimate {
    double error;       // sqrt(mean of v / (m^2 + 0.01)) over pixels and r, g, b
    double spread;      // as above
    double linear;      // sqrt(mean of v), likewise
    double tone_mapped; // after T(c) = c / (1 + max(r, g, b)): sqrt(mean over pixels of the sum)
    double tail; // Hill's index of the worst hundredth of pixel variances: at most this, 95 %
    double lift; // what `error` may be by the neighbours' means, over that by the pixels' own, >= 1
};

// A film at one moment. Its tiles have the samples [first, sample) of the job, and [first, sample +
// samples) where a block of the pass under way is done.
struct glint_film_moment {
    bool complete;                        // no sample will be taken
    bool stopped;                         // by its error
    uint32_t sample, samples, tiles_log2; // the pass: blocks of 2^n tiles a side; samples 0: none
    uint32_t target;                      // sample index at which the job ends at the latest
    struct glint_estimate estimate;
    double worker_seconds;
    uint64_t camera_rays, bounce_rays, shadow_rays;
    const char *shares; // of an adaptive job behind its pilot, a letter for each tile; else NULL
    uint32_t biases;    // approximations that it was rendered under, of bias.h
    uint64_t count[GLINT_COUNTS];
    struct glint_matte_excess excess; // when the last pass ended
    uint32_t points;
    struct glint_convergence_point curve[GLINT_CURVE_POINTS];
};

struct glint_film_header {
    struct glint_film_info info;
    struct glint_film_moment moment;
    cJSON *seconds; // of each pass by its name; NULL: none
    cJSON *plan;    // as clients see it; NULL: none
    // Where it was read; else NULL and zero.
    struct glint_job *job;
    struct glint_arena arena;
};

// One line of JSON, malloc'd, or NULL without memory.
char *glint_film_header_write(const struct glint_film_header *header, size_t *length);

// Reads what somebody else may have written. GLINT_E_SYNTAX, GLINT_E_RANGE, ... for all that is
// wrong with it, pointers into the header.
glint_status glint_film_header_parse(struct glint_film_header **out, const char *text,
                                     size_t length, struct glint_error *err);
void glint_film_header_destroy(struct glint_film_header **header);

// Whether two films are of one job in the same revision, so that their samples may be mixed: all
// that decides what a sample is. `parts`: regions and sample ranges may differ. A fault for each
// member that does not agree, at its pointer in the job; `who` says whose it is.
glint_status glint_film_same(const struct glint_film_info *a, const struct glint_film_info *b,
                             bool parts, const char *who, struct glint_error *err);

#endif
