// accuracy_render.h - one job of `glint accuracy`: a seed of a setting, looked at on its way.
//
// The job is extended from one number of samples to the next, and forgotten at its end.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_ACCURACY_RENDER_H
#define GLINT_CLI_ACCURACY_RENDER_H

#include "protocol/frame.h"
#include "session.h"

struct glint_accuracy_look {
    unsigned spp;
    double rays[3], cpu, wall; // up to here; NAN: not told
    double error;              // the job's own estimate
    struct glint_frame *frame; // borrowed
};

struct glint_accuracy_order {
    const cJSON *job; // without seed and stop
    uint32_t seed;
    const unsigned *ladder; // samples to look at, ascending
    size_t steps;
    glint_status (*look)(void *user, const struct glint_accuracy_look *look,
                         struct glint_error *err);
    void *user;
};

// What a failed job failed with, what `look` answers, or GLINT_OK.
glint_status glint_accuracy_render(struct glint_session *s,
                                   const struct glint_accuracy_order *order,
                                   struct glint_error *err);

// The plan of a job with one sample; a new object.
glint_status glint_accuracy_ask_plan(struct glint_session *s, const cJSON *job, cJSON **plan,
                                     struct glint_error *err);

#endif
