#include "protocol/multipart.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define COUNT(array) (sizeof(array) / sizeof *(array))
#define B "--" GLINT_MULTIPART_BOUNDARY

// What a reader gave, written down.
struct seen {
    unsigned parts;
    struct glint_multipart_head last;
    char text[8192];
    unsigned refuse_after; // parts, 0: never
};

static glint_status note(void *user, const struct glint_multipart_head *head, const uint8_t *body)
{
    struct seen *s = user;
    s->parts++;
    s->last = *head;
    const size_t at = strlen(s->text);
    snprintf(s->text + at, sizeof s->text - at, "[%.*s]", (int)head->length, (const char *)body);
    return s->refuse_after && s->parts >= s->refuse_after ? GLINT_E_IO : GLINT_OK;
}

static glint_multipart_reader *make(struct seen *seen, uint64_t limit)
{
    const struct glint_multipart_params params = {GLINT_MULTIPART_TYPE, limit, note, seen};
    glint_multipart_reader *r;
    assert_int_equal(glint_multipart_reader_create(&r, &params, NULL), GLINT_OK);
    return r;
}

// Feeds `text` in pieces of `step` bytes, each in memory of its own for the sanitizers to guard.
static glint_status feed(glint_multipart_reader *r, const char *text, size_t size, size_t step,
                         struct glint_error *err)
{
    glint_status st = GLINT_OK;
    for (size_t at = 0; !st && at < size; at += step) {
        const size_t bytes = size - at < step ? size - at : step;
        char *piece = malloc(bytes);
        memcpy(piece, text + at, bytes);
        st = glint_multipart_feed(r, piece, bytes, err);
        free(piece);
    }
    return st;
}

static size_t write_stream(char *out, const struct glint_multipart_head *head,
                           const char *const *body, size_t parts)
{
    size_t at = 0;
    for (size_t i = 0; i < parts; i++) {
        struct glint_multipart_head h = *head;
        h.length = strlen(body[i]);
        h.sequence += i;
        at += glint_multipart_write_head(out + at, &h);
        memcpy(out + at, body[i], h.length);
        at += h.length;
    }
    memcpy(out + at, GLINT_MULTIPART_END, strlen(GLINT_MULTIPART_END) + 1);
    return at + strlen(GLINT_MULTIPART_END);
}

static void what_is_written_is_read_wherever_it_is_cut(void **state)
{
    (void)state;
    const struct glint_multipart_head head = {
        "image/x-exr", 0, true, {64, 128, 64, 32}, 16, UINT64_C(1234567890123456789), "abc123"};
    // Bodies that look like structure are only bodies.
    static const char *const body[] = {"one", "", "\r\n" B "--\r\n", "Content-Length: 9\r\n\r\n"};
    char text[8192];
    const size_t size = write_stream(text, &head, body, COUNT(body));
    for (size_t step = 1; step <= size; step = step < 40 ? step + 1 : step * 2) {
        struct seen seen = {0};
        glint_multipart_reader *r = make(&seen, 100);
        assert_false(glint_multipart_ended(r));
        assert_int_equal(feed(r, text, size, step, NULL), GLINT_OK);
        assert_true(glint_multipart_ended(r));
        assert_int_equal(seen.parts, COUNT(body));
        assert_string_equal(seen.text, "[one][][\r\n" B "--\r\n][Content-Length: 9\r\n\r\n]");
        assert_string_equal(seen.last.type, "image/x-exr");
        assert_string_equal(seen.last.revision, "abc123");
        assert_true(seen.last.has_tile);
        assert_memory_equal(seen.last.tile, head.tile, sizeof head.tile);
        assert_true(seen.last.samples == 16);
        assert_true(seen.last.sequence == head.sequence + 3);
        assert_int_equal(glint_multipart_feed(r, "epilogue\0", 9, NULL), GLINT_OK);
        glint_multipart_reader_destroy(&r);
        assert_null(r);
    }
}

static void a_part_is_given_before_the_next_one_starts(void **state)
{
    (void)state;
    struct seen seen = {0};
    glint_multipart_reader *r = make(&seen, 100);
    const char text[] = "\r\n" B "\r\nContent-Length: 2\r\n\r\nhi";
    assert_int_equal(feed(r, text, strlen(text), strlen(text), NULL), GLINT_OK);
    assert_int_equal(seen.parts, 1);
    assert_false(glint_multipart_ended(r));
    glint_multipart_reader_destroy(&r);
}

