// admit.h - what is checked and gathered when a job is submitted, on the submitter's thread.
//
// Thread-safety: any thread.
#ifndef GLINT_JOBS_ADMIT_H
#define GLINT_JOBS_ADMIT_H

#include "jobs/price.h"
#include "jobs/table.h"

// What jobs are admitted to.
struct glint_admission {
    glint_store *store;
    glint_prices *prices;
    uint32_t workers; // how many there are
};

// An entry that no table has yet, with one reference, the scene's current revision pinned, the
// settings picked where the job has a budget. Takes `job` on success.
glint_status glint_admit(struct glint_entry **out, const struct glint_admission *to,
                         struct glint_job *job, const struct glint_submission *from,
                         struct glint_error *err);

// The camera that `job` names is in the revision.
glint_status glint_admit_camera(const glint_revision *revision, const struct glint_job *job,
                                struct glint_error *err);

#endif
