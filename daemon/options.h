// options.h - the command line of glintd.
//
// Thread-safety: main's.
#ifndef GLINT_OPTIONS_H
#define GLINT_OPTIONS_H

#include "settings.h"

#define GLINT_EXIT_USAGE 64
#define GLINT_EXIT_SETTINGS 78

// Returns -1 to go on with *out, or the exit status: after --help, --version and --new-token, and
// for wrong usage, which is told on standard error. Values have been checked. argv outlives *out.
int glint_options_parse(struct glint_settings_source *out, int argc, char **argv);
void glint_options_finish(struct glint_settings_source *source);

#endif
