#include "protocol/dials.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <string.h>

static size_t settings(const struct glint_dial_row *row)
{
    size_t n = 0;
    while (row->setting[n])
        n++;
    return n;
}

static void every_dial_has_a_row_with_an_exact_setting(void **state)
{
    (void)state;
    for (int d = 0; d < GLINT_DIAL_COUNT; d++) {
        const struct glint_dial_row *row = &glint_dial_table[d];
        assert_non_null(row->name);
        assert_in_range(settings(row), 1, GLINT_MAX_SETTINGS);
        assert_true(row->unbiased & 1);
        assert_int_equal(row->unbiased >> settings(row), 0);
        assert_true(!strcmp(row->parent, "accuracy") || !strcmp(row->parent, "mattes"));
        assert_true(settings(row) == 1 || strlen(row->source) > 0);
    }
}

static void a_setting_is_found_by_its_name_alone(void **state)
{
    (void)state;
    for (int d = 0; d < GLINT_DIAL_COUNT; d++) {
        const struct glint_dial_row *row = &glint_dial_table[d];
        for (int i = 0; row->setting[i]; i++)
            assert_int_equal(glint_dial_setting(d, row->setting[i]), i);
        assert_int_equal(glint_dial_setting(d, "surfel"), -1);
    }
}

static void presets_name_settings_that_exist(void **state)
{
    (void)state;
    size_t n = 0;
    for (; glint_preset_table[n].name; n++)
        for (int d = 0; d < GLINT_DIAL_COUNT; d++)
            assert_true(glint_preset_table[n].setting[d] < settings(&glint_dial_table[d]));
    assert_int_equal(n, glint_preset_count);
}

static void reference_is_exact_and_production_is_the_default(void **state)
{
    (void)state;
    assert_string_equal(glint_preset_table[0].name, "production");
    assert_string_equal(glint_preset_table[1].name, "reference");
    for (int d = 0; d < GLINT_DIAL_COUNT; d++) // mattes are as in every preset
        if (strcmp(glint_dial_table[d].parent, "accuracy") == 0)
            assert_int_equal(glint_preset_table[1].setting[d], 0);
        else
            assert_int_equal(glint_preset_table[1].setting[d], glint_preset_table[0].setting[d]);
    const unsigned char *p = glint_preset_table[0].setting;
    assert_int_equal(p[GLINT_DIAL_PRECISION], glint_dial_setting(GLINT_DIAL_PRECISION, "float32"));
    assert_int_equal(p[GLINT_DIAL_TRAVERSAL], glint_dial_setting(GLINT_DIAL_TRAVERSAL, "fast"));
    assert_int_equal(p[GLINT_DIAL_ROULETTE], glint_dial_setting(GLINT_DIAL_ROULETTE, "throughput"));
    assert_int_equal(p[GLINT_DIAL_GI], glint_dial_setting(GLINT_DIAL_GI, "path"));
    assert_int_equal(p[GLINT_DIAL_LIGHTS], glint_dial_setting(GLINT_DIAL_LIGHTS, "spatial"));
    assert_int_equal(p[GLINT_DIAL_MICROFACET],
                     glint_dial_setting(GLINT_DIAL_MICROFACET, "multiple"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_dial_has_a_row_with_an_exact_setting),
        cmocka_unit_test(a_setting_is_found_by_its_name_alone),
        cmocka_unit_test(presets_name_settings_that_exist),
        cmocka_unit_test(reference_is_exact_and_production_is_the_default),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
