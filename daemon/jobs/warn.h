// warn.h - sentences for a job's warnings.
//
// Thread-safety: reentrant.
#ifndef GLINT_JOBS_WARN_H
#define GLINT_JOBS_WARN_H

#include <cjson/cJSON.h>

// As printf, at most 511 bytes, into an array of strings.
void glint_warn(cJSON *warnings, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
