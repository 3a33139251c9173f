// gk_filter.h - pixel filters by importance sampling: every sample has weight 1.
//
// A filter maps a uniform u in [0, 1) to an offset from the pixel's centre, in pixels, for x and y
// alike; the widths are full widths of the support.
#ifndef GK_FILTER_H
#define GK_FILTER_H

#include "kernels/gk_math.h"

// Box: [-width/2, width/2).
GK_INLINE gk_f32 gk_filter_box(gk_f32 u, gk_f32 width)
{
    return (u - 0.5f) * width;
}

// Density of the 4-term Blackman-Harris window at x in [-1, 1], support scaled to that.
// Source: Harris 1978, "On the Use of Windows", doi:10.1109/PROC.1978.10837, 92 dB window. Its mean
// over the support is a0, so the density is the window over 2 a0.
GK_INLINE gk_f32 gk_blackman_harris_pdf(gk_f32 x)
{
    gk_f32 s, c;
    gk_sincos_2pi(0.5f * x, &s, &c);
    const gk_f32 c2 = 2.0f * c * c - 1.0f;
    const gk_f32 c3 = c * (2.0f * c2 - 1.0f);
    return (0.35875f + 0.48829f * c + 0.14128f * c2 + 0.01168f * c3) * (0.5f / 0.35875f);
}

// Probability of [-x, x], x in [0, 1].
GK_INLINE gk_f32 gk_blackman_harris_within(gk_f32 x)
{
    gk_f32 s, c;
    gk_sincos_2pi(0.5f * x, &s, &c);
    const gk_f32 s2 = 2.0f * s * c;
    const gk_f32 s3 = s * (4.0f * c * c - 1.0f);
    return x +
           (0.48829f * s + 0.5f * 0.14128f * s2 + 0.01168f / 3.0f * s3) * (GK_INV_PI / 0.35875f);
}

// Inverse of gk_blackman_harris_within(), t in [0, 1]: a fit in r = sqrt(-log(1 - t^2)), in which
// the inverse of any bell is nearly straight (within 6e-4), and one step of Newton's method. Where
// the density is below 1e-3 the step is damped: a float cannot resolve the probability there.
GK_INLINE gk_f32 gk_blackman_harris_inverse(gk_f32 t)
{
    const gk_f32 w = -gk_log(gk_max((1.0f - t) * (1.0f + t), GK_UNIT));
    const gk_f32 fit =
        0.360409021f +
        w * (-0.00469036773f +
             w * (0.00112951442f +
                  w * (-0.000347791414f +
                       w * (3.65186897e-5f + w * (-1.74767229e-6f + w * 3.21338582e-8f)))));
    const gk_f32 x = gk_saturate(gk_sqrt(w) * fit);
    const gk_f32 slope = 2.0f * gk_max(gk_blackman_harris_pdf(x), 1e-3f);
    return gk_saturate(x - (gk_blackman_harris_within(x) - t) / slope);
}

// Blackman-Harris: [-width/2, width/2], symmetric about u = 1/2.
GK_INLINE gk_f32 gk_filter_blackman_harris(gk_f32 u, gk_f32 width)
{
    const gk_f32 t = 2.0f * u - 1.0f;
    return gk_copysign(0.5f * width * gk_blackman_harris_inverse(gk_abs(t)), t);
}

#endif
