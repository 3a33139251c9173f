// archive.h - the film of a render that has ended, in a file.
//
// Thread-safety: sources by any thread, several at once.
#ifndef GLINT_RENDER_ARCHIVE_H
#define GLINT_RENDER_ARCHIVE_H

#include "protocol/film_file.h"

typedef struct glint_archive glint_archive;

// Takes the file, on success.
glint_status glint_archive_create(glint_archive **out, glint_film_file **file,
                                  struct glint_error *err);
void glint_archive_close(glint_archive **archive); // a pointer to NULL is fine

const glint_film_file *glint_archive_file(const glint_archive *archive);

// *out reads tiles until it is released.
glint_status glint_archive_source(const glint_archive *archive, struct glint_film_source *out,
                                  struct glint_error *err);
void glint_archive_release(struct glint_film_source *source);

cJSON *glint_archive_plan(const glint_archive *archive); // a new object

// Those of the job when it rendered, as in protocol/bias.h.
uint32_t glint_archive_biases(const glint_archive *archive);

#endif
