// buffer.c - memory that kernels, Embree and the host read and write in place.
//
// Plain pages, passed as SVM pointers. A cl_mem for each would be locked by every launch that
// names it (measured, 12 arguments, two workers: 10 us a launch instead of 5).
#include "device/internal.h"

#include <assert.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#define MAX_BYTES ((size_t)1 << 30)

// Embree loads vertices 16 bytes at a time, past the end of the last.
#define SLACK_BYTES 64

// From here on large pages: records are read all over the place, and the columns of a wave lie in a
// second-level cache without conflicts.
#define LARGE_BYTES ((size_t)1 << 20)
#define LARGE_PAGE ((size_t)2 << 20)

static size_t rounded(size_t bytes, size_t page)
{
    return (bytes + page - 1) / page * page;
}

static void *map(size_t bytes)
{
    return mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
}

// Whole large pages: what lies before the first and after the last goes back.
static void *map_large(size_t bytes)
{
    char *all = map(bytes + LARGE_PAGE);
    if (all == MAP_FAILED)
        return all;
    const size_t before = rounded((uintptr_t)all, LARGE_PAGE) - (uintptr_t)all;
    if (before > 0)
        munmap(all, before);
    if (before < LARGE_PAGE)
        munmap(all + before + bytes, LARGE_PAGE - before);
    madvise(all + before, bytes, MADV_HUGEPAGE); // a wish: it works without
    return all + before;
}

glint_status glint_buffer_create(glint_buffer **out, glint_devices *devices, size_t bytes,
                                 struct glint_error *err)
{
    (void)devices;
    assert(out && devices);
    *out = NULL;
    if (bytes > MAX_BYTES)
        return glint_fail(err, GLINT_E_CAPACITY, "",
                          "a buffer of %zu bytes is over the limit of %zu", bytes, MAX_BYTES);
    glint_buffer *b = calloc(1, sizeof *b);
    if (!b)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a buffer");
    const bool large = bytes >= LARGE_BYTES;
    b->bytes = bytes;
    b->mapped = rounded(bytes + SLACK_BYTES, large ? LARGE_PAGE : (size_t)sysconf(_SC_PAGESIZE));
    b->host = large ? map_large(b->mapped) : map(b->mapped);
    if (b->host == MAP_FAILED) {
        free(b);
        return glint_fail(err, GLINT_E_CAPACITY, "", "no memory for a buffer of %zu bytes", bytes);
    }
    atomic_init(&b->references, 1);
    *out = b;
    return GLINT_OK;
}

glint_buffer *glint_buffer_retain(glint_buffer *buffer)
{
    // Relaxed: who retains holds a reference already.
    atomic_fetch_add_explicit(&buffer->references, 1, memory_order_relaxed);
    return buffer;
}

void glint_buffer_destroy(glint_buffer **buffer)
{
    glint_buffer *b = *buffer;
    if (!b)
        return;
    *buffer = NULL;
    // Acquire-release: the last holder sees all that the others did before it frees.
    if (atomic_fetch_sub_explicit(&b->references, 1, memory_order_acq_rel) != 1)
        return;
    munmap(b->host, b->mapped);
    free(b);
}

void *glint_buffer_host(glint_buffer *buffer)
{
    return buffer->host;
}

size_t glint_buffer_bytes(const glint_buffer *buffer)
{
    return buffer->bytes;
}
