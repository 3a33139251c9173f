// keep_collect.c - finds what nobody needs any more, and removes it.
#include "base/clock.h"
#include "base/journal_schema.h"
#include "base/log.h"
#include "base/thread.h"
#include "scene/keep_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PAUSE_SECONDS 1 // between two rounds: a scene that is patched often leaves many

// ---- which revisions are needed

struct node {
    char id[65], parent[65];
    bool file, needed;
};

// The rows of the journal at one moment.
struct graph {
    struct node *node; // [count] by id
    size_t count, capacity;
    bool failed;
};

static void take_node(void *user, const struct glint_row *row)
{
    struct graph *g = user;
    const char *id = glint_row_text(row, 0), *parent = glint_row_text(row, 1);
    if (g->count == g->capacity) {
        const size_t more = g->capacity ? 2 * g->capacity : 256;
        struct node *grown = realloc(g->node, more * sizeof *grown);
        g->failed |= !grown;
        if (!grown)
            return;
        g->node = grown;
        g->capacity = more;
    }
    struct node *n = &g->node[g->count++];
    *n = (struct node){.file = glint_row_integer(row, 2) == GLINT_TEXT_FILE,
                       .needed = glint_row_integer(row, 3) != 0};
    if (id && strlen(id) == 64)
        memcpy(n->id, id, 65);
    if (parent && strlen(parent) == 64)
        memcpy(n->parent, parent, 65);
}

static int by_id(const void *a, const void *b)
{
    return strcmp(((const struct node *)a)->id, ((const struct node *)b)->id);
}

static struct node *find_node(const struct graph *g, const char *id)
{
    struct node key;
    memcpy(key.id, id, 65);
    return g->count ? bsearch(&key, g->node, g->count, sizeof key, by_id) : NULL;
}

// Of what is needed, everything that it is told by.
static void mark(const struct graph *g, struct node *n)
{
    while (n && *n->parent) {
        struct node *parent = find_node(g, n->parent);
        if (!parent || parent->needed)
            return;
        parent->needed = true;
        n = parent;
    }
}

static bool read_graph(glint_keep *k, struct graph *g)
{
    const struct glint_statement all = {
        .sql = "SELECT id, parent, form, "
               "EXISTS(SELECT 1 FROM scene WHERE scene.revision=revision.id) OR "
               "EXISTS(SELECT 1 FROM job WHERE job.revision=revision.id AND state IN "
               "('queued','rendering','paused')) FROM revision ORDER BY id"};
    *g = (struct graph){0};
    return !glint_journal_read(k->journal, &all, take_node, g, NULL) && !g->failed;
}

// ---- collecting

// Whether a file of the vault must stay. With the mutex of the keep.
static bool needed(void *user, const char *name)
{
    glint_keep *k = user;
    if (glint_keep_find(k, name) || glint_assets_has(k->assets, name))
        return true;
    for (size_t i = 0; i < k->pins; i++)
        if (!strcmp(k->pinned[i], name))
            return true;
    return false;
}

struct sweeping {
    glint_keep *keep;
    const struct graph *graph;
};

static bool needed_beside(void *user, const char *name)
{
    const struct sweeping *s = user;
    const struct node *n = find_node(s->graph, name);
    return (n && n->file && n->needed) || needed(s->keep, name);
}

static bool drop_rows(glint_keep *k, const struct graph *g)
{
    struct glint_statement *statement = calloc(g->count + 1, sizeof *statement);
    size_t count = 0;
    for (size_t i = 0; statement && i < g->count; i++)
        if (!g->node[i].needed)
            statement[count++] =
                (struct glint_statement){.sql = "DELETE FROM revision WHERE id=?",
                                         .value = {glint_value_text(g->node[i].id)},
                                         .values = 1};
    // All at once, since they refer to each other.
    const bool dropped =
        statement && (!count || !glint_journal_commit(k->journal, statement, count, NULL));
    free(statement);
    return dropped;
}

// With the mutex, so that nothing that is let go here is taken up again meanwhile: who makes a
// revision holds it first, and waits for that.
// False: files are left that may have to go.
static bool collect(glint_keep *k, bool all)
{
    struct graph g;
    if (!read_graph(k, &g)) {
        free(g.node);
        return false;
    }
    for (size_t i = 0; i < k->helds; i++) {
        struct node *n = find_node(&g, k->held[i].id);
        if (n)
            n->needed = true;
    }
    for (size_t i = 0; i < g.count; i++)
        if (g.node[i].needed)
            mark(&g, &g.node[i]);
    struct sweeping s = {k, &g};
    bool swept = drop_rows(k, &g);
    for (size_t i = 0; i < g.count && swept && !all; i++)
        if (!g.node[i].needed && g.node[i].file)
            swept = glint_vault_sweep(k->vault, g.node[i].id, needed_beside, &s);
    for (size_t i = 0; i < k->gones && swept && !all; i++)
        swept = glint_vault_sweep(k->vault, k->gone[i], needed_beside, &s);
    if (all && swept)
        swept = glint_vault_sweep(k->vault, NULL, needed_beside, &s);
    free(g.node);
    return swept;
}

