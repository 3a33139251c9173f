// memory_file.h - a download that is read as a whole, however large: pages without a name on disk.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_MEMORY_FILE_H
#define GLINT_CLI_MEMORY_FILE_H

#include "protocol/status.h"

#include <stdbool.h>
#include <stdint.h>

struct glint_memory_file {
    int fd;
    int error;            // errno of the first write that failed
    const uint8_t *bytes; // once mapped
    size_t size;
};

glint_status glint_memory_file_open(struct glint_memory_file *out, struct glint_error *err);

// Takes bytes in the form of glint_request.receive; false after a failure.
bool glint_memory_file_write(void *file, const void *bytes, size_t size);

// Makes `bytes` of what was written. GLINT_E_NOMEM.
glint_status glint_memory_file_map(struct glint_memory_file *file, struct glint_error *err);

void glint_memory_file_close(struct glint_memory_file *file);

#endif
