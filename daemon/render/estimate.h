// estimate.h - the job's own error, from the difference of its two independent halves.
//
// Source: ACCURACY 5: v = (A - B)^2 / 4 is an unbiased estimate of the variance of the mean.
#ifndef GLINT_RENDER_ESTIMATE_H
#define GLINT_RENDER_ESTIMATE_H

#include "render/film.h"

// Sum over the pixels (0 <= x < w, 0 <= y < h of the tile) and RGB of v / (m^2 + 0.01). The caller
// holds the tile; samples >= 2.
double glint_estimate_tile(const struct glint_film_tile *at, bool wide, uint32_t samples,
                           uint32_t w, uint32_t h);

// Mean of one half of a pixel: sum over its `n` samples / n. i: pixel of the tile.
float glint_film_mean(const float *planes, bool wide, uint32_t half, uint32_t channel, uint32_t i,
                      uint32_t n);

// Samples that went into half 0 or 1 of `samples`.
uint32_t glint_half_samples(uint32_t samples, uint32_t half);

// Upper end of the interval around an estimate over `pixels` pixels, one in a thousand looks.
double glint_estimate_upper(double error, uint64_t pixels);

// Sample counts at which a job that stops by error looks at itself: 16, 32, then in steps of about
// 2^(1/4), whole passes.
bool glint_estimate_checkpoint(uint32_t samples);

#endif
