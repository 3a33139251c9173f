// arena.h - many small allocations with one lifetime.
//
// Thread-safety: one owner at a time.
#ifndef GLINT_PROTOCOL_ARENA_H
#define GLINT_PROTOCOL_ARENA_H

#include <stddef.h>

// Zero-initialise before use.
struct glint_arena {
    struct glint_arena_block *block; // newest first
    size_t bytes;                    // handed out so far
};

// Zeroed memory aligned to 64 bytes for `bytes` >= 64 and to 16 otherwise, or NULL.
void *glint_arena_alloc(struct glint_arena *a, size_t bytes);

// As above for count*size with the product checked.
void *glint_arena_array(struct glint_arena *a, size_t count, size_t size);

// A copy of the string, or NULL. NULL in, NULL out.
char *glint_arena_string(struct glint_arena *a, const char *text);
char *glint_arena_print(struct glint_arena *a, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

// Frees everything and zeroes *a.
void glint_arena_finish(struct glint_arena *a);

#endif
