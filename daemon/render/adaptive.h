// adaptive.h - where the samples of an adaptive job go: more to tiles that are noisier.
//
// The first 16 samples of all pixels are a pilot. What it says of the noise of each tile decides the
// tile's share of the rest, once; then the pilot is thrown away, for a sample that helped to decide
// how many others there are must not be of their mean. Its samples are of sequences of their own.
// From then on every pass takes 16 samples of some tiles: tile t has ceil(k share / most) times 16
// after k passes, so that at any moment all have about what is theirs. All of it follows from the
// film of the pilot: it does not depend on who rendered what, nor on a restart.
//
// Source: Neyman 1934, samples in proportion to the standard deviation; a quarter of them goes
// evenly over the picture, against what a pilot did not see.
#ifndef GLINT_RENDER_ADAPTIVE_H
#define GLINT_RENDER_ADAPTIVE_H

#include "render/internal.h"

// Under the mutex. Whether the job is adaptive and its pilot is over.
bool glint_adaptive_goes(const glint_render *r);

// The pilot is measured and done: decides the shares, forgets the rest.
void glint_adaptive_decide(glint_render *r);

// Takes the shares of a film, which fit the job's region.
glint_status glint_adaptive_take(glint_render *r, const char *shares, struct glint_error *err);

// The pass that begins at `sample`: lists the blocks of it. Passes are counted by samples, 16 each,
// as if all tiles took part.
void glint_adaptive_begin(glint_render *r, uint32_t sample);

// Samples of a tile before that pass.
uint32_t glint_adaptive_taken(const glint_render *r, uint32_t tile, uint32_t sample);

// Samples of a pixel in the mean before that pass, the pilot's too.
double glint_adaptive_mean(const glint_render *r, uint32_t sample);

// Where passes end so that there are at most `samples` in the mean.
uint32_t glint_adaptive_target(const glint_render *r, uint32_t samples);

#endif
