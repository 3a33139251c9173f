#include "protocol/frame.h"
#include "protocol/job.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <string.h>

static struct glint_frame *make(uint32_t width, uint32_t height)
{
    struct glint_frame *f;
    assert_int_equal(glint_frame_create(&f, 64, 48, -2, 3, width, height, NULL), GLINT_OK);
    return f;
}

static void sizes_out_of_range_are_all_named(void **state)
{
    (void)state;
    struct glint_error err = {0};
    struct glint_frame *f = (void *)1;
    assert_int_equal(glint_frame_create(&f, 0, 1, 0, 0, 1, GLINT_MAX_SIDE + 1, &err),
                     GLINT_E_RANGE);
    assert_null(f);
    assert_int_equal(err.count, 2);
    glint_error_finish(&err);
    assert_int_equal(glint_frame_create(&f, 1, 1, INT32_MAX, 0, 1, 1, NULL), GLINT_E_RANGE);
    assert_int_equal(glint_frame_create(&f, 1, 1, INT32_MAX - 1, 0, 1, 1, NULL), GLINT_OK);
    glint_frame_destroy(&f);
    assert_null(f);
    glint_frame_destroy(&f);
}

static void planes_start_black_and_stay_where_they_are(void **state)
{
    (void)state;
    struct glint_frame *f = make(7, 5);
    float *first = glint_frame_channel(f, "R", GLINT_PIXEL_HALF);
    for (int i = 0; i < 35; i++)
        assert_true(first[i] == 0);
    for (int i = 0; i < 40; i++) {
        char name[32];
        snprintf(name, sizeof name, "layer%d.X", i);
        assert_non_null(glint_frame_channel(f, name, GLINT_PIXEL_FLOAT));
    }
    assert_int_equal(f->channels, 41);
    assert_ptr_equal(glint_frame_find(f, "R"), first);
    assert_ptr_equal(glint_frame_find(f, "layer39.X"), f->channel[40].plane);
    assert_null(glint_frame_find(f, "layer40.X"));
    glint_frame_destroy(&f);
}

static void an_attribute_set_again_is_replaced(void **state)
{
    (void)state;
    struct glint_frame *f = make(1, 1);
    const float m[16] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
    const float c[8] = {.64f, .33f, .30f, .60f, .15f, .06f, .3127f, .3290f};
    assert_int_equal(glint_frame_string(f, "owner", "a"), GLINT_OK);
    assert_int_equal(glint_frame_matrix(f, "worldToCamera", m), GLINT_OK);
    assert_int_equal(glint_frame_chromaticities(f, c), GLINT_OK);
    assert_int_equal(glint_frame_float(f, "x", 2), GLINT_OK);
    assert_int_equal(glint_frame_int(f, "owner", -7), GLINT_OK);
    assert_int_equal(f->attributes, 4);
    const struct glint_attribute *a = glint_frame_attribute(f, "owner");
    assert_int_equal(a->kind, GLINT_ATTR_INT);
    assert_int_equal(a->integer, -7);
    assert_memory_equal(glint_frame_attribute(f, "worldToCamera")->number, m, sizeof m);
    assert_memory_equal(glint_frame_attribute(f, "chromaticities")->number, c, sizeof c);
    assert_true(glint_frame_attribute(f, "x")->number[0] == 2);
    assert_null(glint_frame_attribute(f, "y"));
    glint_frame_destroy(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sizes_out_of_range_are_all_named),
        cmocka_unit_test(planes_start_black_and_stay_where_they_are),
        cmocka_unit_test(an_attribute_set_again_is_replaced),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
