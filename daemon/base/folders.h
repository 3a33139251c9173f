// folders.h - where state and caches are kept.
//
// Thread-safety: reads the environment; main's, before other threads exist.
#ifndef GLINT_BASE_FOLDERS_H
#define GLINT_BASE_FOLDERS_H

#include "protocol/status.h"

// The folder, made if it is missing (0750); malloc'd.
// State: `wanted`, or $STATE_DIRECTORY (systemd), $XDG_STATE_HOME/glint, ~/.local/state/glint.
// GLINT_E_IO: it cannot be made or written.
glint_status glint_folder_state(char **out, const char *wanted, struct glint_error *err);

// Cache: $CACHE_DIRECTORY (systemd), $XDG_CACHE_HOME/glint, ~/.cache/glint; where none of them can
// be written, "cache" in `state`. What is there can be made again.
glint_status glint_folder_cache(char **out, const char *state, struct glint_error *err);

#endif
