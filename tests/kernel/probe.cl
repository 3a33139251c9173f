// probe.cl - the kernel headers put through their paces, one work-item per row; compiled as C by
// test_dialects.c and as OpenCL C by the device, which must answer the same bits.
#define GK_MICROFACET 1
#define GK_TRANSMISSION 1
#define GK_MULTISCATTER 1
#define GK_SPECULAR 1
#define GK_CLEARCOAT 1
#define GK_COLLIMATION 1

#include "kernels/gk_bsdf.h"
#include "kernels/gk_filter.h"
#include "kernels/gk_math.h"
#include "kernels/gk_matte.h"
#include "kernels/gk_sampler.h"

#define PROBE_ROWS 65536
#define PROBE_COLUMNS 16

// Row i of `out`, by column: [PROBE_COLUMNS][PROBE_ROWS].
#define PROBE_PUT(column, bits) (out[(column)*PROBE_ROWS + i] = (bits))
#define PROBE_PUT_F32(column, x) PROBE_PUT(column, gk_as_u32(x))

// [0, 1), a different one for each row and k.
GK_INLINE gk_f32 probe_uniform(gk_u32 i, gk_u32 k)
{
    return gk_unit_float(gk_mix32(gk_mix32(i + 1u) + k));
}

// Any sign, 2^-30 .. 2^30.
GK_INLINE gk_f32 probe_wide(gk_u32 i, gk_u32 k)
{
    const gk_u32 bits = gk_mix32(gk_mix32(i + 7u) + k);
    return gk_as_f32((bits & 0x807fffffu) | ((97u + (bits >> 8) % 61u) << 23));
}

GK_INLINE void probe_math(gk_u32 i, GK_GLOBAL gk_u32 *out)
{
    const gk_f32 u = probe_uniform(i, 0), wide = probe_wide(i, 1), y = probe_wide(i, 2);
    gk_f32 s, c;
    gk_f32 a = wide, b = y, d = probe_wide(i, 3);
    gk_sincos_2pi(8.0f * u - 4.0f, &s, &c);
    PROBE_PUT_F32(0, s);
    PROBE_PUT_F32(1, c);
    PROBE_PUT_F32(2, gk_exp(100.0f * u - 50.0f));
    PROBE_PUT_F32(3, gk_exp2(100.0f * u - 50.0f));
    PROBE_PUT_F32(4, gk_log(gk_abs(wide)));
    PROBE_PUT_F32(5, gk_log2(gk_abs(wide)));
    PROBE_PUT_F32(6, gk_pow(gk_abs(wide), 4.0f * u - 2.0f));
    PROBE_PUT_F32(7, gk_atan2(y, wide));
    PROBE_PUT_F32(8, gk_acos(2.0f * u - 1.0f));
    PROBE_PUT_F32(9, gk_sqrt(gk_abs(wide)));
    PROBE_PUT_F32(10, gk_rsqrt(gk_abs(wide)));
    PROBE_PUT_F32(11, gk_floor(wide));
    PROBE_PUT_F32(12, wide * y + u);
    PROBE_PUT(13, (gk_u32)gk_safe_normalise(&a, &b, &d));
    PROBE_PUT_F32(14, a);
    PROBE_PUT_F32(15, b + d);
}

GK_INLINE void probe_limits(gk_u32 i, GK_GLOBAL gk_u32 *out)
{
    const gk_f32 special = i & 1u ? GK_INFINITY : 0.0f;
    const gk_f32 x = i & 2u ? -special : special;
    PROBE_PUT_F32(0, gk_exp(x));
    PROBE_PUT_F32(1, gk_exp2(x));
    PROBE_PUT_F32(2, gk_log(gk_abs(x)));
    PROBE_PUT_F32(3, gk_rsqrt(gk_abs(x)));
    PROBE_PUT_F32(4, gk_floor(x));
    PROBE_PUT_F32(5, gk_saturate(x));
    PROBE_PUT_F32(6, gk_clamp(NAN, -1.0f, 1.0f));
    PROBE_PUT(7, (gk_u32)gk_isfinite(x));
    PROBE_PUT(8, gk_exp(NAN) != gk_exp(NAN));
    PROBE_PUT(9, gk_log(-1.0f) != gk_log(-1.0f));
    PROBE_PUT_F32(10, gk_pow(gk_abs(x), 2.0f));
    PROBE_PUT_F32(11, gk_pow(gk_abs(x), 0.0f));
    PROBE_PUT_F32(12, gk_copysign(1.0f, x));
}

GK_INLINE void probe_sampler(gk_u32 i, GK_GLOBAL gk_u32 *out)
{
    const gk_u32 base = gk_sampler_base(i & 255u, i >> 8, 42u, i & 1u);
    gk_u32 a, b;
    gk_f32 u, v;
    gk_sample_2d_bits(base, gk_mix32(i), 9u, &a, &b);
    gk_sample_2d(base, i, GK_PAIR_BOUNCE(i & 7u, GK_PAIR_BSDF), &u, &v);
    PROBE_PUT(0, base);
    PROBE_PUT(1, a);
    PROBE_PUT(2, b);
    PROBE_PUT_F32(3, u);
    PROBE_PUT_F32(4, v);
    PROBE_PUT_F32(5, gk_filter_box(u, 1.5f));
    PROBE_PUT_F32(6, gk_filter_blackman_harris(u, 1.5f));
    PROBE_PUT_F32(7, gk_blackman_harris_pdf(2.0f * u - 1.0f));
    gk_sample_crossed_bits(base, gk_sample_order(base, i, 14u), 0u, &a, &b);
    PROBE_PUT(8, a);
    PROBE_PUT(9, b);
}

