#include "scene/assets.h"

#include "base/clock.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#define BUCKETS 16384u // power of two
#define NAME_DIGITS 64u

struct glint_memory_ref {
    atomic_uint references;
    void *base;
    size_t bytes;
    void (*release)(void *base, size_t bytes);
};

struct glint_asset_ref {
    glint_assets *store;
    glint_asset_ref *next; // of the bucket
    struct glint_asset asset;
    glint_memory_ref *memory;
    uint32_t references; // the store's own included
    bool held;           // by the store, for the client that put it
    double used;         // put or asked for last
};

struct glint_assets {
    uint64_t limit_bytes;
    pthread_mutex_t mutex; // guards everything below and every asset's counts
    glint_asset_ref *bucket[BUCKETS];
    uint64_t count, bytes;
    uint64_t put_count, put_bytes, put_large;

    void (*gone)(void *user, const char *sha256);
    void *user;
};

glint_status glint_assets_create(glint_assets **out, uint64_t limit_bytes, struct glint_error *err)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the asset store");
    (*out)->limit_bytes = limit_bytes;
    pthread_mutex_init(&(*out)->mutex, NULL);
    return GLINT_OK;
}

// ---- memory

glint_memory_ref *glint_memory_ref_create(void *base, size_t bytes,
                                          void (*release)(void *base, size_t bytes))
{
    glint_memory_ref *m = malloc(sizeof *m);
    if (!m)
        return NULL;
    *m = (glint_memory_ref){.base = base, .bytes = bytes, .release = release};
    atomic_init(&m->references, 1);
    return m;
}

static void unmap(void *base, size_t bytes)
{
    munmap(base, bytes);
}

static void free_block(void *base, size_t bytes)
{
    (void)bytes;
    free(base);
}

glint_memory_ref *glint_memory_ref_of_block(void *block, size_t bytes)
{
    return glint_memory_ref_create(block, bytes, free_block);
}

glint_memory_ref *glint_memory_ref_of_mapping(const uint8_t **base, size_t bytes)
{
    void *mapping = (void *)*base, *block = mapping;
    if (bytes < GLINT_LARGE_ASSET_BYTES) {
        block = malloc(bytes);
        if (block)
            memcpy(block, mapping, bytes);
        munmap(mapping, bytes);
    }
    void (*release)(void *, size_t) = block == mapping ? unmap : free_block;
    glint_memory_ref *m = block ? glint_memory_ref_create(block, bytes, release) : NULL;
    if (!m && block)
        release(block, bytes);
    *base = m ? block : NULL;
    return m;
}

glint_memory_ref *glint_memory_ref_retain(glint_memory_ref *memory)
{
    // Relaxed: who retains holds a reference already.
    atomic_fetch_add_explicit(&memory->references, 1, memory_order_relaxed);
    return memory;
}

void glint_memory_ref_release(glint_memory_ref **memory)
{
    glint_memory_ref *m = *memory;
    *memory = NULL;
    // Acquire and release: the last to leave sees what the others did before they left.
    if (!m || atomic_fetch_sub_explicit(&m->references, 1, memory_order_acq_rel) != 1)
        return;
    m->release(m->base, m->bytes);
    free(m);
}

// ---- the table, with the mutex

// The name begins with digits that are as good as random.
static uint32_t bucket_of(const char *sha256)
{
    uint32_t index = 0;
    for (int i = 0; i < 4; i++)
        index = index << 4 | (uint32_t)(sha256[i] <= '9' ? sha256[i] - '0' : sha256[i] - 'a' + 10);
    return index & (BUCKETS - 1);
}

static glint_asset_ref *find(const glint_assets *s, const char *sha256)
{
    glint_asset_ref *ref = s->bucket[bucket_of(sha256)];
    while (ref && memcmp(ref->asset.sha256, sha256, NAME_DIGITS) != 0)
        ref = ref->next;
    return ref;
}

static glint_asset_ref *insert(glint_assets *s, const struct glint_asset *asset,
                               glint_memory_ref *memory)
{
    glint_asset_ref *ref = malloc(sizeof *ref);
    if (!ref)
        return NULL;
    glint_asset_ref **at = &s->bucket[bucket_of(asset->sha256)];
    *ref = (glint_asset_ref){.store = s, .next = *at, .asset = *asset};
    ref->memory = glint_memory_ref_retain(memory);
    *at = ref;
    s->count++;
    s->bytes += asset->size;
    return ref;
}

