// exr_stream.h - OpenEXR contexts over memory, shared by the writer and the reader.
//
// Thread-safety: a stream belongs to the thread between its open and its close; one at a time.
#ifndef GLINT_PROTOCOL_EXR_STREAM_H
#define GLINT_PROTOCOL_EXR_STREAM_H

#include "protocol/status.h"

#include <openexr.h>
#include <stdint.h>

struct glint_exr_stream {
    const uint8_t *source;   // reading: borrowed
    uint8_t *sink;           // writing: malloc'd
    size_t size, capacity;   // of source or sink
    size_t allocation_limit; // most bytes that the library may ask for at once
    int starved;             // memory ran out, for the library or the sink
    char message[256];       // the first error the library reported
};

// Prepares `init` for exr_start_read() or exr_start_write() with the stream, which is zeroed first
// but for source, size and allocation_limit. Allocations are zeroed, so that what a damaged chunk
// leaves out is 0 and never a piece of the process.
void glint_exr_stream_open(struct glint_exr_stream *stream, exr_context_initializer_t *init);

// Ends the use of the stream by this thread. The sink is the caller's.
void glint_exr_stream_close(struct glint_exr_stream *stream);

// Adds a fault for what the library answered: GLINT_E_NOMEM where memory ran out, else `otherwise`.
// (Its own code for that also stands for damaged data.)
glint_status glint_exr_stream_fail(const struct glint_exr_stream *stream, exr_result_t result,
                                   glint_status otherwise, struct glint_error *err);

#endif
