#include "protocol/nearest.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <string.h>

static const char *const members[] = {"scene",      "camera",    "resolution", "outputs", "stop",
                                      "base_color", "roughness", "seed",       "fps",     NULL};

static void one_slip_is_understood(void **state)
{
    (void)state;
    static const char *const typed[][2] = {
        {"base_colour", "base_color"}, {"resolutoin", "resolution"},
        {"camra", "camera"},           {"sceen", "scene"},
        {"output", "outputs"},         {"stopp", "stop"},
    };
    for (size_t i = 0; i < sizeof typed / sizeof *typed; i++)
        assert_string_equal(glint_nearest(members, typed[i][0]), typed[i][1]);
}

static void the_fewest_slips_win(void **state)
{
    (void)state;
    static const char *const near[] = {"samples", "sample", "simple", NULL};
    assert_string_equal(glint_nearest(near, "sample"), "sample");
    assert_string_equal(glint_nearest(near, "smaples"), "samples");
}

static void another_word_is_no_slip(void **state)
{
    (void)state;
    static const char *const typed[] = {"x", "", "colour", "light", "priority", "fov"};
    for (size_t i = 0; i < sizeof typed / sizeof *typed; i++)
        assert_null(glint_nearest(members, typed[i]));
}

static void names_without_end_are_not_guessed(void **state)
{
    (void)state;
    char name[5000];
    memset(name, 's', sizeof name - 1);
    name[sizeof name - 1] = '\0';
    assert_null(glint_nearest(members, name));
    const char *const names[] = {name, "scene", NULL};
    assert_string_equal(glint_nearest(names, "scen"), "scene");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_slip_is_understood),
        cmocka_unit_test(the_fewest_slips_win),
        cmocka_unit_test(another_word_is_no_slip),
        cmocka_unit_test(names_without_end_are_not_guessed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
