// storage.h - files that are there whole or not at all, and what a disk says when it has no more.
//
// Thread-safety: reentrant.
#ifndef GLINT_BASE_STORAGE_H
#define GLINT_BASE_STORAGE_H

#include "protocol/status.h"

#include <stdbool.h>
#include <stdint.h>

// Whether errno says that nothing can be written now, as another day it may.
bool glint_storage_lacks(int why);

// GLINT_E_CAPACITY: nothing can be kept in the folder, with how much is free there.
glint_status glint_storage_full(struct glint_error *err, const char *folder, const char *what);

// The fault of a call that set errno `why`: GLINT_E_CAPACITY as above, or GLINT_E_IO.
glint_status glint_storage_fault(struct glint_error *err, const char *folder, const char *what,
                                 int why);

// Bytes that may still be written in the folder, 0: not known.
uint64_t glint_storage_free(const char *folder);

bool glint_storage_sync_folder(const char *path); // false with errno

// Bytes of FOLDER/NAME, 0: it is not there.
uint64_t glint_storage_bytes(const char *folder, const char *name);

#endif
