// half.h - IEEE 754 binary16 as OpenEXR stores it.
//
// Needs no conversion instruction, and gives the same bits in every rounding environment that
// rounds to nearest, flush-to-zero or not.
//
// Thread-safety: reentrant.
#ifndef GLINT_PROTOCOL_HALF_H
#define GLINT_PROTOCOL_HALF_H

#include <stdint.h>
#include <string.h>

#define GLINT_HALF_MAX 65504.0f

// Nearest half, ties to even. Finite or not, what lies beyond +-65504 becomes +-65504 and adds 1 to
// *clamped. NaN becomes the NaN 7e00 (negative: fe00) and is not counted: it is not hidden.
static inline uint16_t glint_half_from_float(float value, uint64_t *clamped)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    const uint16_t sign = bits >> 16 & 0x8000u;
    const uint32_t a = bits & 0x7fffffffu;
    if (a > 0x7f800000u)
        return sign | 0x7e00u;
    if (a > 0x477fe000u) {
        ++*clamped;
        return sign | 0x7bffu;
    }
    if (a < 0x38800000u) {
        // Below 2^-14 a half is a multiple of 2^-24, which is the last place of floats at 0.5.
        float magnitude;
        memcpy(&magnitude, &a, sizeof magnitude);
        magnitude += 0.5f;
        uint32_t rounded;
        memcpy(&rounded, &magnitude, sizeof rounded);
        return sign | (rounded - 0x3f000000u);
    }
    // The exponent's bias goes from 127 to 15; half of the last place, less one for an even one.
    return sign | (a - (112u << 23) + 0xfffu + (a >> 13 & 1u)) >> 13;
}

static inline float glint_float_from_half(uint16_t half)
{
    const uint32_t exponent = half >> 10 & 31u, mantissa = half & 0x3ffu;
    float magnitude;
    if (exponent == 0) {
        magnitude = (float)mantissa * 0x1p-24f;
    } else {
        const uint32_t bits = (exponent == 31 ? 255u : exponent + 112u) << 23 | mantissa << 13;
        memcpy(&magnitude, &bits, sizeof magnitude);
    }
    return half & 0x8000u ? -magnitude : magnitude;
}

#endif
