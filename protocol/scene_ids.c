// scene_ids.c - ids of a collection, found by bisection.
#include "protocol/scene_parts.h"

#include <stdlib.h>
#include <string.h>

static int by_id(const void *a, const void *b)
{
    return strcmp(((const struct glint_id *)a)->id, ((const struct glint_id *)b)->id);
}

bool glint_ids_index(struct glint_ids *out, const cJSON *collection, struct glint_arena *arena)
{
    uint32_t count = 0;
    for (const cJSON *c = collection ? collection->child : NULL; c; c = c->next)
        count++;
    *out = (struct glint_ids){.entry = glint_arena_array(arena, count, sizeof *out->entry)};
    if (!out->entry)
        return false;
    for (const cJSON *c = collection ? collection->child : NULL; c; c = c->next, out->count++)
        out->entry[out->count] = (struct glint_id){c->string, out->count};
    qsort(out->entry, count, sizeof *out->entry, by_id);
    return true;
}

uint32_t glint_ids_find(const struct glint_ids *ids, const char *id)
{
    const struct glint_id key = {id, 0};
    const struct glint_id *found = bsearch(&key, ids->entry, ids->count, sizeof key, by_id);
    return found ? found->index : GLINT_NONE;
}
