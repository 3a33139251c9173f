// gk_math.h - elementary functions with the same bits on host and device.
//
// Straight lines without library calls, so that the work-item loop can be vectorised. Only IEEE
// operations are used (+ - * / sqrt, conversions), so host and device agree in every bit where
// contraction is off and divisions are correctly rounded. Error bounds are stated per function
// and tested against double in tests/kernel/; `ulp` is of the result. Coefficients are minimax
// fits (Lawson's iteration in double, then rounded).
#ifndef GK_MATH_H
#define GK_MATH_H

#include "kernels/gk_types.h"

#define GK_PI 3.14159265f
#define GK_TWO_PI 6.28318531f
#define GK_HALF_PI 1.57079633f
#define GK_QUARTER_PI 0.785398163f
#define GK_INV_PI 0.318309886f
#define GK_INFINITY INFINITY
#define GK_UNIT 5.9604645e-8f // 2^-24: half an ulp of 1, the u of error bounds

// Where one of a, b is NaN, the result is b: put the bound second.
GK_INLINE gk_f32 gk_min(gk_f32 a, gk_f32 b)
{
    return a < b ? a : b;
}

GK_INLINE gk_f32 gk_max(gk_f32 a, gk_f32 b)
{
    return a > b ? a : b;
}

GK_INLINE gk_i32 gk_min_i32(gk_i32 a, gk_i32 b)
{
    return a < b ? a : b;
}

GK_INLINE gk_i32 gk_max_i32(gk_i32 a, gk_i32 b)
{
    return a > b ? a : b;
}

// NaN becomes lo.
GK_INLINE gk_f32 gk_clamp(gk_f32 x, gk_f32 lo, gk_f32 hi)
{
    return gk_min(gk_max(x, lo), hi);
}

GK_INLINE gk_f32 gk_saturate(gk_f32 x)
{
    return gk_clamp(x, 0.0f, 1.0f);
}

GK_INLINE gk_f32 gk_abs(gk_f32 x)
{
    return gk_as_f32(gk_as_u32(x) & 0x7fffffffu);
}

// Magnitude of x, sign of s; -0 and NaN have signs too.
GK_INLINE gk_f32 gk_copysign(gk_f32 x, gk_f32 s)
{
    return gk_as_f32((gk_as_u32(x) & 0x7fffffffu) | (gk_as_u32(s) & 0x80000000u));
}

GK_INLINE gk_i32 gk_isfinite(gk_f32 x)
{
    return (gk_as_u32(x) & 0x7f800000u) != 0x7f800000u;
}

// Correctly rounded; x < 0 gives NaN.
GK_INLINE gk_f32 gk_sqrt(gk_f32 x)
{
#ifdef GK_DEVICE
    return sqrt(x);
#else
    return sqrtf(x);
#endif
}

// 1.5 ulp; 0 gives inf, inf gives 0.
GK_INLINE gk_f32 gk_rsqrt(gk_f32 x)
{
    return 1.0f / gk_sqrt(x);
}

// Exact for every x, inf and NaN included; -0 gives 0.
GK_INLINE gk_f32 gk_floor(gk_f32 x)
{
    const gk_f32 t = (gk_f32)(gk_i32)gk_clamp(x, -8388608.0f, 8388608.0f);
    const gk_f32 floor_x = gk_select(t, t - 1.0f, t > x);
    return gk_select(x, floor_x, gk_abs(x) < 8388608.0f); // larger ones are integers
}

// sin and cos of 2 pi u, |u| <= 2^21. Absolute error <= 1.5e-7; exact where 4 u is an integer.
GK_INLINE void gk_sincos_2pi(gk_f32 u, gk_f32 *sin_out, gk_f32 *cos_out)
{
    const gk_f32 turns4 = 4.0f * u;
    const gk_i32 quadrant = (gk_i32)(turns4 + gk_copysign(0.5f, u));
    const gk_f32 r = turns4 - (gk_f32)quadrant; // exact, |r| <= 1/2
    const gk_f32 z = r * r;
    const gk_f32 s =
        r * (1.57079637f + z * (-0.645963490f + z * (0.0796802267f + z * -0.00460217707f)));
    const gk_f32 c =
        1.0f + z * (-1.23370051f + z * (0.253669232f + z * (-0.0208602883f + z * 0.000904021610f)));
    const gk_i32 odd = (quadrant & 1) != 0;
    const gk_f32 sin_abs = gk_select(s, c, odd);
    const gk_f32 cos_abs = gk_select(c, s, odd);
    *sin_out = gk_select(sin_abs, -sin_abs, (quadrant & 2) != 0);
    *cos_out = gk_select(cos_abs, -cos_abs, ((quadrant + 1) & 2) != 0);
}

// e^r - 1 for |r| <= 0.35.
GK_INLINE gk_f32 gk_exp_rest(gk_f32 r)
{
    return r + r * r *
                   (0.5f +
                    r * (0.166666672f +
                         r * (0.0416662693f +
                              r * (0.00833326578f + r * (0.00139461167f + r * 0.000199178743f)))));
}

