#include "tests/unit/model_expect.h"

#define FACET(A, B, C)                                                                         \
    "facet normal 9 9 9\n outer loop\n vertex " A "\n vertex " B "\n vertex " C "\n endloop\n" \
    "endfacet\n"
#define WEDGE FACET("0 0 0", "1 0 0", "0 1 0")

static struct glint_scene *read_text(const char *text)
{
    return model_read(glint_stl_import, text, strlen(text));
}

static void refused(const char *text, glint_status status, const char *words)
{
    model_refused(glint_stl_import, text, strlen(text), status, words);
}

// Binary: `triangles` copies of (0 0 0) (1 0 0) (0 1 0).
static uint8_t *binary(uint32_t triangles, const char *head, size_t *size)
{
    static const float corner[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0}; // of a little-endian machine
    *size = 84 + 50 * (size_t)triangles;
    uint8_t *bytes = calloc(1, *size);
    memcpy(bytes, head, strlen(head));
    memcpy(bytes + 80, &triangles, 4);
    for (uint32_t i = 0; i < triangles; i++)
        memcpy(bytes + 84 + 50 * (size_t)i + 12, corner, sizeof corner);
    return bytes;
}

static void solids_of_a_text_are_objects(void **state)
{
    (void)state;
    struct glint_scene *s = read_text("solid left ear\n" WEDGE WEDGE "endsolid left ear\n"
                                      "SOLID nose\n" WEDGE "endsolid\n");
    double sum[3];
    assert_int_equal(s->objects, 2);
    assert_string_equal(s->object[0].name, "left ear");
    assert_string_equal(s->object[1].name, "nose");
    assert_int_equal(s->mesh[0].triangles, 2);
    assert_int_equal(s->mesh[1].triangles, 1);
    assert_null(s->mesh[0].normal); // flat, whatever the file says of normals
    assert_true(model_area(&s->mesh[0], sum) == 1 && sum[2] == 1);
    glint_scene_destroy(&s);
}

static void binary_files_are_told_by_their_size(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        size_t size;
        uint8_t *bytes = binary(3, i ? "solid, says the header of many a binary file" : "", &size);
        struct glint_scene *s = model_read(glint_stl_import, bytes, size);
        double sum[3];
        assert_int_equal(s->mesh[0].triangles, 3);
        assert_true(model_area(&s->mesh[0], sum) == 1.5);
        assert_string_equal(s->object[0].name, "default");
        glint_scene_destroy(&s);
        free(bytes);
    }
}

static void what_a_binary_header_claims_must_be_there(void **state)
{
    (void)state;
    size_t size;
    uint8_t *bytes = binary(2, "", &size);
    for (size_t n = 0; n < size; n++)
        model_refused(glint_stl_import, bytes, n, GLINT_E_SYNTAX, "the file has");
    memset(bytes + 80, 0xff, 4);
    model_refused(glint_stl_import, bytes, size, GLINT_E_SYNTAX,
                  "4294967295 triangles as its header says need 214748364834");
    memset(bytes + 80, 0, 4);
    model_refused(glint_stl_import, bytes, size, GLINT_E_RANGE, "no triangles");
    free(bytes);
}

static void every_coordinate_that_is_none_is_named(void **state)
{
    (void)state;
    static const uint8_t nan[4] = {0, 0, 0xc0, 0x7f}, inf[4] = {0, 0, 0x80, 0x7f};
    size_t size;
    uint8_t *bytes = binary(3, "", &size);
    memcpy(bytes + 84 + 50 + 12, nan, 4);
    model_refused(glint_stl_import, bytes, size, GLINT_E_RANGE, "triangle 1: nan is outside");
    memcpy(bytes + 84 + 12 + 32, inf, 4);
    model_refused(glint_stl_import, bytes, size, GLINT_E_RANGE, "triangle 0: inf is outside");
    free(bytes);
    refused("solid\n" FACET("0 0 0", "1 0 nan", "0 1 0"), GLINT_E_RANGE,
            "line 5: \"nan\" is no number");
    refused("solid\n" FACET("0 0 0", "1 0 0", "0 1e999 0"), GLINT_E_RANGE, "line 6: 1e999 is");
    refused("solid\n" FACET("0 0", "1 0 0", "0 1 0"), GLINT_E_RANGE, "line 4: 3 numbers");
}

static void a_text_keeps_to_its_words_and_to_three_corners(void **state)
{
    (void)state;
    refused("solid\nfacet\nvertex 0 0 0\nendfacet\n", GLINT_E_RANGE, "line 4: the facet has 1");
    refused("solid\nfacet\nvertex 0 0 0\n", GLINT_E_SYNTAX, "ends inside a facet");
    refused("solid\nloop\n" WEDGE, GLINT_E_RANGE, "line 2: \"loop\" is no word of STL");
    refused("solid\nendsolid\n", GLINT_E_RANGE, "no triangles");
    refused("", GLINT_E_SYNTAX, "the file has 0 bytes");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(solids_of_a_text_are_objects),
        cmocka_unit_test(binary_files_are_told_by_their_size),
        cmocka_unit_test(what_a_binary_header_claims_must_be_there),
        cmocka_unit_test(every_coordinate_that_is_none_is_named),
        cmocka_unit_test(a_text_keeps_to_its_words_and_to_three_corners),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
