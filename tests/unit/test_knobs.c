// The table of knobs names dials, members and effects that exist, once each.
#include "protocol/accuracy_knobs.h"
#include "protocol/job.h"
#include "render/effects.h"

#include <cjson/cJSON.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void every_dial_has_one_row(void **state)
{
    (void)state;
    for (int d = 0; d < GLINT_DIAL_COUNT; d++) {
        int rows = 0;
        for (size_t i = 0; i < glint_knob_count; i++)
            rows += (int)glint_knob_table[i].dial == d;
        assert_int_equal(rows, 1);
    }
}

static void effects_that_call_for_a_knob_are_rows_of_their_table(void **state)
{
    (void)state;
    for (size_t i = 0; i < glint_knob_count; i++)
        for (int e = 0; e < 3 && glint_knob_table[i].effects[e]; e++)
            if (!glint_effect_bit(glint_knob_table[i].effects[e]))
                fail_msg("there is no effect \"%s\"", glint_knob_table[i].effects[e]);
}

static void add(cJSON *job, const char *parent, const char *name, cJSON *value)
{
    cJSON *object = *parent ? cJSON_GetObjectItemCaseSensitive(job, parent) : job;
    if (!object)
        object = cJSON_AddObjectToObject(job, parent);
    cJSON_DeleteItemFromObjectCaseSensitive(object, name);
    cJSON_AddItemToObject(object, name, value);
}

static cJSON *value_of(const struct glint_knob *k, const char *text)
{
    cJSON *number = k->dial == GLINT_DIAL_COUNT ? cJSON_Parse(text) : NULL;
    return number ? number : cJSON_CreateString(text);
}

// As `glint accuracy` makes the job of a setting.
static void assert_renders(const struct glint_knob *k, const char *setting)
{
    struct glint_error err = {0};
    struct glint_job *job;
    cJSON *tree = cJSON_CreateObject(), *with = k->with ? cJSON_Parse(k->with) : NULL;
    cJSON_AddStringToObject(tree, "scene", "a");
    if (with)
        cJSON_AddItemToObject(tree, "mattes", cJSON_DetachItemFromObject(with, "mattes"));
    cJSON *value = value_of(k, setting);
    if (strcmp(glint_knob_name(k), "slots") == 0)
        add(tree, "mattes", "levels", cJSON_CreateNumber((int)value->valuedouble / 2));
    add(tree, glint_knob_parent(k), glint_knob_name(k), value);
    char *text = cJSON_PrintUnformatted(tree);
    if (glint_job_parse(&job, text, strlen(text), &err))
        fail_msg("%s: %s %s", text, err.fault[0].pointer, err.fault[0].detail);
    glint_job_destroy(&job);
    free(text);
    cJSON_Delete(with);
    cJSON_Delete(tree);
}

static void every_setting_is_one_of_a_job(void **state)
{
    (void)state;
    for (size_t i = 0; i < glint_knob_count; i++) {
        const struct glint_knob *k = &glint_knob_table[i];
        assert_renders(k, glint_knob_twin(k));
        for (size_t n = 0; glint_knob_setting(k, n); n++)
            assert_renders(k, glint_knob_setting(k, n));
    }
}

static void a_twin_has_the_expectation_of_the_exact_setting(void **state)
{
    (void)state;
    for (size_t i = 0; i < glint_knob_count; i++) {
        const struct glint_knob *k = &glint_knob_table[i];
        size_t n = 0;
        while (strcmp(glint_knob_setting(k, n), glint_knob_twin(k)))
            assert_non_null(glint_knob_setting(k, ++n));
        assert_true(glint_knob_unbiased(k, n));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_dial_has_one_row),
        cmocka_unit_test(effects_that_call_for_a_knob_are_rows_of_their_table),
        cmocka_unit_test(every_setting_is_one_of_a_job),
        cmocka_unit_test(a_twin_has_the_expectation_of_the_exact_setting),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
