#include "clients/cli/sse.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

// What came out: "name=data" for each event, with '|' between them.
struct record {
    char text[512];
    int left; // events until it has had enough
};

static bool take(void *user, const char *name, const char *data)
{
    struct record *r = user;
    const size_t n = strlen(r->text);
    snprintf(r->text + n, sizeof r->text - n, "%s%s=%s", n ? "|" : "", name, data);
    return --r->left > 0;
}

// Feeds the text in pieces of `step` bytes.
static bool feed(struct glint_sse *sse, const char *text, size_t step)
{
    for (size_t at = 0, length = strlen(text); at < length; at += step)
        if (!glint_sse_feed(sse, text + at, length - at < step ? length - at : step))
            return false;
    return true;
}

static void check(const char *text, const char *events, const char *id)
{
    for (size_t step = 1; step <= strlen(text); step++) {
        struct record r = {.left = 99};
        struct glint_sse sse = {.event = take, .user = &r};
        assert_true(feed(&sse, text, step));
        assert_string_equal(r.text, events);
        assert_string_equal(sse.id, id);
        glint_sse_finish(&sse);
    }
}

static void events_come_out_whole_however_the_bytes_come_in(void **state)
{
    (void)state;
    check("event: a\ndata: 1\n\nevent: b\ndata: 2\n\n", "a=1|b=2", "");
}

static void every_line_ending_ends_a_line(void **state)
{
    (void)state;
    check("data: 1\r\rdata: 2\r\n\r\ndata: 3\n\n", "message=1|message=2|message=3", "");
}

static void lines_of_data_are_joined(void **state)
{
    (void)state;
    check("data: a\ndata\ndata:b\ndata:  c\n\n", "message=a\n\nb\n c", "");
}

static void comments_unknown_fields_and_events_without_data_are_nothing(void **state)
{
    (void)state;
    check(": ping\n\nretry: 2000\ncolour: red\n\nevent: x\n\n:\ndata: 1\n\n", "message=1", "");
}

static void the_id_is_that_of_the_last_whole_event(void **state)
{
    (void)state;
    check("id: 7\ndata: a\n\ndata: b\n\nid: 8\ndata: c\n", "message=a|message=b", "7");
}

static void a_restart_forgets_the_half_event_and_keeps_the_id(void **state)
{
    (void)state;
    struct record r = {.left = 99};
    struct glint_sse sse = {.event = take, .user = &r};
    assert_true(feed(&sse, "id: 7\ndata: a\n\nid: 8\nevent: half\ndata: b\nda", 3));
    glint_sse_restart(&sse);
    assert_true(feed(&sse, "data: c\n\n", 3));
    assert_string_equal(r.text, "message=a|message=c");
    assert_string_equal(sse.id, "7");
    glint_sse_finish(&sse);
}

static void the_reader_may_have_enough(void **state)
{
    (void)state;
    struct record r = {.left = 1};
    struct glint_sse sse = {.event = take, .user = &r};
    assert_false(feed(&sse, "data: 1\n\ndata: 2\n\n", 100));
    assert_string_equal(r.text, "message=1");
    glint_sse_finish(&sse);
}

static void an_endless_line_or_event_is_refused(void **state)
{
    (void)state;
    struct glint_sse sse = {.event = take};
    char *line = malloc(GLINT_SSE_LINE + 1);
    assert_non_null(line);
    memset(line, 'x', GLINT_SSE_LINE + 1);
    assert_true(glint_sse_feed(&sse, line, GLINT_SSE_LINE));
    assert_false(glint_sse_feed(&sse, line, 1));
    glint_sse_finish(&sse);

    sse = (struct glint_sse){.event = take};
    memcpy(line, "data:", 5);
    line[GLINT_SSE_LINE / 2] = '\n';
    assert_true(glint_sse_feed(&sse, line, GLINT_SSE_LINE / 2 + 1));
    assert_true(glint_sse_feed(&sse, line, GLINT_SSE_LINE / 2 + 1));
    assert_false(glint_sse_feed(&sse, line, GLINT_SSE_LINE / 2 + 1));
    glint_sse_finish(&sse);
    free(line);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(events_come_out_whole_however_the_bytes_come_in),
        cmocka_unit_test(every_line_ending_ends_a_line),
        cmocka_unit_test(lines_of_data_are_joined),
        cmocka_unit_test(comments_unknown_fields_and_events_without_data_are_nothing),
        cmocka_unit_test(the_id_is_that_of_the_last_whole_event),
        cmocka_unit_test(a_restart_forgets_the_half_event_and_keeps_the_id),
        cmocka_unit_test(the_reader_may_have_enough),
        cmocka_unit_test(an_endless_line_or_event_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
