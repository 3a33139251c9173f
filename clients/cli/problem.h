// problem.h - application/problem+json (RFC 9457) to faults and back, and faults as lines to read.
//
// Thread-safety: reentrant.
#ifndef GLINT_CLI_PROBLEM_H
#define GLINT_CLI_PROBLEM_H

#include "protocol/status.h"

#include <cjson/cJSON.h>
#include <stdio.h>

// The status that an HTTP answer stands for; GLINT_OK for 2xx.
glint_status glint_problem_status(long http);

// Appends the faults of an answer that was no success: each of its `errors`, else its detail, else
// its title, else the number. `body` need not be JSON.
glint_status glint_problem_read(long http, const char *body, size_t length,
                                struct glint_error *err);

// Appends the faults of a problem that is already parsed (may be NULL).
void glint_problem_faults(const cJSON *problem, glint_status status, struct glint_error *err);

// The error as a problem document, or NULL without memory.
cJSON *glint_problem_write(const struct glint_error *err);

// One line for each fault: "glint: POINTER: DETAIL".
void glint_problem_print(FILE *out, const struct glint_error *err);

// Writes text that came from elsewhere: control characters become '?', so that no name can steer
// the terminal.
void glint_print_plain(FILE *out, const char *text);

#endif
