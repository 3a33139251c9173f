// accuracy_mean.h - the mean of a setting's images over its seeds, kept in the report's folder.
//
// Kept after every seed, with the set of seeds that are in it, so that a run that was broken off
// goes on: Welford 1962, one image at a time.
//
// Thread-safety: one owner.
#ifndef GLINT_CLI_ACCURACY_MEAN_H
#define GLINT_CLI_ACCURACY_MEAN_H

#include "accuracy_image.h"

#define GLINT_ACCURACY_SEEDS 31 // at most

struct glint_accuracy_mean {
    struct glint_accuracy_image mean, squares; // sums of squared deviations
    uint32_t seeds;                            // bit 1 << seed
};

unsigned glint_accuracy_mean_count(const struct glint_accuracy_mean *mean);

// What is kept under `name`, with the channels of `like`; nothing kept: no seed.
glint_status glint_accuracy_mean_load(struct glint_accuracy_mean *out, const char *folder,
                                      const char *name, const struct glint_accuracy_image *like,
                                      struct glint_error *err);
void glint_accuracy_mean_add(struct glint_accuracy_mean *mean, unsigned seed,
                             const struct glint_accuracy_image *image);
glint_status glint_accuracy_mean_save(const struct glint_accuracy_mean *mean, const char *folder,
                                      const char *name, struct glint_error *err);
void glint_accuracy_mean_finish(struct glint_accuracy_mean *mean);

#endif
