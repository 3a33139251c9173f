// film_spread.c - a first sample of pixels that lie apart, taken on a small film of its own, goes
// into the film. Nothing is added: pixels without a sample hold nothing that counts.
#include "render/film_parts.h"

#include "kernels/gk_film.h"

#include <string.h>

#define SIDE (2 * GK_TILE_SIDE) // pixels of the small film

// A pixel of a tile.
struct spot {
    struct glint_film_tile at;
    uint32_t i;
};

static uint32_t pixel_of(uint32_t x, uint32_t y)
{
    return y % GK_TILE_SIDE * GK_TILE_SIDE + x % GK_TILE_SIDE;
}

// Without what it has in the places of its tile: of one sample that is next to nothing.
static void copy_table(const glint_film *f, const struct spot *to, const struct spot *from)
{
    const uint32_t words = f->tile_slots / GK_TILE_PIXELS, own = words - f->shared_words;
    uint64_t *out =
        (uint64_t *)glint_buffer_host(to->at.tables) + to->at.tables_offset + to->i * words;
    memcpy(out,
           (const uint64_t *)glint_buffer_host(from->at.tables) + from->at.tables_offset +
               from->i * words,
           own * sizeof *out);
    memset(out + own, 0, f->shared_words * sizeof *out);
}

static void copy_pixel(const glint_film *f, const struct spot *to, const struct spot *from)
{
    uint32_t *out = (uint32_t *)glint_buffer_host(to->at.planes) + to->at.planes_offset + to->i;
    const uint32_t *in =
        (const uint32_t *)glint_buffer_host(from->at.planes) + from->at.planes_offset + from->i;
    for (uint32_t w = 0; w < f->tile_words; w += GK_TILE_PIXELS)
        out[w] = in[w];
    if (f->tile_slots)
        copy_table(f, to, from);
}

void glint_film_spread(glint_film *f, uint32_t column, uint32_t row, const glint_film *from,
                       uint32_t step, bool coarser)
{
    for (uint32_t y = 0; y < SIDE; y++)
        for (uint32_t x = 0; x < SIDE; x++) {
            const uint32_t tx = column + x * step / GK_TILE_SIDE;
            const uint32_t ty = row + y * step / GK_TILE_SIDE;
            if (tx >= f->columns || ty >= f->rows || (coarser && !((x | y) & 1)))
                continue;
            struct spot a = {.i = pixel_of(x, y)}, b = {.i = pixel_of(x * step, y * step)};
            glint_film_tile(from, y / GK_TILE_SIDE * 2 + x / GK_TILE_SIDE, &a.at);
            glint_film_tile(f, ty * f->columns + tx, &b.at);
            copy_pixel(f, &b, &a);
        }
}

void glint_film_clear(glint_film *f)
{
    for (uint32_t t = 0; t < f->columns * f->rows; t++)
        glint_film_clear_tile(f, t);
}
