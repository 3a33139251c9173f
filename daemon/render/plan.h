// plan.h - what one job simulates: the rows of the effects table that are on, and all that follows.
//
// Thread-safety: made once, immutable afterwards.
#ifndef GLINT_RENDER_PLAN_H
#define GLINT_RENDER_PLAN_H

#include "render/effects.h"

#include <cjson/cJSON.h>

struct glint_plan {
    uint64_t called;    // rows that scene and job call for
    uint64_t on;        // those and the forced ones
    uint32_t passes;    // bits 1 << glint_pass
    uint32_t carries;   // bits 1 << GK_COL_* of the path columns that effects want
    char options[1024]; // -D..., in table order: with the source, the key of the program variant
    size_t film_bytes;  // per pixel
    uint32_t biases;    // approximations that scene and job are under, of protocol/bias.h
};

// force: rows to switch on although nothing calls for them (tests and benches).
void glint_plan_make(struct glint_plan *out, const struct glint_effect_input *in, uint64_t force);

bool glint_plan_has(const struct glint_plan *plan, enum glint_pass pass);

// What the plan of a job has measured and allocated so far.
struct glint_plan_use {
    const glint_resident *scene;
    const struct glint_job *job;
    const double *seconds; // [GLINT_PASSES]
    uint64_t pixels;       // of the film
};

// The plan as clients see it. An effect that runs inside a pass which others share has no share of
// its own: the pass has one.
cJSON *glint_plan_describe(const struct glint_plan *plan, const struct glint_plan_use *use);

#endif
