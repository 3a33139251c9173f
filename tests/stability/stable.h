// stable.h - renders whose every pixel and counter is checked as they are made.
#ifndef GLINT_TESTS_STABLE_H
#define GLINT_TESTS_STABLE_H

#include "tests/odds.h"
#include "tests/render/offline.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

// Scenes and jobs are written with ' for ". As printf; malloc'd.
char *stable_text(const char *format, ...) __attribute__((format(printf, 1, 2)));

// A job for the beauty pass; `members` are further ones: "'resolution':[8,8],...".
char *stable_job(const char *members);

// Fails the test unless every pixel is finite, none is negative where only light or coverage is
// shown, and at most one sample in 10^6 was rejected. The texts are freed.
struct glint_frame *stable_frame(const struct offline *o, char *scene, char *job);
struct glint_frame *stable_frame_of(const struct offline *o, glint_resident *scene, char *job);

// Samples that a render rejects. The texts are freed.
uint64_t stable_rejected(const struct offline *o, char *scene, char *job);

// Fails unless loading is refused with a fault at `pointer`. The text is freed.
void stable_refused(const struct offline *o, char *scene, const char *pointer);

size_t stable_pixels(const struct glint_frame *f);
double stable_most(const struct glint_frame *f, const char *channel);
double stable_least(const struct glint_frame *f, const char *channel);

// Mean over the pixels and its standard error, from their spread.
struct stable_mean {
    double mean, error;
};
struct stable_mean stable_mean(const struct glint_frame *f, const char *channel);

// Pixels of a channel with the same bits.
size_t stable_equal(const struct glint_frame *a, const struct glint_frame *b, const char *channel);
// Every channel has the same bits.
void stable_assert_same(const struct glint_frame *a, const struct glint_frame *b);

// A data URI of a Radiance or PNG picture; malloc'd. rgb: [height][width][3]. Radiance keeps eight
// bits of the largest channel; PNG is sRGB.
char *stable_hdr(uint32_t width, uint32_t height, const float *rgb);
char *stable_png(uint32_t width, uint32_t height, const float *rgb);

// Uniform in [0, 1), the same in every run.
double stable_random(uint64_t *state);

#endif
