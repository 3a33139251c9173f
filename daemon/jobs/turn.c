#include "jobs/turn.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define KEPT_SLICES 2 // of debt or credit, over a time away

static struct glint_account *find(struct glint_account *first, const char *client, int32_t priority)
{
    while (first && (first->priority != priority || strcmp(first->client, client) != 0))
        first = first->next;
    return first;
}

static struct glint_account *open_account(struct glint_account **accounts, const char *client,
                                          int32_t priority)
{
    struct glint_account *a = calloc(1, sizeof *a);
    char *name = strdup(client);
    if (!a || !name) {
        free(a);
        free(name);
        return NULL;
    }
    *a = (struct glint_account){.next = *accounts, .client = name, .priority = priority};
    return *accounts = a;
}

bool glint_turn_enter(struct glint_account **accounts, struct glint_entry *entry, int32_t priority)
{
    struct glint_account *a = find(*accounts, entry->client, priority);
    if (!a)
        a = open_account(accounts, entry->client, priority);
    if (!a || a == entry->account)
        return a;
    a->entries++;
    glint_turn_leave(accounts, entry);
    entry->account = a;
    return true;
}

void glint_turn_leave(struct glint_account **accounts, struct glint_entry *entry)
{
    struct glint_account *a = entry->account;
    entry->account = NULL;
    if (!a || --a->entries)
        return;
    while (*accounts != a)
        accounts = &(*accounts)->next;
    *accounts = a->next;
    free(a->client);
    free(a);
}

static bool waits(const struct glint_entry *entry)
{
    const bool live = entry->state == GLINT_JOB_QUEUED || entry->state == GLINT_JOB_RENDERING;
    return live && entry->end == GLINT_JOB_QUEUED;
}

bool glint_turn_wants(const struct glint_entry *entry)
{
    return entry->render && waits(entry) && !entry->idle && !entry->next_view;
}

static double pending(const struct glint_entry *entry)
{
    return entry->out * entry->slice_seconds;
}

// Sums up what each account has at the workers.
static void count_pending(struct glint_entry *const *entry, size_t count)
{
    for (size_t i = 0; i < count; i++)
        entry[i]->account->pending = 0;
    for (size_t i = 0; i < count; i++)
        entry[i]->account->pending += pending(entry[i]);
}

// Earlier entries come first among true equals: the caller walks in order of submission.
static bool before(const struct glint_entry *a, const struct glint_entry *b)
{
    if (a->priority != b->priority)
        return a->priority > b->priority;
    if (a->account != b->account)
        return a->account->turn + a->account->pending < b->account->turn + b->account->pending;
    return a->turn + pending(a) < b->turn + pending(b);
}

struct glint_entry *glint_turn_next(struct glint_entry *const *entry, size_t count)
{
    struct glint_entry *next = NULL;
    count_pending(entry, count);
    for (size_t i = 0; i < count; i++)
        if (glint_turn_wants(entry[i]) && !entry[i]->dry && (!next || before(entry[i], next)))
            next = entry[i];
    return next;
}

// Where who stood at `turn`, 0: has had nothing yet, stands among equals of whom the least served is
// at `least`.
static double rejoin(double turn, double least, double slice_seconds)
{
    const double kept = KEPT_SLICES * slice_seconds;
    if (isinf(least))
        return turn;
    return turn > 0 ? fmin(fmax(turn, least - kept), least + kept) : least;
}

void glint_turn_join(struct glint_entry *const *entry, size_t count, struct glint_entry *joining)
{
    struct glint_account *account = joining->account;
    double least_client = INFINITY, least_job = INFINITY;
    for (size_t i = 0; i < count; i++) {
        const struct glint_entry *e = entry[i];
        if (e == joining || !glint_turn_wants(e) || e->priority != joining->priority)
            continue;
        if (e->account == account)
            least_job = fmin(least_job, e->turn);
        else
            least_client = fmin(least_client, e->account->turn);
    }
    if (isinf(least_job)) // the client comes with it
        account->turn = rejoin(account->turn, least_client, joining->slice_seconds);
    joining->turn = rejoin(joining->turn, least_job, joining->slice_seconds);
}

void glint_turn_charge(struct glint_entry *entry, double seconds)
{
    entry->turn += seconds;
    if (entry->account)
        entry->account->turn += seconds;
    entry->slice_seconds += 0.25 * (seconds - entry->slice_seconds);
}

// Counts the films of each account. Returns how many jobs of the priority or higher have one.
static size_t count_films(struct glint_entry *const *entry, size_t count, int32_t priority)
{
    size_t films = 0;
    for (size_t i = 0; i < count; i++)
        entry[i]->account->films = 0;
    for (size_t i = 0; i < count; i++)
        if (glint_turn_wants(entry[i])) {
            entry[i]->account->films++;
            films += entry[i]->priority >= priority;
        }
    return films;
}

static bool sooner(const struct glint_entry *a, const struct glint_entry *b)
{
    return a->priority != b->priority ? a->priority > b->priority
                                      : a->account->films < b->account->films;
}

struct glint_entry *glint_turn_prepare(struct glint_entry *const *entry, size_t count,
                                       uint32_t films)
{
    struct glint_entry *next = NULL;
    count_films(entry, count, 0);
    for (size_t i = 0; i < count; i++) {
        const struct glint_entry *e = entry[i];
        const bool ready = waits(e) && !e->render && !e->preparing;
        if (ready && (!next || sooner(e, next)))
            next = entry[i];
    }
    if (!next || next->blocked)
        return NULL;
    const bool room = count_films(entry, count, next->priority) < films;
    return room || !next->account->films ? next : NULL;
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
