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

// All threads allocate from one arena, where the C library would give each up to eight for a core one
// of its own: what one thread has freed another takes, so the heap stops growing at what was once
// needed at one time, not at the sum of what each thread ever needed. Before the second thread.
void glint_memory_share_arena(void);

// Gets the heap ready for so many bytes in blocks below 32 MiB: in large pages, and from the system at
// once. Whoever builds much on all cores would wait for each page, and each core for the other while
// the heap grows. Between the two the heap gives nothing of it back.
void glint_memory_expect(uint64_t bytes);
void glint_memory_settle(void);

// Bytes of the C library's heap, 0 where another allocator stands in for it.
struct glint_heap {
    uint64_t used, free; // of what it took from the system
    uint64_t mapped;     // large blocks, each a mapping of its own
};

void glint_memory_heap(struct glint_heap *out);

#endif
