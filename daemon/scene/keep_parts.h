// keep_parts.h - the inside of the keep, shared by the files that keep, bring and collect.
#ifndef GLINT_SCENE_KEEP_PARTS_H
#define GLINT_SCENE_KEEP_PARTS_H

#include "scene/keep.h"

#include <pthread.h>
#include <stdbool.h>

// A revision in memory.
struct glint_held {
    char id[65];
    uint32_t count, depth;
};

struct glint_keep {
    glint_keeper *keeper;
    glint_journal *journal;
    glint_vault *vault;
    glint_assets *assets;
    pthread_t thread;
    bool started;

    pthread_mutex_t mutex; // guards what follows; a leaf
    pthread_cond_t changed;
    struct glint_held *held; // [helds]
    size_t helds, held_capacity;
    char (*pinned)[65]; // [pins] assets of what is needed but not in memory
    size_t pins;
    char (*gone)[65]; // [gones] assets that left the memory
    size_t gones;
    bool collects; // false: something is needed that is not known
    bool began;    // collecting
    bool dirty;    // something may have become unneeded
    bool sweep;    // look at every file
    bool stop;
};

// With the mutex.
struct glint_held *glint_keep_find(const glint_keep *keep, const char *id);

// Every asset that the text names, mapped where it is not in memory. One without a file is left to the
// parser to refuse. The caller releases *out.
glint_status glint_keep_gather(glint_keep *keep, const char *text, size_t length,
                               struct glint_asset_set *out, struct glint_error *err);

#endif
