// accuracy_front.h - what was measured of a scene's settings, for choosing among them by price.
//
// A point is one way to render: settings of a job, what a sample costs and how its error falls.
//   error(n)^2 = bias^2 + variance / n       relative, as a job's own error; on average
//   its noise is below variance / n x (1 + 2 spread / sqrt(n)) nearly always; of an image with fewer
//   pixels than the front's the spread is larger, by the root of their ratio
//   seconds(n) = n x pixels x seconds / workers
//
// Thread-safety: immutable once read.
#ifndef GLINT_PROTOCOL_ACCURACY_FRONT_H
#define GLINT_PROTOCOL_ACCURACY_FRONT_H

#include "dials.h"
#include "status.h"

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>

#define GLINT_MAX_FRONT_POINTS 256

// Bit 1 << dial, and this one for the bounces.
#define GLINT_CHOICE_BOUNCES (1u << GLINT_DIAL_COUNT)

struct glint_front_point {
    uint8_t dial[GLINT_DIAL_COUNT]; // settings; those of mattes are not chosen by price
    uint32_t max_bounces;
    double seconds;  // of one worker, for a sample of one pixel, > 0
    double rays;     // likewise
    double variance; // relative, of one sample, >= 0
    double bias;     // relative, upper end of its 95% interval, >= 0
    double spread;   // of an image's squared error over seeds, over its mean, of one sample and the
                     // front's resolution; 0: none
    char row[128];   // of the table that it comes from
};

struct glint_front {
    char revision[65]; // of the scene that it was measured on, "": not said
    double pixels;     // of its images, 0: not said
    size_t points;
    struct glint_front_point point[]; // [points]
};

// A front is {"revision", "build", "resolution", "seeds", "points": [{"settings": {"accuracy": {},
// "max_bounces"}, "seconds", "rays", "variance", "bias", "spread", "row"}]}. Faults as a job's.
// *out is freed with free().
glint_status glint_front_parse(struct glint_front **out, const char *text, size_t length,
                               struct glint_error *err);

// The point that has those settings; NULL: none.
const struct glint_front_point *glint_front_find(const struct glint_front *front,
                                                 const struct glint_front_point *settings);

// The samples that a budget asks for, and what comes of them. None suits: false.
struct glint_front_choice {
    size_t point;
    double samples, error, seconds; // expected
};
struct glint_front_wish {
    double seconds, error; // one of them, the other 0
    double pixels, workers;
    uint32_t pinned; // GLINT_CHOICE_ bits: settings that must be `at`'s
    const struct glint_front_point *at;
    uint32_t max_samples;
};
bool glint_front_choose(const struct glint_front *front, const struct glint_front_wish *wish,
                        struct glint_front_choice *out);

#endif
