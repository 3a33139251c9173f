// accuracy_metric.h - how far an image is from a reference that is itself known up to its noise.
//
// The reference comes as two halves with seeds of their own: their mean is compared with, and a
// quarter of their squared difference, its variance, is taken off every squared error.
//
// Thread-safety: reentrant.
#ifndef GLINT_CLI_ACCURACY_METRIC_H
#define GLINT_CLI_ACCURACY_METRIC_H

#include "accuracy_image.h"

struct glint_accuracy_reference {
    struct glint_accuracy_image mean, half[2]; // equal channels
    bool matte;
};

// Takes both halves; *out then owns them.
glint_status glint_accuracy_reference_take(struct glint_accuracy_reference *out,
                                           struct glint_accuracy_image half[2], bool matte,
                                           struct glint_error *err);
void glint_accuracy_reference_finish(struct glint_accuracy_reference *reference);

// NAN: not of this kind of image.
struct glint_accuracy_error {
    double rmse61; // after c / (1 + max(r, g, b)); of a pixel's three channels together
    double relmse, relmse_trim; // mean of (x-r)^2/(r^2+0.01); without the worst 0.1% of pixels
    double matte_mae, matte_max, tv, lost, within; // of coverage; within 1/255
    bool limited; // the variance of the reference is over a quarter of the squared error
};
void glint_accuracy_compare(struct glint_accuracy_error *out,
                            const struct glint_accuracy_image *image,
                            const struct glint_accuracy_reference *reference);

// Bias against variance, of the mean of `seeds` images and their squared deviations from it.
// Colour: relative, as relmse. Coverage: the sum over a pixel's names.
struct glint_accuracy_spread {
    double bias2;    // may be slightly negative
    double bias2_se; // its standard error over the pixels
    double variance; // of one image
};
void glint_accuracy_spread(struct glint_accuracy_spread *out,
                           const struct glint_accuracy_image *mean,
                           const struct glint_accuracy_image *squares, unsigned seeds,
                           const struct glint_accuracy_reference *reference);

// |mean - reference| x 8 of tone-mapped colour, three planes, or of the total variation, one.
void glint_accuracy_difference(const struct glint_accuracy_image *mean,
                               const struct glint_accuracy_reference *reference, float *plane[3]);

#endif
