// restart.h - the jobs of the daemon that ran before.
//
// Threads: the creator of the jobs, before anybody else knows of them.
#ifndef GLINT_JOBS_RESTART_H
#define GLINT_JOBS_RESTART_H

#include "jobs/checkpoint.h"
#include "jobs/scheduler.h"

// Hands every job of the journal to the scheduler, in order of submission: those that had not ended
// are queued or paused again, with their priority, the seconds they had used and their last film.
// A row that makes no sense is logged and left as it is.
glint_status glint_jobs_recall(glint_checkpoints *checkpoints, glint_store *store,
                               glint_scheduler *scheduler, struct glint_error *err);

#endif
