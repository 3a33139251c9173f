// scene_hashes.c - where the asset of a name is. The first 128 bits of SHA-256 are the key.
#include "protocol/scene_parts.h"

#include <stdlib.h>
#include <string.h>

struct glint_hash_slot {
    uint64_t key[2];
    uint32_t place; // index + 1, 0: free
};

static uint64_t sixteen_digits(const char *hex)
{
    uint64_t value = 0;
    for (int i = 0; i < 16; i++)
        value = value << 4 | (uint64_t)(hex[i] <= '9' ? hex[i] - '0' : hex[i] - 'a' + 10);
    return value;
}

// The slot of the key, or the free one where it belongs.
static struct glint_hash_slot *find(const struct glint_hashes *h, const uint64_t key[2])
{
    const size_t mask = h->capacity - 1;
    for (size_t i = (size_t)key[0] & mask;; i = (i + 1) & mask) {
        struct glint_hash_slot *s = &h->slot[i];
        if (!s->place || (s->key[0] == key[0] && s->key[1] == key[1]))
            return s;
    }
}

static bool grow(struct glint_hashes *h)
{
    struct glint_hashes larger = {.capacity = h->capacity ? 2 * h->capacity : 64, .used = h->used};
    larger.slot = calloc(larger.capacity, sizeof *larger.slot);
    if (!larger.slot)
        return false;
    for (size_t i = 0; i < h->capacity; i++)
        if (h->slot[i].place)
            *find(&larger, h->slot[i].key) = h->slot[i];
    free(h->slot);
    *h = larger;
    return true;
}

bool glint_hashes_add(struct glint_hashes *h, const char *sha256, uint32_t index)
{
    if (2 * h->used >= h->capacity && !grow(h))
        return false;
    const uint64_t key[2] = {sixteen_digits(sha256), sixteen_digits(sha256 + 16)};
    struct glint_hash_slot *s = find(h, key);
    if (s->place)
        return true;
    *s = (struct glint_hash_slot){{key[0], key[1]}, index + 1};
    h->used++;
    return true;
}

uint32_t glint_hashes_find(const struct glint_hashes *h, const char *sha256)
{
    if (!h->capacity)
        return GLINT_NONE;
    const uint64_t key[2] = {sixteen_digits(sha256), sixteen_digits(sha256 + 16)};
    return find(h, key)->place - 1;
}

void glint_hashes_finish(struct glint_hashes *h)
{
    free(h->slot);
    *h = (struct glint_hashes){0};
}
