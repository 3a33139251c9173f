// estimate.h - the job's own error, from the difference of its two independent halves, or of its
// sixteen batches.
//
// Source: ACCURACY 5. With n = nA + nB samples, v = (A - B)^2 nA nB / n^2 is an unbiased estimate
// of the variance of a pixel's mean: (A - B)^2 / 4 for halves of one size. So is, of K batches,
// v = sum of n_k (m_k - m)^2 / ((K - 1) n), once each has a sample.
//
// Relative errors are v / (m^2 + 0.01). With a pixel's own mean for m a rare bright sample would hide
// itself, for it lifts both; with its neighbours' alone what is bright would be taken for chance. So m is
// the posterior mean of a normal law around the median of the neighbours (Efron and Morris 1973): from the
// pixel's own mean it goes towards that by v / (v + t), where the law's variance t is what the own
// mean is off by more than v, (mean - median)^2 - v, or what the neighbours differ among each other,
// whichever is more. The median: of a pixel at a lamp's edge three neighbours are of the lamp, and their mean
// is brighter than any sample.
//
// How far the sum of v may
// be off is taken from neighbouring pixels: (v - v')^2 estimates the variance of v + v' where both
// are alike, whatever the kurtosis of their noise, and more where they are not.
#ifndef GLINT_RENDER_ESTIMATE_H
#define GLINT_RENDER_ESTIMATE_H

#include "protocol/film_header.h"

#include <stdbool.h>
#include <stdint.h>

#define GLINT_TAIL_BINS 256    // of pixel variances, GLINT_TAIL_STEPS to an octave
#define GLINT_TAIL_STEPS 4     // the middle bin begins at 1
#define GLINT_ESTIMATE_CELLS 8 // along a side of the grid of parts of a picture

// Sums over the pixels of a film tile; r, g and b count as three.
struct glint_tile_estimate {
    double relative;               // of v / (m^2 + 0.01)
    double own;                    // the same with m the pixel's own mean
    double most;                   // the same with t only what the pixel's own mean asks for
    double spread;                 // variance of that sum
    double linear;                 // of v
    double tone;                   // of v of T(A) and T(B), T(c) = c / (1 + max(r, g, b))
    uint8_t tail[GLINT_TAIL_BINS]; // pixels by their v, r, g and b summed
};

// What a film holds, measured when a pass of it ended.
struct glint_film_estimate {
    struct glint_estimate whole;
    uint32_t cells; // tiles of the film by where they are; 0: not known
    double relative[GLINT_ESTIMATE_CELLS * GLINT_ESTIMATE_CELLS];
    double spread[GLINT_ESTIMATE_CELLS * GLINT_ESTIMATE_CELLS];
};

// A tile's sums, of the samples [first, first + samples), 2 or more.
struct glint_estimate_source {
    const float *planes;
    const float *batches; // NULL: none
    bool wide;            // sums are doubles
    uint32_t first, samples;
};

// Of the pixels 0 <= x < w, 0 <= y < h of a tile.
void glint_estimate_tile(struct glint_tile_estimate *out, const struct glint_estimate_source *in,
                         uint32_t w, uint32_t h);

// Of the film whose tiles these are, row by row; pixels: of the film. In the order of the tiles, so
// that a decision does not depend on who rendered them.
void glint_estimate_film(struct glint_film_estimate *out, const struct glint_tile_estimate *tile,
                         uint32_t columns, uint32_t rows, uint64_t pixels);

// The ends of the interval around an error that holds in 9 of 10 cases.
void glint_estimate_interval(const struct glint_estimate *e, double interval[2]);

// Upper end of the interval for look number `look`, from 1 on: in one job of twenty, with however
// many looks, the error lies above one of them. Source: alpha spent as 1/(k (k + 1)).
double glint_estimate_upper(const struct glint_estimate *e, uint32_t look);

// Whether an estimate may miss what is still to come. Few pixels have much of the variance: Hill's
// index of the worst hundredth lies below 2.5 with 95 % confidence; or their means are theirs by a few
// samples: where neighbours are believed whenever noise allows it, they lift the error by more than 10 %.
bool glint_estimate_rare(const struct glint_estimate *e);

// Whether it may miss so much that nothing can be said of what is to come but at least: the same with
// a lift of more than 40 %.
bool glint_estimate_heavy(const struct glint_estimate *e);

// Sample counts at which a job that stops by error looks at itself: 16, 32, then in steps of about
// 2^(1/4), whole passes. Returns the number of the look, from 1 on; 0: none is due.
uint32_t glint_estimate_look(uint32_t samples);

// x so that a normal number lies below it with probability p, 0 < p < 1.
double glint_normal_quantile(double p);

#endif
