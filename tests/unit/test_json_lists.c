#include "protocol/json_lists.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const keys[] = {"p", "q", NULL};
static const struct glint_json_limits listed = {
    .bytes = 1u << 22, .depth = 8, .values = 1u << 18, .lists = keys};
static const struct glint_json_limits plain = {.bytes = 1u << 22, .depth = 8, .values = 1u << 18};

static cJSON *parse(const char *text, const struct glint_json_limits *limits)
{
    cJSON *tree;
    assert_int_equal(glint_json_parse(&tree, text, strlen(text), limits, NULL), GLINT_OK);
    return tree;
}

static void arrays_of_numbers_alone_under_these_keys_become_text(void **state)
{
    (void)state;
    const char *text = "{\"p\":[1, 2.5e3,\n-0],\"r\":[1,2],\"q\":[[3],[4]],\"o\":{\"q\":[5],"
                       "\"p\":{\"q\":7,\"p\":[]}},\"l\":[{\"p\":1},[8],{\"p\":[9]}],"
                       "\"\\u0070\\u0070\":[1],\"a\":{\"\\u0070\":[2],\"q\":[3,\"x\"]},\"q2\":[4]}";
    cJSON *tree = parse(text, &listed);
    char *printed = cJSON_PrintUnformatted(tree);
    assert_string_equal(printed,
                        "{\"p\":[1, 2.5e3,\n-0],\"r\":[1,2],\"q\":[[3],[4]],\"o\":{\"q\":[5],"
                        "\"p\":{\"q\":7,\"p\":[]}},\"l\":[{\"p\":1},[8],{\"p\":[9]}],"
                        "\"pp\":[1],\"a\":{\"p\":[2],\"q\":[3,\"x\"]},\"q2\":[4]}");
    const cJSON *o = cJSON_GetObjectItem(tree, "o"), *l = cJSON_GetObjectItem(tree, "l"),
                *a = cJSON_GetObjectItem(tree, "a");
    assert_true(cJSON_IsRaw(cJSON_GetObjectItem(tree, "p")));
    assert_true(cJSON_IsRaw(cJSON_GetObjectItem(o, "q")));
    assert_true(cJSON_IsRaw(cJSON_GetObjectItem(cJSON_GetArrayItem(l, 2), "p")));
    assert_true(cJSON_IsArray(cJSON_GetObjectItem(tree, "r")));
    assert_true(cJSON_IsArray(cJSON_GetObjectItem(tree, "q")));
    assert_true(cJSON_IsArray(cJSON_GetObjectItem(tree, "q2")));
    assert_true(cJSON_IsArray(cJSON_GetObjectItem(cJSON_GetObjectItem(o, "p"), "p")));
    assert_true(cJSON_IsArray(cJSON_GetArrayItem(l, 1)));
    assert_true(cJSON_IsArray(cJSON_GetObjectItem(a, "p"))); // as the key is written
    assert_true(cJSON_IsArray(cJSON_GetObjectItem(a, "q")));
    cJSON *copy = cJSON_Duplicate(tree, true);
    assert_true(cJSON_Compare(tree, copy, true));
    cJSON_Delete(copy);
    cJSON_free(printed);
    cJSON_Delete(tree);
}

static void what_is_refused_is_refused_in_lists_with_the_same_words(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "{\"p\":[1,]}",
        "{\"p\":[01]}",
        "{\"p\":[1 2]}",
        "{\"p\":[1,2",
        "{\"p\":[-]}",
        "{\"p\":[1.]}",
        "{\"p\":[1],\"p\":[2]}",
        "{\"p\":[1e]}",
        "{\"p\":[1]]}",
        "[[[[[[[[[1]]]]]]]]]",
        "{\"q\":{\"q\":[1],\"q\":1}}",
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct glint_error with = {0}, without = {0};
        cJSON *tree;
        assert_int_not_equal(glint_json_parse(&tree, bad[i], strlen(bad[i]), &listed, &with), 0);
        assert_int_not_equal(glint_json_parse(&tree, bad[i], strlen(bad[i]), &plain, &without), 0);
        assert_int_equal(with.status, without.status);
        assert_string_equal(glint_error_text(&with), glint_error_text(&without));
        glint_error_finish(&with);
        glint_error_finish(&without);
    }
    cJSON *tree;
    const struct glint_json_limits three = {.bytes = 100, .depth = 2, .values = 3, .lists = keys};
    assert_int_equal(glint_json_parse(&tree, "{\"p\":[1]}", 9, &three, NULL), GLINT_OK);
    cJSON_Delete(tree);
    assert_int_equal(glint_json_parse(&tree, "{\"p\":[1,2]}", 11, &three, NULL), GLINT_E_TOO_LARGE);
}

static uint64_t next(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return *seed >> 33;
}

// A number as somebody may write it: up to 20 digits, a point anywhere, now and then an exponent.
static int random_number(char out[64], uint64_t *seed)
{
    char digits[24];
    const int count = 1 + (int)(next(seed) % 20), point = (int)(next(seed) % 22);
    for (int i = 0; i < count; i++)
        digits[i] = (char)('0' + next(seed) % 10);
    digits[count] = '\0';
    digits[0] = digits[0] == '0' ? '1' : digits[0];
    const char *sign = next(seed) % 2 ? "-" : "";
    int n;
    if (point == 0)
        n = sprintf(out, "%s0.%s", sign, digits);
    else if (point < count)
        n = sprintf(out, "%s%.*s.%s", sign, point, digits, digits + point);
    else
        n = sprintf(out, "%s%s", sign, digits);
    if (next(seed) % 8 == 0)
        n += sprintf(out + n, "%c%d", next(seed) % 2 ? 'e' : 'E', (int)(next(seed) % 640) - 320);
    return n;
}

