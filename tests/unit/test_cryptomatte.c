#include "protocol/cryptomatte.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cjson/cJSON.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define COUNT(array) (sizeof(array) / sizeof *(array))

static void murmur3_gives_its_published_vectors(void **state)
{
    (void)state;
    static const struct {
        const char *bytes;
        size_t length;
        uint32_t seed, hash;
    } row[] = {
        {"", 0, 0, 0},
        {"", 0, 1, 0x514e28b7},
        {"", 0, 0xffffffff, 0x81f16f39},
        {"\xff\xff\xff\xff", 4, 0, 0x76293b50},
        {"\x21\x43\x65\x87", 4, 0, 0xf55b516b},
        {"\x21\x43\x65\x87", 4, 0x5082edee, 0x2362f9de},
        {"\x21\x43\x65", 3, 0, 0x7e4a8634},
        {"\x21\x43", 2, 0, 0xa0f7b07a},
        {"\x21", 1, 0, 0x72661cf4},
        {"\0\0\0", 3, 0, 0x85f0b427},
        {"The quick brown fox jumps over the lazy dog", 43, 0, 0x2e4ff723},
    };
    for (size_t i = 0; i < COUNT(row); i++)
        assert_int_equal(glint_murmur3_32(row[i].bytes, row[i].length, row[i].seed), row[i].hash);
}

static void names_hash_as_the_specification_and_its_samples(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        uint32_t raw, stored;
        float value;
    } row[] = {
        {"bunny", 0x13851a76, 0x13851a76, 3.36000126e-27f},
        {"default", 0x42c9679f, 0x42c9679f, 100.702385f},
        {"torus", 0xf19c73fd, 0xf19c73fd, -1.54943625e+30f},
        {"равнина", 0x9623511e, 0x9623511e, -1.31926312e-25f},
        {"name, with, comma", 0x62fa4db8, 0x62fa4db8, 2.30864312e+21f},
        {"name containing a \"quote\"  ", 0xaf8bfa09, 0xaf8bfa09, -2.54616134e-10f},
        {"flowerA.flowerA_petal11.:778", 0x000586a5, 0x008586a5, 1.22624223e-38f},
        {"flowerA.flowerA_petal1.:1065", 0x7f8e5296, 0x7f0e5296, 1.89179186e+38f},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        const uint32_t id = glint_cryptomatte_id(row[i].name);
        float value;
        memcpy(&value, &id, sizeof value);
        assert_int_equal(glint_murmur3_32(row[i].name, strlen(row[i].name), 0), row[i].raw);
        assert_int_equal(id, row[i].stored);
        assert_true(value == row[i].value);
    }
    assert_int_equal(glint_cryptomatte_id("torus"), 4053562365u);
    assert_int_equal(glint_cryptomatte_id(""), glint_cryptomatte_id("default"));
}

static void every_id_is_a_normal_float(void **state)
{
    (void)state;
    unsigned repaired = 0;
    for (unsigned i = 0; i < 100000; i++) {
        char name[16];
        snprintf(name, sizeof name, "n%u", i);
        const uint32_t id = glint_cryptomatte_id(name), exponent = id >> 23 & 255;
        assert_in_range(exponent, 1, 254);
        repaired += id != glint_murmur3_32(name, strlen(name), 0);
    }
    // Two exponents of 256: 781 expected, standard deviation 28.
    assert_in_range(repaired, 641, 921);
}

static void keys_are_those_of_the_conventions(void **state)
{
    (void)state;
    static const char *const row[][2] = {
        {"CryptoObject", "3ae39a5"},      {"CryptoReflObject", "9224e9b"},
        {"CryptoMaterial", "be359d6"},    {"CryptoReflMaterial", "8fb1c8b"},
        {"CryptoAsset", "f42029d"},       {"CryptoReflAsset", "94d90fa"},
        {"CryptoRefrObject", "75a407e"},  {"CryptoRefrMaterial", "d451711"},
        {"CryptoRefrAsset", "82286ba"},   {"uCryptoObject", "ae93ba3"},
        {"CryptoGlossObject", "5736b15"}, {"CryptoGlossMaterial", "6c37593"},
        {"CryptoGlossAsset", "a471b68"},  {"CryptoD0Object", "6c5c0ee"},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        char key[8];
        glint_cryptomatte_key(row[i][0], key);
        assert_string_equal(key, row[i][1]);
    }
}

static void no_type_may_be_a_prefix_of_another(void **state)
{
    (void)state;
    const char *const good[] = {"CryptoObject", "CryptoMaterial", "CryptoAsset", "CryptoReflObject",
                                "A_27_byte_type_name_is_okay"};
    assert_int_equal(strlen(good[4]), 27);
    assert_int_equal(glint_cryptomatte_type_check(good, COUNT(good), NULL), GLINT_OK);
    assert_int_equal(glint_cryptomatte_type_check(good, 0, NULL), GLINT_OK);
    static const char *const bad[][2] = {
        {"CryptoObject", "CryptoObjectReflect"},
        {"CryptoObjectReflect", "CryptoObject"},
        {"CryptoObject", "CryptoObject"},
        {"1Crypto", "CryptoObject"},
        {"", "1"},
        {"Crypto-Object", "CryptoObject"},
        {"Objét", "CryptoObject"},
        {"A_28_byte_type_name_is_not_ok", "CryptoObject"},
    };
    for (size_t i = 0; i < COUNT(bad); i++)
        assert_int_equal(glint_cryptomatte_type_check(bad[i], 2, NULL), GLINT_E_RANGE);
    struct glint_error err = {0};
    assert_int_equal(glint_cryptomatte_type_check(bad[0], 2, &err), GLINT_E_RANGE);
    assert_int_equal(err.count, 1);
    glint_error_finish(&err);
}

