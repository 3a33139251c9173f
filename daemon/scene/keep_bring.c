// keep_bring.c - the assets of a kept text: each is read once to check its content, by all cores.
#include "scene/keep_parts.h"

#include "base/thread.h"

#include <stdlib.h>
#include <string.h>

// An asset that the text names.
struct named {
    const char *name; // in the text
    glint_asset_ref *ref;
    struct glint_error fault;
};

struct bringing {
    glint_keep *keep;
    struct named *named; // [count], owned
    size_t count;
};

static glint_status list_names(struct bringing *b, const char *text, size_t length,
                               struct glint_error *err)
{
    size_t at = 0, capacity = 0;
    for (const char *name; (name = glint_assets_next_name(text, length, &at));) {
        if (b->count == capacity) {
            capacity = capacity ? 2 * capacity : 64;
            struct named *more = realloc(b->named, capacity * sizeof *more);
            if (!more)
                return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the assets of a scene");
            b->named = more;
        }
        b->named[b->count++] = (struct named){.name = name};
    }
    return GLINT_OK;
}

static void map_one(glint_keep *k, struct named *n)
{
    struct glint_asset asset = {0};
    memcpy(asset.sha256, n->name, 64);
    if (glint_vault_map(k->vault, asset.sha256, &asset.bytes, &asset.size, &n->fault))
        return;
    glint_memory_ref *memory = glint_memory_ref_of_mapping(&asset.bytes, asset.size);
    if (!memory) {
        glint_fail(&n->fault, GLINT_E_NOMEM, "", "no memory for an asset");
        return;
    }
    glint_assets_add(k->assets, &asset, memory, &n->ref, &n->fault);
    glint_memory_ref_release(&memory);
}

static void bring_one(void *user, size_t i)
{
    const struct bringing *b = user;
    struct named *n = &b->named[i];
    n->ref = glint_assets_find(b->keep->assets, n->name);
    if (!n->ref)
        map_one(b->keep, n);
}

// The first fault, but for a lack of the file.
static glint_status judge(const struct bringing *b, struct glint_error *err)
{
    for (size_t i = 0; i < b->count; i++) {
        const struct glint_error *fault = &b->named[i].fault;
        if (fault->status && fault->status != GLINT_E_NOT_FOUND)
            return glint_fail(err, fault->status, "", "%s", glint_error_text(fault));
    }
    return GLINT_OK;
}

static void let_go(struct bringing *b)
{
    for (size_t i = 0; i < b->count; i++) {
        glint_asset_ref_release(&b->named[i].ref);
        glint_error_finish(&b->named[i].fault);
    }
    free(b->named);
}

glint_status glint_keep_gather(glint_keep *k, const char *text, size_t length,
                               struct glint_asset_set *out, struct glint_error *err)
{
    struct bringing b = {.keep = k};
    glint_status st = list_names(&b, text, length, err);
    if (!st) {
        glint_thread_each("assets", b.count, bring_one, &b);
        st = judge(&b, err);
    }
    if (!st)
        st = glint_assets_gather(k->assets, text, length, out, err);
    let_go(&b);
    return st;
}