// e^r 2^n for |r| <= 0.35, -151 <= n <= 129. The scale is applied in two steps, so that neither
// factor over- or underflows before the result does.
GK_INLINE gk_f32 gk_exp_scaled(gk_f32 r, gk_i32 n)
{
    const gk_f32 p = 1.0f + gk_exp_rest(r);
    const gk_i32 n0 = n >> 1;
    const gk_i32 n1 = n - n0;
    return p * gk_as_f32((gk_u32)(n0 + 127) << 23) * gk_as_f32((gk_u32)(n1 + 127) << 23);
}

// 1.5 ulp where the result is normal. exp(-inf) = 0, exp(inf) = inf, NaN gives NaN.
GK_INLINE gk_f32 gk_exp(gk_f32 x)
{
    const gk_f32 c = gk_clamp(x, -104.5f, 89.0f); // 0 and inf beyond
    const gk_f32 t = c * 1.44269504f;
    const gk_i32 n = (gk_i32)(t + gk_copysign(0.5f, t));
    const gk_f32 k = (gk_f32)n;
    const gk_f32 r = (c - k * 0.693359375f) - k * -2.12194440e-4f; // ln 2 in two parts
    return gk_select(gk_exp_scaled(r, n), x, x != x);
}

// 1.5 ulp where the result is normal; exact for integers. Limits as gk_exp().
GK_INLINE gk_f32 gk_exp2(gk_f32 x)
{
    const gk_f32 c = gk_clamp(x, -151.0f, 129.0f);
    const gk_i32 n = (gk_i32)(c + gk_copysign(0.5f, c));
    const gk_f32 r = (c - (gk_f32)n) * 0.693147181f;
    return gk_select(gk_exp_scaled(r, n), x, x != x);
}

// ln(1 + f) for 1 + f in [sqrt(1/2), sqrt(2)): 2 atanh(s), s = f / (2 + f); the head f - f^2/2 is
// kept exact (as in fdlibm).
GK_INLINE gk_f32 gk_log_near_one(gk_f32 f)
{
    const gk_f32 s = f / (2.0f + f);
    const gk_f32 z = s * s;
    const gk_f32 tail =
        z * (0.666666627f + z * (0.400003344f + z * (0.285373032f + z * 0.235822871f)));
    const gk_f32 half_square = 0.5f * f * f;
    return f - (half_square - s * (half_square + tail));
}

// x = 2^e (1 + f) with 1 + f in [sqrt(1/2), sqrt(2)); x > 0 and finite. Returns f.
GK_INLINE gk_f32 gk_log_split(gk_f32 x, gk_i32 *e)
{
    const gk_u32 bits = gk_as_u32(x) - 0x3f3504f3u;
    *e = (gk_i32)bits >> 23;
    return gk_as_f32((bits & 0x007fffffu) + 0x3f3504f3u) - 1.0f;
}

// ln(1 + f) of that, and e.
GK_INLINE gk_f32 gk_log_reduced(gk_f32 x, gk_f32 *e)
{
    const gk_i32 tiny = x < 1.17549435e-38f; // denormal: no implicit bit to split off
    gk_i32 exponent;
    const gk_f32 f = gk_log_split(gk_select(x, x * 8388608.0f, tiny), &exponent);
    *e = (gk_f32)exponent - gk_select(0.0f, 23.0f, tiny);
    return gk_log_near_one(f);
}

// log of what gk_log_reduced() cannot take: 0 gives -inf, inf gives inf, negative and NaN give NaN.
GK_INLINE gk_f32 gk_log_limits(gk_f32 x, gk_f32 y)
{
    const gk_f32 low = gk_select(NAN, -INFINITY, x == 0.0f);
    return gk_select(gk_select(low, y, x > 0.0f), x, x == INFINITY);
}

// 2 ulp.
GK_INLINE gk_f32 gk_log(gk_f32 x)
{
    gk_f32 e;
    const gk_f32 y = gk_log_reduced(x, &e);
    return gk_log_limits(x, e * 0.693359375f + (e * -2.12194440e-4f + y));
}

// ln(1 + x) for x >= -1, 3 ulp, also where x is small: up to 2^24 the reduced argument is taken from
// x, without the rounding of 1 + x.
GK_INLINE gk_f32 gk_log1p(gk_f32 x)
{
    const gk_f32 u = 1.0f + x;
    gk_i32 e;
    const gk_f32 rounded = gk_log_split(u, &e);
    const gk_f32 scale = gk_as_f32((gk_u32)(127 - gk_min_i32(e, 24)) << 23);
    const gk_f32 f = e > 24 ? rounded : (scale - 1.0f) + x * scale;
    const gk_f32 k = (gk_f32)e;
    return gk_log_limits(u, k * 0.693359375f + (k * -2.12194440e-4f + gk_log_near_one(f)));
}

