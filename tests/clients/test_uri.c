#include "clients/cli/uri.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void check_data(const char *uri, const char *bytes, const char *media)
{
    struct glint_blob blob;
    assert_int_equal(glint_uri_read("/", uri, &blob, "", NULL), GLINT_OK);
    assert_int_equal(blob.size, strlen(bytes));
    assert_memory_equal(blob.bytes, bytes, blob.size);
    assert_string_equal(blob.media, media);
    free(blob.bytes);
}

// The vectors of RFC 4648, section 10.
static void base64_of_every_length_is_decoded(void **state)
{
    (void)state;
    check_data("data:;base64,", "", "");
    check_data("data:;base64,Zg==", "f", "");
    check_data("data:;base64,Zm8=", "fo", "");
    check_data("data:;base64,Zm9v", "foo", "");
    check_data("data:;base64,Zm9vYg==", "foob", "");
    check_data("data:;base64,Zm9vYmE=", "fooba", "");
    check_data("data:;base64,Zm9vYmFy", "foobar", "");
}

static void the_media_type_is_told_without_its_parameters(void **state)
{
    (void)state;
    check_data("data:image/png;base64,Zg==", "f", "image/png");
    check_data("DATA:text/plain;charset=utf-8;BASE64,Zg==", "f", "text/plain");
}

static void malformed_data_is_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "data:",
        "data:,",
        "data:;base64",
        "data:;base64,Z",
        "data:;base64,Zg=",
        "data:;base64,Zg",
        "data:;base64,Z===",
        "data:;base64,====",
        "data:;base64,Zg==Zg==",
        "data:;base64,Z g=",
        "data:;base64,Zm9-",
        "data:;base16,00",
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct glint_blob blob;
        assert_int_equal(glint_uri_read("/", bad[i], &blob, "", NULL), GLINT_E_RANGE);
        assert_null(blob.bytes);
    }
}

static void check_decoded(const char *text, const char *expected)
{
    char *decoded = glint_uri_decode(text);
    if (expected)
        assert_string_equal(decoded, expected);
    else
        assert_null(decoded);
    free(decoded);
}

static void escapes_are_two_digits_and_never_zero(void **state)
{
    (void)state;
    check_decoded("a%20b%2Fc%C3%a9", "a b/c\xc3\xa9");
    check_decoded("100%25", "100%");
    check_decoded("%", NULL);
    check_decoded("%4", NULL);
    check_decoded("%4g", NULL);
    check_decoded("a%00b", NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(base64_of_every_length_is_decoded),
        cmocka_unit_test(the_media_type_is_told_without_its_parameters),
        cmocka_unit_test(malformed_data_is_refused),
        cmocka_unit_test(escapes_are_two_digits_and_never_zero),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
