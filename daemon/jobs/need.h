// need.h - what a job will take of the memory, estimated before anything is spent.
//
// Thread-safety: any thread.
#ifndef GLINT_JOBS_NEED_H
#define GLINT_JOBS_NEED_H

#include "protocol/job.h"
#include "scene/resident.h"

#include <stdint.h>

struct glint_need {
    uint64_t film;  // its film, and a wave for each worker: its own while it has a render
    uint64_t scene; // at most what is made for it of the scene at rest: the pose of its frame with
                    // records, and the structure that its rays go through
};
// scene: at rest. request: the moments that the job shows.
void glint_need_estimate(struct glint_need *out, const struct glint_resident *scene,
                         const struct glint_pose_request *request, const struct glint_job *job,
                         uint32_t workers);

#endif
