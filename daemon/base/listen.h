// listen.h - the socket that the daemon serves.
//
// Thread-safety: reentrant.
#ifndef GLINT_BASE_LISTEN_H
#define GLINT_BASE_LISTEN_H

#include "protocol/status.h"

#include <stdbool.h>

#define GLINT_URL_BYTES 80

// What stands between the socket and who reaches it. Without both only this machine may.
struct glint_guard {
    bool tokens, tls;
};

// Listens on ADDR:PORT (an IPv6 address in brackets; port 0: a free one) and says where, as
// http://ADDR:PORT, https with TLS. *fd is close-on-exec and non-blocking, the caller's.
//   GLINT_E_RANGE        not ADDR:PORT, or no loopback address without both guards
//   GLINT_E_UNAVAILABLE  the system refuses it, e.g. as in use
glint_status glint_listen(int *fd, char url[GLINT_URL_BYTES], const char *address,
                          struct glint_guard guard, struct glint_error *err);

// The same for a socket that was opened elsewhere: it stays the caller's, also on failure.
//   GLINT_E_RANGE        no listening TCP socket, or no loopback address without both guards
glint_status glint_listen_adopt(int fd, char url[GLINT_URL_BYTES], struct glint_guard guard,
                                struct glint_error *err);

#endif
