// outlook.h - a job's own error, what it does not see of it, and when it will be where it is to be:
// the member `estimate` of PROTOCOL's resources.
//
// Thread-safety: reentrant.
#ifndef GLINT_JOBS_OUTLOOK_H
#define GLINT_JOBS_OUTLOOK_H

#include "render/render.h"

#include <cjson/cJSON.h>

// A new object. parallel: seconds of the job for a second of one worker, NAN: not known yet. Numbers
// that are not known are null; so is the forecast of a job that has `ended` or has no error to reach.
cJSON *glint_outlook_describe(const struct glint_render_state *state, const struct glint_job *job,
                              double parallel, bool ended);

// What a journal keeps of it, as members of `object`, and back.
void glint_outlook_write(cJSON *object, const struct glint_render_state *state);
void glint_outlook_read(struct glint_render_state *state, const cJSON *object);

#endif
