// ahead.h - compiles program variants in processes of their own, and knows what is compiled.
//
// PoCL holds its locks while it compiles, seconds in which no worker could launch anything. So the
// kernels of a variant are compiled by a few glint-kernels, side by side, each with a cache folder
// of its own. What they have made is moved into PoCL's cache as one, with a list of its files and
// their hashes: PoCL ends a process that loads a torn file.
//
// Thread-safety: any thread.
#ifndef GLINT_DEVICE_AHEAD_H
#define GLINT_DEVICE_AHEAD_H

#include "protocol/status.h"

#include <stdbool.h>

typedef struct glint_ahead glint_ahead;

// What a kernel is compiled for ahead of its first launch: groups of so many items, launches of at
// most so many. Others are compiled, by the process that launches them, when they are launched.
#define GLINT_AHEAD_GROUP 64u
#define GLINT_AHEAD_ITEMS 4096u

// Exit code of glint-kernels where the kernels do not build; its standard error has the log.
#define GLINT_AHEAD_REFUSED 2

// cache: the folder that PoCL uses. helper: glint-kernels; NULL: $GLINT_KERNELS, that beside the
// running program, or the installed one. Without one *out is NULL, and nothing is compiled ahead.
glint_status glint_ahead_create(glint_ahead **out, const char *cache, const char *helper,
                                struct glint_error *err);
void glint_ahead_destroy(glint_ahead **ahead);
const char *glint_ahead_cache(const glint_ahead *ahead);

// Sees to it that the variant is in the cache, whole: returns at once where it is, else when it is
// compiled. Whatever is compiled of another key in idle time is given up for it.
//   GLINT_E_DEVICE  the kernels do not build; *err has the log
// Where a helper cannot do its work the answer is GLINT_OK: PoCL compiles at the first launch.
glint_status glint_ahead_compile(glint_ahead *ahead, const char *key, const char *options,
                                 struct glint_error *err);

// The same in idle time. False: given up for another.
bool glint_ahead_idle(glint_ahead *ahead, const char *key, const char *options);

// Gives up what is compiled in idle time, now and from now on.
void glint_ahead_hurry(glint_ahead *ahead);

#endif