// Takes an asset that nobody refers to out of the table; *gone, a list, is freed without the mutex.
static void cut(glint_assets *s, glint_asset_ref *ref, glint_asset_ref **gone)
{
    glint_asset_ref **at = &s->bucket[bucket_of(ref->asset.sha256)];
    while (*at != ref)
        at = &(*at)->next;
    *at = ref->next;
    s->count--;
    s->bytes -= ref->asset.size;
    ref->next = *gone;
    *gone = ref;
}

static bool is_large(const struct glint_asset *asset)
{
    return asset->size >= GLINT_LARGE_ASSET_BYTES;
}

static void let_go(glint_assets *s, const struct glint_asset *asset)
{
    s->put_count--;
    s->put_bytes -= asset->size;
    s->put_large -= is_large(asset);
}

// The store lets go of an asset that only it refers to.
static void drop(glint_assets *s, glint_asset_ref *ref, glint_asset_ref **gone)
{
    let_go(s, &ref->asset);
    cut(s, ref, gone);
}

static void free_list(glint_asset_ref *gone)
{
    while (gone) {
        glint_asset_ref *next = gone->next;
        glint_assets *s = gone->store;
        if (s->gone)
            s->gone(s->user, gone->asset.sha256);
        glint_memory_ref_release(&gone->memory);
        free(gone);
        gone = next;
    }
}

void glint_assets_destroy(glint_assets **assets)
{
    glint_assets *s = *assets;
    *assets = NULL;
    if (!s)
        return;
    s->gone = NULL;
    for (uint32_t i = 0; i < BUCKETS; i++)
        free_list(s->bucket[i]);
    pthread_mutex_destroy(&s->mutex);
    free(s);
}

// ---- room for what clients put

// The held asset that nobody uses and that was looked at longest ago, before `latest`; NULL: none.
static glint_asset_ref *most_idle(const glint_assets *s, double latest, bool large)
{
    glint_asset_ref *oldest = NULL;
    for (uint32_t i = 0; i < BUCKETS; i++)
        for (glint_asset_ref *ref = s->bucket[i]; ref; ref = ref->next)
            if (ref->held && ref->references == 1 && ref->used < latest &&
                (!large || is_large(&ref->asset)) && (!oldest || ref->used < oldest->used))
                oldest = ref;
    return oldest;
}

static bool is_crowded(const glint_assets *s, const struct glint_asset *asset)
{
    return is_large(asset) && s->put_large >= GLINT_MOST_LARGE_ASSETS;
}

static bool make_room(glint_assets *s, const struct glint_asset *asset, double now,
                      glint_asset_ref **gone)
{
    if (asset->size > s->limit_bytes)
        return false;
    while (is_crowded(s, asset) || s->put_bytes > s->limit_bytes - asset->size) {
        glint_asset_ref *idle = most_idle(s, now - GLINT_ASSET_GRACE_SECONDS, is_crowded(s, asset));
        if (!idle)
            return false;
        drop(s, idle, gone);
    }
    return true;
}

static uint64_t idle_bytes(const glint_assets *s, uint64_t *count)
{
    uint64_t bytes = 0;
    *count = 0;
    for (uint32_t i = 0; i < BUCKETS; i++)
        for (const glint_asset_ref *ref = s->bucket[i]; ref; ref = ref->next)
            if (ref->held && ref->references == 1) {
                bytes += ref->asset.size;
                ++*count;
            }
    return bytes;
}

static glint_status refuse(const glint_assets *s, const struct glint_asset *asset,
                           struct glint_error *err)
{
    if (is_crowded(s, asset))
        return glint_fail(err, GLINT_E_CAPACITY, "",
                          "of assets of %zu bytes and more %u are held, as many as there may be; "
                          "what no scene uses may go %.0f s after it was put or asked for",
                          GLINT_LARGE_ASSET_BYTES, GLINT_MOST_LARGE_ASSETS,
                          GLINT_ASSET_GRACE_SECONDS);
    uint64_t count;
    const uint64_t idle = idle_bytes(s, &count);
    return glint_fail(
        err, GLINT_E_CAPACITY, "",
        "%llu bytes do not fit: %llu assets hold %llu of %llu bytes; scenes use all but %llu bytes "
        "of them, which may go %.0f s after they were put or asked for",
        (unsigned long long)asset->size, (unsigned long long)s->put_count,
        (unsigned long long)s->put_bytes, (unsigned long long)s->limit_bytes,
        (unsigned long long)idle, GLINT_ASSET_GRACE_SECONDS);
}

