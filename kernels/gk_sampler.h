// gk_sampler.h - random numbers as a pure function (pixel, sample, dimension) -> [0, 1).
//
// Dimensions come in pairs. A pair is the first two Sobol dimensions, a (0,2)-sequence in base 2,
// taken in a shuffled order and Owen-scrambled, all three by nested uniform scrambles with seeds of
// their own; pairs are therefore independent of each other and each is stratified to its last bit.
// Sources: Burley 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4); the hash inside the
// scramble has Vegdahl's constants (psychopath.io, "Building a Better LK Hash", 2021).
//
// Pairs that one integrand knows together share an order. What a vertex takes by light and what it
// takes by scattering are summands: theirs have the same digits and scrambles of their own, which
// leaves their errors uncorrelated. The place in the pixel is a factor of what the first vertex takes:
// its pair has the other two dimensions of the (0,4)-sequence in base 4 of which the Sobol pair is the
// first two, so that every power of four of samples is a net in place and direction together.
// Sources: Faure 1982 over the field of four elements, as in Ahmed et al. 2024, "SZ Sequences:
// Binary-Based (0, 2^q)-Sequences"; that both pairs are (0,2)-sequences in base 2 as well was searched
// for among relabellings of digits.
//
// Samples alternate between two halves: sample s is element s >> 1 of half s & 1. The halves are
// scrambled independently, so their difference estimates the error of their mean. Every power of
// two of samples per half is a (0,m,2)-net in each pair. Jobs that want more than two independent
// parts have sixteen, sample s being element s >> 4 of part s & 15; jobs that do not ask for their error
// have one, and sample s is element s.
#ifndef GK_SAMPLER_H
#define GK_SAMPLER_H

#include "kernels/gk_types.h"

// Dimension pairs. Fixed for ever: pictures and stored jobs depend on them.
#define GK_PAIR_FILTER 0u // position in the pixel's filter, in the order of vertex 0
#define GK_PAIR_LENS 1u
#define GK_PAIR_TIME 2u // u: time, v: reserved
// 3..7: reserved for the camera
#define GK_PAIRS_PER_BOUNCE 8u
#define GK_PAIR_BOUNCE(bounce, k) (8u + (gk_u32)(bounce)*GK_PAIRS_PER_BOUNCE + (k))
#define GK_PAIR_LIGHT_CHOICE 0u // where in a cell of the environment
#define GK_PAIR_LIGHT_POINT 1u  // which light or cell, and where on the light
#define GK_PAIR_LOBE 2u         // u: which lobe, v: roulette
#define GK_PAIR_BSDF 3u         // direction
#define GK_PAIR_ALPHA 4u
#define GK_PAIR_MEDIUM 5u     // u: distance, v: reserved
#define GK_PAIR_ORDER 6u      // no numbers: the order of the light point's and the direction's
#define GK_PAIR_LIGHT_PICK 7u // u: which of the lights at hand, v: reserved

// Bijective mixer of 32 bits. Source: Wellons, "lowbias32", github.com/skeeto/hash-prospector.
GK_INLINE gk_u32 gk_mix32(gk_u32 x)
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    x ^= x >> 16;
    return x;
}

// Upper half of a product.
GK_INLINE gk_u32 gk_mul_high(gk_u32 a, gk_u32 b)
{
#ifdef GK_DEVICE
    return mul_hi(a, b);
#else
    return (gk_u32)(((gk_u64)a * b) >> 32);
#endif
}

GK_INLINE gk_u32 gk_reverse_bits(gk_u32 x)
{
    x = (x >> 16) | (x << 16);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    return ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
}

