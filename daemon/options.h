// options.h - the command line of glintd.
//
// Thread-safety: main's.
#ifndef GLINT_OPTIONS_H
#define GLINT_OPTIONS_H

#include "base/log.h"

#include <stdint.h>

#define GLINT_EXIT_USAGE 64

struct glint_options {
    const char *listen; // ADDR:PORT
    const char *state;  // folder, NULL: where the system keeps a user's or a service's
    uint32_t threads;   // 0: one per core
    enum glint_log_format format;
};

// Returns -1 to go on, or the exit status: after --help and --version, and for wrong usage, which
// is told on standard error.
int glint_options_parse(struct glint_options *out, int argc, char **argv);

#endif
