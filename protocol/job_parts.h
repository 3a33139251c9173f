// job_parts.h - what reading and writing jobs share. Not for others.
#ifndef GLINT_PROTOCOL_JOB_PARTS_H
#define GLINT_PROTOCOL_JOB_PARTS_H

#include "fields.h"
#include "job.h"

extern const struct glint_field glint_job_fields[], glint_filter_fields[], glint_stop_fields[],
    glint_budget_fields[],                // members of `accuracy` that are no dials
    glint_matte_fields[];                 // mattes that are no dials
extern const float glint_filter_widths[]; // default of each kind

#endif