static void foreign_but_valid_streams_are_read(void **state)
{
    (void)state;
    static const char *const text[] = {
        B "\r\nContent-Length:3\r\n\r\nabc\r\n" B "--",
        "preamble\r\n\r\n" B "  \r\ncontent-LENGTH: \t3\r\nX-Other: 1\r\n\r\nabc\r\n" B "--\r\n",
        "\r\n" B "\r\nContent-Length: 0000000000000000003\r\n\r\nabc\r\n" B "-- \r\nepilogue",
    };
    for (size_t i = 0; i < COUNT(text); i++) {
        struct seen seen = {0};
        glint_multipart_reader *r = make(&seen, 3);
        assert_int_equal(feed(r, text[i], strlen(text[i]), 5, NULL), GLINT_OK);
        assert_string_equal(seen.text, "[abc]");
        assert_false(seen.last.has_tile);
        glint_multipart_reader_destroy(&r);
    }
}

#define HEAD "\r\n" B "\r\n"

static void broken_streams_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        glint_status status;
    } row[] = {
        {HEAD "Content-Type: a/b\r\n\r\nabc", GLINT_E_SYNTAX},
        {HEAD "Content-Length: \r\n\r\n", GLINT_E_SYNTAX},
        {HEAD "Content-Length: -1\r\n\r\n", GLINT_E_SYNTAX},
        {HEAD "Content-Length: +1\r\n\r\n", GLINT_E_SYNTAX},
        {HEAD "Content-Length: 0x3\r\n\r\n", GLINT_E_SYNTAX},
        {HEAD "Content-Length: 3 3\r\n\r\n", GLINT_E_SYNTAX},
        {HEAD "Content-Length: 99999999999999999999\r\n\r\n", GLINT_E_SYNTAX},
        {HEAD "Content-Length: 3\r\nContent-Length: 3\r\n\r\n", GLINT_E_SYNTAX},
        {HEAD "Content-Length: 101\r\n\r\n", GLINT_E_TOO_LARGE},
        {HEAD "Content-Length: 9999999999999999999\r\n\r\n", GLINT_E_TOO_LARGE},
        {HEAD "Content-Length: 3\n\nabc", GLINT_E_SYNTAX},
        {HEAD "no colon\r\n", GLINT_E_SYNTAX},
        {HEAD ": no name\r\n", GLINT_E_SYNTAX},
        {HEAD "Glint-Tile: 1 2 3\r\n", GLINT_E_SYNTAX},
        {HEAD "Glint-Tile: 1 2 3 4 5\r\n", GLINT_E_SYNTAX},
        {HEAD "Glint-Tile: 1 2 3 4294967296\r\n", GLINT_E_SYNTAX},
        {HEAD "Glint-Tile: 1 2 -3 4\r\n", GLINT_E_SYNTAX},
        {HEAD "Glint-Samples: many\r\n", GLINT_E_SYNTAX},
        {HEAD "Content-Type: a\tb\r\n", GLINT_E_SYNTAX},
        {HEAD "Content-Length: 3\r\n\r\nabcd\r\n" B "--\r\n", GLINT_E_SYNTAX},
        {HEAD "Content-Length: 3\r\n\r\nabc\r\nnot the boundary\r\n", GLINT_E_SYNTAX},
        {HEAD "Content-Length: 3\r\n\r\nabc\r\n" B "x\r\n", GLINT_E_SYNTAX},
    };
    for (size_t i = 0; i < COUNT(row); i++)
        for (size_t step = 1; step < 100; step += 33) {
            struct seen seen = {0};
            struct glint_error err = {0};
            glint_multipart_reader *r = make(&seen, 100);
            assert_int_equal(feed(r, row[i].text, strlen(row[i].text), step, &err), row[i].status);
            assert_int_equal(err.count, 1);
            assert_int_equal(glint_multipart_feed(r, "x", 1, NULL), row[i].status);
            assert_false(glint_multipart_ended(r));
            glint_error_finish(&err);
            glint_multipart_reader_destroy(&r);
        }
}

static void endless_heads_and_preambles_are_refused(void **state)
{
    (void)state;
    static const char *const start[] = {"", HEAD, HEAD "X: ", "\r\n"}, *const repeat[] = {
                                                                           "preamble\r\n",
                                                                           "X: y\r\n", "long ",
                                                                           "never a line "};
    for (size_t i = 0; i < COUNT(start); i++) {
        struct seen seen = {0};
        glint_multipart_reader *r = make(&seen, 100);
        glint_status st = feed(r, start[i], strlen(start[i]), 1, NULL);
        unsigned times = 0;
        for (; !st && times < 2000; times++)
            st = glint_multipart_feed(r, repeat[i], strlen(repeat[i]), NULL);
        assert_int_equal(st, GLINT_E_SYNTAX);
        glint_multipart_reader_destroy(&r);
    }
}

