// spawn.h - a private daemon for the life of one command.
//
// It listens on a free port of 127.0.0.1, keeps its state in a temporary directory that is removed
// afterwards, and is terminated by the kernel should this process die.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_SPAWN_H
#define GLINT_CLI_SPAWN_H

#include "protocol/status.h"

#include <stdbool.h>

typedef struct glint_daemon glint_daemon;

// Starts glintd: the one beside this program, else the one in libexec, else the one on PATH.
// Returns when it can serve. GLINT_E_UNAVAILABLE: there is none, or it ended; *err has the end of
// its log.
glint_status glint_spawn_start(glint_daemon **out, struct glint_error *err);

// "http://127.0.0.1:PORT"
const char *glint_spawn_url(const glint_daemon *daemon);

// Appends the end of its log to *err if it has ended by itself. After a lost connection: waits a
// moment for that, since sockets close before their process is gone.
void glint_spawn_explain(glint_daemon *daemon, struct glint_error *err);

// Terminates it, waits for its end, removes its state. NULL is fine inside.
void glint_spawn_stop(glint_daemon **daemon);

#endif
