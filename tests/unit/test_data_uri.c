#include "scene/data_uri.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

static void expect(const char *uri, const char *bytes, size_t length)
{
    uint8_t *out;
    size_t size;
    if (glint_data_uri_decode(uri, &out, &size, "", NULL))
        fail_msg("refused: %s", uri);
    assert_int_equal(size, length);
    assert_memory_equal(out, bytes, length);
    free(out);
}

// RFC 4648, section 10.
static void base64_has_the_published_test_vectors(void **state)
{
    (void)state;
    expect("data:;base64,", "", 0);
    expect("data:;base64,Zg==", "f", 1);
    expect("data:;base64,Zm8=", "fo", 2);
    expect("data:;base64,Zm9v", "foo", 3);
    expect("data:;base64,Zm9vYg==", "foob", 4);
    expect("data:;base64,Zm9vYmE=", "fooba", 5);
    expect("data:;base64,Zm9vYmFy", "foobar", 6);
    expect("data:;base64,+/+/", "\xfb\xff\xbf", 3);
}

static void padding_and_media_type_are_optional(void **state)
{
    (void)state;
    expect("data:;base64,Zm8", "fo", 2);
    expect("DATA:image/png;charset=x;BASE64,Zg", "f", 1);
    expect("data:,a%20b%2C", "a b,", 4);
    expect("data:text/plain,%00", "\0", 1);
}

static void what_does_not_belong_is_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "",
        "data:",
        "data:;base64",
        "http://x/,",
        "file.png",
        "data:;base64,Z",
        "data:;base64,Zg=",
        "data:;base64,Zg===",
        "data:;base64,Z=g=",
        "data:;base64,Zm 9v",
        "data:;base64,Zm9v\n",
        "data:;base64,Zm-_",
        "data:;base64,====",
        "data:,%",
        "data:,%1",
        "data:,%1g",
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct glint_error err = {0};
        uint8_t *out;
        size_t size;
        if (glint_data_uri_decode(bad[i], &out, &size, "/images/a/data", &err) != GLINT_E_RANGE)
            fail_msg("accepted: %s", bad[i]);
        assert_string_equal(err.fault[0].pointer, "/images/a/data");
        glint_error_finish(&err);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(base64_has_the_published_test_vectors),
        cmocka_unit_test(padding_and_media_type_are_optional),
        cmocka_unit_test(what_does_not_belong_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
