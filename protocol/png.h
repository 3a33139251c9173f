// png.h - pictures for the eye: float planes as an 8-bit PNG in memory.
//
// Thread-safety: reentrant.
#ifndef GLINT_PROTOCOL_PNG_H
#define GLINT_PROTOCOL_PNG_H

#include "status.h"

#include <stdint.h>

// Tone curves, each applied to every channel by itself: [0, inf] to [0, 1], increasing.
enum glint_tonemap { GLINT_TONEMAP_CLIP, GLINT_TONEMAP_REINHARD, GLINT_TONEMAP_COUNT };

struct glint_tonemap_row {
    const char *name;            // in requests
    float (*curve)(float value); // value: linear, >= 0, may be infinite
    const char *description;
};

extern const struct glint_tonemap_row glint_tonemap_table[GLINT_TONEMAP_COUNT];

// Index of the named curve, or -1.
int glint_tonemap_from_name(const char *name);

// Planes of [height][width] scene-linear Rec. 709 values, colour premultiplied by alpha.
struct glint_png_image {
    uint32_t width, height; // 1..GLINT_MAX_SIDE
    const float *red, *green, *blue;
    const float *alpha; // NULL: an opaque picture; otherwise colour is divided by it where not 0
};

struct glint_png_options {
    float exposure; // stops, -64..64
    enum glint_tonemap tonemap;
};

// sRGB. What is negative or not a number is shown as 0. *bytes is malloc'd, without dates.
//   GLINT_E_RANGE  /exposure is out of range
//   GLINT_E_NOMEM
glint_status glint_png_color(const struct glint_png_image *image,
                             const struct glint_png_options *options, uint8_t **bytes, size_t *size,
                             struct glint_error *err);

// Grey, 255 for coverage 1, in proportion and without a transfer curve: a mask, not a picture.
glint_status glint_png_coverage(const float *plane, uint32_t width, uint32_t height,
                                uint8_t **bytes, size_t *size, struct glint_error *err);

#endif
