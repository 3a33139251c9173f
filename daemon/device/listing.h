// listing.h - the files that make up one compiled variant, so that a torn one is found before use.
// Private to device/.
//
// A listing is "<cache>/glint-<key>": the options on the first line, then for each file its SHA-256
// and its path in the cache. The program's bitcode is listed a second time, by way of the link to
// its folder (bitcode.h), where there is one.
//
// Thread-safety: reentrant; processes may share a cache, each listing appears whole.
#ifndef GLINT_DEVICE_LISTING_H
#define GLINT_DEVICE_LISTING_H

#include <stdbool.h>
#include <stddef.h>

// Whether all of it is there, byte by byte: then it counts as used now. Where not, what is left of it
// is removed.
bool glint_listing_holds(const char *cache, const char *key);
void glint_listing_remove(const char *cache, const char *key);

// The path of the program's bitcode, if it is known by that too. Of what the cache holds.
bool glint_listing_bitcode(const char *cache, const char *key, char *path, size_t capacity);

// Calls for each listing of the cache, until the answer is false. unused: seconds since its last
// use.
typedef bool glint_listing_fn(void *user, const char *key, const char *options, double unused);
void glint_listing_each(const char *cache, glint_listing_fn *call, void *user);

// Moves what is below the folders of `made`, of the same file system, into the cache, over what is
// there, and lists it. At most one of them has a link. False: it could not be written; nothing is
// listed.
bool glint_listing_take(const char *cache, const char *key, const char *options,
                        const char *const *made, int count);

// Removes what processes that were ended left lying in the cache more than a day ago.
void glint_listing_sweep(const char *cache);

// Removes a folder and all in it.
void glint_folder_remove(const char *path);

#endif
