// gltf_names.c - a hash set of strings with open addressing.
#include "scene/gltf_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ID_BYTES 64u

static uint32_t hash(const char *text)
{
    uint32_t h = 2166136261u; // FNV-1a
    for (; *text; text++)
        h = (h ^ (uint8_t)*text) * 16777619u;
    return h;
}

static struct glint_gltf_name *find(const struct glint_gltf_names *n, const char *text)
{
    const uint32_t mask = n->capacity - 1;
    uint32_t i = hash(text) & mask;
    while (n->slot[i].text && strcmp(n->slot[i].text, text) != 0)
        i = (i + 1) & mask;
    return &n->slot[i];
}

static bool grow(struct glint_gltf_names *n)
{
    struct glint_gltf_names more = {.used = n->used,
                                    .capacity = n->capacity ? 2 * n->capacity : 64};
    more.slot = calloc(more.capacity, sizeof *more.slot);
    if (!more.slot)
        return false;
    for (uint32_t i = 0; i < n->capacity; i++)
        if (n->slot[i].text)
            *find(&more, n->slot[i].text) = n->slot[i];
    free(n->slot);
    *n = more;
    return true;
}

uint32_t *glint_gltf_names_at(struct glint_gltf_names *n, struct glint_arena *arena,
                              const char *text)
{
    if (2 * (n->used + 1) > n->capacity && !grow(n))
        return NULL;
    struct glint_gltf_name *slot = find(n, text);
    if (!slot->text) {
        slot->text = glint_arena_string(arena, text);
        slot->value = 0;
        if (!slot->text)
            return NULL;
        n->used++;
    }
    return &slot->value;
}

static bool plain(char c)
{
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
}

char *glint_gltf_names_id(struct glint_gltf_names *n, struct glint_arena *arena, const char *text)
{
    char base[ID_BYTES + 1], id[ID_BYTES + 16];
    size_t length = strnlen(text, ID_BYTES);
    for (size_t i = 0; i < length; i++)
        base[i] = plain(text[i]) ? text[i] : '_';
    base[length] = '\0';
    uint32_t *taken = glint_gltf_names_at(n, arena, base);
    if (!taken)
        return NULL;
    if ((*taken)++ == 0)
        return glint_arena_string(arena, base);
    for (uint32_t k = *taken;; k++) {
        snprintf(id, sizeof id, "%s_%u", base, k);
        uint32_t *other = glint_gltf_names_at(n, arena, id);
        if (!other)
            return NULL;
        if ((*other)++ == 0) {
            *glint_gltf_names_at(n, arena, base) = k;
            return glint_arena_string(arena, id);
        }
    }
}

void glint_gltf_names_finish(struct glint_gltf_names *n)
{
    free(n->slot);
    *n = (struct glint_gltf_names){0};
}
