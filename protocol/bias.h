// bias.h - the approximations that a job runs under: settings whose picture or mattes do not go to
// those of the exact ones, however many samples there are. The table of dials says which those are.
//
// A set has bit 1 << d for dial d, and one for a bound on the length of paths.
//
// Thread-safety: reentrant.
#ifndef GLINT_PROTOCOL_BIAS_H
#define GLINT_PROTOCOL_BIAS_H

#include "job.h"

#include <cjson/cJSON.h>

#define GLINT_BIAS_BOUNCES (1u << GLINT_DIAL_COUNT)

// Those that the job asks for, whether its scene has anything that they change or not.
uint32_t glint_biases_asked(const struct glint_job *job);

// [{"name": "accuracy.traversal", "setting": "fast", "of": "picture" or "mattes", "detail": ...}]
cJSON *glint_biases_describe(uint32_t biases, const struct glint_job *job);

// Those of the set that change the picture, not the mattes alone.
uint32_t glint_biases_of_picture(uint32_t biases);

// The names alone, and back: unknown ones are left out; NULL is none.
cJSON *glint_biases_names(uint32_t biases);
uint32_t glint_biases_named(const cJSON *names);

#endif