static char *random_list(size_t count)
{
    static const char *const special[] = {"0",
                                          "-0",
                                          "-0.0",
                                          "0.000",
                                          "9007199254740992",
                                          "9007199254740993",
                                          "1e400",
                                          "1e-400",
                                          "0.1",
                                          "4e-324",
                                          "9007199254740991.5",
                                          "0.00000000000000000000000001",
                                          "123456789012345678",
                                          "999999999999999999",
                                          "0.1234567890123456",
                                          "1E+2",
                                          "5e-05"};
    const size_t specials = sizeof special / sizeof *special;
    char *text = malloc(count * 66 + 16), *at = text + sprintf(text, "{\"p\":[");
    uint64_t seed = 1;
    assert_non_null(text);
    for (size_t i = 0; i < count; i++) {
        at += i ? sprintf(at, i % 3 ? "," : " ,\t\r\n") : 0;
        at += i < specials ? sprintf(at, "%s", special[i]) : random_number(at, &seed);
    }
    sprintf(at, "]}");
    return text;
}

static void a_list_has_the_very_doubles_that_strtod_gives(void **state)
{
    (void)state;
    enum { COUNT = 50000 };
    char *text = random_list(COUNT);
    cJSON *tree = parse(text, &listed);
    const struct glint_json root = glint_json_root(tree, NULL), at = glint_json_member(&root, "p");
    size_t length = 0, i = 0;
    assert_true(cJSON_IsRaw(at.value) && glint_json_length(&at, &length));
    assert_int_equal(length, COUNT);
    const char *from = text + 6;
    struct glint_json_walk walk = glint_json_walk(at.value);
    for (const cJSON *c; (c = glint_json_next(&walk)); i++) {
        char *end;
        const double expected = strtod(from, &end);
        if (memcmp(&expected, &c->valuedouble, sizeof expected) != 0)
            fail_msg("%.*s became %.17g", (int)(end - from), from, c->valuedouble);
        from = end + strspn(end, " ,\t\r\n");
    }
    assert_int_equal(i, COUNT);
    cJSON_Delete(tree);
    free(text);
}

static void readers_find_in_a_list_what_they_find_in_an_array(void **state)
{
    (void)state;
    const char *text = "{\"p\":[1,2.5,3e9,1e999,-4,0.1]}";
    const struct glint_json_limits *limits[2] = {&plain, &listed};
    struct glint_error err[2] = {{0}, {0}};
    float floats[2][6] = {{0}};
    uint32_t uints[2][6] = {{0}};
    for (int k = 0; k < 2; k++) {
        cJSON *tree = parse(text, limits[k]);
        const struct glint_json root = glint_json_root(tree, &err[k]);
        const struct glint_json at = glint_json_member(&root, "p");
        assert_int_equal(cJSON_IsRaw(at.value), k);
        assert_false(glint_json_floats(&at, 6, -3, 1e10f, floats[k]));
        assert_false(glint_json_uints(&at, 6, 0, 100, uints[k]));
        assert_false(glint_json_floats(&at, 5, 0, 1, floats[k]));
        double one = 7;
        assert_false(glint_json_double(&at, 0, 1, &one));
        cJSON_Delete(tree);
    }
    assert_memory_equal(floats[0], floats[1], sizeof floats[0]);
    assert_memory_equal(uints[0], uints[1], sizeof uints[0]);
    assert_true(floats[1][5] == 0.1f && uints[1][0] == 1);
    assert_int_equal(err[0].count, err[1].count);
    assert_int_equal(err[1].count, 9);
    for (size_t i = 0; i < err[0].count; i++) {
        assert_string_equal(err[0].fault[i].pointer, err[1].fault[i].pointer);
        assert_string_equal(err[0].fault[i].detail, err[1].fault[i].detail);
    }
    assert_string_equal(err[1].fault[0].pointer, "/p/3");
    glint_error_finish(&err[0]);
    glint_error_finish(&err[1]);
}

static void every_cut_of_a_text_with_lists_is_refused(void **state)
{
    (void)state;
    const char *text = "{\"p\":[1,-2.5,3e9],\"o\":[{\"q\":[0.25]}]}";
    for (size_t n = 0; n < strlen(text); n++) {
        char *cut = malloc(n ? n : 1); // so that a read past it is seen
        cJSON *tree;
        memcpy(cut, text, n);
        assert_int_equal(glint_json_parse(&tree, cut, n, &listed, NULL), GLINT_E_SYNTAX);
        free(cut);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arrays_of_numbers_alone_under_these_keys_become_text),
        cmocka_unit_test(what_is_refused_is_refused_in_lists_with_the_same_words),
        cmocka_unit_test(a_list_has_the_very_doubles_that_strtod_gives),
        cmocka_unit_test(readers_find_in_a_list_what_they_find_in_an_array),
        cmocka_unit_test(every_cut_of_a_text_with_lists_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
