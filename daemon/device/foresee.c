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
    all->count += k->options != NULL;
    return all->count < MOST_KNOWN;
}

// What it is compiled to by this release takes the place of what it was.
static bool renew(glint_devices *devices, const char *cache, const struct known *k)
{
    char key[65];
    if (!glint_program_key_of(key, devices, devices->source, k->options) || !strcmp(key, k->key))
        return true;
    if (!glint_ahead_idle(devices->ahead, key, k->options))
        return false;
    glint_listing_remove(cache, k->key);
    return true;
}

bool glint_program_foresee_known(glint_devices *devices)
{
    if (!devices->ahead)
        return true;
    struct all_known *all = calloc(1, sizeof *all);
    bool more = all != NULL;
    if (!all)
        return false;
    all->cache = glint_ahead_cache(devices->ahead);
    glint_listing_each(all->cache, note, all);
    for (size_t i = 0; i < all->count; i++) {
        more = more && renew(devices, all->cache, &all->known[i]);
        free(all->known[i].options);
    }
    free(all);
    return more;
}

void glint_devices_hurry(glint_devices *devices)
{
    if (devices->ahead)
        glint_ahead_hurry(devices->ahead);
}
