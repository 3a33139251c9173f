// config.h - files of settings: lines of `key = value`.
//
// Blanks around key and value count for nothing; empty lines and those that begin with # neither.
// There are no quotes, sections or continued lines. What keys mean is for who reads them.
//
// Thread-safety: reentrant.
#ifndef GLINT_BASE_CONFIG_H
#define GLINT_BASE_CONFIG_H

#include "protocol/status.h"

#include <stdbool.h>
#include <stdint.h>

#define GLINT_CONFIG_BYTES ((size_t)64 << 10)

struct glint_config_line {
    char *key, *value; // owned
    unsigned number;   // in the file, from 1
};

struct glint_config {
    struct glint_config_line *line; // owned
    size_t count;
};

// The file's lines; on failure those that are in order, and each fault is named.
//   GLINT_E_IO     the file cannot be read, is larger than GLINT_CONFIG_BYTES, or everybody may
//                  write it
//   GLINT_E_RANGE  a line is malformed, a key stands twice
glint_status glint_config_read(struct glint_config *out, const char *path, struct glint_error *err);
// The same from text; `name` stands for the file in faults.
glint_status glint_config_parse(struct glint_config *out, const char *name, const char *text,
                                size_t length, struct glint_error *err);
void glint_config_finish(struct glint_config *config);

// Values. False: the text is none, or outside the range; *out is as before.
bool glint_config_whole(const char *text, uint64_t low, uint64_t high, uint64_t *out);
bool glint_config_bytes(const char *text, uint64_t low, uint64_t high, uint64_t *out); // 64M, 2G
bool glint_config_seconds(const char *text, double low, double high, double *out);

#endif
