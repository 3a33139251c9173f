#include "protocol/json.h"
#include "protocol/text.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dirent.h>
#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct glint_json_limits roomy = {.bytes = 1u << 24, .depth = 64, .values = 1u << 20};

static glint_status check(const char *text)
{
    return glint_json_check(text, strlen(text), &roomy, NULL);
}

static void what_is_not_json_is_refused_with_line_and_column(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "",
        " ",
        "{",
        "[1,]",
        "{\"a\":1,}",
        "{a:1}",
        "01",
        "1.",
        ".5",
        "+1",
        "-",
        "1e",
        "1e+",
        "NaN",
        "Infinity",
        "[1] x",
        "[1]\x01",
        "\"\\x\"",
        "\"\\u12g4\"",
        "\"\\ud800\"",
        "\"\\udc00\\ud800\"",
        "\"\t\"",
        "\"\xff\"",
        "\"\xc0\x80\"",
        "\"\xed\xa0\x80\"",
        "\xef\xbb\xbf{}",
        "tru",
        "nulll",
        "'a'",
        "[1 2]",
        "{\"a\" 1}",
        "{1:2}",
        "\"abc",
        "\"abc\\",
        "0x10",
        "[1}",
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        if (check(bad[i]) != GLINT_E_SYNTAX)
            fail_msg("accepted: %s", bad[i]);
    struct glint_error err = {0};
    const char *text = "{\n  \"a\": 01\n}";
    glint_json_check(text, strlen(text), &roomy, &err);
    assert_string_equal(err.fault[0].detail, "line 2, column 9: a comma or } is expected");
    glint_error_finish(&err);
}

static void what_is_json_is_accepted(void **state)
{
    (void)state;
    static const char *const good[] = {
        "0",
        "-0",
        "-0.5e-3",
        "1E+2",
        "\"\"",
        "\"\\u00e4\\ud83d\\ude00\\n\"",
        " [ ] ",
        "{}",
        "null",
        "[[[]],{\"a\":{}}]",
        "\"\x7f\xf4\x8f\xbf\xbf\"",
        "\t{\r\n\"a\" : true }\n",
    };
    for (size_t i = 0; i < sizeof good / sizeof *good; i++)
        if (check(good[i]) != GLINT_OK)
            fail_msg("refused: %s", good[i]);
}

static void the_byte_after_the_length_is_not_read(void **state)
{
    (void)state;
    static const char *const texts[] = {"[1,2]", "\"abc\"", "true", "{\"a\":-1.5e3}"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        for (size_t n = 0; n < strlen(texts[i]); n++) {
            char *cut = malloc(n ? n : 1); // exact, so that a sanitizer sees a step too far
            memcpy(cut, texts[i], n);
            assert_int_equal(glint_json_check(cut, n, &roomy, NULL), GLINT_E_SYNTAX);
            free(cut);
        }
    }
}

static void limits_hold_before_memory_is_spent(void **state)
{
    (void)state;
    cJSON *tree;
    char deep[200];
    memset(deep, '[', 100);
    memset(deep + 100, ']', 100);
    assert_int_equal(glint_json_parse(&tree, deep, 200, &roomy, NULL), GLINT_E_TOO_LARGE);
    assert_int_equal(glint_json_parse(&tree, deep + 36, 128, &roomy, NULL), GLINT_OK);
    cJSON_Delete(tree);
    const struct glint_json_limits three = {.bytes = 100, .depth = 2, .values = 3};
    assert_int_equal(glint_json_parse(&tree, "[1,2]", 5, &three, NULL), GLINT_OK);
    cJSON_Delete(tree);
    assert_int_equal(glint_json_parse(&tree, "[1,2,3]", 7, &three, NULL), GLINT_E_TOO_LARGE);
    assert_int_equal(glint_json_parse(&tree, "[[[]]]", 6, &three, NULL), GLINT_E_TOO_LARGE);
    assert_int_equal(glint_json_parse(&tree, "[]", 101, &three, NULL), GLINT_E_TOO_LARGE);
    const char *digits = "1000000000000000000000000000000000000000000000000000000000000000";
    assert_int_equal(check(digits), GLINT_E_TOO_LARGE);
    assert_int_equal(check(digits + 1), GLINT_E_SYNTAX); // leading zeros
}

static void a_key_that_appears_twice_is_a_fault_at_its_pointer(void **state)
{
    (void)state;
    cJSON *tree;
    struct glint_error err = {0};
    const char *text = "{\"a\":[{\"x/y\":1,\"x/y\":2}],\"b\":1,\"a\":2}";
    assert_int_equal(glint_json_parse(&tree, text, strlen(text), &roomy, &err), GLINT_E_RANGE);
    assert_null(tree);
    assert_int_equal(err.count, 2);
    assert_string_equal(err.fault[0].pointer, "/a/0/x~1y");
    assert_string_equal(err.fault[1].pointer, "/a");
    glint_error_finish(&err);
    const char *many =
        "{\"a\":1,\"b\":1,\"c\":1,\"d\":1,\"e\":1,\"f\":1,\"g\":1,\"h\":1,\"i\":1,\"c\":1}";
    assert_int_equal(glint_json_parse(&tree, many, strlen(many), &roomy, &err), GLINT_E_RANGE);
    assert_string_equal(err.fault[0].pointer, "/c");
    glint_error_finish(&err);
    const char *escaped = "{\"a\":1,\"\\u0061\":2}";
    assert_int_equal(glint_json_parse(&tree, escaped, strlen(escaped), &roomy, NULL),
                     GLINT_E_RANGE);
}

