// sse.h - server-sent events, as they come off the wire in pieces.
//
// Source: WHATWG HTML Living Standard, 9.2.6 "Interpreting an event stream".
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_SSE_H
#define GLINT_CLI_SSE_H

#include <stdbool.h>
#include <stddef.h>

#define GLINT_SSE_LINE ((size_t)1 << 20) // bytes of a line, and of an event's data
#define GLINT_SSE_NAME 128               // bytes of a name or id with its terminator

struct glint_sse_text {
    char *bytes;
    size_t size, capacity;
};

// Zero-initialise before use, then set `event` and `user`.
struct glint_sse {
    bool (*event)(void *user, const char *name, const char *data); // false: no more of it
    void *user;
    char id[GLINT_SSE_NAME]; // of the last event that was complete and had one
    char next_id[GLINT_SSE_NAME];
    char name[GLINT_SSE_NAME];
    struct glint_sse_text line, data;
    bool after_cr;
};

// False: the stream is no longer to be read (too long a line, no memory, or `event` said so).
bool glint_sse_feed(struct glint_sse *sse, const void *bytes, size_t size);

// Forgets a half-read event, keeps the id: before a stream is opened again.
void glint_sse_restart(struct glint_sse *sse);

void glint_sse_finish(struct glint_sse *sse);

#endif