GK_INLINE struct gk_vec probe_direction(gk_u32 i, gk_u32 k)
{
    gk_f32 s, c;
    const gk_f32 z = 2.0f * probe_uniform(i, k) - 1.0f;
    gk_sincos_2pi(probe_uniform(i, k + 1u), &s, &c);
    const gk_f32 r = gk_sqrt(gk_max(1.0f - z * z, 0.0f));
    return gk_vec(r * c, r * s, z);
}

// The layers of row i: a quarter of the rows has none.
GK_INLINE void probe_layers(gk_u32 i, struct gk_surface *s)
{
    const gk_i32 plain = (i & 12u) == 0u;
    s->specular = plain ? 1.0f : probe_uniform(i, 20);
    s->specular_color = gk_splat(plain ? 1.0f : 4.0f * probe_uniform(i, 21));
    s->collimation = plain ? 1.0f : gk_saturate(2.0f * probe_uniform(i, 22));
    s->coat.weight = plain ? 0.0f : gk_saturate(2.0f * probe_uniform(i, 23) - 0.5f);
    s->coat.alpha = probe_uniform(i, 24) * probe_uniform(i, 24);
    s->coat.frame = gk_onb_make(
        gk_normalise(gk_vec(probe_uniform(i, 25) - 0.5f, probe_uniform(i, 26) - 0.5f, 1.0f)));
}

// energy: the white part of gk_energy.h and those of a transmitting interface.
GK_INLINE void probe_bsdf(gk_u32 i, GK_GLOBAL gk_u32 *out, const GK_GLOBAL gk_f32 *energy)
{
    struct gk_surface s;
    struct gk_vec wo = probe_direction(i, 1);
    wo.z = gk_abs(wo.z) + 1e-6f;
    s.base = gk_vec(probe_uniform(i, 3), probe_uniform(i, 4), probe_uniform(i, 5));
    s.metallic = gk_saturate(2.0f * probe_uniform(i, 6) - 0.5f);
    s.transmission = gk_saturate(2.0f * probe_uniform(i, 7) - 0.5f);
    s.alpha = probe_uniform(i, 8) * probe_uniform(i, 8);
    s.eta = i & 1u ? 1.5f : 1.0f / 1.5f;
    s.fresnel_mean = 0.0918f;
    s.thin = (gk_i32)(i >> 1 & 1u);
    s.inside = !s.thin && s.eta < 1.0f;
    s.energy.entry = energy;
    s.energy.cut = gk_cut_none();
    s.interface = GK_ENERGY_COAT;
    probe_layers(i, &s);
    gk_surface_prepare(&s, wo);
    const struct gk_bsdf_value value = gk_bsdf_eval(&s, wo, probe_direction(i, 9));
    const struct gk_bsdf_sample sample =
        gk_bsdf_sample(&s, wo, probe_uniform(i, 11), probe_uniform(i, 12), probe_uniform(i, 13));
    PROBE_PUT_F32(0, value.f.x);
    PROBE_PUT_F32(1, value.f.y);
    PROBE_PUT_F32(2, value.f.z);
    PROBE_PUT_F32(3, value.pdf);
    PROBE_PUT_F32(4, sample.wi.x);
    PROBE_PUT_F32(5, sample.wi.y);
    PROBE_PUT_F32(6, sample.wi.z);
    PROBE_PUT_F32(7, gk_select(0.0f, sample.weight.x, sample.delta));
    PROBE_PUT(8, (gk_u32)sample.delta);
    PROBE_PUT_F32(9, s.p_diffuse);
}

#define PROBE_SLOTS 12u
#define PROBE_PIXELS 64

// Pixel i takes 1000 deposits; `table` is [PROBE_PIXELS][PROBE_SLOTS], `lost` [PROBE_PIXELS].
GK_INLINE void probe_matte(gk_u32 i, GK_GLOBAL gk_u64 *table, GK_GLOBAL gk_u64 *lost)
{
    struct gk_matte_lost none = {0, 0};
    for (gk_u32 k = 0; k < 1000; k++) {
        const gk_u32 bits = gk_mix32(i * 1000u + k);
        gk_matte_deposit(table + i * PROBE_SLOTS, PROBE_SLOTS, 1u + (bits >> 8) % 20u, bits & 1u,
                         gk_matte_units(probe_uniform(i, k)), GK_MATTE_DIRECT_FIRST, bits, &none);
    }
    lost[i] += none.primary + none.bounced;
}

#ifdef GK_DEVICE
#define PROBE_KERNEL(name)                             \
    __kernel void name(GK_GLOBAL gk_u32 *restrict out) \
    {                                                  \
        probe_##name((gk_u32)get_global_id(0), out);   \
    }
PROBE_KERNEL(math)
PROBE_KERNEL(limits)
PROBE_KERNEL(sampler)

__kernel void bsdf(GK_GLOBAL gk_u32 *restrict out, const GK_GLOBAL gk_f32 *restrict energy)
{
    probe_bsdf((gk_u32)get_global_id(0), out, energy);
}

__kernel void matte(GK_GLOBAL gk_u64 *table, GK_GLOBAL gk_u64 *lost)
{
    probe_matte((gk_u32)get_global_id(0), table, lost);
}
#endif
