// film_add.h - one pixel of a film upon another. Not for others than merging.
#ifndef GLINT_PROTOCOL_FILM_ADD_H
#define GLINT_PROTOCOL_FILM_ADD_H

#include "film.h"

// The pixel `from` of one tile upon the pixel `to` of another: sums, counts, the lesser depth.
// wide: sums are doubles.
void glint_film_add_planes(const struct glint_film_info *info, float *to_planes, uint32_t to,
                           const float *from_planes, uint32_t from);

// What pixel `i` of a tile with the tables `from` holds into the table of pixel `at` of another;
// returns the units that found no place of their own, now or before: while there are none the sum is
// that of one run.
uint64_t glint_film_add_table(const struct glint_film_info *info, uint64_t *to, uint32_t at,
                              const uint64_t *from, uint32_t i);

#endif
