// accept.h - takes connections from the listening socket and hands them to the HTTP library.
//
// The library could listen itself, but cannot be told to stop safely: MHD_quiesce_daemon of 0.9.75 ends
// the process if one of the library's threads takes the socket out of its epoll set just then.
//
// Thread-safety: start and stop by one thread each, one after the other.
#ifndef GLINT_HTTP_ACCEPT_H
#define GLINT_HTTP_ACCEPT_H

#include "protocol/status.h"

#include <microhttpd.h>

typedef struct glint_accept glint_accept;

// fd: listening; taken on success. mhd outlives it.
//   GLINT_E_NOMEM, GLINT_E_IO, GLINT_E_CAPACITY
glint_status glint_accept_start(glint_accept **out, struct MHD_Daemon *mhd, int fd,
                                struct glint_error *err);

// Closes the socket: from then on who connects is refused. NULL: nothing.
void glint_accept_stop(glint_accept **accept);

#endif
