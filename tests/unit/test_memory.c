#include "base/memory.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#define MIB ((size_t)1 << 20)
#define BLOCKS 150

static size_t heap_free(void)
{
    struct glint_heap heap;
    glint_memory_heap(&heap);
    return heap.free;
}

static void take_and_free(size_t bytes)
{
    char *volatile block = malloc(bytes); // or the compiler leaves out both
    free(block);
}

static int share(void **state)
{
    (void)state;
    glint_memory_share_arena();
    return 0;
}

// Another allocator, as sanitizers bring one along, expects nothing.
static void skip_without_heap(void)
{
    struct glint_heap heap;
    take_and_free(MIB);
    glint_memory_heap(&heap);
    if (!heap.used && !heap.free)
        skip();
}

// Bytes of mappings that were given this flag of /proc/self/smaps.
static size_t flagged(const char *flag)
{
    FILE *f = fopen("/proc/self/smaps", "re");
    char line[512];
    size_t from = 0, to = 0, bytes = 0;
    while (f && fgets(line, sizeof line, f)) {
        sscanf(line, "%zx-%zx ", &from, &to);
        bytes += !strncmp(line, "VmFlags:", 8) && strstr(line, flag) ? to - from : 0;
    }
    if (f)
        fclose(f);
    return bytes;
}

static void what_is_expected_makes_the_heap_grow_once(void **state)
{
    (void)state;
    skip_without_heap();
    void *block[BLOCKS];
    glint_memory_expect((BLOCKS + 2) * MIB);
    const void *end = sbrk(0);
    for (int i = 0; i < BLOCKS; i++) {
        block[i] = malloc(MIB);
        assert_non_null(block[i]);
    }
    assert_ptr_equal(sbrk(0), end);
    for (int i = 0; i < BLOCKS; i++)
        free(block[i]);
    assert_ptr_equal(sbrk(0), end);
    glint_memory_settle();
}

static void what_is_expected_is_to_have_large_pages(void **state)
{
    (void)state;
    skip_without_heap();
    if (access("/sys/kernel/mm/transparent_hugepage/enabled", R_OK))
        skip();
    glint_memory_expect(100 * MIB);
    assert_true(flagged(" hg") >= 90 * MIB);
    glint_memory_settle();
}

static void a_settled_heap_gives_back_what_was_expected(void **state)
{
    (void)state;
    skip_without_heap();
    glint_memory_expect(300 * MIB);
    assert_true(heap_free() >= 300 * MIB);
    glint_memory_settle();
    take_and_free(4 * MIB);
    assert_true(heap_free() <= 80 * MIB);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_expected_makes_the_heap_grow_once),
        cmocka_unit_test(what_is_expected_is_to_have_large_pages),
        cmocka_unit_test(a_settled_heap_gives_back_what_was_expected),
    };
    return cmocka_run_group_tests(tests, share, NULL);
}
