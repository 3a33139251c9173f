#include "base/sha256.h"
#include "scene/import_answer.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static int memfd(void)
{
    const int fd = memfd_create("answer", MFD_CLOEXEC);
    assert_true(fd >= 0);
    return fd;
}

// An answer of one asset and two warnings.
static int good_answer(void)
{
    static const uint8_t bytes[5] = {1, 2, 3, 4, 5};
    static char *const warnings[] = {"first", "second"};
    struct glint_asset asset = {.bytes = bytes, .size = sizeof bytes};
    glint_sha256(bytes, sizeof bytes, asset.sha256);
    const struct glint_error none = {0};
    const struct glint_answer a = {.error = &none,
                                   .text = "{}",
                                   .length = 2,
                                   .asset = &asset,
                                   .assets = 1,
                                   .warning = warnings,
                                   .warnings = 2,
                                   .seconds = 0.5};
    const int fd = memfd();
    assert_int_equal(glint_answer_write(fd, &a), GLINT_OK);
    return fd;
}

// FIPS 180-2, appendix B.1.
static void sha256_has_the_published_value(void **state)
{
    (void)state;
    char hex[65];
    glint_sha256("abc", 3, hex);
    assert_string_equal(hex, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

static void what_is_written_is_read(void **state)
{
    (void)state;
    struct glint_import *im;
    struct glint_error err = {0};
    const int fd = good_answer();
    assert_int_equal(glint_answer_read(fd, false, &im, &err), GLINT_OK);
    close(fd);
    assert_string_equal(im->text, "{}");
    assert_int_equal(im->length, 2);
    assert_int_equal(im->warnings, 2);
    assert_string_equal(im->warning[1], "second");
    assert_int_equal(im->assets, 1);
    assert_int_equal(im->asset[0].size, 5);
    assert_memory_equal(im->asset[0].bytes, "\1\2\3\4\5", 5);
    assert_int_equal((uintptr_t)im->asset[0].bytes % 64, 0);
    assert_true(im->seconds == 0.5);
    glint_import_destroy(&im);
    assert_null(im);
}

static void faults_keep_pointer_and_sentence(void **state)
{
    (void)state;
    struct glint_fault faults[] = {{"/a", "is bad"}, {"/b~1c", "is worse"}};
    const struct glint_error said = {.status = GLINT_E_SYNTAX, .count = 2, .fault = faults};
    const struct glint_answer a = {.error = &said};
    struct glint_error err = {0};
    struct glint_import *im;
    const int fd = memfd();
    assert_int_equal(glint_answer_write(fd, &a), GLINT_OK);
    assert_int_equal(glint_answer_read(fd, false, &im, &err), GLINT_E_SYNTAX);
    assert_null(im);
    assert_int_equal(err.status, GLINT_E_SYNTAX);
    assert_int_equal(err.count, 2);
    assert_string_equal(err.fault[1].pointer, "/b~1c");
    assert_string_equal(err.fault[1].detail, "is worse");
    glint_error_finish(&err);
    close(fd);
}

static void a_full_memfd_is_an_error(void **state)
{
    (void)state;
    const struct glint_error none = {0};
    const struct glint_answer a = {.error = &none, .text = "{}", .length = 2};
    const int fd = memfd_create("sealed", MFD_ALLOW_SEALING);
    assert_int_equal(fcntl(fd, F_ADD_SEALS, F_SEAL_GROW), 0);
    assert_int_equal(glint_answer_write(fd, &a), GLINT_E_IO);
    close(fd);
}

// The answer with one byte changed: either refused, or every part lies within the mapping and the
// asset has the bytes that its name says.
static void no_byte_that_a_child_writes_is_trusted(void **state)
{
    (void)state;
    const int good = good_answer();
    uint8_t bytes[1024];
    const ssize_t n = pread(good, bytes, sizeof bytes, 0);
    assert_true(n > 150 && n < (ssize_t)sizeof bytes);
    close(good);
    unsigned refused = 0;
    for (ssize_t i = 0; i < n; i++)
        for (int k = 0; k < 4; k++) {
            static const uint8_t change[] = {0x01, 0x80, 0xff, 0x40};
            struct glint_import *im;
            const int fd = memfd();
            bytes[i] ^= change[k];
            assert_int_equal(pwrite(fd, bytes, (size_t)n, 0), n);
            bytes[i] ^= change[k];
            if (glint_answer_read(fd, false, &im, NULL)) {
                refused++;
            } else {
                char hex[65];
                assert_true(strlen(im->text) == im->length);
                for (size_t w = 0; w < im->warnings; w++)
                    assert_true(strlen(im->warning[w]) < (size_t)n);
                for (size_t a = 0; a < im->assets; a++) {
                    glint_sha256(im->asset[a].bytes, im->asset[a].size, hex);
                    assert_string_equal(hex, im->asset[a].sha256);
                }
                glint_import_destroy(&im);
            }
            close(fd);
        }
    assert_true(refused > 200); // magic, counts, offsets, lengths, names, terminators, the asset
}

static void every_cut_is_refused(void **state)
{
    (void)state;
    const int fd = good_answer();
    off_t n = lseek(fd, 0, SEEK_END);
    while (n-- > 0) {
        struct glint_import *im;
        struct glint_error err = {0};
        assert_int_equal(ftruncate(fd, n), 0);
        assert_int_equal(glint_answer_read(fd, false, &im, &err), GLINT_E_RANGE);
        glint_error_finish(&err);
    }
    close(fd);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sha256_has_the_published_value),
        cmocka_unit_test(what_is_written_is_read),
        cmocka_unit_test(faults_keep_pointer_and_sentence),
        cmocka_unit_test(a_full_memfd_is_an_error),
        cmocka_unit_test(no_byte_that_a_child_writes_is_trusted),
        cmocka_unit_test(every_cut_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
