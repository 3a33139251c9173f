#include "protocol/problem.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

static const char *text_of(const cJSON *object, const char *key)
{
    return cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(object, key));
}

static void every_fault_is_listed_and_the_detail_names_the_first(void **state)
{
    (void)state;
    struct glint_error err = {0};
    glint_fail(&err, GLINT_E_RANGE, "/camera/yfov", "4 is outside");
    glint_fail(&err, GLINT_E_RANGE, "/a~1b", "the second");
    cJSON *p = glint_problem_object(&err, "/v1/jobs", "r1");
    assert_string_equal(text_of(p, "type"), "/problems/unprocessable");
    assert_string_equal(text_of(p, "title"), "Unprocessable content");
    assert_string_equal(text_of(p, "detail"),
                        "2 faults; the first, at \"/camera/yfov\": 4 is outside");
    assert_string_equal(text_of(p, "instance"), "/v1/jobs");
    assert_string_equal(text_of(p, "request_id"), "r1");
    assert_int_equal(cJSON_GetObjectItem(p, "status")->valueint, 422);
    const cJSON *errors = cJSON_GetObjectItem(p, "errors");
    assert_int_equal(cJSON_GetArraySize(errors), 2);
    assert_string_equal(text_of(cJSON_GetArrayItem(errors, 1), "pointer"), "/a~1b");
    assert_string_equal(text_of(cJSON_GetArrayItem(errors, 1), "detail"), "the second");
    cJSON_Delete(p);
    glint_error_finish(&err);
}

static void one_fault_is_the_detail_and_absent_members_are_left_out(void **state)
{
    (void)state;
    struct glint_error err = {0};
    glint_fail(&err, GLINT_E_SYNTAX, "", "line 1: \"no\"\xff");
    char *text = glint_problem_text(&err, NULL, NULL);
    assert_string_equal(
        text, "{\"type\":\"/problems/malformed\",\"title\":\"Malformed request\",\"status\":400,"
              "\"detail\":\"line 1: \\\"no\\\"?\",\"errors\":[{\"pointer\":\"\","
              "\"detail\":\"line 1: \\\"no\\\"?\"}]}");
    free(text);
    glint_error_finish(&err);
}

static void an_error_without_faults_still_says_what_it_is(void **state)
{
    (void)state;
    const struct glint_error err = {.status = GLINT_E_NOMEM};
    cJSON *p = glint_problem_object(&err, NULL, NULL);
    assert_string_equal(text_of(p, "detail"), "Out of memory");
    assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(p, "errors")), 0);
    cJSON_Delete(p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_fault_is_listed_and_the_detail_names_the_first),
        cmocka_unit_test(one_fault_is_the_detail_and_absent_members_are_left_out),
        cmocka_unit_test(an_error_without_faults_still_says_what_it_is),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
