// frames.h - encoded frames and tiles that several clients want, each made once; the least lately
// used go first.
//
// Thread-safety: any thread.
#ifndef GLINT_HTTP_FRAMES_H
#define GLINT_HTTP_FRAMES_H

#include "http/blob.h"

typedef struct glint_frames glint_frames;

// slots, bytes: how many are kept and their size together.
glint_status glint_frames_create(glint_frames **out, size_t slots, size_t bytes,
                                 struct glint_error *err);
void glint_frames_destroy(glint_frames **frames);

// key: what the bytes depend on, at most 255 bytes. NULL: not there. The caller gets a reference.
struct glint_blob *glint_frames_find(glint_frames *frames, const char *key);

// Keeps a reference of its own, unless the blob is too large to keep.
void glint_frames_keep(glint_frames *frames, const char *key, struct glint_blob *blob);

#endif
