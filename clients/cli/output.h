// output.h - files that appear whole or not at all.
//
// Written under a temporary name in the same directory, synced, renamed. What is no regular file
// (/dev/null, a pipe) is written in place.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_OUTPUT_H
#define GLINT_CLI_OUTPUT_H

#include "protocol/status.h"

#include <stdbool.h>
#include <stdint.h>

struct glint_output_file {
    char *path, *temporary; // owned; temporary NULL: written in place
    int fd;
    uint64_t size;
    int error; // errno of the first write that failed
};

// GLINT_E_IO if the file cannot be created.
glint_status glint_output_open(struct glint_output_file *out, const char *path,
                               struct glint_error *err);

// Takes bytes in the form of glint_request.receive; false after a failure.
bool glint_output_write(void *output, const void *bytes, size_t size);

// Puts the file in place (`keep`) or removes what was written. Frees *out either way.
glint_status glint_output_close(struct glint_output_file *out, bool keep, struct glint_error *err);

// GLINT_E_IO if no file could be created at `path`; for asking before the work is done.
glint_status glint_output_check(const char *path, struct glint_error *err);

// True if the path ends in ".extension", in any case.
bool glint_output_is(const char *path, const char *extension);

#endif
