// Messages to tev, byte by byte.
#include "clients/cli/tev_packet.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static const char *const rgb[] = {"R", "G", "B"};

static void assert_hex(const char *hex, const struct glint_tev_packet *p)
{
    char text[512];
    assert_true(2 * p->size < sizeof text);
    for (size_t i = 0; i < p->size; i++)
        snprintf(text + 2 * i, 3, "%02x", p->bytes[i]);
    assert_string_equal(hex, text);
}

// The two examples of CONVENTIONS e.
static void an_image_of_64_by_32_is_created_in_29_bytes(void **state)
{
    (void)state;
    struct glint_tev_packet p = {0};
    assert_true(glint_tev_write_create(&p, true, "shot", 64, 32, 3, rgb));
    assert_hex("1d000000040173686f74004000000020000000030000005200"
               "47004200",
               &p);
    glint_tev_packet_finish(&p);
}

static void closing_names_the_image_and_nothing_else(void **state)
{
    (void)state;
    struct glint_tev_packet p = {0};
    assert_true(glint_tev_write_close(&p, "shot"));
    assert_hex("0a0000000273686f7400", &p);
    glint_tev_packet_finish(&p);
}

static void an_update_has_its_planes_one_after_the_other(void **state)
{
    (void)state;
    // Two rows of two pixels out of planes that are three wide.
    const float red[] = {1, 2, 9, 3, 4, 9}, green[] = {-1, 0.5f, 9, 0, 8, 9};
    const float *const plane[] = {red, green};
    struct glint_tev_packet p = {0};
    assert_true(glint_tev_write_close(&p, "a longer one before"));
    assert_true(glint_tev_write_update(&p, "i", (const int32_t[]){5, 6, 2, 2}, 2, rgb, plane, 3));
    assert_hex("60000000"
               "06"
               "00"
               "6900"
               "02000000"
               "52004700"
               "05000000060000000200000002000000"
               "00000000000000000400000000000000"
               "01000000000000000100000000000000"
               "0000803f000000400000404000008040"
               "000080bf0000003f0000000000000041",
               &p);
    glint_tev_packet_finish(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_image_of_64_by_32_is_created_in_29_bytes),
        cmocka_unit_test(closing_names_the_image_and_nothing_else),
        cmocka_unit_test(an_update_has_its_planes_one_after_the_other),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
