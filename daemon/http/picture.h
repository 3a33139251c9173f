// picture.h - any one output of a frame as a picture for the eye.
//
// Colour goes through exposure, tone curve and sRGB. What is no colour is first made one: normals
// as in a normal map, depth from near (white) to far, samples relative to the most, and ID layers as
// the colours of their names weighted by coverage.
//
// Thread-safety: reentrant.
#ifndef GLINT_HTTP_PICTURE_H
#define GLINT_HTTP_PICTURE_H

#include "protocol/frame.h"
#include "protocol/png.h"

struct glint_picture {
    uint32_t output;  // one glint_output bit whose channels the frame has
    const char *type; // of mattes: the Cryptomatte type that is shown
    float exposure;   // stops
    enum glint_tonemap tonemap;
};
// *bytes is malloc'd.
glint_status glint_picture_encode(const struct glint_frame *frame,
                                  const struct glint_picture *picture, uint8_t **bytes,
                                  size_t *size, struct glint_error *err);

#endif
