// film_parts.h - what frames and mattes of a film share. Not for others.
#ifndef GLINT_PROTOCOL_FILM_PARTS_H
#define GLINT_PROTOCOL_FILM_PARTS_H

#include "cryptomatte.h"
#include "film.h"
#include "kernels/gk_film.h"

// Slots of a pixel that hold something: those of its table, and what it has in the places of its tile.
struct glint_film_held {
    uint64_t *slot; // [glint_film_held_room() + 1]
    uint32_t count;
};
uint32_t glint_film_held_room(const struct glint_film_info *info);
// tables: of the tile; pixel: of it.
void glint_film_held_read(const struct glint_film_info *info, const uint64_t *tables,
                          uint32_t pixel, struct glint_film_held *out);

// Room for the IDs of a pixel.
struct glint_film_ranks {
    struct glint_film_held held;
    struct glint_cryptomatte_rank *rank; // [glint_film_held_room()], as are those below
    uint64_t *amount;
};
glint_status glint_film_ranks_create(struct glint_film_ranks *out,
                                     const struct glint_film_info *info, struct glint_error *err);
void glint_film_ranks_finish(struct glint_film_ranks *ranks); // one of zeros is fine

// Fills r->rank with the IDs of a type that cover the pixel that r->held was read of, sorted, coverage
// over `samples`; several keys may share an ID. Returns their number.
// Source: Cryptomatte 1.2.0, "Ranking Pixel Filter".
uint32_t glint_film_rank(const struct glint_film_info *info, const struct glint_matte_type *type,
                         uint32_t samples, struct glint_film_ranks *r);

// The manifest of every name in a layer; malloc'd, NULL without memory.
char *glint_film_manifest(const struct glint_film_info *info, enum glint_matte_layer layer);

// Adds the attributes that every frame has, CONVENTIONS b; `samples`: the fewest of its pixels.
// GLINT_E_NOMEM: some are missing.
glint_status glint_film_attributes(const struct glint_film_source *source, struct glint_frame *f,
                                   uint32_t samples);

// The pixel that pixel i is shown as.
static inline uint32_t glint_film_shown_as(const struct glint_film_pixels *p, uint32_t i)
{
    const uint32_t off = p->step ? p->step - 1 : 0;
    return i & ~(off * GK_TILE_SIDE | off);
}

// Samples of pixel i.
static inline uint32_t glint_film_samples_of(const struct glint_film_pixels *p, uint32_t i,
                                             uint32_t half)
{
    if (p->each)
        return p->each[i][half];
    return glint_film_shown_as(p, i) == i ? p->half[half] : 0;
}

#endif
