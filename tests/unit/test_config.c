#include "base/config.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

static glint_status parse(struct glint_config *out, const char *text, struct glint_error *err)
{
    return glint_config_parse(out, "f", text, strlen(text), err);
}

static void lines_are_keys_and_values_without_blanks_and_comments(void **state)
{
    (void)state;
    struct glint_config config;
    assert_int_equal(parse(&config,
                           "# glintd\n\n listen = [::1]:80\r\n\ttoken_file=/a b/c = d #e\t\n#x=y\n"
                           "last = 1",
                           NULL),
                     GLINT_OK);
    assert_int_equal(config.count, 3);
    assert_string_equal(config.line[0].key, "listen");
    assert_string_equal(config.line[0].value, "[::1]:80");
    assert_int_equal(config.line[0].number, 3);
    assert_string_equal(config.line[1].value, "/a b/c = d #e");
    assert_string_equal(config.line[2].value, "1");
    glint_config_finish(&config);
}

static void every_fault_is_named_with_its_line_and_the_rest_is_read(void **state)
{
    (void)state;
    static const char text[] = "good = 1\n"
                               "no value\n"
                               "empty =\n"
                               "Upper = 1\n"
                               "= 1\n"
                               "a-b = 1\n"
                               "good = 2\n"
                               "bell = \a\n"
                               "byte = \xff\n"
                               "two words = 1\n";
    struct glint_config config;
    struct glint_error err = {0};
    assert_int_equal(parse(&config, text, &err), GLINT_E_RANGE);
    assert_int_equal(config.count, 1);
    assert_int_equal(err.count, 9);
    for (unsigned i = 0; i < 9; i++) {
        char where[8];
        snprintf(where, sizeof where, "f:%u: ", i + 2);
        assert_memory_equal(err.fault[i].detail, where, strlen(where));
    }
    assert_non_null(strstr(err.fault[5].detail, "line 1"));
    glint_error_finish(&err);
    glint_config_finish(&config);
}

static void what_is_no_text_is_refused(void **state)
{
    (void)state;
    struct glint_config config;
    assert_int_equal(glint_config_parse(&config, "f", "a = 1\0b", 7, NULL), GLINT_E_RANGE);
    assert_int_equal(config.count, 0);
    assert_int_equal(parse(&config, "", NULL), GLINT_OK);
    assert_int_equal(config.count, 0);
}

// Lines that a fuzzer would come to soon: nothing may be read outside of them.
static void any_cut_of_a_hostile_file_is_taken_or_refused(void **state)
{
    (void)state;
    static const char text[] =
        "=\n==\n\r\n \t\na=\n=a\na==a\n\x80=1\na=\xc3\n#\n\xef\xbb\xbf\x61=1\n";
    for (size_t from = 0; from < sizeof text; from++)
        for (size_t to = from; to < sizeof text; to++) {
            char *exact = malloc(to - from + 1); // so that a sanitizer sees a step too far
            memcpy(exact, text + from, to - from);
            struct glint_config config;
            glint_config_parse(&config, "f", exact, to - from, NULL);
            glint_config_finish(&config);
            free(exact);
        }
}

static void a_file_that_everybody_may_write_or_that_is_none_is_refused(void **state)
{
    (void)state;
    char path[] = "/tmp/glint-config-XXXXXX";
    const int fd = mkstemp(path);
    struct glint_config config;
    assert_int_equal(write(fd, "a = 1\n", 6), 6);
    assert_int_equal(glint_config_read(&config, path, NULL), GLINT_OK);
    assert_int_equal(config.count, 1);
    glint_config_finish(&config);
    fchmod(fd, 0666);
    assert_int_equal(glint_config_read(&config, path, NULL), GLINT_E_IO);
    fchmod(fd, 0600);
    assert_int_equal(ftruncate(fd, GLINT_CONFIG_BYTES + 1), 0);
    assert_int_equal(glint_config_read(&config, path, NULL), GLINT_E_IO);
    close(fd);
    unlink(path);
    assert_int_equal(glint_config_read(&config, path, NULL), GLINT_E_IO);
    assert_int_equal(glint_config_read(&config, "/tmp", NULL), GLINT_E_IO);
    assert_int_equal(glint_config_read(&config, "/dev/zero", NULL), GLINT_E_IO);
}

static void numbers_are_read_whole_or_not_at_all(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "", "-1", "+1", " 1", "1 ", "0x1", "1.5", "1e3", "11", "18446744073709551617", "1K"};
    uint64_t n = 7;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_false(glint_config_whole(bad[i], 0, 10, &n));
    assert_int_equal(n, 7);
    assert_true(glint_config_whole("0010", 0, 10, &n));
    assert_int_equal(n, 10);
}

static void bytes_take_binary_units_and_never_overflow(void **state)
{
    (void)state;
    uint64_t n = 7;
    assert_true(glint_config_bytes("64M", 0, UINT64_MAX, &n));
    assert_int_equal(n, (uint64_t)64 << 20);
    assert_true(glint_config_bytes("2T", 0, UINT64_MAX, &n));
    assert_int_equal(n, (uint64_t)2 << 40);
    assert_true(glint_config_bytes("512", 0, 512, &n));
    static const char *const bad[] = {"", "M", "1m", "1KB", "1MM", "-1M", "16777216T", "513", "1P"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_false(glint_config_bytes(bad[i], 0, i == 7 ? 512 : UINT64_MAX, &n));
    assert_int_equal(n, 512);
}

static void seconds_are_decimal(void **state)
{
    (void)state;
    double s = 7;
    assert_true(glint_config_seconds("0.25", 0, 10, &s));
    assert_true(s == 0.25);
    static const char *const bad[] = {"",    ".",   "-1", "inf",  "nan",
                                      "0x1", "1e1", "1s", "10.1", "1.1.1"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_false(glint_config_seconds(bad[i], 0, 10, &s));
    assert_true(s == 0.25);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lines_are_keys_and_values_without_blanks_and_comments),
        cmocka_unit_test(every_fault_is_named_with_its_line_and_the_rest_is_read),
        cmocka_unit_test(what_is_no_text_is_refused),
        cmocka_unit_test(any_cut_of_a_hostile_file_is_taken_or_refused),
        cmocka_unit_test(a_file_that_everybody_may_write_or_that_is_none_is_refused),
        cmocka_unit_test(numbers_are_read_whole_or_not_at_all),
        cmocka_unit_test(bytes_take_binary_units_and_never_overflow),
        cmocka_unit_test(seconds_are_decimal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
