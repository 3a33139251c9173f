#include "base/log.h"

#include <cjson/cJSON.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static char output[8192];

static int before, ends[2];

static void begin_capture(void)
{
    assert_int_equal(pipe(ends), 0);
    before = dup(STDERR_FILENO);
    dup2(ends[1], STDERR_FILENO);
}

static const char *end_capture(void)
{
    dup2(before, STDERR_FILENO);
    close(before);
    close(ends[1]);
    const ssize_t length = read(ends[0], output, sizeof output - 1);
    output[length > 0 ? length : 0] = '\0';
    close(ends[0]);
    return output;
}

// What glint_log writes to standard error with these arguments.
static const char *capture(enum glint_log_level level, const char *category, const char *job,
                           const char *message)
{
    begin_capture();
    glint_log(level, category, job, "r1", "%s", message);
    return end_capture();
}

static void start(enum glint_log_format format, const char *debug)
{
    setenv("GLINT_DEBUG", debug, 1);
    glint_log_start(format);
}

static void a_line_carries_priority_category_job_and_request(void **state)
{
    (void)state;
    start(GLINT_LOG_TEXT, "");
    assert_string_equal(capture(GLINT_LOG_WARNING, "jobs", "abc", "slow"),
                        "<4>jobs job=abc request=r1: slow\n");
}

static void a_message_cannot_forge_a_second_line(void **state)
{
    (void)state;
    start(GLINT_LOG_TEXT, "");
    assert_string_equal(capture(GLINT_LOG_INFO, "http", NULL, "a\n<3>forged\x1b"),
                        "<6>http request=r1: a\\u000a<3>forged\\u001b\n");
}

static void debug_lines_appear_for_named_categories_only(void **state)
{
    (void)state;
    start(GLINT_LOG_TEXT, "cl,http");
    assert_true(glint_log_enabled("cl"));
    assert_true(glint_log_enabled("http"));
    assert_false(glint_log_enabled("ht"));
    assert_false(glint_log_enabled("jobs"));
    assert_string_equal(capture(GLINT_LOG_DEBUG, "jobs", NULL, "x"), "");
    assert_string_equal(capture(GLINT_LOG_DEBUG, "cl", NULL, "x"), "<7>cl request=r1: x\n");
}

static void json_lines_parse_whatever_the_message_holds(void **state)
{
    (void)state;
    start(GLINT_LOG_JSON, "");
    char hostile[4096];
    for (size_t i = 0; i < sizeof hostile - 1; i++)
        hostile[i] = (char)(1 + i % 255);
    hostile[sizeof hostile - 1] = '\0';
    cJSON *line = cJSON_Parse(capture(GLINT_LOG_ERROR, "http", "j\"1", hostile));
    assert_non_null(line);
    assert_string_equal(cJSON_GetObjectItem(line, "level")->valuestring, "error");
    assert_string_equal(cJSON_GetObjectItem(line, "job_id")->valuestring, "j\"1");
    assert_memory_equal(cJSON_GetObjectItem(line, "message")->valuestring, hostile, 127);
    cJSON_Delete(line);
    assert_int_equal(output[strlen(output) - 1], '\n');
}

static void a_value_is_cut_but_the_line_stays_whole(void **state)
{
    (void)state;
    start(GLINT_LOG_JSON, "");
    char quotes[4000];
    memset(quotes, '"', sizeof quotes - 1);
    quotes[sizeof quotes - 1] = '\0';
    cJSON *line = cJSON_Parse(capture(GLINT_LOG_INFO, "http", quotes, quotes));
    assert_non_null(line);
    assert_true(strlen(cJSON_GetObjectItem(line, "message")->valuestring) > 1000);
    assert_true(strlen(output) < 4096);
    cJSON_Delete(line);
}

static const char *capture_event(void)
{
    static const struct glint_log_field field[] = {
        {.name = "trace_id", .text = "t\"1"},
        {.name = "client", .text = NULL},
        {.name = "status", .text = "404", .number = true, .said = true},
        {.name = "path", .text = "/v1\n<0>", .said = false},
    };
    begin_capture();
    glint_log_event(GLINT_LOG_INFO, "http", field, 4, "answered %d", 404);
    return end_capture();
}

static void fields_are_members_and_numbers_are_numbers(void **state)
{
    (void)state;
    start(GLINT_LOG_JSON, "");
    cJSON *line = cJSON_Parse(capture_event());
    assert_non_null(line);
    assert_string_equal(cJSON_GetObjectItem(line, "trace_id")->valuestring, "t\"1");
    assert_null(cJSON_GetObjectItem(line, "client"));
    assert_true(cJSON_IsNumber(cJSON_GetObjectItem(line, "status")));
    assert_string_equal(cJSON_GetObjectItem(line, "path")->valuestring, "/v1\n<0>");
    cJSON_Delete(line);
    start(GLINT_LOG_TEXT, "");
    assert_string_equal(capture_event(), "<6>http trace=t\"1 path=/v1\\u000a<0>: answered 404\n");
}

static void what_is_written_may_change_at_any_time(void **state)
{
    (void)state;
    start(GLINT_LOG_TEXT, "cl");
    glint_log_filter(GLINT_LOG_ERROR, "jobs");
    assert_string_equal(capture(GLINT_LOG_WARNING, "main", NULL, "x"), "");
    assert_string_equal(capture(GLINT_LOG_DEBUG, "cl", NULL, "x"), "");
    assert_string_equal(capture(GLINT_LOG_DEBUG, "jobs", NULL, "x"), "<7>jobs request=r1: x\n");
    assert_string_equal(capture(GLINT_LOG_ERROR, "main", NULL, "x"), "<3>main request=r1: x\n");
    glint_log_filter(GLINT_LOG_DEBUG, "");
    assert_string_equal(capture(GLINT_LOG_DEBUG, "cl", NULL, "x"), "<7>cl request=r1: x\n");
    glint_log_filter(GLINT_LOG_INFO, NULL); // as the environment says
    assert_true(glint_log_enabled("cl"));
    assert_false(glint_log_enabled("jobs"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_line_carries_priority_category_job_and_request),
        cmocka_unit_test(a_message_cannot_forge_a_second_line),
        cmocka_unit_test(debug_lines_appear_for_named_categories_only),
        cmocka_unit_test(json_lines_parse_whatever_the_message_holds),
        cmocka_unit_test(a_value_is_cut_but_the_line_stays_whole),
        cmocka_unit_test(fields_are_members_and_numbers_are_numbers),
        cmocka_unit_test(what_is_written_may_change_at_any_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
