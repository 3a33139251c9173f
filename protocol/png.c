// png.c - tone curves, the sRGB transfer curve, and libpng.
#include "protocol/png.h"

#include <assert.h>
#include <math.h>
#include <png.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define MAX_EXPOSURE 64.0f

static float clip(float value)
{
    return fminf(value, 1.0f);
}

static float reinhard(float value)
{
    return 1.0f - 1.0f / (1.0f + value); // value/(1+value), but 1 for infinity
}

const struct glint_tonemap_row glint_tonemap_table[GLINT_TONEMAP_COUNT] = {
    [GLINT_TONEMAP_CLIP] = {"clip", clip, "what is above 1 becomes 1"},
    [GLINT_TONEMAP_REINHARD] = {"reinhard", reinhard,
                                "v/(1+v) in each channel, after Reinhard, "
                                "Stark, Shirley and Ferwerda 2002, Eq. 3"},
};

int glint_tonemap_from_name(const char *name)
{
    for (int i = 0; i < GLINT_TONEMAP_COUNT; i++)
        if (!strcmp(name, glint_tonemap_table[i].name))
            return i;
    return -1;
}

// From which linear value on each 8-bit code is the nearest, in sRGB (IEC 61966-2-1).
struct transfer {
    float from[256];
};

static void init_transfer(struct transfer *t)
{
    t->from[0] = 0;
    for (int code = 1; code < 256; code++) {
        const double v = (code - 0.5) / 255;
        t->from[code] = (float)(v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4));
    }
}

static uint8_t encode(const struct transfer *t, float value)
{
    unsigned code = 0;
    for (unsigned step = 128; step; step /= 2)
        if (value >= t->from[code + step])
            code += step;
    return (uint8_t)code;
}

// 0 for what is negative or not a number.
static float not_negative(float value)
{
    return value > 0 ? value : 0;
}

static uint8_t to_linear_code(float value)
{
    return (uint8_t)(fminf(not_negative(value), 1.0f) * 255.0f + 0.5f);
}

// Compresses 8-bit pixels; the buffer is as large as a PNG of that size can be, then shrunk.
static glint_status compress(png_image *image, const uint8_t *pixels, uint8_t **bytes, size_t *size,
                             struct glint_error *err)
{
    png_alloc_size_t length = PNG_IMAGE_PNG_SIZE_MAX(*image);
    uint8_t *file = malloc(length);
    if (!file)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a PNG of %ux%u pixels",
                          image->width, image->height);
    if (!png_image_write_to_memory(image, file, &length, 0, pixels, 0, NULL)) {
        free(file);
        return glint_fail(err, GLINT_E_INTERNAL, "", "PNG: %s", image->message);
    }
    uint8_t *shrunk = realloc(file, length);
    *bytes = shrunk ? shrunk : file;
    *size = length;
    return GLINT_OK;
}

static png_image describe(uint32_t width, uint32_t height, png_uint_32 format)
{
    return (png_image){.version = PNG_IMAGE_VERSION,
                       .width = width,
                       .height = height,
                       .format = format,
                       .flags = PNG_IMAGE_FLAG_FAST};
}

static void encode_pixels(const struct glint_png_image *image,
                          const struct glint_png_options *options, uint8_t *to)
{
    const float *const plane[3] = {image->red, image->green, image->blue};
    const float scale = exp2f(options->exposure);
    float (*const curve)(float) = glint_tonemap_table[options->tonemap].curve;
    struct transfer transfer;
    init_transfer(&transfer);
    for (size_t i = 0; i < (size_t)image->width * image->height; i++) {
        const float alpha = image->alpha ? image->alpha[i] : 1;
        const float gain = alpha > 0 ? scale / alpha : scale;
        for (int c = 0; c < 3; c++)
            *to++ = encode(&transfer, curve(not_negative(plane[c][i] * gain)));
        if (image->alpha)
            *to++ = to_linear_code(alpha);
    }
}

glint_status glint_png_color(const struct glint_png_image *image,
                             const struct glint_png_options *options, uint8_t **bytes, size_t *size,
                             struct glint_error *err)
{
    assert(options->tonemap >= 0 && options->tonemap < GLINT_TONEMAP_COUNT);
    *bytes = NULL;
    *size = 0;
    if (!(fabsf(options->exposure) <= MAX_EXPOSURE))
        return glint_fail(err, GLINT_E_RANGE, "/exposure", "%g stops, not -%g..%g",
                          options->exposure, MAX_EXPOSURE, MAX_EXPOSURE);
    png_image png =
        describe(image->width, image->height, image->alpha ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB);
    uint8_t *pixels = malloc(PNG_IMAGE_SIZE(png));
    if (!pixels)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %ux%u pixels", image->width,
                          image->height);
    encode_pixels(image, options, pixels);
    glint_status st = compress(&png, pixels, bytes, size, err);
    free(pixels);
    return st;
}

glint_status glint_png_coverage(const float *plane, uint32_t width, uint32_t height,
                                uint8_t **bytes, size_t *size, struct glint_error *err)
{
    *bytes = NULL;
    *size = 0;
    png_image png = describe(width, height, PNG_FORMAT_GRAY);
    const size_t pixels = (size_t)width * height;
    uint8_t *grey = malloc(pixels);
    if (!grey)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for %ux%u pixels", width, height);
    for (size_t i = 0; i < pixels; i++)
        grey[i] = to_linear_code(plane[i]);
    glint_status st = compress(&png, grey, bytes, size, err);
    free(grey);
    return st;
}
