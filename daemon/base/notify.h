// notify.h - what the service manager is told, and the sockets that it hands over.
//
// The only file that names sd_* (log.c writes to the journal). Without a service manager, which is
// without $NOTIFY_SOCKET, nothing is told to nobody.
//
// Thread-safety: any thread; glint_notify_socket by main, before other threads exist.
#ifndef GLINT_BASE_NOTIFY_H
#define GLINT_BASE_NOTIFY_H

#include "protocol/status.h"

// Start and every reload are over. The status is a line for people.
void glint_notify_ready(const char *format, ...) __attribute__((format(printf, 1, 2)));
void glint_notify_status(const char *format, ...) __attribute__((format(printf, 1, 2)));
void glint_notify_reloading(void);
void glint_notify_stopping(void);

// While it starts or ends: it will take no longer than this from now on without saying so again.
void glint_notify_more_time(double seconds);

// Seconds after which a process that was not alive is killed, 0: never. $WATCHDOG_USEC.
double glint_notify_watchdog(void);
void glint_notify_alive(void);

// The socket that was passed, or -1 where none was ($LISTEN_FDS, $LISTEN_PID). Of several the one
// named "http" ($LISTEN_FDNAMES). The environment forgets them; the others are closed.
//   GLINT_E_RANGE  several, and none is named so
glint_status glint_notify_socket(int *fd, struct glint_error *err);

#endif
