// offload.h - a few threads for work that the HTTP library's threads must not do.
//
// Thread-safety: push by any thread; create and destroy by one.
#ifndef GLINT_HTTP_OFFLOAD_H
#define GLINT_HTTP_OFFLOAD_H

#include "protocol/status.h"

#include <stdbool.h>

typedef struct glint_offload glint_offload;

// Part of whatever it works on; belongs to the pool from push until `run` is called.
struct glint_task {
    void (*run)(struct glint_task *task);
};

// capacity: tasks that may wait. name: of the threads. GLINT_E_CAPACITY, GLINT_E_NOMEM.
glint_status glint_offload_create(glint_offload **out, const char *name, unsigned threads,
                                  size_t capacity, struct glint_error *err);

// False, and nothing kept, when `capacity` tasks wait. Never blocks.
bool glint_offload_push(glint_offload *offload, struct glint_task *task);

size_t glint_offload_waiting(glint_offload *offload); // tasks that no thread has begun

// Runs what waits, then ends the threads and stores NULL.
void glint_offload_destroy(glint_offload **offload);

#endif
