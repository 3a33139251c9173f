// blob.h - immutable bytes with a count of references and, where asked, their digest: what an
// answer sends and the cache of finished frames keeps.
//
// Thread-safety: any thread.
#ifndef GLINT_HTTP_BLOB_H
#define GLINT_HTTP_BLOB_H

#include "protocol/status.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

struct glint_blob {
    atomic_uint references;
    uint8_t *bytes; // owned
    size_t size;
    void (*gone)(void); // NULL: the bytes are malloc'd; else mapped, and it is called without them
    char etag[67];      // 64 hex digits of the SHA-256 in quotes; "" without a digest
    char digest[64];    // "sha-256=:BASE64:"; "" without a digest
};

// Takes `bytes` (malloc'd) always, also when it fails. NULL without memory.
struct glint_blob *glint_blob_take(uint8_t *bytes, size_t size);

// As above with ETag and digest.
struct glint_blob *glint_blob_digest(uint8_t *bytes, size_t size);

// Maps the file, which is then the blob's; `digest` as above. gone() is called when it is released,
// and at once when this fails.
struct glint_blob *glint_blob_map(int fd, size_t size, bool digest, void (*gone)(void));

struct glint_blob *glint_blob_retain(struct glint_blob *blob);
void glint_blob_release(struct glint_blob **blob); // stores NULL

#endif
