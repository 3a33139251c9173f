// status.h - what can go wrong, and every place where it did.
//
// A function that can fail returns glint_status and appends one fault for each broken rule to a
// struct glint_error, so that bad input is answered with all its faults at once. The code of the
// first fault is the code of the error.
//
// Thread-safety: a glint_error belongs to the thread that fills it.
#ifndef GLINT_PROTOCOL_STATUS_H
#define GLINT_PROTOCOL_STATUS_H

#include <stddef.h>

typedef enum {
    GLINT_OK = 0,
    GLINT_E_SYNTAX,       // not JSON, not GLB, not HTTP: 400
    GLINT_E_RANGE,        // understood, but a rule is broken: 422
    GLINT_E_UNAUTHORIZED, // who asks is not known: 401
    GLINT_E_FORBIDDEN,    // he may not: 403
    GLINT_E_NOT_FOUND,    // 404
    GLINT_E_METHOD,       // 405
    GLINT_E_CONFLICT,     // 409
    GLINT_E_STALE,        // If-Match does not hold: 412
    GLINT_E_TOO_LARGE,    // 413
    GLINT_E_MEDIA_TYPE,   // 415
    GLINT_E_BUSY,         // try again later: 503
    GLINT_E_CAPACITY,     // the machine cannot hold it just now: 507
    GLINT_E_NOMEM,        // allocation failed: 507
    GLINT_E_IO,           // 500
    GLINT_E_DEVICE,       // OpenCL or Embree refused: 500
    GLINT_E_UNAVAILABLE,  // no daemon answers (clients only): 503
    GLINT_E_VERSION,      // a file of a format that came later: 500
    GLINT_E_INTERNAL,     // 500
    // Jobs are kept with the numbers of these: what is new comes last.
    GLINT_E_DAMAGED, // what was kept can no longer be read: 500
    GLINT_E_PENDING, // the same request is being answered: 409
    GLINT_STATUS_COUNT
} glint_status;

struct glint_fault {
    char *pointer; // JSON pointer (RFC 6901) into the input, "" for the whole of it
    char *detail;  // one sentence with the offending value
};

// Zero-initialise before use; glint_error_finish() frees the faults and zeroes it again.
struct glint_error {
    glint_status status; // of the first fault
    size_t count, capacity;
    struct glint_fault *fault; // owned
};

// Appends a fault and returns `status`. `err` may be NULL. More than GLINT_MAX_FAULTS are counted
// in `count` no further: the last says so.
#define GLINT_MAX_FAULTS 64
glint_status glint_fail(struct glint_error *err, glint_status status, const char *pointer,
                        const char *format, ...) __attribute__((format(printf, 4, 5)));

void glint_error_finish(struct glint_error *err);

// The first fault's detail, or the title of the status.
const char *glint_error_text(const struct glint_error *err);

// One row of the table that maps codes to HTTP and to words.
int glint_status_http(glint_status status);            // 200..599
const char *glint_status_title(glint_status status);   // "Unprocessable content"
const char *glint_status_problem(glint_status status); // "/problems/unprocessable"
const char *glint_status_meaning(glint_status status); // a sentence or two on what to do
int glint_status_exit(glint_status status);            // exit code of a command-line client
// The status whose problem is /problems/NAME; GLINT_OK: none.
glint_status glint_status_of_problem(const char *name);

#endif
