#include "scene/image_decode.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jpeglib.h>

// --- makers

static void png_bytes(png_structp png, png_bytep bytes, size_t n)
{
    FILE *out = png_get_io_ptr(png);
    fwrite(bytes, 1, n, out);
}

// rows: as libpng wants them for this colour type and depth.
static uint8_t *make_png(uint32_t w, uint32_t h, int depth, int type, int interlace,
                         const uint8_t *rows, size_t row_bytes, size_t *size)
{
    char *bytes = NULL;
    FILE *out = open_memstream(&bytes, size);
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    png_set_write_fn(png, out, png_bytes, NULL);
    png_set_IHDR(png, info, w, h, depth, type, interlace, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    if (type == PNG_COLOR_TYPE_PALETTE) {
        const png_color palette[2] = {{10, 20, 30}, {40, 50, 60}};
        const png_byte alpha[2] = {0, 255};
        png_set_PLTE(png, info, palette, 2);
        png_set_tRNS(png, info, alpha, 2, NULL);
    }
    png_write_info(png, info);
    const int passes = png_set_interlace_handling(png);
    for (int pass = 0; pass < passes; pass++)
        for (uint32_t y = 0; y < h; y++)
            png_write_row(png, rows + y * row_bytes);
    png_write_end(png, NULL);
    png_destroy_write_struct(&png, &info);
    fclose(out);
    return (uint8_t *)bytes;
}

static uint8_t *make_jpeg(uint32_t w, uint32_t h, int components, J_COLOR_SPACE space,
                          const uint8_t *rows, size_t *size)
{
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr errors;
    unsigned char *bytes = NULL;
    unsigned long length = 0;
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    jpeg_mem_dest(&jpeg, &bytes, &length);
    jpeg.image_width = w;
    jpeg.image_height = h;
    jpeg.input_components = components;
    jpeg.in_color_space = space;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, 100, TRUE);
    jpeg_start_compress(&jpeg, TRUE);
    while (jpeg.next_scanline < h) {
        JSAMPROW row = (JSAMPROW)rows + (size_t)jpeg.next_scanline * w * (uint32_t)components;
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    *size = length;
    return bytes;
}

// --- expectations

static struct glint_arena arena;

static struct glint_pixels decode(const uint8_t *bytes, size_t size)
{
    struct glint_error err = {0};
    struct glint_pixels p;
    if (glint_image_decode(&p, &arena, bytes, size, "/x", &err))
        fail_msg("refused: %s", glint_error_text(&err));
    return p;
}

static void refuse(const uint8_t *bytes, size_t size, const char *word)
{
    struct glint_error err = {0};
    struct glint_pixels p;
    assert_int_equal(glint_image_decode(&p, &arena, bytes, size, "/x", &err), GLINT_E_RANGE);
    assert_string_equal(err.fault[0].pointer, "/x");
    if (!strstr(err.fault[0].detail, word))
        fail_msg("\"%s\" does not say \"%s\"", err.fault[0].detail, word);
    glint_error_finish(&err);
}

static int forget(void **state)
{
    (void)state;
    glint_arena_finish(&arena);
    return 0;
}

// --- PNG

static void every_png_colour_type_becomes_rgba8(void **state)
{
    (void)state;
    static const struct {
        int depth, type;
        uint8_t row[16];
        uint8_t rgba[8];
    } kinds[] = {
        {8, PNG_COLOR_TYPE_RGBA, {1, 2, 3, 4, 5, 6, 7, 8}, {1, 2, 3, 4, 5, 6, 7, 8}},
        {8, PNG_COLOR_TYPE_RGB, {1, 2, 3, 5, 6, 7}, {1, 2, 3, 255, 5, 6, 7, 255}},
        {8, PNG_COLOR_TYPE_GRAY, {9, 200}, {9, 9, 9, 255, 200, 200, 200, 255}},
        {8, PNG_COLOR_TYPE_GRAY_ALPHA, {9, 4, 200, 5}, {9, 9, 9, 4, 200, 200, 200, 5}},
        {1, PNG_COLOR_TYPE_GRAY, {0x40}, {0, 0, 0, 255, 255, 255, 255, 255}},
        {1, PNG_COLOR_TYPE_PALETTE, {0x40}, {10, 20, 30, 0, 40, 50, 60, 255}},
        // 16 bits are rounded: 0x0180 / 257 = 1.49, 0xfe80 / 257 = 253.5
        {16,
         PNG_COLOR_TYPE_RGB,
         {1, 0x80, 0xff, 0xff, 0, 0, 0, 0, 0, 0, 0xfe, 0x90},
         {1, 255, 0, 255, 0, 0, 254, 255}},
    };
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        size_t size;
        uint8_t *png = make_png(2, 1, kinds[i].depth, kinds[i].type, PNG_INTERLACE_NONE,
                                kinds[i].row, 0, &size);
        const struct glint_pixels p = decode(png, size);
        assert_true(p.width == 2 && p.height == 1 && p.format == GLINT_IMAGE_RGBA8 && p.bytes == 8);
        assert_memory_equal(p.pixels, kinds[i].rgba, 8);
        free(png);
    }
}

