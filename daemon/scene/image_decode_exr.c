// image_decode_exr.c - OpenEXR pictures to RGBA16F: environments as they are painted and captured.
#include "protocol/half.h"
#include "scene/exr_read.h"
#include "scene/image_decode.h"

#include <math.h>
#include <stdlib.h>

// What no light can be is made the nearest that it can, and counted.
static uint16_t radiance(float value, uint64_t *odd)
{
    const bool dark = !(value >= 0.0f); // negative or NaN
    *odd += dark;
    return dark ? 0 : glint_half_from_float(value, odd);
}

static glint_status refuse(enum glint_exr_result result, const struct glint_exr_fault *fault,
                           const char *pointer, struct glint_error *err)
{
    if (result == GLINT_EXR_NOMEM)
        return glint_fail(err, GLINT_E_NOMEM, pointer, "no memory for the OpenEXR picture");
    return glint_fail(err, GLINT_E_RANGE, pointer, "the OpenEXR picture is not read: %s",
                      fault->text);
}

static glint_status read_rows(struct glint_exr *exr, struct glint_pixels *out, float *row,
                              const char *pointer, struct glint_error *err)
{
    struct glint_exr_fault fault;
    uint16_t *to = out->pixels;
    for (uint32_t y = 0; y < out->height; y++) {
        const enum glint_exr_result result = glint_exr_row(exr, y, row, &fault);
        if (result)
            return refuse(result, &fault, pointer, err);
        for (uint32_t x = 0; x < out->width; x++, to += 4) {
            for (int c = 0; c < 3; c++)
                to[c] = radiance(row[3 * x + c], &out->clamped);
            to[3] = 0x3c00;
        }
    }
    return GLINT_OK;
}

glint_status glint_image_decode_exr(struct glint_pixels *out, struct glint_arena *arena,
                                    const uint8_t *bytes, size_t size, const char *pointer,
                                    struct glint_error *err)
{
    struct glint_exr *exr;
    struct glint_exr_fault fault;
    const enum glint_exr_result result =
        glint_exr_open(&exr, bytes, size, GLINT_IMAGE_MAX_SIDE, &fault);
    if (result)
        return refuse(result, &fault, pointer, err);
    glint_status st = glint_pixels_alloc(out, arena, glint_exr_width(exr), glint_exr_height(exr),
                                         GLINT_IMAGE_RGBA16F, pointer, err);
    float *row = st ? NULL : malloc((size_t)out->width * 3 * sizeof *row);
    if (!st && !row)
        st = glint_fail(err, GLINT_E_NOMEM, pointer, "no memory for a row of pixels");
    if (!st)
        st = read_rows(exr, out, row, pointer, err);
    free(row);
    glint_exr_close(&exr);
    return st;
}
