// invariants.h - what a job has counted against the rules that hold for every sample, in its
// resource.
//
// Thread-safety: reentrant.
#ifndef GLINT_JOBS_INVARIANTS_H
#define GLINT_JOBS_INVARIANTS_H

#include "render/render.h"

// Adds the member "invariants".
void glint_invariants_add(cJSON *object, const struct glint_render_state *state);

// Adds to an array of strings what its owner should know of.
void glint_invariants_warn(cJSON *warnings, const struct glint_render_state *state);

// Adds the member "ranks", of a job whose names have been counted against its levels.
void glint_invariants_ranks(cJSON *object, const struct glint_matte_excess *excess);

// Adds what its files leave out, of a job that has ended: before, it changes.
void glint_invariants_warn_of_ranks(cJSON *warnings, const struct glint_matte_excess *excess,
                                    const struct glint_job *job);

#endif