static void a_nul_between_parts_is_refused(void **state)
{
    (void)state;
    struct seen seen = {0};
    glint_multipart_reader *r = make(&seen, 100);
    const char text[] = HEAD "Content-Type: a\0b\r\n";
    assert_int_equal(feed(r, text, sizeof text - 1, 7, NULL), GLINT_E_SYNTAX);
    glint_multipart_reader_destroy(&r);
}

static void damaged_streams_do_no_harm(void **state)
{
    (void)state;
    const struct glint_multipart_head head = {.type = "image/x-exr", .has_tile = true};
    static const char *const body[] = {"one", "two", "three"};
    char text[4096];
    const size_t size = write_stream(text, &head, body, COUNT(body));
    uint32_t seed = 3;
    unsigned refused = 0;
    for (int round = 0; round < 20000; round++) {
        char damaged[4096];
        memcpy(damaged, text, size);
        for (int k = 0; k <= round % 4; k++) {
            seed = seed * 1664525u + 1013904223u;
            damaged[(seed >> 4) % size] = "\r\n-: 0129\0\xff"[(seed >> 20) % 11];
        }
        struct seen seen = {0};
        glint_multipart_reader *r = make(&seen, 64);
        refused += feed(r, damaged, size, 1 + seed % 64, NULL) != GLINT_OK;
        assert_in_range(seen.parts, 0, 3);
        glint_multipart_reader_destroy(&r);
    }
    assert_in_range(refused, 5000, 20000);
}

static void a_status_of_the_taker_ends_the_reading(void **state)
{
    (void)state;
    struct seen seen = {.refuse_after = 2};
    const struct glint_multipart_head head = {.type = "a/b"};
    static const char *const body[] = {"1", "2", "3"};
    char text[4096];
    const size_t size = write_stream(text, &head, body, COUNT(body));
    glint_multipart_reader *r = make(&seen, 100);
    assert_int_equal(feed(r, text, size, size, NULL), GLINT_E_IO);
    assert_string_equal(seen.text, "[1][2]");
    glint_multipart_reader_destroy(&r);
}

static void the_boundary_is_found_in_the_content_type(void **state)
{
    (void)state;
    static const struct {
        const char *type;
        glint_status status;
    } row[] = {
        {"multipart/mixed; boundary=abc", GLINT_OK},
        {"Multipart/Mixed;charset=utf-8; Boundary=\"a b:c\"", GLINT_OK},
        {"multipart/mixed;boundary=abc; charset=utf-8", GLINT_OK},
        {"text/plain; boundary=abc", GLINT_E_MEDIA_TYPE},
        {"multipart/mixed", GLINT_E_MEDIA_TYPE},
        {"multipart/mixed;", GLINT_E_MEDIA_TYPE},
        {"multipart/mixed; boundary=", GLINT_E_MEDIA_TYPE},
        {"multipart/mixed; boundary=\"\"", GLINT_E_MEDIA_TYPE},
        {"multipart/mixed; boundary=\"a \"", GLINT_E_MEDIA_TYPE},
        {"multipart/mixed; boundary=a\"b", GLINT_E_MEDIA_TYPE},
        {"multipart/mixed; boundary="
         "71_characters_are_one_more_than_a_boundary_may_have_so_this_is_refused_",
         GLINT_E_MEDIA_TYPE},
        {"", GLINT_E_MEDIA_TYPE},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        const struct glint_multipart_params params = {.content_type = row[i].type};
        glint_multipart_reader *r;
        assert_int_equal(glint_multipart_reader_create(&r, &params, NULL), row[i].status);
        assert_true(!r == !!row[i].status);
        glint_multipart_reader_destroy(&r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_written_is_read_wherever_it_is_cut),
        cmocka_unit_test(a_part_is_given_before_the_next_one_starts),
        cmocka_unit_test(foreign_but_valid_streams_are_read),
        cmocka_unit_test(broken_streams_are_refused),
        cmocka_unit_test(endless_heads_and_preambles_are_refused),
        cmocka_unit_test(a_nul_between_parts_is_refused),
        cmocka_unit_test(damaged_streams_do_no_harm),
        cmocka_unit_test(a_status_of_the_taker_ends_the_reading),
        cmocka_unit_test(the_boundary_is_found_in_the_content_type),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
