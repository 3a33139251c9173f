#include "base/memory.h"

#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define GROUP_BYTES 512

// The number in a file below /sys/fs/cgroup, UINT64_MAX where there is none ("max").
static uint64_t read_limit(const char *mount, const char *group, const char *file)
{
    char path[GROUP_BYTES + 64];
    unsigned long long limit;
    snprintf(path, sizeof path, "/sys/fs/cgroup%s%s/%s", mount, group, file);
    FILE *f = fopen(path, "re");
    const int found = f ? fscanf(f, "%llu", &limit) : 0;
    if (f)
        fclose(f);
    return found == 1 ? limit : UINT64_MAX;
}

// A container sees its own group as the root of the mount, whatever the kernel calls it.
static uint64_t limit_of(const char *mount, const char *group, const char *file)
{
    const uint64_t named = read_limit(mount, group, file), root = read_limit(mount, "", file);
    return named < root ? named : root;
}

// line: "0::/group" (version 2) or "4:memory:/group" (version 1) of /proc/self/cgroup.
static uint64_t limit_in(char *line)
{
    char *group = strchr(line, '/');
    if (!group)
        return UINT64_MAX;
    group[strcspn(group, "\n")] = '\0';
    if (!strncmp(line, "0::", 3))
        return limit_of("", group, "memory.max");
    return strstr(line, ":memory:") ? limit_of("/memory", group, "memory.limit_in_bytes")
                                    : UINT64_MAX;
}

uint64_t glint_memory_total(void)
{
    const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    uint64_t total = (uint64_t)(pages > 0 ? pages : 1) * (uint64_t)page;
    FILE *f = fopen("/proc/self/cgroup", "re");
    char line[GROUP_BYTES];
    while (f && fgets(line, sizeof line, f)) {
        const uint64_t limit = limit_in(line);
        total = limit < total ? limit : total;
    }
    if (f)
        fclose(f);
    return total;
}

uint64_t glint_memory_resident(void)
{
    unsigned long long pages = 0;
    FILE *f = fopen("/proc/self/statm", "re");
    const int found = f ? fscanf(f, "%*u %llu", &pages) : 0;
    if (f)
        fclose(f);
    return found == 1 ? pages * (uint64_t)sysconf(_SC_PAGESIZE) : 0;
}

// Where the C library arrives by itself once a large block has been freed: smaller blocks are the
// heap's, of whose end so much is kept.
#define MAPPED_BYTES ((size_t)32 << 20)
#define KEPT_BYTES (2 * MAPPED_BYTES)
#define MOST_EXPECTED ((uint64_t)1 << 30)
#define LARGE_PAGE ((uintptr_t)2 << 20)

void glint_memory_share_arena(void)
{
    mallopt(M_ARENA_MAX, 1);
    mallopt(M_MMAP_THRESHOLD, (int)MAPPED_BYTES);
    glint_memory_settle();
}

static void wish_large_pages(const void *block, size_t bytes)
{
    const uintptr_t first = ((uintptr_t)block + LARGE_PAGE - 1) / LARGE_PAGE * LARGE_PAGE;
    const uintptr_t end = ((uintptr_t)block + bytes) / LARGE_PAGE * LARGE_PAGE;
    if (first < end)
        madvise((void *)first, end - first, MADV_HUGEPAGE); // a wish: it works without
}

// A block of the heap, the one before it in its first bytes.
static void **add_piece(void **before, size_t bytes)
{
    void **piece = malloc(bytes);
    if (!piece)
        return NULL;
    wish_large_pages(piece, bytes);
    *piece = before;
    return piece;
}

void glint_memory_expect(uint64_t bytes)
{
    const size_t most = MAPPED_BYTES / 2;
    void **last = NULL, **piece = NULL;
    bytes = bytes < MOST_EXPECTED ? bytes : MOST_EXPECTED;
    mallopt(M_TRIM_THRESHOLD, (int)(KEPT_BYTES + bytes));
    for (size_t size; bytes >= LARGE_PAGE; bytes -= size) {
        size = bytes < most ? (size_t)bytes : most;
        if (!(piece = add_piece(last, size)))
            break;
        last = piece;
    }
    for (; last; last = piece) {
        piece = *last;
        free(last);
    }
}

void glint_memory_settle(void)
{
    mallopt(M_TRIM_THRESHOLD, (int)KEPT_BYTES);
}

void glint_memory_heap(struct glint_heap *out)
{
    const struct mallinfo2 now = mallinfo2();
    *out = (struct glint_heap){now.uordblks, now.fordblks, now.hblkhd};
}

const char *glint_memory_text(uint64_t bytes, char out[16])
{
    static const char *const unit[] = {"bytes", "KiB", "MiB", "GiB", "TiB", "PiB"};
    double value = (double)bytes;
    size_t u = 0;
    for (; value >= 999.5 && u + 1 < sizeof unit / sizeof *unit; u++)
        value /= 1024;
    snprintf(out, 16, "%.3g %s", value, unit[u]);
    return out;
}
