#include "render/order.h"

#include <stdlib.h>

void glint_order_place(uint32_t wide, uint32_t high, uint32_t block, uint32_t *column,
                       uint32_t *row)
{
    const uint32_t first = block / (2 * wide) * 2; // of a pair of rows
    const uint32_t rows = first + 1 < high ? 2 : 1, i = block - first * wide;
    *column = i / rows;
    *row = first + i % rows;
}

struct place {
    uint64_t distance; // from the middle to that of the block's tile, squared, in half blocks
    uint32_t tile, block;
};

static struct place place_of(uint32_t wide, uint32_t high, uint32_t block)
{
    uint32_t column, row;
    glint_order_place(wide, high, block, &column, &row);
    const int64_t x = 4 * (int64_t)(column / 2) + 2 - wide, y = 4 * (int64_t)(row / 2) + 2 - high;
    return (struct place){(uint64_t)(x * x + y * y), row / 2 * ((wide + 1) / 2) + column / 2,
                          block};
}

static int compare(const void *a, const void *b)
{
    const struct place *p = a, *q = b;
    if (p->distance != q->distance)
        return p->distance < q->distance ? -1 : 1;
    if (p->tile != q->tile)
        return p->tile < q->tile ? -1 : 1;
    return p->block < q->block ? -1 : p->block > q->block;
}

uint32_t *glint_order_create(uint32_t wide, uint32_t high)
{
    const size_t blocks = (size_t)wide * high;
    struct place *place = malloc(blocks * sizeof *place);
    uint32_t *order = malloc(blocks * sizeof *order);
    if (!place || !order) {
        free(place);
        free(order);
        return NULL;
    }
    for (uint32_t b = 0; b < blocks; b++)
        place[b] = place_of(wide, high, b);
    qsort(place, blocks, sizeof *place, compare);
    for (size_t b = 0; b < blocks; b++)
        order[b] = place[b].block;
    free(place);
    return order;
}
