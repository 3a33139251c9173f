// listen.h - the socket that the daemon serves.
//
// Thread-safety: reentrant.
#ifndef GLINT_BASE_LISTEN_H
#define GLINT_BASE_LISTEN_H

#include "protocol/status.h"

#define GLINT_URL_BYTES 80

// Listens on ADDR:PORT (an IPv6 address in brackets; port 0: a free one) and says where, as
// http://ADDR:PORT. Only loopback addresses: others need tokens and TLS, which do not exist.
// *fd is close-on-exec and non-blocking, the caller's.
//   GLINT_E_RANGE        not ADDR:PORT, or no loopback address
//   GLINT_E_UNAVAILABLE  the system refuses it, e.g. as in use
glint_status glint_listen(int *fd, char url[GLINT_URL_BYTES], const char *address,
                          struct glint_error *err);

#endif
