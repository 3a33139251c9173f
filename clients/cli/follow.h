// follow.h - a job from now to its end, by its event stream.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_FOLLOW_H
#define GLINT_CLI_FOLLOW_H

#include "session.h"

// Shows progress and warnings until the job has ended; *job is then its resource. A stream that
// breaks off is taken up where it was. Ends s->tev.
glint_status glint_follow_job(struct glint_session *s, const char *id, cJSON **job,
                              struct glint_error *err);

// GLINT_OK for a job that is done, else what became of it (a failed job's problem).
glint_status glint_follow_verdict(struct glint_session *s, const cJSON *job,
                                  struct glint_error *err);

// True for done, failed and cancelled.
bool glint_follow_ended(const char *state);

#endif
