#include "protocol/film_pack.h"

#include <string.h>

size_t glint_film_pack_bound(size_t bytes)
{
    return bytes + bytes / 32;
}

size_t glint_film_pack(const void *memory, size_t bytes, uint8_t *out)
{
    uint8_t *word = out + bytes / 32;
    for (size_t group = 0; group < bytes / 32; group++) {
        uint32_t w[8];
        memcpy(w, (const uint8_t *)memory + group * 32, sizeof w);
        unsigned bits = 0;
        for (unsigned i = 0; i < 8; i++)
            if (w[i]) {
                bits |= 1u << i;
                memcpy(word, &w[i], 4);
                word += 4;
            }
        out[group] = (uint8_t)bits;
    }
    return (size_t)(word - out);
}

bool glint_film_unpack(const uint8_t *packed, size_t size, void *memory, size_t bytes)
{
    const size_t groups = bytes / 32;
    size_t words = 0;
    if (size < groups)
        return false;
    for (size_t group = 0; group < groups; group++)
        words += (size_t)__builtin_popcount(packed[group]);
    if (size != groups + words * 4)
        return false;
    const uint8_t *word = packed + groups;
    for (size_t group = 0; group < groups; group++) {
        uint32_t w[8] = {0};
        for (unsigned i = 0; i < 8; i++)
            if (packed[group] >> i & 1) {
                memcpy(&w[i], word, 4);
                word += 4;
            }
        memcpy((uint8_t *)memory + group * 32, w, sizeof w);
    }
    return true;
}
