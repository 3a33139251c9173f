// film_levels.h - how many ranks a file needs for the names that its pixels have.
//
// A file of n ranks holds n names of a pixel, however exact the table was that they come from: no
// such file is nearer to the mattes than the (n+1)th coverage of a pixel. What is counted here is all
// that has no rank, so that no union of names is further off than that.
//
// Thread-safety: reentrant.
#ifndef GLINT_PROTOCOL_FILM_LEVELS_H
#define GLINT_PROTOCOL_FILM_LEVELS_H

#include "film.h"

#define GLINT_MOST_LEFT_OUT 0.02 // of a pixel, that "auto" leaves without a rank

struct glint_matte_excess {
    uint64_t pixels; // that have more names of a type than levels
    uint32_t needed; // levels, even, that leave out GLINT_MOST_LEFT_OUT at most; 0: not looked for
    double left_out; // the most that a pixel has of a type and that has no rank
};

// Levels of a job's files; with "auto" the most that they may have.
uint32_t glint_film_levels(const struct glint_job *job);

// The fewest even number of ranks from `levels` on that leave out GLINT_MOST_LEFT_OUT at most of n
// sorted ones.
struct glint_cryptomatte_rank;
uint32_t glint_film_levels_of(const struct glint_cryptomatte_rank *rank, uint32_t n,
                              uint32_t levels);

// That of the tile's first size[0] columns and size[1] rows, added to *out. GLINT_E_NOMEM: not all.
glint_status glint_film_excess_add(const struct glint_film_info *info,
                                   const struct glint_film_pixels *pixels, const uint32_t size[2],
                                   struct glint_matte_excess *out, struct glint_error *err);

// Of a whole film that has coverage.
glint_status glint_film_excess(const struct glint_film_source *source,
                               struct glint_matte_excess *out, struct glint_error *err);

// One more part of a film.
void glint_matte_excess_merge(struct glint_matte_excess *sum,
                              const struct glint_matte_excess *part);

// What the owner of a job should know; empty where nothing is left out that "auto" would hold.
// Returns whether there is something.
bool glint_matte_excess_tell(const struct glint_matte_excess *excess, const struct glint_job *job,
                             char text[256]);

#endif
