#include "http/frames.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static glint_frames *frames;

static int start(void **state)
{
    (void)state;
    return glint_frames_create(&frames, 3, 100, NULL);
}

static int stop(void **state)
{
    (void)state;
    glint_frames_destroy(&frames);
    return 0;
}

static void keep(const char *key, size_t size)
{
    struct glint_blob *blob = glint_blob_take(calloc(1, size), size);
    glint_frames_keep(frames, key, blob);
    glint_blob_release(&blob);
}

static bool has(const char *key)
{
    struct glint_blob *blob = glint_frames_find(frames, key);
    const bool found = blob;
    glint_blob_release(&blob);
    return found;
}

static void what_was_not_used_for_longest_goes_first(void **state)
{
    (void)state;
    keep("a", 1);
    keep("b", 1);
    keep("c", 1);
    assert_true(has("a"));
    keep("d", 1);
    assert_true(has("a") && !has("b") && has("c") && has("d"));
}

static void bytes_are_bounded_together(void **state)
{
    (void)state;
    keep("a", 40);
    keep("b", 40);
    keep("c", 70);
    assert_true(!has("a") && !has("b") && has("c"));
    keep("d", 101);
    assert_true(has("c") && !has("d"));
}

static void a_blob_lives_on_with_who_found_it(void **state)
{
    (void)state;
    uint8_t *bytes = malloc(3);
    memcpy(bytes, "abc", 3);
    // SHA-256 of "abc": FIPS 180-2, appendix B.1.
    struct glint_blob *blob = glint_blob_digest(bytes, 3);
    assert_string_equal("\"ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad\"",
                        blob->etag);
    assert_string_equal("sha-256=:ungWv48Bz+pBQUDeXa4iI7ADYaOWF3qctBD/YfIAFa0=:", blob->digest);
    glint_frames_keep(frames, "a", blob);
    glint_blob_release(&blob);
    blob = glint_frames_find(frames, "a");
    keep("b", 100);
    assert_false(has("a"));
    assert_memory_equal("abc", blob->bytes, 3);
    glint_blob_release(&blob);
    assert_null(blob);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(what_was_not_used_for_longest_goes_first, start, stop),
        cmocka_unit_test_setup_teardown(bytes_are_bounded_together, start, stop),
        cmocka_unit_test_setup_teardown(a_blob_lives_on_with_who_found_it, start, stop),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
