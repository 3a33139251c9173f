// assets.h - bytes that scenes name by the SHA-256 of their content, held in memory once.
//
// An asset lives while somebody refers to it: revisions do. What a client put here by itself is
// held by the store too, because the scene that names it comes later; the limit is on that. When
// the room is needed, those of them that nobody else refers to go, the least recently put or asked
// for first, but none that was within the last GLINT_ASSET_GRACE_SECONDS. A process may have 65,530
// mappings: a small asset lies in the heap, of large ones only so many are held for clients.
//
// Imports add their assets where they lie, in the mapping of the child's answer: the memory is
// counted, and goes with the last asset in it.
//
// Threads: any; one mutex, held for look-ups only. A reference belongs to whoever retained it.
#ifndef GLINT_SCENE_ASSETS_H
#define GLINT_SCENE_ASSETS_H

#include "protocol/scene.h"

#define GLINT_ASSET_GRACE_SECONDS 300.0
#define GLINT_LARGE_ASSET_BYTES ((size_t)128 << 10) // from here on it stays in its own mapping
#define GLINT_MOST_LARGE_ASSETS 32768u              // held for clients

typedef struct glint_assets glint_assets;         // the store
typedef struct glint_asset_ref glint_asset_ref;   // one asset of it, counted
typedef struct glint_memory_ref glint_memory_ref; // memory that assets lie in, counted

// limit_bytes: of what clients put, used by scenes or not.
glint_status glint_assets_create(glint_assets **out, uint64_t limit_bytes, struct glint_error *err);
void glint_assets_destroy(glint_assets **assets); // no reference may be left

// ---- memory

// Counted from 1. `release` is called with the two when nobody refers to it any more. NULL without
// memory: nothing was taken.
glint_memory_ref *glint_memory_ref_create(void *base, size_t bytes,
                                          void (*release)(void *base, size_t bytes));
glint_memory_ref *glint_memory_ref_of_block(void *block, size_t bytes); // the same of malloc's

// The same of a mapping, *base with `bytes` > 0, which it takes over: what is small moves into the
// heap, and *base with it. NULL without memory, the mapping gone.
glint_memory_ref *glint_memory_ref_of_mapping(const uint8_t **base, size_t bytes);
glint_memory_ref *glint_memory_ref_retain(glint_memory_ref *memory);
void glint_memory_ref_release(glint_memory_ref **memory);

// ---- one asset

// Adds the asset, which lies in `memory`, or finds the one of the same name; *out is retained.
// The name must be that of the bytes. GLINT_E_NOMEM.
glint_status glint_assets_add(glint_assets *assets, const struct glint_asset *asset,
                              glint_memory_ref *memory, glint_asset_ref **out,
                              struct glint_error *err);

// The same for what a client sent, which is then held for it; *created: it was not held before.
//   GLINT_E_CAPACITY  a limit is reached, with figures
glint_status glint_assets_put(glint_assets *assets, const struct glint_asset *asset,
                              glint_memory_ref *memory, bool *created, struct glint_error *err);

// Undoes a put that found nothing held: the client is told that it was not kept.
void glint_assets_unput(glint_assets *assets, const char *sha256);

// Called with the name of every asset that has gone, without a lock. To be set before any is there;
// NULL: none.
void glint_assets_on_gone(glint_assets *assets, void (*gone)(void *user, const char *sha256),
                          void *user);
bool glint_assets_has(glint_assets *assets, const char *sha256); // which is well formed

// Retained, or NULL where there is none of this name.
glint_asset_ref *glint_assets_find(glint_assets *assets, const char *sha256);
glint_asset_ref *glint_asset_ref_retain(glint_asset_ref *ref);
void glint_asset_ref_release(glint_asset_ref **ref);
const struct glint_asset *glint_asset_ref_bytes(const glint_asset_ref *ref); // borrowed

// ---- the assets of a scene

struct glint_asset_set {
    struct glint_asset *asset; // [count] as glint_scene_parse() takes them
    glint_asset_ref **ref;     // [count]
    size_t count;
};

// Every asset here that the native text names: that 64 lower-case hex digits between quotes are the
// name of. A name that nothing has is left to the parser to refuse. The caller releases *out.
// GLINT_E_NOMEM.
glint_status glint_assets_gather(glint_assets *assets, const char *text, size_t length,
                                 struct glint_asset_set *out, struct glint_error *err);
void glint_asset_set_release(struct glint_asset_set *set); // and zeroes it

// The next 64 lower-case hex digits between quotes from *at on, or NULL; *at moves behind them.
const char *glint_assets_next_name(const char *text, size_t length, size_t *at);

struct glint_assets_stats {
    uint64_t count, bytes;           // of all
    uint64_t put_count, put_bytes;   // held for clients
    uint64_t idle_count, idle_bytes; // of these, what no scene uses
    uint64_t limit_bytes;
};
void glint_assets_stats(glint_assets *assets, struct glint_assets_stats *out);

#endif
