// alias.h - tables that turn one random number into a weighted choice.
#ifndef GLINT_SCENE_ALIAS_H
#define GLINT_SCENE_ALIAS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Walker's alias method in Vose's stable form (1991): entry i is kept with probability keep[i],
// else other[i] is taken. weight: [n], >= 0, finite; all zero counts as all equal.
// The strides, in floats, let both land inside records. False without memory.
bool glint_alias_build(const double *weight, uint32_t n, float *keep, uint32_t *other,
                       size_t stride);

// Rounds the keeps of a table up to whole steps of 2^-24, those of the sampler's numbers, and says with
// what probability each entry is then really taken: never zero where its weight is not.
void glint_alias_round(float *keep, const uint32_t *other, uint32_t n, size_t stride,
                       double *probability);

#endif
