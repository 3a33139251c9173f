// film_merge.h - films of parts of one job, added up.
//
// Parts are regions, ranges of samples, or both: boxes of pixels and samples. Together they are the
// film that one run takes, and make the same frame, bit for bit, unless a warning says otherwise.
//
// Thread-safety: one owner; the source as a film's is.
#ifndef GLINT_PROTOCOL_FILM_MERGE_H
#define GLINT_PROTOCOL_FILM_MERGE_H

#include "film_file.h"

struct glint_film_part {
    const glint_film_file *file;
    const char *name; // in messages
};

typedef struct glint_film_sum glint_film_sum;

// Adds up `count` > 0 parts. partial: samples may be missing.
//   GLINT_E_RANGE  other jobs, samples that two parts have or none has: every fault, with the names
//   GLINT_E_IO, GLINT_E_NOMEM
glint_status glint_film_merge(glint_film_sum **out, const struct glint_film_part *part,
                              size_t count, bool partial, struct glint_error *err);
void glint_film_sum_destroy(glint_film_sum **sum);

const struct glint_film_source *glint_film_sum_source(const glint_film_sum *sum);

// What may not be as in one run: sentences, *out lives as long as the sum. Returns their number.
size_t glint_film_sum_warnings(const glint_film_sum *sum, const char *const **out);

// The sum as a film. GLINT_E_RANGE: pixels of a tile have different numbers of samples, which a
// film cannot say.
glint_status glint_film_sum_write(const glint_film_sum *sum, int fd, struct glint_error *err);

#endif