static void a_manifest_is_sorted_escaped_and_without_duplicates(void **state)
{
    (void)state;
    const char *const names[] = {"torus",     "a\"b",  "a\\b",    "",
                                 "tab\there", "torus", "равнина", "Zoo"};
    char *text = glint_cryptomatte_manifest(names, COUNT(names));
    static const char *const order[] = {"Zoo",       "a\"b",  "a\\b",   "default",
                                        "tab\there", "torus", "равнина"};
    cJSON *object = cJSON_Parse(text);
    assert_int_equal(cJSON_GetArraySize(object), (int)COUNT(order));
    for (size_t i = 0; i < COUNT(order); i++) {
        const cJSON *item = cJSON_GetArrayItem(object, (int)i);
        char hex[9];
        snprintf(hex, sizeof hex, "%08x", glint_cryptomatte_id(order[i]));
        assert_string_equal(item->string, order[i]);
        assert_string_equal(item->valuestring, hex);
    }
    assert_non_null(strstr(text, "\"a\\\"b\":\""));
    assert_non_null(strstr(text, "\"tab\\u0009here\""));
    assert_non_null(strstr(text, "\"torus\":\"f19c73fd\""));
    cJSON_Delete(object);
    free(text);
}

static void a_manifest_holds_the_repaired_hash(void **state)
{
    (void)state;
    const char *const name = "flowerA.flowerA_petal11.:778";
    char *text = glint_cryptomatte_manifest(&name, 1);
    assert_string_equal(text, "{\"flowerA.flowerA_petal11.:778\":\"008586a5\"}");
    free(text);
    text = glint_cryptomatte_manifest(NULL, 0);
    assert_string_equal(text, "{}");
    free(text);
}

static void a_name_that_is_no_utf8_still_gives_json(void **state)
{
    (void)state;
    const char *const name = "a\xff\xc3(";
    char *text = glint_cryptomatte_manifest(&name, 1);
    cJSON *object = cJSON_Parse(text);
    assert_string_equal(object->child->string, "a\xef\xbf\xbd\xef\xbf\xbd(");
    cJSON_Delete(object);
    free(text);
}

// Found by search; both have the ID 5b9d5b0e.
#define CLASH_A "object_48770"
#define CLASH_B "object_8333"

static void different_names_with_one_id_are_reported(void **state)
{
    (void)state;
    const char *const names[] = {CLASH_A, "torus", CLASH_B, "torus", "", "default", CLASH_A};
    struct glint_cryptomatte_clash *clash;
    size_t count;
    assert_int_equal(glint_cryptomatte_clashes(names, COUNT(names), &clash, &count), GLINT_OK);
    assert_int_equal(count, 1);
    assert_string_equal(clash[0].a, CLASH_A);
    assert_string_equal(clash[0].b, CLASH_B);
    free(clash);
    assert_int_equal(glint_cryptomatte_clashes(NULL, 0, &clash, &count), GLINT_OK);
    assert_int_equal(count, 0);
    free(clash);
}

static void ranks_sort_by_coverage_then_by_bits(void **state)
{
    (void)state;
    struct glint_cryptomatte_rank rank[] = {{9, .25f}, {0, 0},    {0xf0000000, .5f},
                                            {3, .25f}, {0, .25f}, {0x70000000, .5f}};
    static const uint32_t order[] = {0x70000000, 0xf0000000, 0, 3, 9, 0};
    glint_cryptomatte_sort(rank, COUNT(rank));
    for (size_t i = 0; i < COUNT(order); i++)
        assert_int_equal(rank[i].id, order[i]);
    assert_true(rank[0].coverage == .5f && rank[4].coverage == .25f && rank[5].coverage == 0);
    glint_cryptomatte_sort(rank, 0);
}

static void set_bits(float *plane, size_t i, uint32_t bits)
{
    memcpy(&plane[i], &bits, sizeof bits);
}

// Two pixels: 60% a, 30% b, 10% c; and c alone.
static struct glint_frame *matte_frame(const char *const suffix[4], uint32_t a, uint32_t b,
                                       uint32_t c)
{
    struct glint_frame *f;
    assert_int_equal(glint_frame_create(&f, 2, 1, 0, 0, 2, 1, NULL), GLINT_OK);
    float *plane[8];
    for (int i = 0; i < 8; i++) {
        char name[32];
        snprintf(name, sizeof name, "CryptoObject%02d.%s", i / 4, suffix[i % 4]);
        plane[i] = glint_frame_channel(f, name, GLINT_PIXEL_FLOAT);
    }
    set_bits(plane[0], 0, a);
    plane[1][0] = .6f;
    set_bits(plane[2], 0, b);
    plane[3][0] = .3f;
    set_bits(plane[4], 0, c);
    plane[5][0] = .1f;
    set_bits(plane[0], 1, c);
    plane[1][1] = 1;
    return f;
}