struct reading {
    cJSON *tree;
    struct glint_error err;
    struct glint_json root;
};

static void start(struct reading *r, const char *text)
{
    *r = (struct reading){0};
    assert_int_equal(glint_json_parse(&r->tree, text, strlen(text), &roomy, &r->err), GLINT_OK);
    r->root = glint_json_root(r->tree, &r->err);
}

static void finish(struct reading *r)
{
    cJSON_Delete(r->tree);
    glint_error_finish(&r->err);
}

static void expect(const struct reading *r, size_t i, const char *pointer, const char *part)
{
    assert_true(i < r->err.count);
    assert_string_equal(r->err.fault[i].pointer, pointer);
    if (!strstr(r->err.fault[i].detail, part))
        fail_msg("\"%s\" does not say \"%s\"", r->err.fault[i].detail, part);
}

static void every_bad_value_is_named_with_its_pointer(void **state)
{
    (void)state;
    struct reading r;
    start(&r, "{\"f\":2,\"u\":1.5,\"b\":0,\"v\":[1,\"x\",9],\"c\":\"no\",\"big\":1e999,\"s\":null,"
              "\"~\":1}");
    float f = 7, v[3] = {0};
    uint32_t u = 7;
    bool b = true;
    double d = 7;
    int c = 7;
    char *s = NULL;
    struct glint_arena arena = {0};
    const struct glint_json *root = &r.root;
    struct glint_json at = glint_json_member(root, "f");
    assert_false(glint_json_float(&at, 0, 1, &f));
    at = glint_json_member(root, "u");
    assert_false(glint_json_uint(&at, 0, 9, &u));
    at = glint_json_member(root, "b");
    assert_false(glint_json_bool(&at, &b));
    at = glint_json_member(root, "v");
    assert_false(glint_json_floats(&at, 3, 0, 5, v));
    at = glint_json_member(root, "c");
    assert_false(glint_json_choice(&at, (const char *const[]){"yes", "maybe", NULL}, &c));
    at = glint_json_member(root, "big");
    assert_false(glint_json_double(&at, 0, DBL_MAX, &d));
    at = glint_json_member(root, "s");
    assert_false(glint_json_string(&at, &arena, &s));
    assert_false(
        glint_json_only(root, (const char *const[]){"f", "u", "b", "v", "c", "big", "s", NULL}));
    assert_int_equal(r.err.count, 9);
    expect(&r, 0, "/f", "2 is outside of 0 to 1");
    expect(&r, 1, "/u", "integer");
    expect(&r, 2, "/b", "boolean");
    expect(&r, 3, "/v/1", "a number is expected, not a string");
    expect(&r, 4, "/v/2", "9 is outside");
    expect(&r, 5, "/c", "yes, maybe");
    expect(&r, 6, "/big", "too large");
    expect(&r, 7, "/s", "not null");
    expect(&r, 8, "/~0", "no member \"~\"");
    assert_true(f == 7 && u == 7 && b && d == 7 && c == 7 && !s);
    glint_arena_finish(&arena);
    finish(&r);
}

static void bounds_are_told_as_they_were_written(void **state)
{
    (void)state;
    struct reading r;
    start(&r, "{\"yfov\":4}");
    const struct glint_json at = glint_json_member(&r.root, "yfov");
    float f = 7;
    double d = 7;
    assert_false(glint_json_float(&at, 1e-6f, 3.1415925f, &f));
    assert_false(glint_json_double(&at, 0.01, 2.5, &d));
    assert_string_equal(r.err.fault[0].detail, "4 is outside of 1e-06 to 3.1415925");
    assert_string_equal(r.err.fault[1].detail, "4 is outside of 0.01 to 2.5");
    finish(&r);
}

static void an_absent_value_leaves_the_default(void **state)
{
    (void)state;
    struct reading r;
    start(&r, "{\"a\":1}");
    const struct glint_json at = glint_json_member(&r.root, "b"),
                            under = glint_json_member(&at, "c");
    float f = 7, v[3] = {7, 7, 7};
    assert_true(glint_json_float(&at, 0, 1, &f) && glint_json_floats(&under, 3, 0, 1, v));
    assert_true(f == 7 && v[2] == 7);
    assert_false(glint_json_require(&under));
    expect(&r, 0, "/b/c", "required");
    finish(&r);
}

