// dispatch.h - from the library's callbacks to a handler on its lane and back.
#ifndef GLINT_HTTP_DISPATCH_H
#define GLINT_HTTP_DISPATCH_H

#include "http/request.h"

// The library's access handler and its notice that a request is over. user: the glint_http.
enum MHD_Result glint_dispatch_request(void *user, struct MHD_Connection *connection,
                                       const char *url, const char *method, const char *version,
                                       const char *data, size_t *size, void **context);
void glint_dispatch_completed(void *user, struct MHD_Connection *connection, void **context,
                              enum MHD_RequestTerminationCode code);

// Calls the handlers of parked requests again whose jobs have ended. Watcher's thread.
void glint_dispatch_parked(glint_http *http);

#endif
