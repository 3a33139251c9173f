// recolour.h - another colour for what a matte covers, in a finished picture.
//
// The picture is scene-linear. Of a pixel `in` that the matte covers by a share alpha, that share
// is F, what the matte's surface shows there, and the rest is none of ours:
//
//   out = in + alpha (T F - F)        T_k(F) = c_k (u_k F_k / a_k + (1 - u_k) F_j / a_j)
//
// c is the new colour, a the old one, j its largest component and u_k = (a_k / a_j)^2. The bracket
// is the light that falls on the surface, seen through the old colour: of each component by itself
// where the old colour has it, so that coloured light stays coloured, and of the largest where it
// has not, so that a highlight or noise is not blown up. A surface of colour a under white light
// becomes one of colour c exactly; hue and saturation are c's, shading and texture stay.
//
// The old colour a is the mean albedo under the matte, where the frame has an albedo; the albedo is
// recoloured by the same T, so that the frame can be recoloured again. Otherwise it is the mean of
// the picture under the matte, scaled to the luminance of c: then the surface keeps its brightness.
// Of a matte through bounces only what is seen directly has an albedo of its own: where mirrors and
// glass show the surface the albedo is theirs.
//
// At an edge F is not in the file. It is the mean of the pixels around, those that the matte covers
// most counting by far the most, and never more than the pixel holds (F <= in / alpha): the
// background keeps its colour, the edge gets the new one.
//
// Thread-safety: reentrant.
#ifndef GLINT_CLI_RECOLOUR_H
#define GLINT_CLI_RECOLOUR_H

#include "pixel.h"

struct glint_recolour {
    uint32_t width, height;
    const float *matte;  // [height][width], 0..1
    const float *direct; // likewise, what is seen directly; may be `matte`
    float *picture[3];   // changed in place
    float *albedo[3];    // changed in place, or NULL
    struct glint_rgb colour;
};

struct glint_recoloured {
    struct glint_rgb old; // the colour that was there
    bool by_albedo;       // known from the albedo of what is seen directly; else from the picture
    double covered;       // pixels of the matte, 0: nothing was changed
};
// GLINT_E_NOMEM only.
glint_status glint_recolour(const struct glint_recolour *r, struct glint_recoloured *out,
                            struct glint_error *err);

#endif
