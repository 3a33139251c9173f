// scores.h - whether pixels are as near to the truth as their sixteen batches say.
//
// A pixel's mean m has, from its batches, the variance v. z = (m - r) / sqrt(v + v_r), r the mean of
// the other seeds and v_r its variance from their batches, follows Student's law of 15 degrees, for
// which |z| < 2.13 in 95 of 100 cases, where batches are near enough to normal.
#ifndef GLINT_TESTS_SCORES_H
#define GLINT_TESTS_SCORES_H

#include "tests/render/offline.h"

struct scores {
    uint64_t values, inside; // r, g and b of pixels that have noise, for each seed
};

// Renders the job with seeds 1 to `seeds`, 3 or more, with batches.
struct scores scores_take(const struct offline *o, const struct glint_posed *rest,
                          struct glint_job *job, uint32_t seeds);

#endif
