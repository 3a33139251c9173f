// common.h - the program variants that most jobs want.
//
// Thread-safety: reentrant.
#ifndef GLINT_RENDER_COMMON_H
#define GLINT_RENDER_COMMON_H

#include <stddef.h>

#define GLINT_COMMON_OPTIONS 1024

// Options of variant number `index`, the most wanted first. Returns the number of them.
size_t glint_common_variant(size_t index, char options[GLINT_COMMON_OPTIONS]);

#endif