// What clients put and nobody used went with its memory.
static void drop_asset_rows(glint_keep *k)
{
    struct glint_statement *statement = calloc(k->gones + 1, sizeof *statement);
    size_t count = 0;
    for (size_t i = 0; statement && i < k->gones; i++)
        if (!glint_assets_has(k->assets, k->gone[i]))
            statement[count++] = (struct glint_statement){.sql = "DELETE FROM asset WHERE name=?",
                                                          .value = {glint_value_text(k->gone[i])},
                                                          .values = 1};
    if (count)
        glint_journal_commit(k->journal, statement, count, NULL);
    free(statement);
}

static void *run(void *arg)
{
    glint_keep *k = arg;
    pthread_mutex_lock(&k->mutex);
    while (!k->stop) {
        if (!k->began || !k->dirty) {
            pthread_cond_wait(&k->changed, &k->mutex);
            continue;
        }
        k->dirty = false;
        if (k->collects) {
            drop_asset_rows(k);
            k->sweep = k->dirty = !collect(k, k->sweep);
        }
        k->gones = 0;
        const double until = glint_now() + PAUSE_SECONDS;
        while (!k->stop && glint_condition_wait(&k->changed, &k->mutex, until)) {
        }
    }
    pthread_mutex_unlock(&k->mutex);
    return NULL;
}

// An asset has left the memory; the caller may be the collector's callee, which holds the mutex: it
// never lets go of one.
static void gone(void *user, const char *name)
{
    glint_keep *k = user;
    pthread_mutex_lock(&k->mutex);
    char(*more)[65] = realloc(k->gone, (k->gones + 1) * sizeof *more);
    if (more) {
        k->gone = more;
        memcpy(more[k->gones++], name, 65);
    } else {
        k->sweep = true;
    }
    k->dirty = true;
    pthread_cond_signal(&k->changed);
    pthread_mutex_unlock(&k->mutex);
}

// ---- what clients had put

struct names {
    char (*name)[65];
    size_t count;
};

static void take_name(void *user, const struct glint_row *row)
{
    struct names *names = user;
    const char *name = glint_row_text(row, 0);
    char(*more)[65] = realloc(names->name, (names->count + 1) * sizeof *more);
    if (!more || !name || strlen(name) != 64) {
        names->name = more ? more : names->name;
        return;
    }
    names->name = more;
    memcpy(more[names->count++], name, 65);
}

static void adopt(glint_keep *k, const char *name)
{
    struct glint_asset asset = {0};
    struct glint_error err = {0};
    bool created;
    memcpy(asset.sha256, name, 65);
    glint_status st = glint_vault_map(k->vault, name, &asset.bytes, &asset.size, &err);
    glint_memory_ref *memory = st ? NULL : glint_memory_ref_of_mapping(&asset.bytes, asset.size);
    if (!st && !memory)
        st = glint_fail(&err, GLINT_E_NOMEM, "", "no memory for an asset");
    if (memory)
        st = glint_assets_put(k->assets, &asset, memory, &created, &err);
    if (memory)
        glint_memory_ref_release(&memory);
    if (st)
        glint_log(GLINT_LOG_WARNING, "store", NULL, NULL, "asset %.12s is not taken up again: %s",
                  name, glint_error_text(&err));
    glint_error_finish(&err);
}

void glint_keep_adopt(glint_keep *k)
{
    struct names names = {0};
    const struct glint_statement all = {.sql = "SELECT name FROM asset"};
    glint_journal_read(k->journal, &all, take_name, &names, NULL);
    for (size_t i = 0; i < names.count; i++)
        adopt(k, names.name[i]);
    free(names.name);
}

void glint_keep_collect(glint_keep *k)
{
    pthread_mutex_lock(&k->mutex);
    k->began = k->dirty = k->sweep = true;
    pthread_cond_signal(&k->changed);
    pthread_mutex_unlock(&k->mutex);
}

// ---- life

glint_status glint_keep_create(glint_keep **out, glint_keeper *keeper, glint_assets *assets,
                               struct glint_error *err)
{
    glint_keep *k = *out = calloc(1, sizeof *k);
    if (!k)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory to keep scenes");
    k->keeper = keeper;
    k->journal = glint_keeper_journal(keeper);
    k->vault = glint_keeper_vault(keeper);
    k->assets = assets;
    k->collects = true;
    pthread_mutex_init(&k->mutex, NULL);
    glint_condition_init(&k->changed);
    const glint_status st = glint_thread_start(&k->thread, "collect", run, k, err);
    k->started = !st;
    if (st)
        glint_keep_destroy(out);
    else
        glint_assets_on_gone(assets, gone, k);
    return st;
}

void glint_keep_stop(glint_keep *k)
{
    if (!k->started)
        return;
    pthread_mutex_lock(&k->mutex);
    k->stop = true;
    pthread_cond_signal(&k->changed);
    pthread_mutex_unlock(&k->mutex);
    pthread_join(k->thread, NULL);
    k->started = false;
}

void glint_keep_destroy(glint_keep **keep)
{
    glint_keep *k = *keep;
    *keep = NULL;
    if (!k)
        return;
    glint_keep_stop(k);
    glint_assets_on_gone(k->assets, NULL, NULL);
    pthread_cond_destroy(&k->changed);
    pthread_mutex_destroy(&k->mutex);
    free(k->pinned);
    free(k->held);
    free(k->gone);
    free(k);
}
