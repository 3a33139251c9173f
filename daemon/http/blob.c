#include "http/blob.h"

#include <assert.h>
#include <openssl/evp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

struct glint_blob *glint_blob_take(uint8_t *bytes, size_t size)
{
    struct glint_blob *b = calloc(1, sizeof *b);
    if (!b) {
        free(bytes);
        return NULL;
    }
    atomic_init(&b->references, 1);
    b->bytes = bytes;
    b->size = size;
    return b;
}

// NULL in, NULL out; where it fails the blob is released.
static struct glint_blob *digest(struct glint_blob *b)
{
    unsigned char sum[EVP_MAX_MD_SIZE], base64[45]; // of 32 bytes, and a terminator
    unsigned length = 0;
    if (!b || !EVP_Digest(b->bytes, b->size, sum, &length, EVP_sha256(), NULL)) {
        glint_blob_release(&b);
        return NULL;
    }
    assert(length == 32);
    EVP_EncodeBlock(base64, sum, (int)length);
    snprintf(b->digest, sizeof b->digest, "sha-256=:%s:", (char *)base64);
    b->etag[0] = '"';
    for (unsigned i = 0; i < length; i++)
        snprintf(b->etag + 1 + 2 * i, 3, "%02x", sum[i]);
    strcpy(b->etag + 65, "\"");
    return b;
}

struct glint_blob *glint_blob_digest(uint8_t *bytes, size_t size)
{
    return digest(glint_blob_take(bytes, size));
}

struct glint_blob *glint_blob_map(int fd, size_t size, bool digested, void (*gone)(void))
{
    void *bytes = mmap(NULL, size, PROT_READ, MAP_SHARED, fd, 0);
    struct glint_blob *b = bytes == MAP_FAILED ? NULL : glint_blob_take(NULL, size);
    if (!b) {
        if (bytes != MAP_FAILED)
            munmap(bytes, size);
        gone();
        return NULL;
    }
    b->bytes = bytes;
    b->gone = gone;
    return digested ? digest(b) : b;
}

struct glint_blob *glint_blob_retain(struct glint_blob *blob)
{
    // Relaxed: who retains already holds a reference.
    atomic_fetch_add_explicit(&blob->references, 1, memory_order_relaxed);
    return blob;
}

void glint_blob_release(struct glint_blob **blob)
{
    struct glint_blob *b = *blob;
    *blob = NULL;
    // Acquire-release: the last one to leave sees what the others did with the bytes.
    if (!b || atomic_fetch_sub_explicit(&b->references, 1, memory_order_acq_rel) > 1)
        return;
    if (b->gone) {
        munmap(b->bytes, b->size);
        b->gone();
    } else {
        free(b->bytes);
    }
    free(b);
}
