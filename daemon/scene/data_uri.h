// data_uri.h - "data:" URIs (RFC 2397), the only kind that a scene may hold.
//
// Thread-safety: reentrant.
#ifndef GLINT_SCENE_DATA_URI_H
#define GLINT_SCENE_DATA_URI_H

#include "protocol/status.h"

#include <stdbool.h>
#include <stdint.h>

bool glint_data_uri_is(const char *uri);

// Decodes the payload, base64 (RFC 4648, padding may be absent) or percent-encoded. The media type
// is not looked at: what reads the bytes knows them by their signature.
// GLINT_OK: *bytes is malloc'd (never NULL), the caller's. GLINT_E_RANGE at `pointer`: no data URI,
// or a character that does not belong. GLINT_E_NOMEM.
glint_status glint_data_uri_decode(const char *uri, uint8_t **bytes, size_t *size,
                                   const char *pointer, struct glint_error *err);

#endif
