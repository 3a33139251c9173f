// house.h - what a daemon does at one moment: its jobs, its workers, its memory.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_HOUSE_H
#define GLINT_CLI_HOUSE_H

#include "session.h"

struct glint_house {
    double seconds; // of this machine's clock, from anywhere
    cJSON *jobs;    // {"jobs": [...]} in order of submission
    cJSON *stats;   // GET /v1/stats
};

glint_status glint_house_look(struct glint_session *s, struct glint_house *out,
                              struct glint_error *err);
void glint_house_finish(struct glint_house *house);

// Shares of the workers that are at work, together.
double glint_house_busy(const struct glint_house *house);

// Gives each job of `now` the number "workers": how many it had on average since `before`.
void glint_house_compare(const struct glint_house *before, struct glint_house *now);

#endif
