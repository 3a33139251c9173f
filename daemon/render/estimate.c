#include "render/estimate.h"

#include "kernels/gk_film.h"
#include "protocol/film.h"

#include <math.h>

double glint_estimate_tile(const float *planes, bool wide, const uint32_t half[2], uint32_t w,
                           uint32_t h)
{
    double sum = 0.0;
    for (uint32_t y = 0; y < h; y++)
        for (uint32_t x = 0; x < w; x++)
            for (uint32_t c = 0; c < 3; c++) {
                const uint32_t i = y * GK_TILE_SIDE + x;
                const double a = glint_film_mean(planes, wide, 0, c, i, half[0]);
                const double b = glint_film_mean(planes, wide, 1, c, i, half[1]);
                const double m = (a * half[0] + b * half[1]) / (half[0] + half[1]);
                sum += 0.25 * (a - b) * (a - b) / (m * m + 0.01);
            }
    return sum;
}

double glint_estimate_upper(double error, uint64_t pixels)
{
    // The relative standard deviation of the estimate is 1/sqrt(2 P) for P independent pixels.
    return error * (1.0 + 3.29 / sqrt(2.0 * (double)pixels));
}

bool glint_estimate_checkpoint(uint32_t samples)
{
    double next = 16.0;
    while (next < samples)
        next = ceil(next * 1.189207 / 16.0) * 16.0;
    return samples > 0 && next == samples;
}
