// listing.h - the files that make up one compiled variant, so that a torn one is found before use.
// Private to device/.
//
// A listing is "<cache>/glint-<key>": the options on the first line, then for each file its SHA-256
// and its path in the cache.
//
// Thread-safety: reentrant; processes may share a cache, each listing appears whole.
#ifndef GLINT_DEVICE_LISTING_H
#define GLINT_DEVICE_LISTING_H

#include <stdbool.h>

// Whether all of it is there, byte by byte. Where not, what is left of it is removed.
bool glint_listing_holds(const char *cache, const char *key);

// Moves what is below `made`, a folder of the same file system, into the cache, over what is there,
// and lists it. False: it could not be written; nothing is listed.
bool glint_listing_take(const char *cache, const char *key, const char *options,
                        const char *const *made, int count);

// Removes a folder and all in it.
void glint_folder_remove(const char *path);

#endif
