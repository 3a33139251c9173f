// pixels.h - a job's render, opened for a request that wants something of it.
#ifndef GLINT_HTTP_PIXELS_H
#define GLINT_HTTP_PIXELS_H

#include "http/request.h"

// Opens the view of the job argument[0]. With ?wait=done the request waits until the job has
// ended, and only a job that is done will do. False: there is an answer, or the request waits.
// Faults already in *err are answered with; it is finished in any case.
bool glint_pixels_open(struct glint_request *r, struct glint_job_view *view,
                       struct glint_error *err);

static inline bool glint_pixels_final(const struct glint_job_view *view)
{
    return view->state >= GLINT_JOB_DONE;
}

#endif
