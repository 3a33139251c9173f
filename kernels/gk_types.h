// gk_types.h - scalars, address spaces and bit casts that mean the same in C11 and OpenCL C 1.2.
//
// Every gk_ header is compiled in both dialects; the build defines GK_DEVICE for OpenCL, nothing
// guesses it. Contraction is off in both (here for OpenCL, -ffp-contract=off for C), so that both
// compute the same bits.
#ifndef GK_TYPES_H
#define GK_TYPES_H

#ifdef GK_DEVICE

#pragma OPENCL FP_CONTRACT OFF

typedef float gk_f32;
typedef int gk_i32;
typedef uint gk_u32;
typedef ulong gk_u64; // not in the hot path: vectorised 64-bit multiplies are slow

// Always: a call that is left over keeps the whole work-item loop from being vectorised.
#define GK_INLINE static inline __attribute__((always_inline))
#define GK_GLOBAL __global
#define GK_LAYOUT(tag, bytes) \
    typedef char gk_layout_of_##tag[sizeof(struct tag) == (bytes) ? 1 : -1]

#else

#include <math.h>
#include <stdint.h>
#include <string.h>

typedef float gk_f32;
typedef int32_t gk_i32;
typedef uint32_t gk_u32;
typedef uint64_t gk_u64;

#define GK_INLINE static inline
#define GK_GLOBAL
#define GK_LAYOUT(tag, bytes) _Static_assert(sizeof(struct tag) == (bytes), #tag)

#endif

// `t` where cond holds, else `f`. Both are evaluated: compilers turn it into a blend.
#define gk_select(f, t, cond) ((cond) ? (t) : (f))

// Member of record `index` in a table of struct `tag`, four bytes, read by a signed offset of 32 bits
// from the table's own address: so 16 lanes are one gather. By addresses they are two, and their
// arithmetic. A table has less than 2^31 words.
#define GK_READ_ALONE(table, tag, index, member)                          \
    (((const GK_GLOBAL __typeof__(+((struct tag *)0)->member) *)(table) + \
      __builtin_offsetof(struct tag, member) /                            \
          4)[(gk_i32)((gk_u32)(index) * (gk_u32)(sizeof(struct tag) / 4))])

// The same of a member that is read together with its neighbour, the other word of the eight bytes that
// it lies in. A gather costs by the lane, not by its width: one reads both. Where lanes are read one by
// one that brings nothing.
#if defined(GK_DEVICE) && !defined(GK_NO_GATHERS)
typedef gk_u64 __attribute__((aligned(4), may_alias)) gk_two_words; // the first in the lower half
#define GK_READ(table, tag, index, member)                                                \
    (((union {                                                                            \
         gk_u32 bits;                                                                     \
         __typeof__(+((struct tag *)0)->member) value;                                    \
     }){(gk_u32)(((const GK_GLOBAL gk_two_words *)(table) +                               \
                  __builtin_offsetof(struct tag, member) /                                \
                      8)[(gk_i32)((gk_u32)(index) * (gk_u32)(sizeof(struct tag) / 8))] >> \
                 (__builtin_offsetof(struct tag, member) % 8 * 8))})                      \
         .value)
#else
#define GK_READ GK_READ_ALONE
#endif

struct gk_two {
    gk_u32 first, second;
};

// Words `at` and at + 1 of a table of less than 2^29. By bytes: gathers of 64 bits scale their offsets
// by 8 or not at all.
GK_INLINE struct gk_two gk_two_at(const GK_GLOBAL void *table, gk_i32 at)
{
    struct gk_two two;
#if defined(GK_DEVICE) && !defined(GK_NO_GATHERS)
    const gk_u64 words = *(const GK_GLOBAL gk_two_words *)((const GK_GLOBAL char *)table +
                                                           (gk_i32)((gk_u32)at * 4u));
    two.first = (gk_u32)words;
    two.second = (gk_u32)(words >> 32);
#else
    two.first = ((const GK_GLOBAL gk_u32 *)table)[at];
    two.second = ((const GK_GLOBAL gk_u32 *)table + 1)[at];
#endif
    return two;
}

GK_INLINE gk_u32 gk_as_u32(gk_f32 x)
{
#ifdef GK_DEVICE
    return as_uint(x);
#else
    gk_u32 bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
#endif
}

GK_INLINE gk_f32 gk_as_f32(gk_u32 bits)
{
#ifdef GK_DEVICE
    return as_float(bits);
#else
    gk_f32 x;
    memcpy(&x, &bits, sizeof x);
    return x;
#endif
}

#endif