static void interlaced_rows_come_out_in_order(void **state)
{
    (void)state;
    uint8_t rows[13 * 11], *png;
    size_t size;
    for (size_t i = 0; i < sizeof rows; i++)
        rows[i] = (uint8_t)(i * 7);
    png = make_png(13, 11, 8, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_ADAM7, rows, 13, &size);
    const struct glint_pixels p = decode(png, size);
    for (size_t i = 0; i < sizeof rows; i++)
        assert_int_equal(((const uint8_t *)p.pixels)[4 * i], rows[i]);
    free(png);
}

static void every_cut_of_a_png_is_refused(void **state)
{
    (void)state;
    uint8_t rows[64];
    size_t size;
    for (size_t i = 0; i < sizeof rows; i++)
        rows[i] = (uint8_t)(i * i);
    uint8_t *png = make_png(8, 8, 8, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, rows, 8, &size);
    for (size_t n = 0; n < size; n++) {
        uint8_t *cut = malloc(n ? n : 1);
        memcpy(cut, png, n);
        refuse(cut, n, "");
        free(cut);
    }
    png[size - 20] ^= 0x55; // in the compressed data
    refuse(png, size, "the PNG is damaged");
    free(png);
}

static void a_png_over_the_limits_is_refused_by_its_header(void **state)
{
    (void)state;
    static const uint8_t header[] =
        "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x40\x01\0\0\0\x01\x08\0\0\0\0";
    uint8_t png[33 + 12];
    memset(png, 0, sizeof png);
    memcpy(png, header, 29);
    refuse(png, sizeof png, "PNG"); // its CRC is wrong as well
    size_t size;
    uint8_t *row = calloc(1, 2048);
    uint8_t *large =
        make_png(16384, 8193, 1, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, row, 0, &size);
    refuse(large, size, "16384x8193");
    free(large);
    free(row);
}

// --- JPEG

static void jpeg_colours_arrive_within_their_coding_error(void **state)
{
    (void)state;
    uint8_t rows[16 * 16 * 3];
    size_t size;
    for (size_t i = 0; i < sizeof rows; i += 3)
        memcpy(rows + i, (const uint8_t[]){200, 100, 50}, 3);
    uint8_t *jpeg = make_jpeg(16, 16, 3, JCS_RGB, rows, &size);
    const struct glint_pixels p = decode(jpeg, size);
    assert_true(p.width == 16 && p.height == 16 && p.format == GLINT_IMAGE_RGBA8);
    for (size_t i = 0; i < 256; i++) {
        const uint8_t *c = (const uint8_t *)p.pixels + 4 * i;
        assert_true(abs(c[0] - 200) <= 2 && abs(c[1] - 100) <= 2 && abs(c[2] - 50) <= 2);
        assert_int_equal(c[3], 255);
    }
    free(jpeg);
}

