// problem.h - an error as application/problem+json (RFC 9457).
//
// Thread-safety: reentrant.
#ifndef GLINT_PROTOCOL_PROBLEM_H
#define GLINT_PROTOCOL_PROBLEM_H

#include "status.h"

#include <cjson/cJSON.h>

// {"type","title","status","detail","instance","errors":[{"pointer","detail"}],"request_id"} as one
// line. `instance` (a path) and `request_id` may be NULL and are left out then. `errors` names every
// fault. malloc'd, NULL without memory.
char *glint_problem_text(const struct glint_error *err, const char *instance,
                         const char *request_id);

// The same as a new object, or NULL without memory.
cJSON *glint_problem_object(const struct glint_error *err, const char *instance,
                            const char *request_id);

#endif
