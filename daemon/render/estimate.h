// estimate.h - the job's own error, from the difference of its two independent halves.
//
// Source: ACCURACY 5: v = (A - B)^2 / 4 is an unbiased estimate of the variance of the mean.
#ifndef GLINT_RENDER_ESTIMATE_H
#define GLINT_RENDER_ESTIMATE_H

#include <stdbool.h>
#include <stdint.h>

// Sum over the pixels (0 <= x < w, 0 <= y < h of the tile) and RGB of v / (m^2 + 0.01). half:
// samples of the halves, both > 0.
double glint_estimate_tile(const float *planes, bool wide, const uint32_t half[2], uint32_t w,
                           uint32_t h);

// Upper end of the interval around an estimate over `pixels` pixels, one in a thousand looks.
double glint_estimate_upper(double error, uint64_t pixels);

// Sample counts at which a job that stops by error looks at itself: 16, 32, then in steps of about
// 2^(1/4), whole passes.
bool glint_estimate_checkpoint(uint32_t samples);

#endif
