// dice.h - random numbers that are the same everywhere.
//
// Source: G. L. Steele, D. Lea, C. H. Flood 2014, "Fast splittable pseudorandom number generators"
// (SplitMix64).
#ifndef GLINT_DEMO_DICE_H
#define GLINT_DEMO_DICE_H

#include <stdint.h>

struct glint_dice {
    uint64_t state;
};

static inline uint64_t glint_dice_next(struct glint_dice *dice)
{
    uint64_t z = dice->state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

static inline double glint_dice_range(struct glint_dice *dice, double least, double most)
{
    return least + (most - least) * (double)(glint_dice_next(dice) >> 11) * 0x1p-53;
}

static inline unsigned glint_dice_below(struct glint_dice *dice, unsigned count)
{
    return (unsigned)(glint_dice_next(dice) >> 32) % count;
}

#endif
