// ties.c - placements of one mesh in one place, so that the first of them can be seen.
#include "kernels/gk_sampler.h"
#include "scene/internal.h"

#include <stdlib.h>
#include <string.h>

static bool drawn_often(const struct glint_resident *r, const struct glint_row *row)
{
    const struct glint_kept *k = &r->kept[row->kept];
    return k->uses > 1 && k->triangles;
}

static bool any_drawn_often(const struct glint_resident *r)
{
    bool any = false;
    for (uint32_t i = 0; !any && i < r->rows; i++)
        any = drawn_often(r, &r->row[i]);
    return any;
}

static uint32_t hash_of(const struct glint_row *row)
{
    uint32_t word[16], hash = row->kept;
    memcpy(word, row->transform, sizeof word);
    for (int k = 0; k < 16; k++)
        hash = gk_mix32(hash ^ word[k]) + (uint32_t)k;
    return hash;
}

static bool in_one_place(const struct glint_resident *r, const struct glint_row *a,
                         const struct glint_row *b)
{
    const size_t motion = 16 * sizeof(float) * glint_resident_keys(r);
    return a->kept == b->kept && memcmp(a->transform, b->transform, sizeof a->transform) == 0 &&
           !a->motion == !b->motion && (!a->motion || memcmp(a->motion, b->motion, motion) == 0);
}

// Joins the row to the ring of the first that lies where it does. known: [slots], first rows + 1.
static bool join(const struct glint_resident *r, uint32_t *ring, uint32_t *known, uint32_t slots,
                 uint32_t row)
{
    uint32_t at = hash_of(&r->row[row]) & (slots - 1);
    while (known[at] && !in_one_place(r, &r->row[known[at] - 1], &r->row[row]))
        at = (at + 1) & (slots - 1);
    if (!known[at]) {
        known[at] = row + 1;
        return false;
    }
    const uint32_t first = known[at] - 1;
    ring[row] = ring[first];
    ring[first] = row;
    return true;
}

static bool join_all(const struct glint_resident *r, uint32_t *ring, uint32_t *known,
                     uint32_t slots)
{
    bool any = false;
    for (uint32_t i = 0; i < r->rows; i++) {
        ring[i] = i;
        if (drawn_often(r, &r->row[i]))
            any |= join(r, ring, known, slots, i);
    }
    return any;
}

glint_status glint_ties_find(uint32_t **ring, const struct glint_resident *r,
                             struct glint_error *err)
{
    uint32_t slots = 2;
    *ring = NULL;
    if (!any_drawn_often(r))
        return GLINT_OK;
    while (slots < 2 * r->rows)
        slots *= 2;
    uint32_t *of = malloc((size_t)r->rows * sizeof *of), *known = calloc(slots, sizeof *known);
    const bool memory = of && known;
    const bool any = memory && join_all(r, of, known, slots);
    free(known);
    if (any)
        *ring = of;
    else
        free(of);
    return memory ? GLINT_OK
                  : glint_fail(err, GLINT_E_NOMEM, "", "no memory for %u instances", r->rows);
}
