// accuracy_image.h - a frame as planes that can be compared: colour, or coverage by name.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_ACCURACY_IMAGE_H
#define GLINT_CLI_ACCURACY_IMAGE_H

#include "protocol/frame.h"

#define GLINT_ACCURACY_CHANNELS 48 // the last one of mattes is for all other names

struct glint_accuracy_image {
    uint32_t width, height;
    size_t channels;
    struct {
        char type[32]; // "R", "CryptoObject"
        uint32_t id;   // of coverage
        float *plane;  // owned, [height][width]
    } channel[GLINT_ACCURACY_CHANNELS];
};

// Colour: R G B. Coverage: of the Cryptomatte types of objects, the names that cover most.
//   GLINT_E_RANGE  the frame has not what is asked for
glint_status glint_accuracy_image_take(struct glint_accuracy_image *out,
                                       const struct glint_frame *frame, bool matte,
                                       struct glint_error *err);
void glint_accuracy_image_finish(struct glint_accuracy_image *image);

// The same coverage with the channels of `like`: what it has not goes to its last. Where `like` has
// coverage through reflections and the image has none, what is seen directly stands for it.
glint_status glint_accuracy_image_align(struct glint_accuracy_image *image,
                                        const struct glint_accuracy_image *like,
                                        struct glint_error *err);

// Zeroed planes with the names and size of `like`.
glint_status glint_accuracy_image_like(struct glint_accuracy_image *out,
                                       const struct glint_accuracy_image *like,
                                       struct glint_error *err);

#endif
