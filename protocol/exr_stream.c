// exr_stream.c - random access to one block of memory.
#include "protocol/exr_stream.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// The library calls back without our pointer when it allocates or reports an error, and asking the
// context for it from there deadlocks.
static _Thread_local struct glint_exr_stream *current;

static void *allocate(size_t bytes)
{
    if (!current || bytes > current->allocation_limit)
        return NULL;
    void *memory = calloc(1, bytes ? bytes : 1);
    if (!memory)
        current->starved = 1;
    return memory;
}

static void report(exr_const_context_t context, exr_result_t result, const char *message)
{
    (void)context;
    (void)result;
    if (current && !*current->message)
        snprintf(current->message, sizeof current->message, "%s", message);
}

static int64_t read_at(exr_const_context_t context, void *user, void *to, uint64_t bytes,
                       uint64_t offset, exr_stream_error_func_ptr_t fail)
{
    (void)context;
    (void)fail;
    const struct glint_exr_stream *s = user;
    const uint64_t there = offset < s->size ? s->size - offset : 0;
    const uint64_t given = bytes < there ? bytes : there;
    if (given)
        memcpy(to, s->source + offset, given);
    return (int64_t)given;
}

static int64_t size_of(exr_const_context_t context, void *user)
{
    (void)context;
    return (int64_t)((const struct glint_exr_stream *)user)->size;
}

static int reserve(struct glint_exr_stream *s, uint64_t end)
{
    if (end <= s->capacity)
        return 1;
    size_t capacity = s->capacity ? s->capacity : 16384;
    while (capacity < end)
        capacity *= 2;
    uint8_t *sink = realloc(s->sink, capacity);
    if (!sink)
        return 0;
    s->sink = sink;
    s->capacity = capacity;
    return 1;
}

static int64_t write_at(exr_const_context_t context, void *user, const void *from, uint64_t bytes,
                        uint64_t offset, exr_stream_error_func_ptr_t fail)
{
    struct glint_exr_stream *s = user;
    const uint64_t end = offset + bytes;
    if (end > SIZE_MAX / 2 || !reserve(s, end)) {
        s->starved = 1;
        fail(context, EXR_ERR_OUT_OF_MEMORY, "no memory for a file of %llu bytes",
             (unsigned long long)end);
        return -1;
    }
    if (offset > s->size)
        memset(s->sink + s->size, 0, offset - s->size);
    memcpy(s->sink + offset, from, bytes);
    if (end > s->size)
        s->size = end;
    return (int64_t)bytes;
}

void glint_exr_stream_open(struct glint_exr_stream *stream, exr_context_initializer_t *init)
{
    assert(!current);
    stream->sink = NULL;
    stream->capacity = 0;
    stream->starved = 0;
    *stream->message = 0;
    current = stream;
    *init = (exr_context_initializer_t)EXR_DEFAULT_CONTEXT_INITIALIZER;
    init->error_handler_fn = report;
    init->alloc_fn = allocate;
    init->free_fn = free;
    init->user_data = stream;
    init->read_fn = read_at;
    init->size_fn = size_of;
    init->write_fn = write_at;
}

void glint_exr_stream_close(struct glint_exr_stream *stream)
{
    assert(current == stream);
    (void)stream;
    current = NULL;
}

glint_status glint_exr_stream_fail(const struct glint_exr_stream *stream, exr_result_t result,
                                   glint_status otherwise, struct glint_error *err)
{
    const char *message =
        *stream->message ? stream->message : exr_get_default_error_message(result);
    return glint_fail(err, stream->starved ? GLINT_E_NOMEM : otherwise, "", "OpenEXR: %s", message);
}
