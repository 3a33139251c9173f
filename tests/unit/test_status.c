#include "protocol/status.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <string.h>

static void every_code_has_a_row(void **state)
{
    (void)state;
    for (int s = GLINT_E_SYNTAX; s < GLINT_STATUS_COUNT; s++) {
        assert_in_range(glint_status_http(s), 400, 599);
        assert_in_range(glint_status_exit(s), 1, 127);
        assert_true(strlen(glint_status_title(s)) > 3);
        assert_memory_equal(glint_status_problem(s), "/problems/", 10);
        assert_int_equal(glint_status_of_problem(glint_status_problem(s) + 10), s);
        assert_true(strlen(glint_status_meaning(s)) > 20);
    }
}

static void problems_that_do_not_exist_have_no_status(void **state)
{
    (void)state;
    static const char *const name[] = {"", "OK", "about:blank", "rang", "conflict/", "/conflict"};
    for (size_t i = 0; i < sizeof name / sizeof *name; i++)
        assert_int_equal(glint_status_of_problem(name[i]), GLINT_OK);
}

static void http_codes_are_those_of_the_conventions(void **state)
{
    (void)state;
    assert_int_equal(glint_status_http(GLINT_OK), 200);
    assert_int_equal(glint_status_http(GLINT_E_SYNTAX), 400);
    assert_int_equal(glint_status_http(GLINT_E_RANGE), 422);
    assert_int_equal(glint_status_http(GLINT_E_STALE), 412);
    assert_int_equal(glint_status_http(GLINT_E_CAPACITY), 507);
    assert_int_equal(glint_status_exit(GLINT_E_UNAVAILABLE), 69);
    assert_int_equal(glint_status_exit(GLINT_E_BUSY), 75);
}

static void the_first_fault_gives_the_code_and_all_are_kept(void **state)
{
    (void)state;
    struct glint_error err = {0};
    assert_int_equal(glint_fail(&err, GLINT_E_RANGE, "/a", "%d is odd", 3), GLINT_E_RANGE);
    assert_int_equal(glint_fail(&err, GLINT_E_IO, "/b", "gone"), GLINT_E_IO);
    assert_int_equal(err.status, GLINT_E_RANGE);
    assert_int_equal(err.count, 2);
    assert_string_equal(err.fault[0].detail, "3 is odd");
    assert_string_equal(err.fault[1].pointer, "/b");
    assert_string_equal(glint_error_text(&err), "3 is odd");
    glint_error_finish(&err);
    assert_int_equal(err.count, 0);
    assert_string_equal(glint_error_text(&err), glint_status_title(GLINT_OK));
    assert_int_equal(glint_fail(NULL, GLINT_E_BUSY, "", "nobody listens"), GLINT_E_BUSY);
}

static void too_many_faults_end_with_a_sentence_that_says_so(void **state)
{
    (void)state;
    struct glint_error err = {0};
    for (int i = 0; i < GLINT_MAX_FAULTS; i++)
        glint_fail(&err, GLINT_E_RANGE, "/x", "fault %d", i);
    assert_string_equal(err.fault[GLINT_MAX_FAULTS - 1].detail, "fault 63");
    for (int i = 0; i < 100; i++)
        glint_fail(&err, GLINT_E_RANGE, "/x", "another");
    assert_int_equal(err.count, GLINT_MAX_FAULTS);
    assert_non_null(strstr(err.fault[GLINT_MAX_FAULTS - 1].detail, "more faults"));
    assert_string_equal(err.fault[GLINT_MAX_FAULTS - 2].detail, "fault 62");
    glint_error_finish(&err);
}

static void a_detail_is_printable_utf8_whatever_it_repeats(void **state)
{
    (void)state;
    struct glint_error err = {0};
    glint_fail(&err, GLINT_E_RANGE, "", "%s", "a\n\x1b[31m\xff\xc3\xa4\xe2\x82");
    assert_string_equal(err.fault[0].detail, "a  [31m?\xc3\xa4??");
    glint_error_finish(&err);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_code_has_a_row),
        cmocka_unit_test(problems_that_do_not_exist_have_no_status),
        cmocka_unit_test(http_codes_are_those_of_the_conventions),
        cmocka_unit_test(the_first_fault_gives_the_code_and_all_are_kept),
        cmocka_unit_test(too_many_faults_end_with_a_sentence_that_says_so),
        cmocka_unit_test(a_detail_is_printable_utf8_whatever_it_repeats),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
