// memory.h - how much memory there is.
//
// Thread-safety: any thread.
#ifndef GLINT_BASE_MEMORY_H
#define GLINT_BASE_MEMORY_H

#include <stdint.h>

// Bytes that this process and its neighbours in the control group may have: the machine's memory or
// the group's limit, whichever is less.
uint64_t glint_memory_total(void);

// In the unit that fits, from bytes to PiB: "3.25 GiB". Returns `out`.
const char *glint_memory_text(uint64_t bytes, char out[16]);

// Bytes of this process that are in memory now, 0: not known.
uint64_t glint_memory_resident(void);

#endif
