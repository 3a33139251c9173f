// events.h - what happened to the jobs that somebody watches, in the order it was noticed.
//
// A topic is a job's ring of events. It is brought up to date by whoever reads it; what happened
// between two looks shows as one change. Event ids grow for ever, also across restarts.
//
// Thread-safety: any thread.
#ifndef GLINT_HTTP_EVENTS_H
#define GLINT_HTTP_EVENTS_H

#include "protocol/status.h"

typedef struct glint_topics glint_topics;

glint_status glint_topics_create(glint_topics **out, struct glint_error *err);
void glint_topics_destroy(glint_topics **topics); // nobody reads

#endif
