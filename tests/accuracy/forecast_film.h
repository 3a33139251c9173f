// forecast_film.h - films of many seeds at every look, kept as the means of their halves, so that
// estimates of their error can be made again without rendering.
//
// A seed's file FOLDER/SEED.means has, for each look, the means of half A and of half B, each
// [height][width][3] floats. Looks are at 2, 4, 8, 12, 16 samples, then at every 16, and from 2048 on
// at every 256.
#ifndef GLINT_TESTS_FORECAST_FILM_H
#define GLINT_TESTS_FORECAST_FILM_H

#include "render/estimate.h"

#include <stddef.h>
#include <stdint.h>

#define FORECAST_EARLY 4 // looks before 16 samples

struct forecast_films {
    const char *folder;
    uint32_t width, height, samples; // of the last look
    uint32_t first_seed, seeds;
};

// Renders the job with those seeds by one worker; a seed whose file is there already is left alone.
void forecast_film_record(const char *scene, const char *job, const struct forecast_films *films);

uint32_t forecast_film_looks(const struct forecast_films *films);
uint32_t forecast_film_samples(uint32_t look);

// The halves' means of a seed at all looks, [looks][2][height][width][3]; malloc'd.
float *forecast_film_read(const struct forecast_films *films, uint32_t seed);

// [2][height][width][3] of one look. What a job says of it.
void forecast_film_estimate(const struct forecast_films *films, const float *halves,
                            uint32_t samples, struct glint_film_estimate *out);

// Zeros; ends the program without memory.
void *forecast_room(size_t n, size_t size);

#endif
