// program.h - programs from source text; private to device/ and its tests.
#ifndef GLINT_DEVICE_PROGRAM_H
#define GLINT_DEVICE_PROGRAM_H

#include "device/device.h"
#include "device/sources.h"

// The text of every .cl file in the table, one after the other, with the contents of
// `#include "kernels/..."` put in place of its first occurrence and nothing of the later ones.
// malloc'd, terminated. GLINT_E_INTERNAL: an included file is not in the table.
glint_status glint_source_expand(char **out, const struct glint_source *table,
                                 struct glint_error *err);

// As glint_program_get() for this text instead of the embedded kernels.
glint_status glint_program_build(glint_program **out, glint_devices *devices, const char *source,
                                 const char *options, struct glint_error *err);

// The key that a program of these would have. False: no memory.
bool glint_program_key_of(char key[65], const glint_devices *devices, const char *source,
                          const char *options);

// What it is built with, malloc'd; NULL without memory.
char *glint_program_options(const char *options);

// SHA-256 in hex of source, options, device and driver; lives as long as the program.
const char *glint_program_key(const glint_program *program);

#endif
