// image_decode_png.c - PNG by libpng, any colour type to RGBA8.
#include "scene/image_decode.h"

#include <png.h>
#include <setjmp.h>
#include <stdio.h>
#include <string.h>

struct source {
    const uint8_t *at;
    size_t left;
    char why[120]; // of the failure
};

static void take(png_structp png, png_bytep out, size_t n)
{
    struct source *s = png_get_io_ptr(png);
    if (n > s->left)
        png_error(png, "the file ends early");
    memcpy(out, s->at, n);
    s->at += n;
    s->left -= n;
}

static void failed(png_structp png, png_const_charp why)
{
    struct source *s = png_get_error_ptr(png);
    snprintf(s->why, sizeof s->why, "%s", why);
    png_longjmp(png, 1);
}

static void warned(png_structp png, png_const_charp why)
{
    (void)png, (void)why;
}

static void ask_for_rgba8(png_structp png)
{
    png_set_expand(png);
    png_set_scale_16(png);
    png_set_gray_to_rgb(png);
    png_set_add_alpha(png, 0xff, PNG_FILLER_AFTER);
}

static glint_status read_rows(png_structp png, png_infop info, struct glint_pixels *out,
                              struct glint_arena *arena, const char *pointer,
                              struct glint_error *err)
{
    png_read_info(png, info);
    const glint_status st =
        glint_pixels_alloc(out, arena, png_get_image_width(png, info),
                           png_get_image_height(png, info), GLINT_IMAGE_RGBA8, pointer, err);
    if (st)
        return st;
    ask_for_rgba8(png);
    const int passes = png_set_interlace_handling(png);
    png_read_update_info(png, info);
    const size_t row = (size_t)out->width * 4;
    if (png_get_rowbytes(png, info) != row)
        png_error(png, "its rows are not RGBA");
    for (int pass = 0; pass < passes; pass++)
        for (uint32_t y = 0; y < out->height; y++)
            png_read_row(png, (png_bytep)out->pixels + y * row, NULL);
    png_read_end(png, NULL);
    return GLINT_OK;
}

glint_status glint_image_decode_png(struct glint_pixels *out, struct glint_arena *arena,
                                    const uint8_t *bytes, size_t size, const char *pointer,
                                    struct glint_error *err)
{
    struct source source = {.at = bytes, .left = size};
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &source, failed, warned);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    glint_status st;
    if (!info) {
        st = glint_fail(err, GLINT_E_NOMEM, pointer, "no memory for a PNG decoder");
    } else if (setjmp(png_jmpbuf(png))) {
        st = glint_fail(err, GLINT_E_RANGE, pointer, "the PNG is damaged: %s", source.why);
    } else {
        png_set_read_fn(png, &source, take);
        png_set_user_limits(png, GLINT_IMAGE_MAX_SIDE, GLINT_IMAGE_MAX_SIDE);
        png_set_chunk_cache_max(png, 128);
        png_set_chunk_malloc_max(png, 8u << 20);
        st = read_rows(png, info, out, arena, pointer, err);
    }
    png_destroy_read_struct(&png, &info, NULL);
    return st;
}