static void integers_hold_to_their_bounds(void **state)
{
    (void)state;
    struct reading r;
    start(&r, "[4294967295, 4294967296, -2147483648, 1e1, -1]");
    uint32_t u = 0;
    int32_t i = 0;
    struct glint_json at[5];
    size_t n = 0;
    for (const cJSON *c = r.tree->child; c; c = c->next, n++)
        at[n] = glint_json_item(&r.root, c, n);
    assert_true(glint_json_uint(&at[0], 0, UINT32_MAX, &u) && u == UINT32_MAX);
    assert_false(glint_json_uint(&at[1], 0, UINT32_MAX, &u));
    assert_true(glint_json_int(&at[2], INT32_MIN, INT32_MAX, &i) && i == INT32_MIN);
    assert_true(glint_json_uint(&at[3], 0, 10, &u) && u == 10);
    assert_false(glint_json_uint(&at[4], 0, 10, &u));
    finish(&r);
}

static void written_floats_read_back_and_are_short(void **state)
{
    (void)state;
    static const struct {
        float value;
        const char *text;
    } cases[] = {
        {0.1f, "0.1"},
        {1, "1"},
        {-0.0f, "-0"},
        {16777216, "16777216"},
        {1e10f, "1e+10"},
        {0.333333343f, "0.33333334"},
        {3.14159274f, "3.1415927"},
        {FLT_MAX, "3.4028235e+38"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct glint_text t = {0};
        glint_text_float(&t, cases[i].value);
        char *text = glint_text_take(&t, NULL);
        assert_string_equal(text, cases[i].text);
        free(text);
    }
    uint32_t bits = 1;
    for (int i = 0; i < 20000; i++) {
        float value;
        bits = bits * 1664525u + 1013904223u;
        if ((bits >> 23 & 255) == 255)
            continue;
        memcpy(&value, &bits, 4);
        struct glint_text t = {0};
        glint_text_float(&t, value);
        char *text = glint_text_take(&t, NULL);
        assert_true((float)strtod(text, NULL) == value);
        free(text);
    }
}

static void written_text_parses_to_what_was_written(void **state)
{
    (void)state;
    struct glint_text t = {0};
    glint_text_add(&t, "{");
    glint_text_key(&t, "a\"b\\\n\x01");
    glint_text_string(&t, "tab\t \xc3\xa4 \xff end");
    glint_text_key(&t, "v");
    glint_text_floats(&t, (const float[]){1, 2.5f}, 2);
    glint_text_add(&t, "}");
    size_t length;
    char *text = glint_text_take(&t, &length);
    struct reading r;
    start(&r, text);
    assert_int_equal(length, strlen(text));
    assert_string_equal(r.tree->child->string, "a\"b\\\n\x01");
    assert_string_equal(r.tree->child->valuestring, "tab\t \xc3\xa4 \xef\xbf\xbd end");
    assert_true(r.tree->child->next->child->next->valuedouble == 2.5);
    finish(&r);
    free(text);
}

static char *slurp(const char *path, size_t *length)
{
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    char *bytes = malloc(1u << 20);
    *length = fread(bytes, 1, 1u << 20, f);
    fclose(f);
    return bytes;
}

// Stricter than the grammar on purpose: a key twice, U+0000, a number of more than 63 characters.
static bool refused_on_purpose(const char *name)
{
    return strstr(name, "duplicated_key") || strstr(name, "null_escape") ||
           strstr(name, "double_close_to_zero");
}

// y_ must be accepted, n_ refused, i_ may be either.
static void check_vector(const char *folder, const char *name)
{
    char path[2048];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    size_t length;
    char *text = slurp(path, &length);
    cJSON *tree;
    const glint_status status = glint_json_parse(&tree, text, length, &roomy, NULL);
    if (name[0] == 'y' && (status != GLINT_OK) != refused_on_purpose(name))
        fail_msg("wrong about: %s", name);
    if (name[0] == 'n' && !status)
        fail_msg("accepted: %s", name);
    cJSON_Delete(tree);
    free(text);
}

static void the_public_test_suite_agrees(void **state)
{
    (void)state;
    const char *scenes = getenv("GLINT_SCENES");
    char folder[900];
    snprintf(folder, sizeof folder, "%s/hostile/json", scenes ? scenes : "../shared/scenes");
    DIR *dir = opendir(folder);
    if (!dir)
        skip();
    for (struct dirent *e; (e = readdir(dir));)
        if (strchr("yni", e->d_name[0]) && e->d_name[1] == '_')
            check_vector(folder, e->d_name);
    closedir(dir);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_not_json_is_refused_with_line_and_column),
        cmocka_unit_test(what_is_json_is_accepted),
        cmocka_unit_test(the_byte_after_the_length_is_not_read),
        cmocka_unit_test(limits_hold_before_memory_is_spent),
        cmocka_unit_test(a_key_that_appears_twice_is_a_fault_at_its_pointer),
        cmocka_unit_test(every_bad_value_is_named_with_its_pointer),
        cmocka_unit_test(bounds_are_told_as_they_were_written),
        cmocka_unit_test(an_absent_value_leaves_the_default),
        cmocka_unit_test(integers_hold_to_their_bounds),
        cmocka_unit_test(written_floats_read_back_and_are_short),
        cmocka_unit_test(written_text_parses_to_what_was_written),
        cmocka_unit_test(the_public_test_suite_agrees),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
