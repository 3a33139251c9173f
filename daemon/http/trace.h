// trace.h - the place of a request in a trace that began at its client or before.
//
// Source: W3C Trace Context, Recommendation 23 November 2021, 3.2 (traceparent, version 00).
// Departure: a later version is not read as if it were 00; a new trace begins.
//
// Thread-safety: any thread.
#ifndef GLINT_HTTP_TRACE_H
#define GLINT_HTTP_TRACE_H

#define GLINT_TRACE_BYTES 56 // "00-", trace-id, "-", parent-id, "-", flags
#define GLINT_TRACE_ID 3     // where the 32 digits of the trace-id begin

// Writes the traceparent of a request that came with the header `given`: its trace and its sampled
// flag, with a parent-id of our own. NULL, or malformed: a new trace, not sampled.
void glint_trace_continue(char out[GLINT_TRACE_BYTES], const char *given);

#endif