// e^x - 1 for x <= 0, 2 ulp, also where x is small. -inf gives -1.
GK_INLINE gk_f32 gk_expm1(gk_f32 x)
{
    const gk_f32 c = gk_clamp(x, -20.0f, 0.0f); // -1 beyond
    const gk_i32 n = (gk_i32)(c * 1.44269504f - 0.5f);
    const gk_f32 k = (gk_f32)n;
    const gk_f32 r = (c - k * 0.693359375f) - k * -2.12194440e-4f; // ln 2 in two parts
    const gk_f32 scale = gk_as_f32((gk_u32)(n + 127) << 23);
    return gk_select((scale - 1.0f) + scale * gk_exp_rest(r), x, x != x);
}

// 3 ulp; exact for powers of two.
GK_INLINE gk_f32 gk_log2(gk_f32 x)
{
    gk_f32 e;
    const gk_f32 y = gk_log_reduced(x, &e);
    return gk_log_limits(x, e + y * 1.44269504f);
}

// x^y for x >= 0. Relative error <= (2 + 2 |y log2 x|) 2^-24 + 2^-23, so for ordinary exponents some
// ulp. x^0 = 1 for every x, 0^y = 0 for y > 0, inf for y < 0. x < 0 gives NaN.
GK_INLINE gk_f32 gk_pow(gk_f32 x, gk_f32 y)
{
    return gk_select(gk_exp2(y * gk_log2(x)), 1.0f, y == 0.0f);
}

// Angle of (x, y) in [-pi, pi]; |x|, |y| <= 2^126. 3 ulp. (0, 0) gives 0 with the sign of y.
GK_INLINE gk_f32 gk_atan2(gk_f32 y, gk_f32 x)
{
    const gk_f32 ax = gk_abs(x);
    const gk_f32 ay = gk_abs(y);
    const gk_f32 lo = gk_min(ax, ay);
    const gk_f32 hi = gk_max(ax, ay);
    const gk_i32 upper = lo > 0.414213562f * hi; // reduce about 45 degrees
    const gk_f32 num = gk_select(lo, lo - hi, upper);
    const gk_f32 den = gk_select(hi, lo + hi, upper);
    const gk_f32 t = gk_select(num / den, 0.0f, hi == 0.0f);
    const gk_f32 z = t * t;
    const gk_f32 series =
        t +
        t * z *
            (-0.333333015f +
             z * (0.199978948f + z * (-0.142345086f + z * (0.105361156f + z * -0.0594835236f))));
    const gk_f32 octant = gk_select(series, GK_QUARTER_PI + series, upper);
    const gk_f32 quadrant = gk_select(octant, GK_HALF_PI - octant, ay > ax);
    return gk_copysign(gk_select(quadrant, GK_PI - quadrant, x < 0.0f), y);
}

// [0, pi], absolute error <= 3e-7; x is clamped to [-1, 1]. acos(1) = 0 exactly, and near 1 the error
// is relative to the result (4 ulp).
GK_INLINE gk_f32 gk_acos(gk_f32 x)
{
    const gk_f32 a = gk_min(gk_abs(x), 1.0f);
    const gk_i32 steep = a > 0.5f; // acos(a) = 2 asin(sqrt((1 - a) / 2))
    const gk_f32 z = gk_select(a * a, 0.5f * (1.0f - a), steep);
    const gk_f32 s = gk_select(a, gk_sqrt(z), steep);
    const gk_f32 asin_s =
        s + s * z *
                (0.166666538f +
                 z * (0.0750081465f +
                      z * (0.0444671810f +
                           z * (0.0321702361f + z * (0.0132107809f + z * 0.0390885212f)))));
    const gk_f32 acos_a = gk_select(GK_HALF_PI - asin_s, 2.0f * asin_s, steep);
    return gk_select(acos_a, GK_PI - acos_a, x < 0.0f);
}

// Scales (*x, *y, *z) to length 1, 3 ulp. Works from the smallest denormal to FLT_MAX: a power of
// two is taken out first. Returns 1; or 0 for a zero or non-finite vector, which becomes (0, 0, 1).
GK_INLINE gk_i32 gk_safe_normalise(gk_f32 *x, gk_f32 *y, gk_f32 *z)
{
    const gk_f32 largest = gk_max(gk_abs(*x), gk_max(gk_abs(*y), gk_abs(*z)));
    const gk_i32 exponent = (gk_i32)(gk_as_u32(largest) & 0x7f800000u);
    const gk_i32 inverse = 0x7f000000 - exponent;
    const gk_f32 scale = gk_as_f32((gk_u32)gk_select(inverse, 0x00800000, inverse < 0x00800000));
    const gk_f32 sx = *x * scale;
    const gk_f32 sy = *y * scale;
    const gk_f32 sz = *z * scale;
    const gk_f32 square = sx * sx + sy * sy + sz * sz;
    const gk_i32 fine = square > 0.0f && square < INFINITY;
    const gk_f32 inv = gk_rsqrt(gk_select(1.0f, square, fine));
    *x = gk_select(0.0f, sx * inv, fine);
    *y = gk_select(0.0f, sy * inv, fine);
    *z = gk_select(1.0f, sz * inv, fine);
    return fine;
}

#endif
