// use.h - what a worker does, and how busy it has been of late.
//
// Thread-safety: of whoever owns the struct.
#ifndef GLINT_JOBS_USE_H
#define GLINT_JOBS_USE_H

#include "jobs/jobs.h"

struct glint_use {
    double seconds;               // of all slices that have ended
    double share, seen;           // busy of late, 0..1, as of glint_now() == seen
    char job[GLINT_JOB_ID_BYTES]; // of the slice that it runs, "": none
};

// It runs a slice of `job` from `now` on; NULL: nothing.
void glint_use_set(struct glint_use *use, const char *job, double now);
// A slice has ended that took so long.
void glint_use_add(struct glint_use *use, double seconds);
// What it is at `now`, to be shown.
struct glint_worker_use glint_use_look(const struct glint_use *use, double now);

#endif
