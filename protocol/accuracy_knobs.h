// accuracy_knobs.h - what `glint accuracy` turns: every dial and every number that trades accuracy
// for cost, with its exact setting, its ladder, and what in a scene calls for it.
//
// Settings are JSON values as text. The rows of dials take theirs from dials.h; nothing is listed a
// second time. The second table has the methods of the design that have no row, because no method
// is built yet.
//
// Thread-safety: constant.
#ifndef GLINT_PROTOCOL_ACCURACY_KNOBS_H
#define GLINT_PROTOCOL_ACCURACY_KNOBS_H

#include "dials.h"

#include <stdbool.h>

enum glint_accuracy_metric {
    GLINT_METRIC_COLOUR, // rmse61, relative MSE, bias against variance
    GLINT_METRIC_MATTE,  // coverage: absolute error, total variation, lost
    GLINT_METRICS
};
extern const char *const glint_accuracy_metric_name[GLINT_METRICS];

#define GLINT_MAX_LADDER 10

struct glint_knob {
    enum glint_dial dial;     // GLINT_DIAL_COUNT: a plain member of the job
    const char *parent;       // of a plain member: the object that has it, "": the job itself
    const char *name, *exact; // likewise
    const char *ladder[GLINT_MAX_LADDER + 1];
    const char *twin; // setting in the exact twin where another of equal expectation costs less
    const char *with; // JSON merged into a job that leaves the twin's setting; NULL: nothing
    const char *base; // JSON merged into every job of the row, its exact twin's too: a row with one
                      // has a reference of its own; NULL: the row shares that of its metric
    enum glint_accuracy_metric metric;
    bool other_question;    // its settings ask for another picture: none of them is wrong
    const char *effects[3]; // the scene calls for it if any is on; none: always
};

extern const struct glint_knob glint_knob_table[];
extern const size_t glint_knob_count;

// Of either kind of row.
const char *glint_knob_name(const struct glint_knob *knob);
const char *glint_knob_parent(const struct glint_knob *knob);
// Setting 0 is the exact one, then the ladder; NULL behind the last.
const char *glint_knob_setting(const struct glint_knob *knob, size_t index);
const char *glint_knob_twin(const struct glint_knob *knob);
// Whether setting `index` has the expectation of the exact one, for any scene.
bool glint_knob_unbiased(const struct glint_knob *knob, size_t index);

struct glint_unbuilt {
    const char *approximation, *exact, *metric;
};
extern const struct glint_unbuilt glint_unbuilt_table[]; // NULL approximation ends it

#endif
