#include "tests/unit/model_expect.h"

#include <math.h>

#define HEAD(FORMAT, VERTICES) \
    "ply\nformat " FORMAT " 1.0\ncomment made by hand\nelement vertex " VERTICES "\n"
#define XYZ "property float x\nproperty float y\nproperty float z\n"
#define FACES(COUNT) "element face " COUNT "\nproperty list uchar int vertex_indices\n"
#define END "end_header\n"

static struct glint_scene *read_text(const char *text)
{
    return model_read(glint_ply_import, text, strlen(text));
}

static void refused(const char *text, glint_status status, const char *words)
{
    model_refused(glint_ply_import, text, strlen(text), status, words);
}

// A text that is built byte by byte.
struct bytes {
    uint8_t data[1024];
    size_t size;
};

static void put(struct bytes *b, const void *data, size_t size)
{
    memcpy(b->data + b->size, data, size);
    b->size += size;
}

static void put_number(struct bytes *b, uint64_t bits, unsigned size, bool big)
{
    for (unsigned i = 0; i < size; i++)
        b->data[b->size++] = (uint8_t)(bits >> 8 * (big ? size - 1 - i : i));
}

static void put_float(struct bytes *b, float value, bool big)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_number(b, bits, 4, big);
}

// The unit square with one face of four corners.
static struct bytes square(bool big)
{
    static const float position[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    static const char little[] = HEAD("binary_little_endian", "4") XYZ FACES("1") END;
    static const char large[] = HEAD("binary_big_endian", "4") XYZ FACES("1") END;
    struct bytes b = {.size = 0};
    put(&b, big ? large : little, (big ? sizeof large : sizeof little) - 1);
    for (int i = 0; i < 12; i++)
        put_float(&b, position[i / 3][i % 3], big);
    put_number(&b, 4, 1, big);
    for (uint32_t i = 0; i < 4; i++)
        put_number(&b, i, 4, big);
    return b;
}

static void expect_square(struct glint_scene *s)
{
    double sum[3];
    assert_int_equal(s->meshes, 1);
    assert_int_equal(s->mesh[0].vertices, 4);
    assert_int_equal(s->mesh[0].triangles, 2);
    assert_true(model_area(&s->mesh[0], sum) == 1 && sum[2] == 1);
    glint_scene_destroy(&s);
}

static void text_and_both_byte_orders_give_the_same_square(void **state)
{
    (void)state;
    expect_square(
        read_text(HEAD("ascii", "4") XYZ FACES("1") END "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"));
    for (int big = 0; big < 2; big++) {
        const struct bytes b = square(big);
        expect_square(model_read(glint_ply_import, b.data, b.size));
    }
}

static void every_cut_is_refused_as_syntax(void **state)
{
    (void)state;
    const struct bytes b = square(true);
    for (size_t n = 0; n < b.size; n++)
        model_refused(glint_ply_import, b.data, n, GLINT_E_SYNTAX, "");
}

// 0 1 2 3 turns at every second triangle; -1 begins anew.
static void strips_keep_their_sense_and_restart(void **state)
{
    (void)state;
    struct glint_scene *s =
        read_text(HEAD("ascii", "4") XYZ "element tristrips 1\n"
                                         "property list int int vertex_indices\n" END
                                         "0 0 0\n1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 2 1 3\n");
    const uint32_t expected[] = {0, 1, 2, 1, 3, 2, 2, 1, 3};
    assert_int_equal(s->mesh[0].triangles, 3);
    assert_memory_equal(s->mesh[0].index, expected, sizeof expected);
    glint_scene_destroy(&s);
}

static void attributes_and_strange_properties_are_told_apart(void **state)
{
    (void)state;
    struct glint_scene *s = read_text(
        HEAD("ascii", "3") "property list uchar float extra\n" XYZ
                           "property float nx\nproperty float ny\nproperty float nz\n"
                           "property float s\nproperty float t\nproperty double quality\n"
                           "property uchar red\nproperty uchar green\nproperty uchar blue\n" FACES(
                               "2") "property int flags\nelement edge 1\nproperty int a\n" END
                                    "2 9 9 0 0 0 0 0 2 0 0.25 7 255 0 188\n"
                                    "0 1 0 0 0 0 0 1 0 7 0 0 0\n1 5 0 1 0 0 0 1 0 1 7 255 255 255\n"
                                    "3 0 1 2 9\n2 0 1 9\n17\n");
    const struct glint_mesh *m = &s->mesh[0];
    assert_int_equal(m->triangles, 1);
    assert_true(m->uv[1] == 0.75f);
    assert_true(m->normal[2] == 1); // made unit
    assert_true(m->normal[5] == 1); // of no length: that of its face
    assert_true(m->color[0] == 1 && m->color[1] == 0);
    assert_true(fabsf(m->color[2] - 0.50288645f) < 1e-5f); // IEC 61966-2-1 of 188/255
    assert_true(m->color[3] == 1);
    assert_true(model_warns(s, "1 faces of less than three corners"));
    glint_scene_destroy(&s);
}

static void counts_are_bounded_by_the_file_before_anything_is_allocated(void **state)
{
    (void)state;
    refused(HEAD("binary_little_endian", "4000000000") XYZ FACES("1") END "1234", GLINT_E_SYNTAX,
            "too short for 4000000000 elements \"vertex\"");
    refused(HEAD("ascii", "1") XYZ FACES("4294967295") END "0 0 0\n", GLINT_E_SYNTAX,
            "too short for 4294967295 elements \"face\"");
    refused(HEAD("ascii", "99999999999") XYZ END, GLINT_E_SYNTAX, "line 4: \"99999999999\"");
    refused(HEAD("ascii", "3") XYZ "element face 1\nproperty list uint int vertex_indices\n" END
                                   "0 0 0\n1 0 0\n0 1 0\n4000000000 0 1 2\n",
            GLINT_E_SYNTAX, "line 14, face 0: a list of 4e+09 values");
}

static void what_is_wrong_is_named_by_its_place(void **state)
{
    (void)state;
    refused("", GLINT_E_SYNTAX, "does not start with \"ply\"");
    refused("ply\nformat ascii\n", GLINT_E_SYNTAX, "ends inside its header");
    refused("ply\nformat morse 1.0\n", GLINT_E_SYNTAX, "line 2: \"morse\" is no format");
    refused("ply\nproperty int x\n", GLINT_E_SYNTAX, "line 2: a property before any element");
    refused("ply\nelement a 1\nproperty real x\n", GLINT_E_SYNTAX, "line 3: \"real\" is no type");
    refused("ply\nelement a 1\nproperty list float int x\n", GLINT_E_SYNTAX, "no whole number");
    refused("ply\nwhat\n", GLINT_E_SYNTAX, "line 2: \"what\" is no word");
    refused("ply\n" END, GLINT_E_SYNTAX, "names no format");
    refused(HEAD("ascii", "1") "property float x\n" END "0\n", GLINT_E_RANGE, "no x, y and z");
    refused(HEAD("ascii", "1") XYZ END "0 0 0\n", GLINT_E_RANGE, "1 vertices, no faces");
    refused(HEAD("ascii", "2") XYZ FACES("1") END "0 0 0\n0 nan 0\n3 0 1 1\n", GLINT_E_RANGE,
            "line 12, vertex 1: \"nan\" is no number");
    refused(HEAD("ascii", "1") XYZ FACES("1") END "0 1e999 0\n3 0 0 0\n", GLINT_E_RANGE,
            "line 11, vertex 0: y is inf");
    refused(HEAD("ascii", "1") XYZ FACES("1") END "0 0 0\n3 0 1 0\n", GLINT_E_RANGE,
            "line 12, face 0: vertex 1 of 1");
    refused(HEAD("ascii", "1") XYZ FACES("1") END "0 0 0\n3 0 -1 0\n", GLINT_E_RANGE,
            "face 0: vertex -1 of 1");
    refused("ply\nformat ascii 1.0\n" FACES("1") "element vertex 1\n" XYZ END "3 0 0 0\n0 0 0\n",
            GLINT_E_RANGE, "face 0: there are no vertices before it");
    struct bytes b = square(false);
    b.data[b.size - 1] = 0x7f; // the last number of a corner
    model_refused(glint_ply_import, b.data, b.size, GLINT_E_RANGE,
                  "face 0: vertex 2.13071e+09 of 4");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(text_and_both_byte_orders_give_the_same_square),
        cmocka_unit_test(every_cut_is_refused_as_syntax),
        cmocka_unit_test(strips_keep_their_sense_and_restart),
        cmocka_unit_test(attributes_and_strange_properties_are_told_apart),
        cmocka_unit_test(counts_are_bounded_by_the_file_before_anything_is_allocated),
        cmocka_unit_test(what_is_wrong_is_named_by_its_place),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
