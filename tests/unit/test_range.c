#include "http/range.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

// RFC 9110 14.1.2, of a representation of 10 bytes.
static const struct {
    const char *header;
    enum glint_range_verdict verdict;
    size_t first, length;
} row[] = {
    {"bytes=0-0", GLINT_RANGE_PART, 0, 1},
    {"bytes=0-9", GLINT_RANGE_PART, 0, 10},
    {"Bytes=2-5", GLINT_RANGE_PART, 2, 4},
    {"bytes=9-", GLINT_RANGE_PART, 9, 1},
    {"bytes=4-1000", GLINT_RANGE_PART, 4, 6},
    {"bytes=-3", GLINT_RANGE_PART, 7, 3},
    {"bytes=-11", GLINT_RANGE_PART, 0, 10},
    {"bytes=10-", GLINT_RANGE_OUTSIDE, 0, 0},
    {"bytes=10-20", GLINT_RANGE_OUTSIDE, 0, 0},
    {"bytes=-0", GLINT_RANGE_OUTSIDE, 0, 0},
    {"bytes=5-4", GLINT_RANGE_WHOLE, 0, 0},
    {"bytes=0-1,3-4", GLINT_RANGE_WHOLE, 0, 0},
    {"bytes=", GLINT_RANGE_WHOLE, 0, 0},
    {"bytes=-", GLINT_RANGE_WHOLE, 0, 0},
    {"bytes=a-b", GLINT_RANGE_WHOLE, 0, 0},
    {"bytes=1-2x", GLINT_RANGE_WHOLE, 0, 0},
    {"bytes=+1-2", GLINT_RANGE_WHOLE, 0, 0},
    {"bytes=99999999999999999999999-", GLINT_RANGE_WHOLE, 0, 0},
    {"pages=1-2", GLINT_RANGE_WHOLE, 0, 0},
};

static void one_range_of_bytes_is_understood(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        struct glint_range part = {0, 0};
        assert_int_equal(row[i].verdict, glint_range_parse(row[i].header, 10, &part));
        if (row[i].verdict == GLINT_RANGE_PART) {
            assert_int_equal(row[i].first, part.first);
            assert_int_equal(row[i].length, part.length);
        }
    }
}

static void nothing_is_a_part_of_nothing(void **state)
{
    (void)state;
    struct glint_range part;
    assert_int_equal(GLINT_RANGE_OUTSIDE, glint_range_parse("bytes=0-", 0, &part));
    assert_int_equal(GLINT_RANGE_OUTSIDE, glint_range_parse("bytes=-1", 0, &part));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_range_of_bytes_is_understood),
        cmocka_unit_test(nothing_is_a_part_of_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
