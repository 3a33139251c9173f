// foresee.c - variants that are compiled before anybody asks for them.
#include "device/internal.h"
#include "device/listing.h"
#include "device/program.h"

#include <stdlib.h>
#include <string.h>

#define MONTH (30.0 * 86400.0)
#define MOST_KNOWN 64

// Listings, while the folder is read: what is compiled changes it.
struct known {
    char key[65];
    char *options;
    double unused; // seconds
};

struct all_known {
    size_t count;
    struct known known[MOST_KNOWN];
    const char *cache;
};

bool glint_program_foresee(glint_devices *devices, const char *options)
{
    char key[65];
    return !devices->ahead || !glint_program_key_of(key, devices, devices->source, options) ||
           glint_ahead_idle(devices->ahead, key, options);
}

static bool note(void *user, const char *key, const char *options, double unused)
{
    struct all_known *all = user;
    if (unused > MONTH) {
        glint_listing_remove(all->cache, key);
        return true;
    }
    struct known *k = &all->known[all->count];
    k->options = strdup(options);
    memcpy(k->key, key, sizeof k->key);
    k->unused = unused;
    all->count += k->options != NULL;
    return all->count < MOST_KNOWN;
}

// What it is compiled to by this release takes the place of what it was.
static bool renew(glint_devices *devices, const char *cache, const struct known *k)
{
    if (!glint_program_foresee(devices, k->options))
        return false;
    glint_listing_remove(cache, k->key);
    return true;
}

// NULL where there is nothing or no memory.
static struct all_known *read_known(glint_devices *devices)
{
    struct all_known *all = devices->ahead ? calloc(1, sizeof *all) : NULL;
    if (all) {
        all->cache = glint_ahead_cache(devices->ahead);
        glint_listing_sweep(all->cache);
        glint_listing_each(all->cache, note, all);
    }
    return all;
}

static void forget(struct all_known *all)
{
    for (size_t i = 0; i < all->count; i++)
        free(all->known[i].options);
    free(all);
}

static bool is_ours(const glint_devices *devices, const struct known *k)
{
    char key[65];
    return glint_program_key_of(key, devices, devices->source, k->options) && !strcmp(key, k->key);
}

bool glint_program_recall(glint_devices *devices)
{
    glint_program *program = NULL;
    const struct known *newest = NULL;
    struct all_known *all = read_known(devices);
    for (size_t i = 0; all && i < all->count; i++)
        if (is_ours(devices, &all->known[i]) && (!newest || all->known[i].unused < newest->unused))
            newest = &all->known[i];
    const bool found = newest && !glint_program_get(&program, devices, newest->options, NULL);
    glint_program_release(&program);
    if (all)
        forget(all);
    return found;
}

bool glint_program_foresee_known(glint_devices *devices)
{
    struct all_known *all = read_known(devices);
    bool more = true;
    for (size_t i = 0; all && more && i < all->count; i++)
        more = is_ours(devices, &all->known[i]) || renew(devices, all->cache, &all->known[i]);
    if (all)
        forget(all);
    return more;
}

void glint_devices_hurry(glint_devices *devices)
{
    if (devices->ahead)
        glint_ahead_hurry(devices->ahead);
}
