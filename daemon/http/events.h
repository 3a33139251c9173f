// events.h - what happened to the jobs that somebody watches, in the order it was noticed.
//
// A topic is a job's ring of events, each made once for all who read it. What happened between two
// looks shows as one change.
//
// An event's id is the time at which its cause became known, microseconds since 1970, raised where
// needed so that ids of a topic grow. A client may resume only after an id that is still in the ring;
// so neither a restart nor a clock that was set back can make it miss an event.
//
// Thread-safety: any thread.
#ifndef GLINT_HTTP_EVENTS_H
#define GLINT_HTTP_EVENTS_H

#include "http/server.h"

glint_status glint_topics_create(glint_topics **out, struct glint_error *err);
void glint_topics_destroy(glint_topics **topics); // nobody reads

// Looks at the jobs with readers. cause_us: when it became known that there is news, on the ids'
// clock. Watcher's thread.
void glint_topics_round(glint_http *http, uint64_t cause_us);

// The ids' clock.
uint64_t glint_topics_clock(void);

#endif
