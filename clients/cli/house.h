// house.h - what a daemon does at one moment: its jobs, its workers, its memory.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_HOUSE_H
#define GLINT_CLI_HOUSE_H

#include "session.h"

struct glint_house {
    double seconds; // of this machine's clock, from anywhere
    cJSON *jobs;    // array, in order of submission
    double workers, busy_seconds;
    double scene_bytes, film_bytes, resident_bytes; // NAN: it does not tell
};

glint_status glint_house_look(struct glint_session *s, struct glint_house *out,
                              struct glint_error *err);
void glint_house_finish(struct glint_house *house);

// Workers that were at work on average from one moment to the next, NAN where there is none.
double glint_house_busy(const struct glint_house *before, const struct glint_house *now);

// Gives each job of `now` the number "workers": how many it had on average since `before`.
void glint_house_compare(const struct glint_house *before, struct glint_house *now);

// Value of a sample without labels in Prometheus text, or NAN.
double glint_house_metric(const char *text, const char *name);

#endif
