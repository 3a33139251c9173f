// gk_texture.h - bilinear look-up of 8-bit RGBA textures.
#ifndef GK_TEXTURE_H
#define GK_TEXTURE_H

#include "kernels/gk_cut.h"
#include "kernels/gk_math.h"
#include "kernels/gk_scene.h"

// Everything a look-up reads. decode: what the 256 sRGB values mean.
struct gk_texture_pools {
    const GK_GLOBAL struct gk_texture *texture;
    const GK_GLOBAL gk_u32 *pool0;
    const GK_GLOBAL gk_u32 *pool1;
    const GK_GLOBAL gk_u32 *pool2;
    const GK_GLOBAL gk_u32 *pool3;
    const GK_GLOBAL gk_f32 *decode;
    struct gk_cut cut;
};

#define GK_TEXTURE(pools, index, member) GK_READ((pools)->texture, gk_texture, index, member)

// What r, g and b of an image are, by what a material uses it for; alpha is always a number.
enum gk_texels {
    GK_TEXELS_COLOUR, // sRGB
    GK_TEXELS_NUMBERS // k/255
};

struct gk_texel {
    gk_f32 r, g, b, a;
};

// Where a point lies in the textures of its mesh.
struct gk_coordinates {
    gk_f32 u, v;
    gk_f32 u1, v1; // second set, under GK_UV1
};

// Coordinate in texels: position of the lower of the two taps, both wrapped, and the weight of the
// upper, 0 where the nearest texel is wanted. Only multiples of the period are taken off before
// scaling, so |t| may be large.
struct gk_taps {
    gk_i32 lower, upper;
    gk_f32 weight;
};

GK_INLINE struct gk_taps gk_wrap_taps(gk_f32 t, gk_u32 size, gk_u32 wrap, gk_i32 nearest)
{
    const gk_i32 n = (gk_i32)size;
    const gk_f32 whole = gk_floor(t);
    const gk_f32 fraction = t - whole;
    const gk_f32 pair = t * 0.5f - gk_floor(t * 0.5f);
    const gk_f32 mirrored = 1.0f - gk_abs(pair * 2.0f - 1.0f);
    const gk_f32 clamped = gk_clamp(t, 0.0f, 1.0f);
    const gk_f32 unit = wrap == GK_WRAP_REPEAT   ? fraction
                        : wrap == GK_WRAP_MIRROR ? mirrored
                                                 : clamped;
    const gk_f32 x = unit * (gk_f32)n - (nearest ? 0.0f : 0.5f);
    const gk_f32 floor_x = gk_floor(x);
    struct gk_taps taps;
    taps.lower = (gk_i32)floor_x;
    taps.upper = taps.lower + 1;
    taps.weight = nearest ? 0.0f : x - floor_x;
    const gk_i32 below = wrap == GK_WRAP_REPEAT ? n - 1 : 0;
    const gk_i32 above = wrap == GK_WRAP_REPEAT ? 0 : n - 1;
    taps.lower = taps.lower < 0 ? below : taps.lower > n - 1 ? n - 1 : taps.lower;
    taps.upper = taps.upper > n - 1 ? above : taps.upper < 0 ? 0 : taps.upper;
    return taps;
}

GK_INLINE gk_u32 gk_texel_bits(const struct gk_texture_pools *p, gk_u32 pool, gk_u32 index)
{
#if GK_TEXTURE_POOLS > 1
    const gk_i32 i = (gk_i32)index;
    return pool == 0u   ? p->pool0[i]
           : pool == 1u ? p->pool1[i]
           : pool == 2u ? p->pool2[i]
                        : p->pool3[i];
#else
    (void)pool;
    return p->pool0[(gk_i32)index]; // below 2^28
#endif
}

// offset, width: of the texture's record.
GK_INLINE gk_u32 gk_texel_index(gk_u32 offset, gk_u32 width, gk_i32 x, gk_i32 y)
{
    const gk_u32 tile = ((gk_u32)y >> 3) * ((width + 7u) >> 3) + ((gk_u32)x >> 3);
    return offset + (tile << 6) + (((gk_u32)y & 7u) << 3) + ((gk_u32)x & 7u);
}

// One of r, g, b. What holds numbers is divided: that is exact, and quicker than to look it up.
GK_INLINE gk_f32 gk_texel_value(const struct gk_texture_pools *p, gk_u32 byte, enum gk_texels kind)
{
    return kind == GK_TEXELS_COLOUR ? p->decode[(gk_i32)byte] : (gk_f32)(gk_i32)byte / 255.0f;
}

GK_INLINE struct gk_texel gk_texel_decode(const struct gk_texture_pools *p, gk_u32 bits,
                                          enum gk_texels kind)
{
    struct gk_texel t;
    t.r = gk_texel_value(p, bits & 255u, kind);
    t.g = gk_texel_value(p, (bits >> 8) & 255u, kind);
    t.b = gk_texel_value(p, (bits >> 16) & 255u, kind);
    t.a = (gk_f32)(gk_i32)(bits >> 24) * (1.0f / 255.0f);
    return t;
}

