#include "protocol/arena.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <string.h>

static int all_zero(const unsigned char *p, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (p[i])
            return 0;
    return 1;
}

static void memory_is_zeroed_aligned_and_disjoint(void **state)
{
    (void)state;
    struct glint_arena a = {0};
    unsigned char *piece[600];
    for (size_t i = 0; i < 600; i++) {
        const size_t bytes = i * i % 5003;
        piece[i] = glint_arena_alloc(&a, bytes);
        assert_non_null(piece[i]);
        assert_int_equal((uintptr_t)piece[i] % (bytes >= 64 ? 64 : 16), 0);
        assert_true(all_zero(piece[i], bytes));
        memset(piece[i], (int)(i % 255) + 1, bytes);
    }
    for (size_t i = 0; i < 600; i++)
        for (size_t k = 0; k < i * i % 5003; k++)
            assert_int_equal(piece[i][k], i % 255 + 1);
    glint_arena_finish(&a);
    assert_null(a.block);
}

static void a_large_piece_leaves_the_room_of_the_small_block(void **state)
{
    (void)state;
    struct glint_arena a = {0};
    char *first = glint_arena_alloc(&a, 16);
    char *large = glint_arena_alloc(&a, 8u << 20);
    char *second = glint_arena_alloc(&a, 16);
    assert_non_null(large);
    assert_ptr_equal(second, first + 16);
    assert_int_equal(a.bytes, 32 + (8u << 20));
    glint_arena_finish(&a);
}

static void a_product_that_overflows_gives_null(void **state)
{
    (void)state;
    struct glint_arena a = {0};
    assert_null(glint_arena_array(&a, SIZE_MAX / 4, 8));
    assert_null(glint_arena_array(&a, SIZE_MAX, 1));
    assert_null(glint_arena_alloc(&a, SIZE_MAX - 8));
    assert_non_null(glint_arena_array(&a, 0, 8));
    glint_arena_finish(&a);
}

static void strings_are_copied_and_printed(void **state)
{
    (void)state;
    struct glint_arena a = {0};
    char text[] = "abc";
    char *copy = glint_arena_string(&a, text);
    text[0] = 'x';
    assert_string_equal(copy, "abc");
    assert_null(glint_arena_string(&a, NULL));
    assert_string_equal(glint_arena_print(&a, "%s-%d", text, 7), "xbc-7");
    glint_arena_finish(&a);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memory_is_zeroed_aligned_and_disjoint),
        cmocka_unit_test(a_large_piece_leaves_the_room_of_the_small_block),
        cmocka_unit_test(a_product_that_overflows_gives_null),
        cmocka_unit_test(strings_are_copied_and_printed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