static void grey_jpegs_have_three_equal_channels(void **state)
{
    (void)state;
    uint8_t rows[64];
    size_t size;
    memset(rows, 77, sizeof rows);
    uint8_t *jpeg = make_jpeg(8, 8, 1, JCS_GRAYSCALE, rows, &size);
    const struct glint_pixels p = decode(jpeg, size);
    for (size_t i = 0; i < 64; i++)
        assert_memory_equal((const uint8_t *)p.pixels + 4 * i, "\x4d\x4d\x4d\xff", 4);
    free(jpeg);
}

static void every_cut_of_a_jpeg_is_refused(void **state)
{
    (void)state;
    uint8_t rows[32 * 32 * 3];
    size_t size;
    for (size_t i = 0; i < sizeof rows; i++)
        rows[i] = (uint8_t)(i * i >> 3);
    uint8_t *jpeg = make_jpeg(32, 32, 3, JCS_RGB, rows, &size);
    for (size_t n = 0; n + 2 < size;
         n += n < 700 ? 1 : 37) { // the end marker itself may be missing
        uint8_t *cut = malloc(n ? n : 1);
        memcpy(cut, jpeg, n);
        refuse(cut, n, "");
        free(cut);
    }
    free(jpeg);
}

static void cmyk_jpegs_are_refused_by_name(void **state)
{
    (void)state;
    uint8_t rows[8 * 8 * 4] = {0};
    size_t size;
    uint8_t *jpeg = make_jpeg(8, 8, 4, JCS_CMYK, rows, &size);
    refuse(jpeg, size, "CMYK");
    free(jpeg);
}

// --- Radiance

#define HDR_HEAD "#?RADIANCE\n# comment\nFORMAT=32-bit_rle_rgbe\n"

static struct glint_pixels decode_hdr(const char *head, const void *data, size_t bytes)
{
    uint8_t file[512];
    const size_t n = strlen(head);
    memcpy(file, head, n);
    memcpy(file + n, data, bytes);
    return decode(file, n + bytes);
}

static void flat_radiance_pixels_are_mantissa_times_power(void **state)
{
    (void)state;
    // m * 2^(e-136): 128 at e = 129 is 1; 64, 32 are 1/2, 1/4; e = 0 is black
    static const uint8_t rgbe[] = {128, 64, 32, 129, 255, 255, 255, 0};
    static const uint16_t half[] = {0x3c00, 0x3800, 0x3400, 0x3c00, 0, 0, 0, 0x3c00};
    const struct glint_pixels p = decode_hdr(HDR_HEAD "\n-Y 2 +X 1\n", rgbe, sizeof rgbe);
    assert_true(p.width == 1 && p.height == 2 && p.format == GLINT_IMAGE_RGBA16F && p.bytes == 16);
    assert_memory_equal(p.pixels, half, sizeof half);
}

static void exposure_is_divided_out_and_large_values_are_clamped(void **state)
{
    (void)state;
    static const uint8_t rgbe[] = {128, 0, 0, 129, 255, 255, 255, 200};
    const struct glint_pixels p =
        decode_hdr(HDR_HEAD "EXPOSURE=2\nEXPOSURE=2\n\n-Y 1 +X 2\n", rgbe, sizeof rgbe);
    const uint16_t *h = p.pixels;
    assert_int_equal(h[0], 0x3400); // 1/4
    assert_int_equal(h[4], 0x7bff); // 65504
}

