// sources.h - the kernels' source text, embedded by the build.
#ifndef GLINT_DEVICE_SOURCES_H
#define GLINT_DEVICE_SOURCES_H

#include <stddef.h>

struct glint_source {
    const char *name; // "kernels/gk_math.h"; NULL ends the table
    const char *text; // not terminated
    size_t length;
};

// Headers first, then the .cl files, each group in alphabetical order.
extern const struct glint_source glint_sources[];

#endif
