// gk_vec.h - three floats as a plain structure: scalars to the compiler, so a work-item loop that
// uses them still vectorises (an OpenCL float3 would not).
#ifndef GK_VEC_H
#define GK_VEC_H

#include "kernels/gk_math.h"

struct gk_vec {
    gk_f32 x, y, z;
};

GK_INLINE struct gk_vec gk_vec(gk_f32 x, gk_f32 y, gk_f32 z)
{
    struct gk_vec v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

// Three elements, from k on, of an array in record `index`; read: GK_READ() for a table of its kind.
#define GK_TRIPLE(read, table, index, member, k)                               \
    gk_vec(read(table, index, member[k]), read(table, index, member[(k) + 1]), \
           read(table, index, member[(k) + 2]))

GK_INLINE struct gk_vec gk_splat(gk_f32 s)
{
    return gk_vec(s, s, s);
}

GK_INLINE struct gk_vec gk_add(struct gk_vec a, struct gk_vec b)
{
    return gk_vec(a.x + b.x, a.y + b.y, a.z + b.z);
}

GK_INLINE struct gk_vec gk_sub(struct gk_vec a, struct gk_vec b)
{
    return gk_vec(a.x - b.x, a.y - b.y, a.z - b.z);
}

GK_INLINE struct gk_vec gk_mul(struct gk_vec a, struct gk_vec b)
{
    return gk_vec(a.x * b.x, a.y * b.y, a.z * b.z);
}

GK_INLINE struct gk_vec gk_scale(struct gk_vec a, gk_f32 s)
{
    return gk_vec(a.x * s, a.y * s, a.z * s);
}

// a + b s
GK_INLINE struct gk_vec gk_along(struct gk_vec a, struct gk_vec b, gk_f32 s)
{
    return gk_vec(a.x + b.x * s, a.y + b.y * s, a.z + b.z * s);
}

GK_INLINE struct gk_vec gk_negate(struct gk_vec a)
{
    return gk_vec(-a.x, -a.y, -a.z);
}

GK_INLINE gk_f32 gk_dot(struct gk_vec a, struct gk_vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

GK_INLINE struct gk_vec gk_cross(struct gk_vec a, struct gk_vec b)
{
    return gk_vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

// a, or b where `take_b`.
GK_INLINE struct gk_vec gk_vec_select(struct gk_vec a, struct gk_vec b, gk_i32 take_b)
{
    return gk_vec(take_b ? b.x : a.x, take_b ? b.y : a.y, take_b ? b.z : a.z);
}

// Unit vector; a zero vector stays zero.
GK_INLINE struct gk_vec gk_normalise(struct gk_vec a)
{
    const gk_f32 length = gk_sqrt(gk_dot(a, a));
    const gk_f32 s = length > 0.0f ? 1.0f / length : 0.0f;
    return gk_scale(a, s);
}

// The same for any length that a float can have; a zero vector becomes +z.
GK_INLINE struct gk_vec gk_normalise_any(struct gk_vec a)
{
    gk_safe_normalise(&a.x, &a.y, &a.z);
    return a;
}

GK_INLINE gk_f32 gk_mean3(struct gk_vec a)
{
    return (a.x + a.y + a.z) * (1.0f / 3.0f);
}

GK_INLINE gk_f32 gk_max3(struct gk_vec a)
{
    return gk_max(a.x, gk_max(a.y, a.z));
}

// An orthonormal frame around a unit normal n.
// Source: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
struct gk_onb {
    struct gk_vec t, b, n;
};

GK_INLINE struct gk_onb gk_onb_make(struct gk_vec n)
{
    const gk_f32 sign = n.z < 0.0f ? -1.0f : 1.0f;
    const gk_f32 a = -1.0f / (sign + n.z);
    const gk_f32 b = n.x * n.y * a;
    struct gk_onb f;
    f.t = gk_vec(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x);
    f.b = gk_vec(b, sign + n.y * n.y * a, -n.y);
    f.n = n;
    return f;
}

GK_INLINE struct gk_vec gk_to_local(struct gk_onb f, struct gk_vec v)
{
    return gk_vec(gk_dot(v, f.t), gk_dot(v, f.b), gk_dot(v, f.n));
}

GK_INLINE struct gk_vec gk_to_world(struct gk_onb f, struct gk_vec v)
{
    return gk_along(gk_along(gk_scale(f.t, v.x), f.b, v.y), f.n, v.z);
}

#endif