// ---- one asset

glint_status glint_assets_add(glint_assets *s, const struct glint_asset *asset,
                              glint_memory_ref *memory, glint_asset_ref **out,
                              struct glint_error *err)
{
    pthread_mutex_lock(&s->mutex);
    glint_asset_ref *ref = find(s, asset->sha256);
    if (!ref)
        ref = insert(s, asset, memory);
    if (ref)
        ref->references++;
    pthread_mutex_unlock(&s->mutex);
    *out = ref;
    return ref ? GLINT_OK : glint_fail(err, GLINT_E_NOMEM, "", "no memory for an asset");
}

// With the mutex.
static glint_status hold(glint_assets *s, const struct glint_asset *asset, glint_memory_ref *memory,
                         glint_asset_ref **gone, struct glint_error *err)
{
    const double now = glint_now();
    if (!make_room(s, asset, now, gone))
        return refuse(s, asset, err);
    glint_asset_ref *ref = find(s, asset->sha256);
    if (!ref)
        ref = insert(s, asset, memory);
    if (!ref)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for an asset");
    ref->held = true;
    ref->references++;
    ref->used = now;
    s->put_count++;
    s->put_bytes += asset->size;
    s->put_large += is_large(asset);
    return GLINT_OK;
}

glint_status glint_assets_put(glint_assets *s, const struct glint_asset *asset,
                              glint_memory_ref *memory, bool *created, struct glint_error *err)
{
    glint_asset_ref *gone = NULL;
    glint_status st = GLINT_OK;
    pthread_mutex_lock(&s->mutex);
    glint_asset_ref *known = find(s, asset->sha256);
    *created = !known || !known->held;
    if (*created)
        st = hold(s, asset, memory, &gone, err);
    else
        known->used = glint_now();
    pthread_mutex_unlock(&s->mutex);
    free_list(gone);
    return st;
}

void glint_assets_unput(glint_assets *s, const char *sha256)
{
    pthread_mutex_lock(&s->mutex);
    glint_asset_ref *gone = NULL, *ref = find(s, sha256);
    if (ref && ref->held) {
        ref->held = false;
        let_go(s, &ref->asset);
        if (--ref->references == 0)
            cut(s, ref, &gone);
    }
    pthread_mutex_unlock(&s->mutex);
    free_list(gone);
}

void glint_assets_on_gone(glint_assets *s, void (*gone)(void *user, const char *sha256), void *user)
{
    s->gone = gone;
    s->user = user;
}

bool glint_assets_has(glint_assets *s, const char *sha256)
{
    pthread_mutex_lock(&s->mutex);
    const bool found = find(s, sha256) != NULL;
    pthread_mutex_unlock(&s->mutex);
    return found;
}

glint_asset_ref *glint_assets_find(glint_assets *s, const char *sha256)
{
    if (strspn(sha256, "0123456789abcdef") < NAME_DIGITS)
        return NULL;
    pthread_mutex_lock(&s->mutex);
    glint_asset_ref *ref = find(s, sha256);
    if (ref) {
        ref->references++;
        ref->used = glint_now();
    }
    pthread_mutex_unlock(&s->mutex);
    return ref;
}

glint_asset_ref *glint_asset_ref_retain(glint_asset_ref *ref)
{
    pthread_mutex_lock(&ref->store->mutex);
    ref->references++;
    pthread_mutex_unlock(&ref->store->mutex);
    return ref;
}

void glint_asset_ref_release(glint_asset_ref **ref)
{
    glint_asset_ref *r = *ref, *gone = NULL;
    *ref = NULL;
    if (!r)
        return;
    glint_assets *s = r->store;
    pthread_mutex_lock(&s->mutex);
    if (--r->references == 0)
        cut(s, r, &gone);
    pthread_mutex_unlock(&s->mutex);
    free_list(gone);
}

const struct glint_asset *glint_asset_ref_bytes(const glint_asset_ref *ref)
{
    return &ref->asset;
}

void glint_assets_stats(glint_assets *s, struct glint_assets_stats *out)
{
    pthread_mutex_lock(&s->mutex);
    *out = (struct glint_assets_stats){.count = s->count,
                                       .bytes = s->bytes,
                                       .put_count = s->put_count,
                                       .put_bytes = s->put_bytes,
                                       .limit_bytes = s->limit_bytes};
    out->idle_bytes = idle_bytes(s, &out->idle_count);
    pthread_mutex_unlock(&s->mutex);
}
