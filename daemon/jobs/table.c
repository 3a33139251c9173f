#include "jobs/table.h"

#include "base/clock.h"
#include "base/log.h"
#include "jobs/checkpoint.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool glint_job_table_init(struct glint_job_table *table, uint32_t workers)
{
    *table = (struct glint_job_table){0};
    pthread_mutex_init(&table->mutex, NULL);
    table->worker = calloc(workers, sizeof *table->worker);
    table->workers = table->worker ? workers : 0;
    return table->worker;
}

void glint_job_table_finish(struct glint_job_table *table)
{
    for (size_t i = 0; i < table->count; i++)
        glint_entry_release(&table->entry[i]);
    free(table->entry);
    free(table->worker);
    pthread_mutex_destroy(&table->mutex);
}

// With the mutex.
static struct glint_entry *find(const struct glint_job_table *table, const char *id)
{
    for (size_t i = 0; i < table->count; i++)
        if (!strcmp(table->entry[i]->id, id))
            return table->entry[i];
    return NULL;
}

struct glint_entry *glint_job_table_hold(struct glint_job_table *table, const char *id,
                                         struct glint_error *err)
{
    pthread_mutex_lock(&table->mutex);
    struct glint_entry *entry = find(table, id);
    if (entry)
        glint_entry_retain(entry);
    pthread_mutex_unlock(&table->mutex);
    if (!entry)
        glint_fail(err, GLINT_E_NOT_FOUND, "", "there is no job \"%.64s\"", id);
    return entry;
}

struct glint_entry *glint_job_table_find_key(const struct glint_job_table *table,
                                             const char *client, const char *key)
{
    const double oldest = glint_now() - GLINT_KEY_SECONDS;
    for (size_t i = table->count; i--;) {
        struct glint_entry *entry = table->entry[i];
        if (entry->submitted < oldest)
            return NULL;
        if (entry->key && !strcmp(entry->key, key) && !strcmp(entry->client, client))
            return entry;
    }
    return NULL;
}

static bool grow(struct glint_job_table *table)
{
    const size_t capacity = table->capacity ? 2 * table->capacity : 64;
    struct glint_entry **more = malloc(capacity * sizeof *more);
    if (!more)
        return false;
    if (table->count)
        memcpy(more, table->entry, table->count * sizeof *more);
    struct glint_entry **old = table->entry;
    pthread_mutex_lock(&table->mutex);
    table->entry = more;
    table->capacity = capacity;
    pthread_mutex_unlock(&table->mutex);
    free(old);
    return true;
}

bool glint_job_table_add(struct glint_job_table *table, struct glint_entry *entry)
{
    if (table->count == table->capacity && !grow(table))
        return false;
    entry->listed = true;
    pthread_mutex_lock(&table->mutex);
    table->entry[table->count++] = entry;
    table->submitted++;
    pthread_mutex_unlock(&table->mutex);
    return true;
}

void glint_job_table_remove(struct glint_job_table *table, struct glint_entry *entry)
{
    size_t at = 0;
    while (table->entry[at] != entry)
        at++;
    entry->listed = false;
    pthread_mutex_lock(&table->mutex);
    table->count--;
    memmove(table->entry + at, table->entry + at + 1, (table->count - at) * sizeof *table->entry);
    pthread_mutex_unlock(&table->mutex);
}

// Takes an entry out and puts it at the head of a list.
static void take_out(struct glint_job_table *table, struct glint_entry *entry,
                     struct glint_entry **gone)
{
    glint_job_table_remove(table, entry);
    entry->next = *gone;
    *gone = entry;
}

struct glint_entry *glint_job_table_trim(struct glint_job_table *table, size_t most)
{
    size_t ended = 0;
    for (size_t i = 0; i < table->count; i++)
        ended += glint_state_ended(table->entry[i]->state);
    struct glint_entry *gone = NULL;
    for (size_t i = 0; ended > most;) {
        if (!glint_state_ended(table->entry[i]->state)) {
            i++;
            continue;
        }
        take_out(table, table->entry[i], &gone);
        ended--;
    }
    return gone;
}

// The render of an ended entry that is on the disk and that nobody uses; NULL: it stays.
static glint_render *part_with(struct glint_job_table *table, struct glint_entry *e)
{
    glint_render *render = NULL;
    pthread_mutex_lock(&table->mutex);
    if (glint_checkpoint_complete(e) && !e->views) {
        render = e->render;
        e->render = NULL;
    }
    pthread_mutex_unlock(&table->mutex);
    return render;
}

bool glint_job_table_make_room(struct glint_job_table *table, uint64_t wanted, uint64_t limit,
                               struct glint_entry **gone,
                               void (*let_go)(void *user, glint_render **render), void *user)
{
    uint64_t live = wanted, ended = 0;
    for (size_t i = 0; i < table->count; i++) {
        const struct glint_entry *e = table->entry[i];
        if (e->render)
            *(glint_state_ended(e->state) ? &ended : &live) += e->need.film;
    }
    if (live > limit)
        return false;
    for (size_t i = 0; i < table->count && live + ended > limit;) {
        struct glint_entry *e = table->entry[i];
        const bool has = e->render && glint_state_ended(e->state);
        glint_render *render = has && e->keeper ? part_with(table, e) : NULL;
        if (render || (has && !e->keeper))
            ended -= e->need.film;
        if (render)
            let_go(user, &render);
        if (has && !e->keeper)
            take_out(table, e, gone);
        else
            i++;
    }
    return live + ended <= limit;
}

struct glint_entry *glint_entry_retain(struct glint_entry *entry)
{
    // Relaxed: who retains holds a reference already, or the table's mutex.
    atomic_fetch_add_explicit(&entry->references, 1, memory_order_relaxed);
    return entry;
}

void glint_entry_release(struct glint_entry **entry)
{
    struct glint_entry *e = *entry;
    *entry = NULL;
    // Acquire and release: the last to leave sees what the others did before they left.
    if (!e || atomic_fetch_sub_explicit(&e->references, 1, memory_order_acq_rel) != 1)
        return;
    glint_view_release(&e->next_view);
    glint_render_destroy(&e->render);
    glint_revision_release(&e->next_revision);
    glint_revision_release(&e->revision);
    glint_look_release(&e->look);
    glint_job_destroy(&e->job);
    glint_error_finish(&e->problem);
    cJSON_Delete(e->warnings);
    free(e->trouble);
    free(e->kept.trouble);
    free(e->kept.torn);
    free(e->text);
    free(e->asked);
    cJSON_Delete(e->chosen);
    free(e->client);
    free(e->request);
    free(e->key);
    free(e);
}

void glint_entry_release_all(struct glint_entry *gone)
{
    while (gone) {
        struct glint_entry *next = gone->next;
        glint_log(GLINT_LOG_DEBUG, "jobs", gone->id, gone->request, "forgotten");
        glint_entry_release(&gone);
        gone = next;
    }
}

double glint_entry_seconds(const struct glint_entry *entry, double now)
{
    return entry->render_seconds + (isnan(entry->since) ? 0 : fmax(now - entry->since, 0));
}
