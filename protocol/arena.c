// arena.c - blocks that double up to a bound; what is large gets a block of its own.
#include "protocol/arena.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FIRST_BLOCK 4096u
#define LAST_BLOCK (1u << 20)
#define WIDE 64u
#define NARROW 16u

struct glint_arena_block {
    struct glint_arena_block *older;
    size_t used, capacity; // bytes of data, which starts WIDE bytes after the block
};

static unsigned char *data(struct glint_arena_block *b)
{
    return (unsigned char *)b + WIDE;
}

static size_t round_up(size_t n, size_t unit)
{
    return (n + unit - 1) / unit * unit;
}

static struct glint_arena_block *new_block(size_t capacity)
{
    _Static_assert(sizeof(struct glint_arena_block) <= WIDE, "the header fits before the data");
    struct glint_arena_block *b = aligned_alloc(WIDE, WIDE + round_up(capacity, WIDE));
    if (b)
        *b = (struct glint_arena_block){.capacity = round_up(capacity, WIDE)};
    return b;
}

// A block with room for `bytes`. Large ones go behind the newest, which keeps its room.
static struct glint_arena_block *block_for(struct glint_arena *a, size_t bytes)
{
    const size_t newest = a->block ? a->block->capacity : FIRST_BLOCK / 2;
    const size_t size = newest < LAST_BLOCK ? 2 * newest : LAST_BLOCK;
    const int own = bytes > size / 4;
    struct glint_arena_block *b = new_block(own ? bytes : size);
    if (!b)
        return NULL;
    struct glint_arena_block **where = own && a->block ? &a->block->older : &a->block;
    b->older = *where;
    *where = b;
    return b;
}

void *glint_arena_alloc(struct glint_arena *a, size_t bytes)
{
    if (bytes > SIZE_MAX / 2)
        return NULL;
    const size_t align = bytes >= WIDE ? WIDE : NARROW;
    const size_t room = round_up(bytes ? bytes : 1, NARROW);
    struct glint_arena_block *b = a->block;
    size_t at = b ? round_up(b->used, align) : 0;
    if (!b || at > b->capacity || room > b->capacity - at) {
        b = block_for(a, room);
        at = 0;
    }
    if (!b)
        return NULL;
    b->used = at + room;
    a->bytes += bytes;
    return memset(data(b) + at, 0, room);
}

void *glint_arena_array(struct glint_arena *a, size_t count, size_t size)
{
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes))
        return NULL;
    return glint_arena_alloc(a, bytes);
}

char *glint_arena_string(struct glint_arena *a, const char *text)
{
    if (!text)
        return NULL;
    const size_t bytes = strlen(text) + 1;
    char *copy = glint_arena_alloc(a, bytes);
    return copy ? memcpy(copy, text, bytes) : NULL;
}

char *glint_arena_print(struct glint_arena *a, const char *format, ...)
{
    va_list args, again;
    va_start(args, format);
    va_copy(again, args);
    const int length = vsnprintf(NULL, 0, format, args);
    char *text = length < 0 ? NULL : glint_arena_alloc(a, (size_t)length + 1);
    if (text)
        vsnprintf(text, (size_t)length + 1, format, again);
    va_end(again);
    va_end(args);
    return text;
}

void glint_arena_finish(struct glint_arena *a)
{
    while (a->block) {
        struct glint_arena_block *older = a->block->older;
        free(a->block);
        a->block = older;
    }
    *a = (struct glint_arena){0};
}
