// watch.h - one thread that sees what the HTTP library does not: jobs that change, clients that
// leave while their connection is suspended, and connections that dawdle.
//
// Clients go by number, which is never used twice: a client that is gone is not an error.
//
// Thread-safety: any thread, except create and destroy. `left` and `reads` are called on the
// watcher's thread under its mutex, so they must not call back into this module.
#ifndef GLINT_HTTP_WATCH_H
#define GLINT_HTTP_WATCH_H

#include "protocol/status.h"

#include <stdint.h>

typedef struct glint_watch glint_watch;

// `round` is called on the watcher's thread soon after each wake, never more often than every
// 2 ms, and at least every 250 ms.
glint_status glint_watch_create(glint_watch **out, void (*round)(void *user), void *user,
                                struct glint_error *err);
void glint_watch_destroy(glint_watch **watch);

void glint_watch_wake(glint_watch *watch); // never blocks

// From accept to close. The socket is shut down when the deadline passes, `seconds` from now.
// Returns the client's number, 0 without memory.
uint64_t glint_watch_add(glint_watch *watch, int fd, double seconds);
void glint_watch_remove(glint_watch *watch, uint64_t client);
void glint_watch_deadline(glint_watch *watch, uint64_t client, double seconds); // INFINITY: none

// Calls left(user) once if the client closes its end; NULL ends that. Where `reads` is given, calls
// reads(user) whenever the socket takes bytes again, and a round follows.
void glint_watch_attend(glint_watch *watch, uint64_t client, void (*left)(void *user),
                        void (*reads)(void *user), void *user);

uint32_t glint_watch_clients(glint_watch *watch); // connections that are open

#endif
