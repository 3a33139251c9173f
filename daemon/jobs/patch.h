// patch.h - the merge patch that PATCH /v1/jobs/{id} takes.
//
// Thread-safety: reentrant.
#ifndef GLINT_JOBS_PATCH_H
#define GLINT_JOBS_PATCH_H

#include "jobs/look.h"

struct glint_job_patch {
    bool has_priority, has_paused;
    bool has_samples, has_seconds, has_error; // of `stop`
    int32_t priority;
    bool paused;
    struct glint_job_stop stop;
    struct glint_look *look; // owned; NULL: the camera stays
};

// Reads a merge patch (RFC 7396) of `priority`, `paused`, `stop` and `camera`; null sets a member's
// default: a member of `stop` then imposes nothing, and `stop` itself is that of a job which has
// none.
//   GLINT_E_SYNTAX  not JSON
//   GLINT_E_RANGE   unknown members, values out of range; every fault in *err
glint_status glint_job_patch_parse(struct glint_job_patch *out, const char *text, size_t length,
                                   struct glint_error *err);
// `stop` as it is with the patch.
struct glint_job_stop glint_job_patch_stop(const struct glint_job_patch *patch,
                                           const struct glint_job_stop *stop);
bool glint_job_patch_stops(const struct glint_job_patch *patch); // it has a member of `stop`

void glint_job_patch_finish(struct glint_job_patch *patch);

#endif