static void a_matte_is_the_coverage_of_the_union(void **state)
{
    (void)state;
    static const char *const spelling[][4] = {
        {"R", "G", "B", "A"}, {"r", "g", "b", "a"}, {"red", "green", "blue", "alpha"}};
    const uint32_t a = glint_cryptomatte_id("a"), b = 0x008586a5, c = glint_cryptomatte_id("c");
    for (size_t i = 0; i < COUNT(spelling); i++) {
        struct glint_frame *f = matte_frame(spelling[i], a, b, c);
        const uint32_t ids[] = {c, a, c};
        float matte[2] = {7, 7};
        assert_int_equal(glint_cryptomatte_matte(f, "CryptoObject", ids, 3, matte, NULL), GLINT_OK);
        assert_true(matte[0] == .6f + .1f && matte[1] == 1);
        assert_int_equal(glint_cryptomatte_matte(f, "CryptoObject", &b, 1, matte, NULL), GLINT_OK);
        assert_true(matte[0] == .3f && matte[1] == 0);
        assert_int_equal(glint_cryptomatte_matte(f, "CryptoObject", NULL, 0, matte, NULL),
                         GLINT_OK);
        assert_true(matte[0] == 0 && matte[1] == 0);
        assert_int_equal(glint_cryptomatte_matte(f, "CryptoAsset", ids, 3, matte, NULL),
                         GLINT_E_NOT_FOUND);
        glint_frame_destroy(&f);
    }
}

static void a_header_has_the_four_keys_of_its_type(void **state)
{
    (void)state;
    struct glint_frame *f;
    assert_int_equal(glint_frame_create(&f, 1, 1, 0, 0, 1, 1, NULL), GLINT_OK);
    assert_int_equal(glint_cryptomatte_header(f, "CryptoObject", "{}"), GLINT_OK);
    static const char *const row[][2] = {{"cryptomatte/3ae39a5/name", "CryptoObject"},
                                         {"cryptomatte/3ae39a5/hash", "MurmurHash3_32"},
                                         {"cryptomatte/3ae39a5/conversion", "uint32_to_float32"},
                                         {"cryptomatte/3ae39a5/manifest", "{}"}};
    assert_int_equal(f->attributes, COUNT(row));
    for (size_t i = 0; i < COUNT(row); i++)
        assert_string_equal(glint_frame_attribute(f, row[i][0])->text, row[i][1]);
    glint_frame_destroy(&f);
}

static void channels_belong_to_the_types_of_the_header(void **state)
{
    (void)state;
    struct glint_frame *f;
    assert_int_equal(glint_frame_create(&f, 1, 1, 0, 0, 1, 1, NULL), GLINT_OK);
    glint_frame_string(f, "comments", "CryptoX");
    glint_cryptomatte_header(f, "CryptoObject", "{}");
    glint_cryptomatte_header(f, "CryptoAsset", "{}");
    assert_string_equal(glint_cryptomatte_type_of(f, "CryptoObject00.R")->text, "CryptoObject");
    assert_string_equal(glint_cryptomatte_type_of(f, "CryptoAsset12.a")->text, "CryptoAsset");
    static const char *const others[] = {"R",
                                         "CryptoObject.R",
                                         "CryptoObject0.R",
                                         "CryptoObject00",
                                         "CryptoObjects00.R",
                                         "CryptoMaterial00.R",
                                         "CryptoX00.R"};
    for (size_t i = 0; i < COUNT(others); i++)
        assert_null(glint_cryptomatte_type_of(f, others[i]));
    assert_int_equal(glint_cryptomatte_check(f, NULL), GLINT_OK);
    glint_cryptomatte_header(f, "CryptoObjectReflect", "{}");
    assert_int_equal(glint_cryptomatte_check(f, NULL), GLINT_E_RANGE);
    glint_frame_destroy(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(murmur3_gives_its_published_vectors),
        cmocka_unit_test(names_hash_as_the_specification_and_its_samples),
        cmocka_unit_test(every_id_is_a_normal_float),
        cmocka_unit_test(keys_are_those_of_the_conventions),
        cmocka_unit_test(no_type_may_be_a_prefix_of_another),
        cmocka_unit_test(a_manifest_is_sorted_escaped_and_without_duplicates),
        cmocka_unit_test(a_manifest_holds_the_repaired_hash),
        cmocka_unit_test(a_name_that_is_no_utf8_still_gives_json),
        cmocka_unit_test(different_names_with_one_id_are_reported),
        cmocka_unit_test(ranks_sort_by_coverage_then_by_bits),
        cmocka_unit_test(a_matte_is_the_coverage_of_the_union),
        cmocka_unit_test(a_header_has_the_four_keys_of_its_type),
        cmocka_unit_test(channels_belong_to_the_types_of_the_header),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
