// matte_names.c - names that differ have IDs that differ: of two that hash to one, the later in
// bytewise order is written under another name.
#include "protocol/cryptomatte.h"
#include "scene/internal.h"

#include <stdlib.h>
#include <string.h>

#define MOST_TRIES 16 // for a name: by chance the first one does
#define MOST_ROUNDS 4 // in which new names may meet each other
#define MOST_RENAMED 1000

struct renamed {
    const char *from, *to;
};

// The names of a layer, and their IDs in order.
struct layer {
    const char **name; // [count]
    uint32_t *id;      // sorted
    size_t count;
    struct renamed renamed[MOST_RENAMED]; // by `from`
    size_t renames;
};

static int by_value(const void *a, const void *b)
{
    const uint32_t p = *(const uint32_t *)a, q = *(const uint32_t *)b;
    return (p > q) - (p < q);
}

static int by_from(const void *a, const void *b)
{
    return strcmp(((const struct renamed *)a)->from, ((const struct renamed *)b)->from);
}

static void collect(struct layer *l, const struct glint_resident *r, int k)
{
    l->count = l->renames = 0;
    for (uint32_t m = 2; m < r->mattes; m++)
        if (r->matte[m].id[k]) {
            l->name[l->count] = r->matte[m].name[k];
            l->id[l->count++] = r->matte[m].id[k];
        }
    qsort(l->id, l->count, sizeof *l->id, by_value);
}

// A name whose ID nothing in the layer has; NULL: the clash stays, or there is no memory.
static const char *another(const struct layer *l, struct glint_arena *arena, const char *name)
{
    for (int n = 2; n < 2 + MOST_TRIES; n++) {
        const char *text = glint_arena_print(arena, "%s~%d", name, n);
        const uint32_t id = text ? glint_cryptomatte_id(text) : 0;
        if (!text)
            return NULL;
        if (!bsearch(&id, l->id, l->count, sizeof id, by_value))
            return text;
    }
    return NULL;
}

static void choose(struct layer *l, struct glint_arena *arena,
                   const struct glint_cryptomatte_clash *clash, size_t clashes)
{
    for (size_t i = 0; i < clashes && l->renames < MOST_RENAMED; i++) {
        const char *to = another(l, arena, clash[i].b);
        if (to)
            l->renamed[l->renames++] = (struct renamed){clash[i].b, to};
    }
    qsort(l->renamed, l->renames, sizeof *l->renamed, by_from);
}

static void rename_keys(const struct layer *l, struct glint_resident *r, int k)
{
    for (uint32_t m = 2; m < r->mattes && l->renames; m++) {
        const struct renamed wanted = {r->matte[m].name[k], NULL};
        const struct renamed *found =
            r->matte[m].id[k] ? bsearch(&wanted, l->renamed, l->renames, sizeof wanted, by_from)
                              : NULL;
        if (!found)
            continue;
        r->matte[m].name[k] = found->to;
        r->matte[m].id[k] = glint_cryptomatte_id(found->to);
    }
}

// Returns whether something has another name now.
static bool tell_apart(struct glint_resident *r, int k, struct layer *l)
{
    struct glint_cryptomatte_clash *clash;
    size_t clashes;
    collect(l, r, k);
    if (glint_cryptomatte_clashes(l->name, l->count, &clash, &clashes))
        return false;
    choose(l, &r->names, clash, clashes);
    rename_keys(l, r, k);
    free(clash);
    return l->renames > 0;
}

glint_status glint_resident_tell_mattes_apart(struct glint_resident *r, struct glint_error *err)
{
    struct layer *l = calloc(1, sizeof *l);
    if (l) {
        l->name = malloc((r->mattes + (size_t)1) * sizeof *l->name);
        l->id = malloc((r->mattes + (size_t)1) * sizeof *l->id);
    }
    const bool room = l && l->name && l->id;
    for (int k = 0; room && k < GLINT_MATTE_LAYERS; k++)
        for (int n = 0; n < MOST_ROUNDS && tell_apart(r, k, l); n++)
            ;
    if (l) {
        free(l->name);
        free(l->id);
    }
    free(l);
    return room ? GLINT_OK
                : glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u names", r->mattes);
}