// Owen scramble of a number whose digits are stored lowest bit first: each bit is flipped or not
// depending on the bits below it and on the seed, which must be well mixed.
GK_INLINE gk_u32 gk_owen_reversed(gk_u32 x, gk_u32 seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

// Second Sobol dimension of `index`, first digit in the lowest bit. The generator is the Pascal
// matrix mod 2; C(j, i) is odd when i is a subset of j, so it is a sum over supersets.
GK_INLINE gk_u32 gk_sobol1_reversed(gk_u32 index)
{
    index ^= (index >> 1) & 0x55555555u;
    index ^= (index >> 2) & 0x33333333u;
    index ^= (index >> 4) & 0x0f0f0f0fu;
    index ^= (index >> 8) & 0x00ff00ffu;
    return index ^ (index >> 16);
}

// Seed of one pixel's half. x, y < 65536; part: 0 for A, 1 for B. For a given job seed and part, different
// pixels have different bases. The key enters twice: entering once, one seed's picture would be
// another's with its pixels exchanged.
GK_INLINE gk_u32 gk_sampler_base(gk_u32 x, gk_u32 y, gk_u32 seed, gk_u32 part)
{
    const gk_u32 key = gk_mix32(gk_mix32(seed + 0x9e3779b9u) + part * 0x85ebca6bu + 0xc2b2ae35u);
    return gk_mix32(gk_mix32(((y << 16) | (x & 0xffffu)) ^ key) + gk_mix32(key ^ 0x27d4eb2fu));
}

// Digits in base 4 of a word, first digit in the lowest bits, as elements low + high w of the field of
// four, w w = w + 1: times w, and times w w.
GK_INLINE gk_u32 gk_field_w(gk_u32 x)
{
    return ((x >> 1) & 0x55555555u) | ((x ^ x << 1) & 0xaaaaaaaau);
}

GK_INLINE gk_u32 gk_field_ww(gk_u32 x)
{
    return ((x ^ x >> 1) & 0x55555555u) | ((x << 1) & 0xaaaaaaaau);
}

// Digit j times w^j, and divided by it.
GK_INLINE gk_u32 gk_field_rise(gk_u32 x)
{
    return (x & 0xc30c30c3u) | (gk_field_w(x) & 0x0c30c30cu) | (gk_field_ww(x) & 0x30c30c30u);
}

GK_INLINE gk_u32 gk_field_fall(gk_u32 x)
{
    return (x & 0xc30c30c3u) | (gk_field_ww(x) & 0x0c30c30cu) | (gk_field_w(x) & 0x30c30c30u);
}

// Pascal matrix mod 2 over those digits.
GK_INLINE gk_u32 gk_field_pascal(gk_u32 x)
{
    x ^= (x >> 2) & 0x33333333u;
    x ^= (x >> 4) & 0x0f0f0f0fu;
    x ^= (x >> 8) & 0x00ff00ffu;
    return x ^ (x >> 16);
}

GK_INLINE gk_u32 gk_pair_seed(gk_u32 base, gk_u32 pair)
{
    return gk_mix32(base + pair * 0x9e3779b9u);
}

// Where element `index` stands in the order of a pair: digits for the functions below.
GK_INLINE gk_u32 gk_sample_order(gk_u32 base, gk_u32 index, gk_u32 pair)
{
    return gk_reverse_bits(gk_owen_reversed(gk_reverse_bits(index), gk_pair_seed(base, pair)));
}

GK_INLINE void gk_sample_scrambled(gk_u32 base, gk_u32 pair, gk_u32 *u, gk_u32 *v)
{
    const gk_u32 seed = gk_pair_seed(base, pair);
    *u = gk_reverse_bits(gk_owen_reversed(*u, gk_mix32(seed + 0x68bc21ebu)));
    *v = gk_reverse_bits(gk_owen_reversed(*v, gk_mix32(seed + 0x02e5be93u)));
}

// Both coordinates of a pair as fractions of 2^32: the first two dimensions of the (0,4)-sequence.
GK_INLINE void gk_sample_ordered_bits(gk_u32 base, gk_u32 order, gk_u32 pair, gk_u32 *u, gk_u32 *v)
{
    *u = order;
    *v = gk_sobol1_reversed(order);
    gk_sample_scrambled(base, pair, u, v);
}

// The same with the other two.
GK_INLINE void gk_sample_crossed_bits(gk_u32 base, gk_u32 order, gk_u32 pair, gk_u32 *u, gk_u32 *v)
{
    const gk_u32 w = gk_field_fall(gk_field_pascal(gk_field_rise(order)));
    const gk_u32 ww = gk_field_rise(gk_field_pascal(gk_field_fall(order)));
    *u = w;
    *v = ww ^ ((ww >> 1) & 0x55555555u);
    gk_sample_scrambled(base, pair, u, v);
}

// Both coordinates of element `index` of a pair that has an order of its own.
GK_INLINE void gk_sample_2d_bits(gk_u32 base, gk_u32 index, gk_u32 pair, gk_u32 *u, gk_u32 *v)
{
    gk_sample_ordered_bits(base, gk_sample_order(base, index, pair), pair, u, v);
}

// Bits to [0, 1 - 2^-24]. Through a signed integer: older vector units convert no unsigned ones.
GK_INLINE gk_f32 gk_unit_float(gk_u32 bits)
{
    return (gk_f32)(gk_i32)(bits >> 8) * (1.0f / 16777216.0f);
}

// Element `index` of a pair, each in [0, 1 - 2^-24].
GK_INLINE void gk_sample_2d(gk_u32 base, gk_u32 index, gk_u32 pair, gk_f32 *u, gk_f32 *v)
{
    gk_u32 a, b;
    gk_sample_2d_bits(base, index, pair, &a, &b);
    *u = gk_unit_float(a);
    *v = gk_unit_float(b);
}

// A pair of a vertex in the vertex's order: gk_sample_order() of its GK_PAIR_ORDER.
GK_INLINE void gk_sample_ordered(gk_u32 base, gk_u32 order, gk_u32 pair, gk_f32 *u, gk_f32 *v)
{
    gk_u32 a, b;
    gk_sample_ordered_bits(base, order, pair, &a, &b);
    *u = gk_unit_float(a);
    *v = gk_unit_float(b);
}

#endif
