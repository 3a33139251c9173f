// order.h - what `glint render` and `glint submit` were asked for: the job's document, its scene, its files.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_ORDER_H
#define GLINT_CLI_ORDER_H

#include "session.h"

#define GLINT_MAX_FILES 8

struct glint_order {
    cJSON *job;                    // the body of POST /v1/jobs, `scene` included
    const char *file;              // the scene to upload, or NULL: the job's `scene` is resident
    char scene[129];               // its name
    char *output[GLINT_MAX_FILES]; // owned
    size_t outputs;
    const char *key; // Idempotency-Key, or NULL
    const char *tev; // address of a viewer, or NULL
    bool detached;   // nobody waits for the job: it is live, or was only to be submitted
};

// The options of a job whose frames are fetched; from [GLINT_ORDER_DETACHED] on those of a job that
// is only submitted.
#define GLINT_ORDER_DETACHED 5
extern const struct glint_option glint_order_options[];

// Reads the command line and the file of --job; `detached` is set by the caller. What is wrong is
// a usage fault, each named; outputs that cannot be written are GLINT_E_IO.
glint_status glint_order_read(struct glint_order *out, struct glint_session *s,
                              const struct glint_arguments *a, struct glint_error *err);

void glint_order_finish(struct glint_order *order);

#endif
