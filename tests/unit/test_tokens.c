#include "base/tokens.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

// SHA-256 of "abc", FIPS 180-4, and of the empty text.
#define ABC "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
#define EMPTY "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"

static glint_status parse(glint_tokens *tokens, const char *text, struct glint_error *err)
{
    return glint_tokens_parse(tokens, "f", text, strlen(text), err);
}

static int make(void **state)
{
    return glint_tokens_create((glint_tokens **)state, NULL);
}

static int drop(void **state)
{
    glint_tokens_destroy((glint_tokens **)state);
    return 0;
}

static void a_token_is_known_by_its_sha256(void **state)
{
    char name[GLINT_CLIENT_BYTES];
    assert_int_equal(glint_tokens_find(*state, "abc", name), GLINT_SCOPE_NONE);
    assert_int_equal(parse(*state, "# who\n\n alice \t submit " ABC "\r\n", NULL), GLINT_OK);
    assert_int_equal(glint_tokens_count(*state), 1);
    assert_int_equal(glint_tokens_find(*state, "abc", name), GLINT_SCOPE_SUBMIT);
    assert_string_equal(name, "alice");
    assert_int_equal(glint_tokens_find(*state, "abd", name), GLINT_SCOPE_NONE);
    assert_int_equal(glint_tokens_find(*state, "", name), GLINT_SCOPE_NONE);
    assert_int_equal(glint_tokens_find(*state, ABC, name), GLINT_SCOPE_NONE);
    assert_string_equal(name, "");
}

static void a_drawn_token_is_good_with_its_line(void **state)
{
    char secret[2][GLINT_TOKEN_BYTES], line[GLINT_TOKEN_LINE_BYTES], name[GLINT_CLIENT_BYTES];
    for (int i = 0; i < 2; i++)
        assert_int_equal(glint_token_draw(secret[i], line, "farm.1@x", GLINT_SCOPE_ADMIN, NULL),
                         GLINT_OK);
    assert_string_not_equal(secret[0], secret[1]);
    assert_null(strstr(line, secret[1] + 6));
    assert_int_equal(parse(*state, line, NULL), GLINT_OK);
    assert_int_equal(glint_tokens_find(*state, secret[1], name), GLINT_SCOPE_ADMIN);
    assert_string_equal(name, "farm.1@x");
    assert_int_equal(glint_tokens_find(*state, secret[0], name), GLINT_SCOPE_NONE);
    assert_int_equal(glint_token_draw(secret[0], line, "two words", GLINT_SCOPE_READ, NULL),
                     GLINT_E_RANGE);
}

static void every_fault_is_named_and_the_tokens_before_stay(void **state)
{
    static const char text[] = "alice submit " ABC "\n"
                               "alice submit\n"
                               "alice submit " ABC " more\n"
                               "al/ice submit " EMPTY "\n"
                               "alice write " EMPTY "\n"
                               "alice submit ABC\n"
                               "alice submit " EMPTY "0\n"
                               "bob read " ABC "\n"
                               "!!! root not-a-digest\n";
    char name[GLINT_CLIENT_BYTES];
    struct glint_error err = {0};
    assert_int_equal(parse(*state, "bob read " ABC "\n", NULL), GLINT_OK);
    assert_int_equal(parse(*state, text, &err), GLINT_E_RANGE);
    static const unsigned line[] = {2, 3, 4, 5, 6, 7, 8, 9, 9, 9};
    assert_int_equal(err.count, 10);
    for (size_t i = 0; i < 10; i++) {
        char where[8];
        snprintf(where, sizeof where, "f:%u: ", line[i]);
        assert_memory_equal(err.fault[i].detail, where, strlen(where));
    }
    glint_error_finish(&err);
    assert_int_equal(glint_tokens_find(*state, "abc", name), GLINT_SCOPE_READ);
    assert_string_equal(name, "bob");
}

// Somebody may have written the token where its digest belongs.
static void a_fault_does_not_repeat_what_may_be_a_secret(void **state)
{
    struct glint_error err = {0};
    assert_int_equal(parse(*state, "alice submit glint_0123456789\n", &err), GLINT_E_RANGE);
    assert_null(strstr(err.fault[0].detail, "0123456789"));
    glint_error_finish(&err);
}

static void no_token_too_many_and_no_text_are_refused(void **state)
{
    assert_int_equal(parse(*state, "", NULL), GLINT_E_RANGE);
    assert_int_equal(parse(*state, "# nobody\n", NULL), GLINT_E_RANGE);
    assert_int_equal(glint_tokens_parse(*state, "f", "a read " ABC "\0", 72, NULL), GLINT_E_RANGE);
    char *text = malloc((GLINT_MAX_TOKENS + 1) * 80 + 1);
    size_t length = 0;
    for (unsigned i = 0; i <= GLINT_MAX_TOKENS; i++) {
        if (i == GLINT_MAX_TOKENS)
            assert_int_equal(parse(*state, text, NULL), GLINT_OK);
        length += (size_t)sprintf(text + length, "a read %064x\n", i);
    }
    assert_int_equal(parse(*state, text, NULL), GLINT_E_RANGE);
    assert_int_equal(glint_tokens_count(*state), GLINT_MAX_TOKENS);
    free(text);
}

static void any_cut_of_a_file_is_taken_or_refused(void **state)
{
    static const char text[] = "\n\t \r\na read " ABC "\nb \xff " EMPTY "\n#\nc admin";
    for (size_t to = 0; to < sizeof text; to++) {
        char *exact = malloc(to + 1);
        memcpy(exact, text, to);
        glint_tokens_parse(*state, "f", exact, to, NULL);
        free(exact);
    }
}

static void names_are_short_and_plain(void **state)
{
    (void)state;
    char longest[GLINT_CLIENT_BYTES + 1];
    memset(longest, 'a', sizeof longest);
    longest[GLINT_CLIENT_BYTES - 1] = '\0';
    assert_true(glint_client_name_valid(longest));
    longest[GLINT_CLIENT_BYTES - 1] = 'a';
    longest[GLINT_CLIENT_BYTES] = '\0';
    assert_false(glint_client_name_valid(longest));
    assert_true(glint_client_name_valid("a.B-9_@x"));
    static const char *const bad[] = {"", " ", "a b", "a\n", "a/b", "\xc3\xa4", "a\"b"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_false(glint_client_name_valid(bad[i]));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_token_is_known_by_its_sha256, make, drop),
        cmocka_unit_test_setup_teardown(a_drawn_token_is_good_with_its_line, make, drop),
        cmocka_unit_test_setup_teardown(every_fault_is_named_and_the_tokens_before_stay, make,
                                        drop),
        cmocka_unit_test_setup_teardown(a_fault_does_not_repeat_what_may_be_a_secret, make, drop),
        cmocka_unit_test_setup_teardown(no_token_too_many_and_no_text_are_refused, make, drop),
        cmocka_unit_test_setup_teardown(any_cut_of_a_file_is_taken_or_refused, make, drop),
        cmocka_unit_test(names_are_short_and_plain),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
