// media.h - which kind of scene a body is: what Content-Type says, held against its first bytes.
//
// Thread-safety: reentrant.
#ifndef GLINT_HTTP_MEDIA_H
#define GLINT_HTTP_MEDIA_H

#include "http/request.h"

#define GLINT_MAX_MEDIA 9 // that a route takes, with room for the end of the list

// Types of scenes, NULL-terminated.
extern const char *const glint_media_scenes[GLINT_MAX_MEDIA];

// True when the header's type is `type`, whatever its parameters.
bool glint_media_is(const char *header, const char *type);

// Fills type, bytes, size, fd and boundary in from the request; `boundary` has to live as long.
//   GLINT_E_SYNTAX      the body is empty
//   GLINT_E_MEDIA_TYPE  it is something else than its type says, or neither type nor bytes tell
glint_status glint_media_source(struct glint_request *r, char boundary[GLINT_MAX_BOUNDARY + 1],
                                struct glint_import_source *out, struct glint_error *err);

#endif