GK_INLINE struct gk_texel gk_texel_mix(struct gk_texel a, struct gk_texel b, gk_f32 w)
{
    struct gk_texel t;
    t.r = a.r + (b.r - a.r) * w;
    t.g = a.g + (b.g - a.g) * w;
    t.b = a.b + (b.b - a.b) * w;
    t.a = a.a + (b.a - a.a) * w;
    return t;
}

// Texture `index` at (u, v), v downwards; white where index is GK_NONE. Interpolates in linear
// light, as glTF 2.0 3.9.2 asks for.
GK_INLINE struct gk_texel gk_texture_fetch(const struct gk_texture_pools *p, gk_u32 index,
                                           enum gk_texels kind, gk_f32 u, gk_f32 v)
{
    const gk_i32 none = index == GK_NONE;
    const gk_u32 record = none ? 0u : index;
    u = none ? 0.0f : u; // paths without a texture read one place, not all over the first
    v = none ? 0.0f : v;
    const gk_u32 flags = GK_TEXTURE(p, record, flags);
    const gk_u32 pool = GK_READ_ALONE(p->texture, gk_texture, record, pool);
    const gk_u32 offset = GK_TEXTURE(p, record, offset);
    const gk_u32 width = GK_TEXTURE(p, record, width);
#ifdef GK_NEAREST_TEXELS
    const gk_i32 nearest = (flags & GK_TEXTURE_NEAREST) != 0u;
#else
    const gk_i32 nearest = 0;
#endif
    const struct gk_taps x = gk_wrap_taps(u, width, flags & 3u, nearest);
    const struct gk_taps y =
        gk_wrap_taps(v, GK_TEXTURE(p, record, height), (flags >> 2) & 3u, nearest);
    const gk_u32 i00 = gk_texel_index(offset, width, x.lower, y.lower);
    const gk_u32 i10 = gk_texel_index(offset, width, x.upper, y.lower);
    const gk_u32 i01 = gk_texel_index(offset, width, x.lower, y.upper);
    const gk_u32 i11 = gk_texel_index(offset, width, x.upper, y.upper);
    GK_CUT(p->cut, i00 ^ i10 ^ i01 ^ i11);
    const gk_u32 b00 = gk_texel_bits(p, pool, i00), b10 = gk_texel_bits(p, pool, i10);
    const gk_u32 b01 = gk_texel_bits(p, pool, i01), b11 = gk_texel_bits(p, pool, i11);
    const struct gk_texel top =
        gk_texel_mix(gk_texel_decode(p, b00, kind), gk_texel_decode(p, b10, kind), x.weight);
    const struct gk_texel bottom =
        gk_texel_mix(gk_texel_decode(p, b01, kind), gk_texel_decode(p, b11, kind), x.weight);
    struct gk_texel r = gk_texel_mix(top, bottom, y.weight);
    r.r = none ? 1.0f : r.r;
    r.g = none ? 1.0f : r.g;
    r.b = none ? 1.0f : r.b;
    r.a = none ? 1.0f : r.a;
    return r;
}

// Texture `index` at a point of a mesh: the record says which coordinates it reads and how it
// transforms them (KHR_texture_transform).
GK_INLINE struct gk_texel gk_texture_at(const struct gk_texture_pools *p, gk_u32 index,
                                        enum gk_texels kind, struct gk_coordinates at)
{
    gk_f32 u = at.u, v = at.v;
#if defined(GK_UV1) || defined(GK_TEXTURE_TRANSFORMS)
    const gk_u32 record = index == GK_NONE ? 0u : index;
    const gk_u32 flags = GK_TEXTURE(p, record, flags);
#endif
#ifdef GK_UV1
    const gk_i32 second = (flags & GK_TEXTURE_UV1) != 0u;
    u = second ? at.u1 : u;
    v = second ? at.v1 : v;
#endif
#ifdef GK_TEXTURE_TRANSFORMS
    const gk_i32 moved = (flags & GK_TEXTURE_TRANSFORMED) != 0u;
    const gk_f32 moved_u = GK_TEXTURE(p, record, transform[0]) * u +
                           GK_TEXTURE(p, record, transform[1]) * v +
                           GK_TEXTURE(p, record, transform[2]);
    const gk_f32 moved_v = GK_TEXTURE(p, record, transform[3]) * u +
                           GK_TEXTURE(p, record, transform[4]) * v +
                           GK_TEXTURE(p, record, transform[5]);
    u = moved ? moved_u : u;
    v = moved ? moved_v : v;
#endif
    return gk_texture_fetch(p, index, kind, u, v);
}

#endif
