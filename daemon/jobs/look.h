// look.h - the camera that a live job was given after it was submitted.
//
// Thread-safety: immutable and counted; retain and release by any thread.
#ifndef GLINT_JOBS_LOOK_H
#define GLINT_JOBS_LOOK_H

#include "protocol/job.h"
#include "protocol/json.h"

#include <stdatomic.h>

struct glint_look {
    atomic_uint references;
    struct glint_job *job; // owned; only what it says of the camera counts
    cJSON *camera;         // owned: as the client said it, null for the default
};

// Reads what a job may say as its camera, or null: that of a job which says nothing.
//   GLINT_E_RANGE  every fault in *err, with pointers from /camera on
//   GLINT_E_NOMEM
glint_status glint_look_parse(struct glint_look **out, const cJSON *camera,
                              struct glint_error *err);
struct glint_look *glint_look_retain(struct glint_look *look); // NULL in, NULL out
void glint_look_release(struct glint_look **look);

// `job` with this camera, whose strings it borrows; NULL: its own.
struct glint_job glint_look_apply(const struct glint_look *look, const struct glint_job *job);

#endif
