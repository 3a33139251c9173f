// keep_ahead.c - content on its way to the disk while a revision is made of it.
#include "scene/keep_parts.h"

#include "base/thread.h"

#include <stdlib.h>
#include <string.h>

struct glint_keeping {
    glint_keep *keep;
    char id[65];
    struct glint_import *import; // what is kept of the caller's, counted
    pthread_t thread;
};

static bool copy_set(struct glint_asset_set *out, const struct glint_asset_set *set)
{
    out->asset = calloc(set->count + 1, sizeof *out->asset);
    out->ref = calloc(set->count + 1, sizeof(glint_asset_ref *));
    if (!out->asset || !out->ref)
        return false;
    for (; out->count < set->count; out->count++) {
        out->asset[out->count] = set->asset[out->count];
        out->ref[out->count] = glint_asset_ref_retain(set->ref[out->count]);
    }
    return true;
}

// Text and assets alone; NULL without memory.
static struct glint_import *copy_import(const struct glint_import *from)
{
    struct glint_import *im = calloc(1, sizeof *im);
    if (!im)
        return NULL;
    *im = (struct glint_import){.text = from->text,
                                .length = from->length,
                                .memory = glint_memory_ref_retain(from->memory)};
    const bool copied = copy_set(&im->set, &from->set);
    im->asset = im->set.asset;
    im->assets = im->set.count;
    if (!copied)
        glint_import_destroy(&im);
    return im;
}

static void *write_content(void *arg)
{
    const struct glint_keeping *g = arg;
    glint_keep_content(g->keep, g->id, g->import, NULL); // who needs it asks again, and is told
    return NULL;
}

static void release(struct glint_keeping *g)
{
    glint_keep_release(g->keep, g->id);
    glint_import_destroy(&g->import);
    free(g);
}

struct glint_keeping *glint_keep_begin(glint_keep *keep, const char *id,
                                       const struct glint_import *import)
{
    struct glint_keeping *g = calloc(1, sizeof *g);
    struct glint_import *copy = g ? copy_import(import) : NULL;
    if (!copy) {
        free(g);
        return NULL;
    }
    g->keep = keep;
    g->import = copy;
    memcpy(g->id, id, sizeof g->id);
    glint_keep_hold(keep, id, 0); // nobody takes away what is written for it
    if (!glint_thread_start(&g->thread, "keep", write_content, g, NULL))
        return g;
    release(g);
    return NULL;
}

void glint_keep_end(struct glint_keeping **keeping)
{
    struct glint_keeping *g = *keeping;
    *keeping = NULL;
    if (!g)
        return;
    pthread_join(g->thread, NULL);
    release(g);
}
