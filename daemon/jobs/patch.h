// patch.h - the merge patch that PATCH /v1/jobs/{id} takes.
//
// Thread-safety: reentrant.
#ifndef GLINT_JOBS_PATCH_H
#define GLINT_JOBS_PATCH_H

#include "jobs/look.h"

struct glint_job_patch {
    bool has_priority, has_paused, has_seconds;
    int32_t priority;
    bool paused;
    double seconds;          // stop.seconds, 0: none
    struct glint_look *look; // owned; NULL: the camera stays
};

// Reads a merge patch (RFC 7396) of `priority`, `paused`, `stop.seconds` and `camera`; null sets a
// member's default. How many samples a job takes and which error ends it is settled when it is
// submitted.
//   GLINT_E_SYNTAX  not JSON
//   GLINT_E_RANGE   unknown members, values out of range; every fault in *err
glint_status glint_job_patch_parse(struct glint_job_patch *out, const char *text, size_t length,
                                   struct glint_error *err);
void glint_job_patch_finish(struct glint_job_patch *patch);

#endif
