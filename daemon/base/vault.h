// vault.h - files named by the SHA-256 of their content: FOLDER/ab/<64 hex digits>.
//
// A file is written beside its place, synced, renamed and its folder synced: under its name it is
// whole or not there. What is read back is checked against its name.
//
// Files are removed only through glint_vault_sweep, which asks whether they are needed. Who puts one
// makes sure first that the answer will be yes: then nobody takes away what another relies on.
//
// Threads: any that may wait for a disk; create and destroy by one.
#ifndef GLINT_BASE_VAULT_H
#define GLINT_BASE_VAULT_H

#include "protocol/status.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct glint_vault glint_vault;

struct glint_content {
    char name[65]; // the SHA-256 of the bytes, which is not checked again
    const void *bytes;
    size_t size;
};

// Makes FOLDER where it is missing and removes what was not finished there.
glint_status glint_vault_create(glint_vault **out, const char *folder, struct glint_error *err);
void glint_vault_destroy(glint_vault **vault);

// When it returns GLINT_OK all blobs are on the disk. Those that are there already cost nothing.
// After a failure nothing half written is left.
//   GLINT_E_CAPACITY  they do not fit, with figures
glint_status glint_vault_put(glint_vault *vault, const struct glint_content *blob, size_t count,
                             struct glint_error *err);

// Maps a file that munmap() frees; it lives as long as the mapping, whatever becomes of its name.
//   GLINT_E_NOT_FOUND  there is none of this name
//   GLINT_E_IO         its content is not what its name says; it is kept aside as NAME.torn
glint_status glint_vault_map(glint_vault *vault, const char *name, const uint8_t **bytes,
                             size_t *size, struct glint_error *err);

// Removes every file that is not needed. name: one alone; NULL: all. `needed` may be called for any
// name, under a lock of the vault: it must not put. False: somebody is putting, nothing was done.
bool glint_vault_sweep(glint_vault *vault, const char *name,
                       bool (*needed)(void *user, const char *name), void *user);

uint64_t glint_vault_bytes(const glint_vault *vault);

#endif
