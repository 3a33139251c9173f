#include "render/estimate.h"

#include "kernels/gk_film.h"

#include <math.h>

uint32_t glint_half_samples(uint32_t samples, uint32_t half)
{
    return (samples + 1 - half) / 2;
}

float glint_film_mean(const float *planes, bool wide, uint32_t half, uint32_t channel, uint32_t i,
                      uint32_t n)
{
    const float *sum = planes + (GK_PLANE_COLOUR + half * 6 + channel * 2) * GK_TILE_PIXELS;
    const double total = wide ? ((const double *)(const void *)sum)[i]
                              : (double)sum[i] + (double)sum[i + GK_TILE_PIXELS];
    return n ? (float)(total / n) : 0.0f;
}

double glint_estimate_tile(const struct glint_film_tile *at, bool wide, uint32_t samples,
                           uint32_t w, uint32_t h)
{
    const float *planes = (const float *)glint_buffer_host(at->planes) + at->planes_offset;
    const uint32_t na = glint_half_samples(samples, 0), nb = glint_half_samples(samples, 1);
    double sum = 0.0;
    for (uint32_t y = 0; y < h; y++)
        for (uint32_t x = 0; x < w; x++)
            for (uint32_t c = 0; c < 3; c++) {
                const uint32_t i = y * GK_TILE_SIDE + x;
                const double a = glint_film_mean(planes, wide, 0, c, i, na);
                const double b = glint_film_mean(planes, wide, 1, c, i, nb);
                const double m = (a * na + b * nb) / samples;
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
