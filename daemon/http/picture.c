#include "http/picture.h"

#include "protocol/job.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MISS 1e29f // depths from here on are no surface

static const struct {
    uint32_t output;
    const char *name[4]; // channels; one stands for grey
} layout[] = {
    {GLINT_OUT_BEAUTY, {"R", "G", "B", "A"}},
    {GLINT_OUT_ALBEDO, {"albedo.R", "albedo.G", "albedo.B"}},
    {GLINT_OUT_VARIANCE, {"variance.R", "variance.G", "variance.B"}},
    {GLINT_OUT_NORMAL, {"N.X", "N.Y", "N.Z"}},
    {GLINT_OUT_DEPTH, {"Z"}},
    {GLINT_OUT_SAMPLES, {"samples.Y"}},
    {GLINT_OUT_MOTION, {"forward.u", "forward.v", "forward.v"}},
    {GLINT_OUT_MATTE_SUMS, {"sums.bounced", "sums.lost_primary", "sums.lost_bounced"}},
};

// Adds the colours of the IDs of one rank. A colour is a name's hash, bright enough to be seen.
static void add_rank(const float *id, const float *coverage, size_t pixels, float *rgb)
{
    for (size_t i = 0; i < pixels; i++) {
        uint32_t bits;
        memcpy(&bits, &id[i], sizeof bits);
        for (int c = 0; bits && c < 3; c++)
            rgb[c * pixels + i] += coverage[i] * (0.05f + (bits >> (8 * c) & 255) / 270.f);
    }
}

static glint_status paint_ids(const struct glint_frame *frame, const char *type, float *rgb,
                              struct glint_error *err)
{
    static const char component[] = "RGBA";
    const size_t pixels = (size_t)frame->width * frame->height;
    for (int rank = 0;; rank++) {
        const float *plane[2];
        for (int k = 0; k < 2; k++) {
            char name[32];
            snprintf(name, sizeof name, "%s%02d.%c", type, rank / 2, component[2 * (rank % 2) + k]);
            plane[k] = glint_frame_find(frame, name);
        }
        if (!plane[0] || !plane[1])
            return rank ? GLINT_OK
                        : glint_fail(err, GLINT_E_INTERNAL, "", "the frame has no %s", type);
        add_rank(plane[0], plane[1], pixels, rgb);
    }
}

// From -1 to 1. Undoes the transfer curve that follows: without exposure the bytes are those of a
// normal map.
static void paint_signed(float *rgb, size_t values)
{
    for (size_t i = 0; i < values; i++) {
        const float shown = fmaxf(0.5f * rgb[i] + 0.5f, 0);
        rgb[i] = shown <= 0.04045f ? shown / 12.92f : powf((shown + 0.055f) / 1.055f, 2.4f);
    }
}

static void paint_depth(float *grey, size_t pixels)
{
    float near = INFINITY, far = -INFINITY;
    for (size_t i = 0; i < pixels; i++)
        if (grey[i] < MISS) {
            near = fminf(near, grey[i]);
            far = fmaxf(far, grey[i]);
        }
    const float range = far > near ? far - near : 1;
    for (size_t i = 0; i < pixels; i++)
        grey[i] = grey[i] < MISS ? 1 - 0.9f * (grey[i] - near) / range : 0;
}

static void paint_samples(float *grey, size_t pixels)
{
    float most = 1;
    for (size_t i = 0; i < pixels; i++)
        most = fmaxf(most, grey[i]);
    for (size_t i = 0; i < pixels; i++)
        grey[i] /= most;
}

// Grey is rest; the fastest pixel reaches 0 or 1, of u in red and of v in green.
static void paint_motion(float *rgb, size_t pixels)
{
    float most = 1e-30f;
    for (size_t i = 0; i < 2 * pixels; i++)
        most = fmaxf(most, fabsf(rgb[i]));
    for (size_t i = 0; i < 2 * pixels; i++)
        rgb[i] /= most;
    memset(rgb + 2 * pixels, 0, pixels * sizeof *rgb);
}

// Copies the output's planes to rgb[3][pixels] and makes them a colour.
static glint_status paint(const struct glint_frame *frame, const struct glint_picture *picture,
                          float *rgb, const float **alpha, struct glint_error *err)
{
    const size_t pixels = (size_t)frame->width * frame->height;
    const uint32_t output = picture->output;
    if (output & GLINT_OUT_CRYPTO)
        return paint_ids(frame, picture->type, rgb, err);
    size_t row = 0;
    while (layout[row].output != output)
        row++;
    for (int c = 0; c < 3; c++) {
        const char *name = layout[row].name[c] ? layout[row].name[c] : layout[row].name[0];
        const float *plane = glint_frame_find(frame, name);
        if (!plane)
            return glint_fail(err, GLINT_E_INTERNAL, "", "the frame has no channel %s", name);
        memcpy(rgb + c * pixels, plane, pixels * sizeof *rgb);
        if (output == GLINT_OUT_DEPTH)
            paint_depth(rgb + c * pixels, pixels);
        else if (output == GLINT_OUT_SAMPLES)
            paint_samples(rgb + c * pixels, pixels);
    }
    if (output == GLINT_OUT_MOTION)
        paint_motion(rgb, pixels);
    if (output == GLINT_OUT_NORMAL || output == GLINT_OUT_MOTION)
        paint_signed(rgb, 3 * pixels);
    *alpha = layout[row].name[3] ? glint_frame_find(frame, layout[row].name[3]) : NULL;
    return GLINT_OK;
}

glint_status glint_picture_encode(const struct glint_frame *frame,
                                  const struct glint_picture *picture, uint8_t **bytes,
                                  size_t *size, struct glint_error *err)
{
    const size_t pixels = (size_t)frame->width * frame->height;
    float *rgb = calloc(pixels, 3 * sizeof *rgb);
    if (!rgb)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a picture");
    struct glint_png_image image = {.width = frame->width,
                                    .height = frame->height,
                                    .red = rgb,
                                    .green = rgb + pixels,
                                    .blue = rgb + 2 * pixels};
    const struct glint_png_options options = {.exposure = picture->exposure,
                                              .tonemap = picture->tonemap};
    glint_status st = paint(frame, picture, rgb, &image.alpha, err);
    if (!st)
        st = glint_png_color(&image, &options, bytes, size, err);
    free(rgb);
    return st;
}
