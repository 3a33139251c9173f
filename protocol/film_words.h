// film_words.h - what writing and reading films share. Not for others.
#ifndef GLINT_PROTOCOL_FILM_WORDS_H
#define GLINT_PROTOCOL_FILM_WORDS_H

#include <stddef.h>
#include <stdint.h>
#include <zlib.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "words are stored as they lie in memory");

#define GLINT_FILM_MAGIC "GLNTFILM"
#define GLINT_FILM_HEAD_WORDS 5 // before their CRC
#define GLINT_FILM_TILE_WORDS 3
#define GLINT_FILM_END UINT32_MAX

// Of the words and the bytes that follow them; `b` may be NULL with no bytes.
static inline uint32_t glint_film_crc(const void *a, size_t a_bytes, const void *b, size_t b_bytes)
{
    const uLong crc = crc32_z(0, a, a_bytes);
    return (uint32_t)(b_bytes ? crc32_z(crc, b, b_bytes) : crc);
}

#endif