static void coded_scan_lines_hold_runs_and_literals(void **state)
{
    (void)state;
    static const uint8_t line[] = {2,   2,   0, 8,                    // eight pixels
                                   136, 128,                          // red: a run of 8
                                   8,   1,   2, 3,  4,  5,  6,  7, 8, // green: 8 literals
                                   132, 0,   4, 16, 16, 16, 16,       // blue: a run, then literals
                                   136, 129};
    const struct glint_pixels p = decode_hdr(HDR_HEAD "\n-Y 1 +X 8\n", line, sizeof line);
    const uint16_t *h = p.pixels;
    for (int x = 0; x < 8; x++) {
        assert_int_equal(h[4 * x], 0x3c00);
        assert_int_equal(h[4 * x + 2], x < 4 ? 0 : 0x3000); // 16/128 = 2^-3
    }
    assert_int_equal(h[1], 0x2000);         // 1/128 = 2^-7
    assert_int_equal(h[4 * 7 + 1], 0x2c00); // 8/128 = 2^-4
}

static void old_runs_repeat_the_last_pixel(void **state)
{
    (void)state;
    // 1 1 1 2 and 1 1 1 1: two, then one shifted by 8 bits: 256 more
    static const uint8_t line[] = {128, 128, 128, 129, 1, 1, 1, 2, 1, 1, 1, 1};
    const struct glint_pixels p = decode_hdr(HDR_HEAD "\n-Y 1 +X 259\n", line, sizeof line);
    for (int x = 0; x < 259; x++)
        assert_int_equal(((const uint16_t *)p.pixels)[4 * x], 0x3c00);
}

static void bad_radiance_files_are_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "#?",
        "#?RADIANCE\n",
        "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n1234",
        HDR_HEAD "\n+Y 1 +X 1\n1234",
        HDR_HEAD "\n-Y 1 +X 1 \n1234",
        HDR_HEAD "\n-Y 0 +X 1\n",
        HDR_HEAD "\n-Y 99999 +X 1\n1234",
        HDR_HEAD "\n-Y 1 +X 1\n123",
        HDR_HEAD "\n-Y 2 +X 1\n1234",
        HDR_HEAD "EXPOSURE=0\n\n-Y 1 +X 1\n1234",
        HDR_HEAD "EXPOSURE=nan\n\n-Y 1 +X 1\n1234",
        HDR_HEAD "\n-Y 1 +X 1\n\1\1\1\1",       // a run without a pixel
        HDR_HEAD "\n-Y 1 +X 2\n1234\1\1\1\2",   // a run over the end
        HDR_HEAD "\n-Y 1 +X 258\n\2\2\1\2\377", // ends in a run
        HDR_HEAD "\n-Y 1 +X 258\n\2\2\1\2\200", // ends in literals
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        refuse((const uint8_t *)bad[i], strlen(bad[i]), "");
}

static void other_formats_are_named(void **state)
{
    (void)state;
    refuse((const uint8_t *)"RIFF\0\0\0\0WEBP", 12, "WebP");
    refuse((const uint8_t *)"\xabKTX 20\xbb\r\n\x1a\n", 12, "KTX");
    refuse((const uint8_t *)"", 0, "0 bytes");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(every_png_colour_type_becomes_rgba8, forget),
        cmocka_unit_test_teardown(interlaced_rows_come_out_in_order, forget),
        cmocka_unit_test_teardown(every_cut_of_a_png_is_refused, forget),
        cmocka_unit_test_teardown(a_png_over_the_limits_is_refused_by_its_header, forget),
        cmocka_unit_test_teardown(jpeg_colours_arrive_within_their_coding_error, forget),
        cmocka_unit_test_teardown(grey_jpegs_have_three_equal_channels, forget),
        cmocka_unit_test_teardown(every_cut_of_a_jpeg_is_refused, forget),
        cmocka_unit_test_teardown(cmyk_jpegs_are_refused_by_name, forget),
        cmocka_unit_test_teardown(flat_radiance_pixels_are_mantissa_times_power, forget),
        cmocka_unit_test_teardown(exposure_is_divided_out_and_large_values_are_clamped, forget),
        cmocka_unit_test_teardown(coded_scan_lines_hold_runs_and_literals, forget),
        cmocka_unit_test_teardown(old_runs_repeat_the_last_pixel, forget),
        cmocka_unit_test_teardown(bad_radiance_files_are_refused, forget),
        cmocka_unit_test_teardown(other_formats_are_named, forget),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
