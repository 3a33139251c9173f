// checkpoint_file.h - one film file: where it is, how it is written whole, how it is put aside.
//
// Thread-safety: reentrant; two writers of one name exclude each other.
#ifndef GLINT_JOBS_CHECKPOINT_FILE_H
#define GLINT_JOBS_CHECKPOINT_FILE_H

#include "render/render.h"

#include <stdint.h>

// Which film of which job, in which folder.
struct glint_checkpoint_file {
    const char *folder, *job;
    uint64_t number;
};

// Has the render written. *bytes: of the file.
//   GLINT_E_CAPACITY  it does not fit, with figures; nothing is left of it
glint_status glint_checkpoint_file_write(const struct glint_checkpoint_file *file,
                                         glint_render *render, uint64_t *bytes,
                                         struct glint_error *err);
// A descriptor to read from, or -1 with GLINT_E_NOT_FOUND or GLINT_E_IO.
int glint_checkpoint_file_open(const struct glint_checkpoint_file *file, struct glint_error *err);
void glint_checkpoint_file_remove(const struct glint_checkpoint_file *file);
// Out of the way, and kept.
void glint_checkpoint_file_put_aside(const struct glint_checkpoint_file *file, const char *suffix);
uint64_t glint_checkpoint_file_bytes(const struct glint_checkpoint_file *file);
// When it was written, UTC; "": not known.
void glint_checkpoint_file_time(const struct glint_checkpoint_file *file, char text[32]);

// Calls `visit` with every file's name in the folder.
void glint_checkpoint_files_list(const char *folder, void (*visit)(void *user, const char *name),
                                 void *user);
// Reads "<job>.<number>"; false: no name of a whole film.
bool glint_checkpoint_file_parse(const char *name, char job[33], uint64_t *number);

#endif
