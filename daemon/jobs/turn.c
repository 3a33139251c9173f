#include "jobs/turn.h"

#include <math.h>

static bool waits(const struct glint_entry *entry)
{
    const bool live = entry->state == GLINT_JOB_QUEUED || entry->state == GLINT_JOB_RENDERING;
    return live && entry->end == GLINT_JOB_QUEUED;
}

bool glint_turn_wants(const struct glint_entry *entry)
{
    return entry->render && waits(entry) && !entry->idle && !entry->next_view;
}

static double standing(const struct glint_entry *entry)
{
    return entry->turn + entry->out * entry->slice_seconds;
}

// Earlier entries come first among true equals: the caller walks in order of submission.
static bool before(const struct glint_entry *a, const struct glint_entry *b)
{
    return a->priority != b->priority ? a->priority > b->priority : standing(a) < standing(b);
}

struct glint_entry *glint_turn_next(struct glint_entry *const *entry, size_t count)
{
    struct glint_entry *next = NULL;
    for (size_t i = 0; i < count; i++)
        if (glint_turn_wants(entry[i]) && !entry[i]->dry && (!next || before(entry[i], next)))
            next = entry[i];
    return next;
}

void glint_turn_join(struct glint_entry *const *entry, size_t count, struct glint_entry *joining)
{
    double least = INFINITY;
    for (size_t i = 0; i < count; i++)
        if (entry[i] != joining && glint_turn_wants(entry[i]) &&
            entry[i]->priority == joining->priority)
            least = fmin(least, entry[i]->turn);
    if (isfinite(least))
        joining->turn = least;
}

void glint_turn_charge(struct glint_entry *entry, double seconds)
{
    entry->turn += seconds;
    entry->slice_seconds += 0.25 * (seconds - entry->slice_seconds);
}

static size_t films_before(struct glint_entry *const *entry, size_t count, int32_t priority)
{
    size_t films = 0;
    for (size_t i = 0; i < count; i++)
        films += glint_turn_wants(entry[i]) && entry[i]->priority >= priority;
    return films;
}

struct glint_entry *glint_turn_prepare(struct glint_entry *const *entry, size_t count)
{
    struct glint_entry *next = NULL;
    for (size_t i = 0; i < count; i++) {
        const struct glint_entry *e = entry[i];
        const bool ready = waits(e) && !e->render && !e->preparing;
        if (ready && (!next || e->priority > next->priority))
            next = entry[i];
    }
    if (!next || next->blocked || films_before(entry, count, next->priority) >= GLINT_MAX_FILMS)
        return NULL;
    return next;
}

struct glint_entry *glint_turn_move(struct glint_entry *const *entry, size_t count)
{
    struct glint_entry *next = NULL;
    for (size_t i = 0; i < count; i++) {
        const struct glint_entry *e = entry[i];
        const bool ready = e->stale > 0 && e->render && e->end == GLINT_JOB_QUEUED;
        if (ready && (!next || e->stale < next->stale))
            next = entry[i];
    }
    return next;
}
