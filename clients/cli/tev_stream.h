// tev_stream.h - a job's tiles on their way to tev, beside whatever else the command does.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_TEV_STREAM_H
#define GLINT_CLI_TEV_STREAM_H

#include "session.h"

// Begins to read the tiles of a job; name: of the image. What goes wrong later ends the pictures
// and nothing else.
glint_status glint_tev_stream_create(glint_tev_stream **out, struct glint_session *s,
                                     const char *address, const char *job, const char *name,
                                     struct glint_error *err);

// Takes a stream up again that has broken off. Between requests; NULL is fine.
void glint_tev_stream_tend(glint_tev_stream *stream);

// Lets the viewer get what is left, for a few seconds at most, and stops.
void glint_tev_stream_destroy(glint_tev_stream **stream);

#endif
