// film_pack.h - the words of a tile, without those that are zero.
//
// Thread-safety: reentrant.
#ifndef GLINT_PROTOCOL_FILM_PACK_H
#define GLINT_PROTOCOL_FILM_PACK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// `bytes`: a multiple of 32.
size_t glint_film_pack_bound(size_t bytes);
size_t glint_film_pack(const void *memory, size_t bytes, uint8_t *out);
// False where `size` is not what the words take.
bool glint_film_unpack(const uint8_t *packed, size_t size, void *memory, size_t bytes);

#endif
