#include "accuracy_metric.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FLOOR 0.01 // beside the squared value
#define SCALE 8.0  // of differences that are shown

// ---- the reference

glint_status glint_accuracy_reference_take(struct glint_accuracy_reference *out,
                                           struct glint_accuracy_image half[2], bool matte,
                                           struct glint_error *err)
{
    *out = (struct glint_accuracy_reference){.matte = matte, .half = {half[0], half[1]}};
    half[0] = half[1] = (struct glint_accuracy_image){0};
    glint_status st = glint_accuracy_image_align(&out->half[1], &out->half[0], err);
    if (!st)
        st = glint_accuracy_image_like(&out->mean, &out->half[0], err);
    const size_t pixels = (size_t)out->mean.width * out->mean.height;
    for (size_t c = 0; c < out->mean.channels; c++)
        for (size_t p = 0; p < pixels; p++)
            out->mean.channel[c].plane[p] =
                0.5f * (out->half[0].channel[c].plane[p] + out->half[1].channel[c].plane[p]);
    if (st)
        glint_accuracy_reference_finish(out);
    return st;
}

void glint_accuracy_reference_finish(struct glint_accuracy_reference *reference)
{
    glint_accuracy_image_finish(&reference->mean);
    glint_accuracy_image_finish(&reference->half[0]);
    glint_accuracy_image_finish(&reference->half[1]);
}

static size_t pixels_of(const struct glint_accuracy_reference *r)
{
    return (size_t)r->mean.width * r->mean.height;
}

// ---- colour

static void tone(const struct glint_accuracy_image *image, size_t p, double out[3])
{
    double most = 0;
    for (int c = 0; c < 3; c++)
        most = fmax(most, image->channel[c].plane[p]);
    for (int c = 0; c < 3; c++)
        out[c] = image->channel[c].plane[p] / (1 + most);
}

static double tone_distance(const struct glint_accuracy_image *a,
                            const struct glint_accuracy_image *b, size_t p)
{
    double x[3], y[3], sum = 0;
    tone(a, p, x);
    tone(b, p, y);
    for (int c = 0; c < 3; c++)
        sum += (x[c] - y[c]) * (x[c] - y[c]);
    return sum;
}

