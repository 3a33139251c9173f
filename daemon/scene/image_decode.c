// image_decode.c - which decoder, and the limits that all of them keep.
#include "scene/image_decode.h"

#include <string.h>

glint_status glint_pixels_alloc(struct glint_pixels *out, struct glint_arena *arena, uint32_t width,
                                uint32_t height, enum glint_image_format format,
                                const char *pointer, struct glint_error *err)
{
    if (!width || !height || width > GLINT_IMAGE_MAX_SIDE || height > GLINT_IMAGE_MAX_SIDE ||
        (uint64_t)width * height > GLINT_IMAGE_MAX_PIXELS)
        return glint_fail(err, GLINT_E_RANGE, pointer,
                          "the image is %ux%u; at most %u on a side and %u pixels in all", width,
                          height, GLINT_IMAGE_MAX_SIDE, GLINT_IMAGE_MAX_PIXELS);
    const size_t pixel = format == GLINT_IMAGE_RGBA8 ? 4 : 8;
    *out = (struct glint_pixels){.width = width, .height = height, .format = format};
    out->bytes = (size_t)width * height * pixel;
    out->pixels = glint_arena_alloc(arena, out->bytes);
    if (!out->pixels)
        return glint_fail(err, GLINT_E_NOMEM, pointer, "no memory for an image of %ux%u", width,
                          height);
    return GLINT_OK;
}

static bool starts(const uint8_t *bytes, size_t size, const char *magic, size_t length)
{
    return size >= length && memcmp(bytes, magic, length) == 0;
}

glint_status glint_image_decode(struct glint_pixels *out, struct glint_arena *arena,
                                const uint8_t *bytes, size_t size, const char *pointer,
                                struct glint_error *err)
{
    *out = (struct glint_pixels){0};
    if (starts(bytes, size, "\x89PNG\r\n\x1a\n", 8))
        return glint_image_decode_png(out, arena, bytes, size, pointer, err);
    if (starts(bytes, size, "\xff\xd8\xff", 3))
        return glint_image_decode_jpeg(out, arena, bytes, size, pointer, err);
    if (starts(bytes, size, "#?", 2))
        return glint_image_decode_hdr(out, arena, bytes, size, pointer, err);
    if (starts(bytes, size, "\x76\x2f\x31\x01", 4))
        return glint_image_decode_exr(out, arena, bytes, size, pointer, err);
    if (starts(bytes, size, "RIFF", 4))
        return glint_fail(err, GLINT_E_RANGE, pointer, "the image is WebP, which is not read");
    if (starts(bytes, size, "\xabKTX", 4))
        return glint_fail(err, GLINT_E_RANGE, pointer, "the image is KTX, which is not read");
    return glint_fail(err, GLINT_E_RANGE, pointer,
                      "the image of %zu bytes is not PNG, JPEG, Radiance or OpenEXR", size);
}
