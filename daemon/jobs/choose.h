// choose.h - a job that says what it may take, or must reach, gets its settings from a front.
//
// Thread-safety: any thread that may wait for a disk.
#ifndef GLINT_JOBS_CHOOSE_H
#define GLINT_JOBS_CHOOSE_H

#include "jobs/price.h"
#include "protocol/job.h"
#include "scene/store.h"

// Sets dials, bounces and stop of a job with a budget; what the job says itself stays. *chosen tells
// what was picked from what, and what is expected of it; NULL: the job has no budget.
// Sets the job's known bias: of what was picked; of a job without a budget, where its settings change
// the picture and a front of its scene has a point with them.
//   GLINT_E_RANGE  no settings measured reach what is asked; says what can be reached
glint_status glint_choose(cJSON **chosen, glint_prices *prices, const glint_revision *revision,
                          uint32_t workers, struct glint_job *job, struct glint_error *err);

// What GET .../front answers: {"scene", "from", "class", "current", "front": {...}}.
cJSON *glint_choose_describe(glint_prices *prices, const char *scene,
                             const glint_revision *revision, struct glint_error *err);

#endif
