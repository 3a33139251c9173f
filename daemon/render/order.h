// order.h - in which order a live job's first samples are taken: from the middle outwards, where
// people look, the blocks of a tile that clients see one after another.
//
// Threads: made by whoever makes the render, immutable afterwards.
#ifndef GLINT_RENDER_ORDER_H
#define GLINT_RENDER_ORDER_H

#include <stdint.h>

// The indices of the blocks of a pass that is `wide` x `high` blocks, 2 x 2 to a client's tile;
// malloc'd, NULL without memory.
uint32_t *glint_order_create(uint32_t wide, uint32_t high);

// Where block number `block` of a pass is: they go two by two, down, then to the right.
void glint_order_place(uint32_t wide, uint32_t high, uint32_t block, uint32_t *column,
                       uint32_t *row);

#endif
