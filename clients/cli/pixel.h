// pixel.h - three planes of a frame that belong together: a colour.
//
// Thread-safety: reentrant.
#ifndef GLINT_CLI_PIXEL_H
#define GLINT_CLI_PIXEL_H

#include "protocol/frame.h"

struct glint_rgb {
    double c[3]; // red, green, blue: scene-linear Rec. 709
};

// Relative luminance.
double glint_rgb_luminance(struct glint_rgb colour);

// "#rgb" or "#rrggbb" (sRGB, as the screen shows it), or "r,g,b" (scene-linear numbers of at least
// 0). False for anything else.
bool glint_rgb_read(const char *text, struct glint_rgb *out);

// The planes PREFIX.R, .G and .B, or R, G and B for the empty prefix; names of any case. False
// where one is missing.
bool glint_rgb_planes(const struct glint_frame *frame, const char *prefix, float *plane[3]);

#endif
