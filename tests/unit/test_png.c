#include "protocol/png.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>

// Reads a file back as it was stored, without any conversion; frees it.
static uint8_t *decode(uint8_t *bytes, size_t size, png_uint_32 format, uint32_t width,
                       uint32_t height)
{
    png_image image = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_memory(&image, bytes, size));
    assert_int_equal(image.format, format);
    assert_int_equal(image.width, width);
    assert_int_equal(image.height, height);
    uint8_t *pixels = malloc(PNG_IMAGE_SIZE(image));
    assert_true(png_image_finish_read(&image, NULL, pixels, 0, NULL));
    free(bytes);
    return pixels;
}

// The 8-bit codes of grey values in one row.
static uint8_t *codes(const float *value, uint32_t count, float exposure,
                      enum glint_tonemap tonemap)
{
    const struct glint_png_image image = {count, 1, value, value, value, NULL};
    const struct glint_png_options options = {exposure, tonemap};
    uint8_t *bytes;
    size_t size;
    assert_int_equal(glint_png_color(&image, &options, &bytes, &size, NULL), GLINT_OK);
    return decode(bytes, size, PNG_FORMAT_RGB, count, 1);
}

static double linear(double code)
{
    const double v = code / 255;
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static void every_code_comes_back_from_its_linear_value(void **state)
{
    (void)state;
    float value[256 * 3];
    for (int code = 0; code < 256; code++)
        for (int i = 0; i < 3; i++) // and from nearly half a code beside it
            value[code * 3 + i] = (float)linear(code + (i - 1) * 0.499);
    uint8_t *got = codes(value, 256 * 3, 0, GLINT_TONEMAP_CLIP);
    for (int i = 0; i < 256 * 3; i++)
        assert_int_equal(got[i * 3], i / 3);
    free(got);
}

static void values_outside_the_range_are_shown_at_its_ends(void **state)
{
    (void)state;
    const float value[] = {-1, -INFINITY, NAN, 0, 1, 2, 1e30f, INFINITY, 1e-40f};
    static const uint8_t want[] = {0, 0, 0, 0, 255, 255, 255, 255, 0};
    uint8_t *got = codes(value, sizeof want, 0, GLINT_TONEMAP_CLIP);
    for (size_t i = 0; i < sizeof want; i++)
        assert_int_equal(got[i * 3], want[i]);
    free(got);
}

static void exposure_is_in_stops(void **state)
{
    (void)state;
    const float value[] = {0.125f, 0.25f, 0.5f};
    uint8_t *plus = codes(value, 3, 1, GLINT_TONEMAP_CLIP);
    uint8_t *minus = codes(value, 3, -1, GLINT_TONEMAP_CLIP);
    uint8_t *zero = codes(value, 3, 0, GLINT_TONEMAP_CLIP);
    assert_int_equal(zero[6], 188); // 0.5 is 0.7354 of full scale in sRGB
    assert_int_equal(plus[3], zero[6]);
    assert_int_equal(minus[6], zero[3]);
    assert_int_equal(plus[0], zero[3]);
    free(plus);
    free(minus);
    free(zero);
}

static void reinhard_maps_one_to_a_half_and_infinity_to_one(void **state)
{
    (void)state;
    const float value[] = {0, 1, 3, INFINITY, NAN, -2};
    const double want[] = {0, 0.5, 0.75, 1, 0, 0};
    uint8_t *got = codes(value, 6, 0, GLINT_TONEMAP_REINHARD);
    for (int i = 0; i < 6; i++)
        assert_true(fabs(linear(got[i * 3]) - want[i]) < 0.005);
    free(got);
}

static void every_curve_is_increasing_within_zero_and_one(void **state)
{
    (void)state;
    for (int t = 0; t < GLINT_TONEMAP_COUNT; t++) {
        assert_int_equal(glint_tonemap_from_name(glint_tonemap_table[t].name), t);
        assert_true(glint_tonemap_table[t].curve(0) == 0);
        assert_true(glint_tonemap_table[t].curve(INFINITY) == 1);
        float last = 0;
        for (float v = 1e-30f; v < 1e30f; v *= 1.25f) {
            const float now = glint_tonemap_table[t].curve(v);
            assert_true(now >= last && now <= 1);
            last = now;
        }
    }
    assert_int_equal(glint_tonemap_from_name("filmic"), -1);
}

static void channels_and_rows_keep_their_places(void **state)
{
    (void)state;
    const float red[] = {1, 0, 0, 0, 0, 0}, green[] = {0, 1, 0, 0, 0, 0},
                blue[] = {0, 0, 0, 1, 0, 1};
    const struct glint_png_image image = {2, 3, red, green, blue, NULL};
    const struct glint_png_options options = {0};
    uint8_t *bytes;
    size_t size;
    assert_int_equal(glint_png_color(&image, &options, &bytes, &size, NULL), GLINT_OK);
    uint8_t *got = decode(bytes, size, PNG_FORMAT_RGB, 2, 3);
    static const uint8_t want[18] = {255, 0, 0, 0, 255, 0, 0, 0, 0, 0, 0, 255, 0, 0, 0, 0, 0, 255};
    assert_memory_equal(got, want, sizeof want);
    free(got);
}

static void colour_is_divided_by_alpha(void **state)
{
    (void)state;
    const float colour[] = {.25f, 1, .5f, 0}, alpha[] = {.5f, 1, 0, 0};
    const struct glint_png_image image = {4, 1, colour, colour, colour, alpha};
    const struct glint_png_options options = {0};
    uint8_t *bytes;
    size_t size;
    assert_int_equal(glint_png_color(&image, &options, &bytes, &size, NULL), GLINT_OK);
    uint8_t *got = decode(bytes, size, PNG_FORMAT_RGBA, 4, 1);
    static const uint8_t want[] = {188, 188, 188, 128, 255, 255, 255, 255,
                                   188, 188, 188, 0,   0,   0,   0,   0};
    assert_memory_equal(got, want, sizeof want);
    free(got);
}

static void coverage_is_grey_in_proportion(void **state)
{
    (void)state;
    const float plane[] = {0, 1, 0.5f, 0.2f, 2, -1, NAN, 1.0f / 255};
    static const uint8_t want[] = {0, 255, 128, 51, 255, 0, 0, 1};
    uint8_t *bytes;
    size_t size;
    assert_int_equal(glint_png_coverage(plane, 4, 2, &bytes, &size, NULL), GLINT_OK);
    uint8_t *got = decode(bytes, size, PNG_FORMAT_GRAY, 4, 2);
    assert_memory_equal(got, want, sizeof want);
    free(got);
}

static void an_exposure_out_of_range_is_a_fault(void **state)
{
    (void)state;
    const float value = 1;
    const struct glint_png_image image = {1, 1, &value, &value, &value, NULL};
    const float exposure[] = {65, -65, NAN, INFINITY};
    for (int i = 0; i < 4; i++) {
        const struct glint_png_options options = {exposure[i], GLINT_TONEMAP_CLIP};
        struct glint_error err = {0};
        uint8_t *bytes;
        size_t size;
        assert_int_equal(glint_png_color(&image, &options, &bytes, &size, &err), GLINT_E_RANGE);
        assert_string_equal(err.fault[0].pointer, "/exposure");
        assert_null(bytes);
        glint_error_finish(&err);
    }
}

static void equal_pictures_are_equal_files(void **state)
{
    (void)state;
    const float value[] = {.1f, .2f, .3f, .4f};
    const struct glint_png_image image = {2, 2, value, value, value, NULL};
    const struct glint_png_options options = {0};
    uint8_t *bytes[2];
    size_t size[2];
    for (int i = 0; i < 2; i++)
        glint_png_color(&image, &options, &bytes[i], &size[i], NULL);
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(bytes[0], bytes[1], size[0]);
    assert_null(memmem(bytes[0], size[0], "tIME", 4));
    free(bytes[0]);
    free(bytes[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_code_comes_back_from_its_linear_value),
        cmocka_unit_test(values_outside_the_range_are_shown_at_its_ends),
        cmocka_unit_test(exposure_is_in_stops),
        cmocka_unit_test(reinhard_maps_one_to_a_half_and_infinity_to_one),
        cmocka_unit_test(every_curve_is_increasing_within_zero_and_one),
        cmocka_unit_test(channels_and_rows_keep_their_places),
        cmocka_unit_test(colour_is_divided_by_alpha),
        cmocka_unit_test(coverage_is_grey_in_proportion),
        cmocka_unit_test(an_exposure_out_of_range_is_a_fault),
        cmocka_unit_test(equal_pictures_are_equal_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