// Mean over the channels, each relative to the reference there.
static double relative_distance(const struct glint_accuracy_image *a,
                                const struct glint_accuracy_image *b,
                                const struct glint_accuracy_image *reference, size_t p)
{
    double sum = 0;
    for (int c = 0; c < 3; c++) {
        const double d = a->channel[c].plane[p] - b->channel[c].plane[p];
        const double r = reference->channel[c].plane[p];
        sum += d * d / (r * r + FLOOR);
    }
    return sum / 3;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Mean of all but the largest 0.1%, less the reference's variance.
static double trimmed(double *value, size_t count, double noise)
{
    const size_t kept = count - count / 1000;
    double sum = 0;
    qsort(value, count, sizeof *value, ascending);
    for (size_t i = 0; i < kept; i++)
        sum += value[i];
    return sum / (double)kept - noise;
}

static void compare_colour(struct glint_accuracy_error *out,
                           const struct glint_accuracy_image *image,
                           const struct glint_accuracy_reference *r)
{
    const size_t n = pixels_of(r);
    double *relative = malloc(n * sizeof *relative);
    double toned = 0, toned_noise = 0, sum = 0, noise = 0;
    for (size_t p = 0; p < n; p++) {
        const double d = relative_distance(image, &r->mean, &r->mean, p);
        toned += tone_distance(image, &r->mean, p);
        toned_noise += 0.25 * tone_distance(&r->half[0], &r->half[1], p);
        noise += 0.25 * relative_distance(&r->half[0], &r->half[1], &r->mean, p);
        sum += d;
        if (relative)
            relative[p] = d;
    }
    const double pixels = (double)n;
    out->rmse61 = sqrt(fmax(toned - toned_noise, 0) / pixels);
    out->relmse = (sum - noise) / pixels;
    out->relmse_trim = relative ? trimmed(relative, n, noise / pixels) : NAN;
    out->limited = toned_noise > 0.25 * toned;
    free(relative);
}

// ---- coverage

static double sum_at(const struct glint_accuracy_image *image, size_t p)
{
    double sum = 0;
    for (size_t c = 0; c < image->channels; c++)
        sum += image->channel[c].plane[p];
    return sum;
}

static double variation_at(const struct glint_accuracy_image *a,
                           const struct glint_accuracy_image *b, size_t p, double *most)
{
    double sum = 0;
    *most = 0;
    for (size_t c = 0; c < a->channels; c++) {
        const double d = fabs(a->channel[c].plane[p] - b->channel[c].plane[p]);
        sum += d;
        *most = fmax(*most, d);
    }
    return 0.5 * sum;
}

static void compare_mattes(struct glint_accuracy_error *out,
                           const struct glint_accuracy_image *image,
                           const struct glint_accuracy_reference *r)
{
    const size_t n = pixels_of(r);
    double variation = 0, lost = 0, within = 0, noise = 0, most, largest = 0;
    for (size_t p = 0; p < n; p++) {
        noise += 0.5 * variation_at(&r->half[0], &r->half[1], p, &most);
        variation += variation_at(image, &r->mean, p, &most);
        largest = fmax(largest, most);
        within += most <= 1.0 / 255;
        lost += fmax(sum_at(&r->mean, p) - sum_at(image, p), 0);
    }
    const double pixels = (double)n;
    out->tv = variation / pixels;
    out->matte_mae = 2 * out->tv / (double)image->channels;
    out->matte_max = largest;
    out->within = within / pixels;
    out->lost = lost / pixels;
    out->limited = noise * noise > 0.25 * variation * variation;
}

void glint_accuracy_compare(struct glint_accuracy_error *out,
                            const struct glint_accuracy_image *image,
                            const struct glint_accuracy_reference *reference)
{
    *out = (struct glint_accuracy_error){NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, false};
    if (reference->matte)
        compare_mattes(out, image, reference);
    else
        compare_colour(out, image, reference);
}

// ---- bias against variance

// Of one pixel: squared distance of the mean, variance of one image, variance of the reference.
static void spread_at(const struct glint_accuracy_image *mean,
                      const struct glint_accuracy_image *squares, unsigned seeds,
                      const struct glint_accuracy_reference *r, size_t p, double out[3])
{
    out[0] = out[1] = out[2] = 0;
    for (size_t c = 0; c < mean->channels; c++) {
        const double value = r->mean.channel[c].plane[p];
        const double weight = r->matte ? 1 : 1 / (3 * (value * value + FLOOR));
        const double d = mean->channel[c].plane[p] - value;
        const double h = r->half[0].channel[c].plane[p] - r->half[1].channel[c].plane[p];
        out[0] += weight * d * d;
        out[1] += weight * squares->channel[c].plane[p] / fmax(seeds - 1.0, 1);
        out[2] += weight * 0.25 * h * h;
    }
}

void glint_accuracy_spread(struct glint_accuracy_spread *out,
                           const struct glint_accuracy_image *mean,
                           const struct glint_accuracy_image *squares, unsigned seeds,
                           const struct glint_accuracy_reference *reference)
{
    const size_t n = pixels_of(reference);
    double sum = 0, sum2 = 0, variance = 0;
    for (size_t p = 0; p < n; p++) {
        double at[3];
        spread_at(mean, squares, seeds, reference, p, at);
        const double bias2 = at[0] - at[1] / seeds - at[2];
        sum += bias2;
        sum2 += bias2 * bias2;
        variance += at[1];
    }
    const double pixels = (double)n;
    out->bias2 = sum / pixels;
    out->bias2_se = sqrt(fmax(sum2 / pixels - out->bias2 * out->bias2, 0) / pixels);
    out->variance = variance / pixels;
}

void glint_accuracy_difference(const struct glint_accuracy_image *mean,
                               const struct glint_accuracy_reference *reference, float *plane[3])
{
    const size_t n = pixels_of(reference);
    for (size_t p = 0; p < n; p++) {
        double x[3], y[3], most;
        if (reference->matte) {
            plane[0][p] = (float)(SCALE * variation_at(mean, &reference->mean, p, &most));
            continue;
        }
        tone(mean, p, x);
        tone(&reference->mean, p, y);
        for (int c = 0; c < 3; c++)
            plane[c][p] = (float)(SCALE * fabs(x[c] - y[c]));
    }
}
