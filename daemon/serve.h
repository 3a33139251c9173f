// serve.h - what a daemon that runs does until it is told to end.
//
// Threads: main's.
#ifndef GLINT_SERVE_H
#define GLINT_SERVE_H

#include "house.h"

#include <signal.h>

// The signals that glint_serve waits for; blocked in every thread from the start on.
void glint_serve_signals(sigset_t *set);

// Says that it serves, then heeds signals: SIGHUP reads settings, tokens and certificates again,
// SIGUSR1 writes checkpoints, SIGTERM and SIGINT drain. Returns when the server has drained; what
// comes after is finish's. A second SIGTERM or SIGINT exits at once, with status 1.
void glint_serve(struct glint_house *house);

// Ends what glint_serve has started to tell the service manager that it is still at work.
void glint_serve_finish(void);

#endif
