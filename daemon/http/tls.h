// tls.h - the certificate that the server shows, exchanged while it serves.
//
// The only file that names gnutls_*. There is one at most, because the HTTP library asks for the
// certificate without saying for whom.
//
// Thread-safety: create, load and destroy by main; handshakes run beside a load.
#ifndef GLINT_HTTP_TLS_H
#define GLINT_HTTP_TLS_H

#include "protocol/status.h"

typedef struct glint_tls glint_tls;

// cert: the chain, ours first; key: its private key, which only its owner and group may read. Both
// PEM.
//   GLINT_E_IO     a file cannot be read, or too many may
//   GLINT_E_RANGE  it is no certificate, no key, or they do not belong together
glint_status glint_tls_create(glint_tls **out, const char *cert, const char *key,
                              struct glint_error *err);
// The same for a running server: new connections are shown the new one. On failure the one before
// stays.
glint_status glint_tls_load(glint_tls *tls, const char *cert, const char *key,
                            struct glint_error *err);
void glint_tls_destroy(glint_tls **tls); // after the server

// For the HTTP library: its gnutls_certificate_retrieve_function2, and the versions to offer.
void *glint_tls_callback(void);
const char *glint_tls_priorities(void);

#endif
