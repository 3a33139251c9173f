// gk_hit.h - from what the tracer wrote to a point with normals and texture coordinates.
#ifndef GK_HIT_H
#define GK_HIT_H

#include "kernels/gk_scene.h"
#include "kernels/gk_texture.h"
#include "kernels/gk_vec.h"

// The tables of a resident scene, as a kernel was given them.
struct gk_resident {
    const GK_GLOBAL struct gk_triangle *triangle;
    const GK_GLOBAL struct gk_tangent *tangent;
    const GK_GLOBAL struct gk_uv1 *uv1;
    const GK_GLOBAL struct gk_colour *colour;
    const GK_GLOBAL struct gk_instance *instance;
    const GK_GLOBAL struct gk_mover *mover;
    const GK_GLOBAL struct gk_turn *turn;
    const GK_GLOBAL struct gk_flow *flow;
    const GK_GLOBAL struct gk_material *material;
    const GK_GLOBAL gk_f32 *energy; // table of gk_bsdf.h
    struct gk_texture_pools textures;
};

#define GK_TRIANGLE(r, index, member) GK_READ((r)->triangle, gk_triangle, index, member)
#define GK_TANGENT(r, index, member) GK_READ((r)->tangent, gk_tangent, index, member)
#define GK_INSTANCE(r, index, member) GK_READ((r)->instance, gk_instance, index, member)
#define GK_MATERIAL(r, index, member) GK_READ((r)->material, gk_material, index, member)

// A hit as the tracer reports it.
struct gk_raw_hit {
    gk_u32 primitive, geometry, instance;
    gk_f32 u, v;
    struct gk_vec ng; // not normalised
    gk_u32 key;       // under GK_MOTION: the motion key before the path's time,
    gk_f32 w;         // and the way to the next one, 0..1
};

struct gk_hit {
    struct gk_vec ng, ns; // unit, world, on the side that the ray came from
    struct gk_vec nc;     // likewise, of the coat, under GK_CLEARCOAT
    gk_f32 cos_g;         // of the ray with the front side's geometric normal, signed; > 0: back
    gk_f32 u, v;          // barycentrics of the second and third vertex
    struct gk_coordinates at; // in its textures
    gk_f32 eta;      // under GK_NESTED: index beyond the surface over that before it, 0: none
    gk_u32 triangle; // record
    gk_u32 instance; // row
    gk_u32 material;
};

GK_INLINE struct gk_vec gk_interpolate3(struct gk_vec a, struct gk_vec b, struct gk_vec c, gk_f32 u,
                                        gk_f32 v)
{
    const gk_f32 w = 1.0f - u - v;
    return gk_vec(w * a.x + u * b.x + v * c.x, w * a.y + u * b.y + v * c.y,
                  w * a.z + u * b.z + v * c.z);
}

// Texture coordinates at barycentrics (u, v) of a record.
GK_INLINE struct gk_coordinates gk_coordinates_at(const struct gk_resident *r, gk_u32 triangle,
                                                  gk_f32 u, gk_f32 v)
{
    const gk_f32 w = 1.0f - u - v;
    struct gk_coordinates at;
    at.u = w * GK_TRIANGLE(r, triangle, uv[0]) + u * GK_TRIANGLE(r, triangle, uv[2]) +
           v * GK_TRIANGLE(r, triangle, uv[4]);
    at.v = w * GK_TRIANGLE(r, triangle, uv[1]) + u * GK_TRIANGLE(r, triangle, uv[3]) +
           v * GK_TRIANGLE(r, triangle, uv[5]);
#ifdef GK_UV1
    const gk_i32 has = (GK_TRIANGLE(r, triangle, flags) & GK_TRIANGLE_UV1) != 0u;
    const GK_GLOBAL gk_f32 *uv1 = r->uv1[has ? triangle : 0u].uv;
    const gk_f32 u1 = w * uv1[0] + u * uv1[2] + v * uv1[4];
    const gk_f32 v1 = w * uv1[1] + u * uv1[3] + v * uv1[5];
    at.u1 = has ? u1 : 0.0f;
    at.v1 = has ? v1 : 0.0f;
#else
    at.u1 = at.v1 = 0.0f;
#endif
    return at;
}

// How a row turns what its mesh has into the world, at a path's time.
struct gk_turning {
    struct gk_vec a, b, c; // rows of the inverse transpose
    gk_i32 turns;          // else the mesh is in the world as it is
    gk_f32 sign;           // of the determinant
};

#ifdef GK_MOTION
// Row k of the matrix between the two motion keys around the hit.
GK_INLINE struct gk_vec gk_turn_row(const GK_GLOBAL struct gk_turn *turn, gk_u32 k, gk_f32 w)
{
    const GK_GLOBAL gk_f32 *m = turn->normal + 3u * k, *n = (turn + 1)->normal + 3u * k;
    const struct gk_vec from = gk_vec(m[0], m[1], m[2]);
    return gk_along(from, gk_sub(gk_vec(n[0], n[1], n[2]), from), w);
}
#endif

GK_INLINE struct gk_turning gk_instance_turning(const struct gk_resident *r, gk_u32 row,
                                                const struct gk_raw_hit *raw)
{
    struct gk_turning t;
#ifdef GK_INSTANCES
    const gk_u32 flags = GK_INSTANCE(r, row, flags);
    t.a = GK_TRIPLE(GK_INSTANCE, r, row, normal, 0);
    t.b = GK_TRIPLE(GK_INSTANCE, r, row, normal, 3);
    t.c = GK_TRIPLE(GK_INSTANCE, r, row, normal, 6);
    t.turns = (flags & GK_INSTANCE_TRANSFORMED) != 0u;
    t.sign = (flags & GK_INSTANCE_MIRRORED) != 0u ? -1.0f : 1.0f;
#else
    t.a = gk_vec(1.0f, 0.0f, 0.0f);
    t.b = gk_vec(0.0f, 1.0f, 0.0f);
    t.c = gk_vec(0.0f, 0.0f, 1.0f);
    t.turns = 0;
    t.sign = 1.0f;
#endif
#ifdef GK_MOTION
    const gk_u32 mover = GK_INSTANCE(r, row, mover);
    const gk_u32 turn_of_mover = r->mover[mover == GK_NONE ? 0u : mover].turn;
    const gk_u32 first = mover == GK_NONE ? GK_NONE : turn_of_mover;
    const gk_i32 moves = first != GK_NONE;
    const GK_GLOBAL struct gk_turn *turn = r->turn + (moves ? first + raw->key : 0u);
    t.a = gk_vec_select(t.a, gk_turn_row(turn, 0u, raw->w), moves);
    t.b = gk_vec_select(t.b, gk_turn_row(turn, 1u, raw->w), moves);
    t.c = gk_vec_select(t.c, gk_turn_row(turn, 2u, raw->w), moves);
    t.turns = t.turns || moves;
#else
    (void)r;
    (void)row;
    (void)raw;
#endif
    return t;
}

GK_INLINE struct gk_vec gk_instance_normal(const struct gk_turning *t, struct gk_vec n)
{
    const struct gk_vec turned = gk_vec(gk_dot(t->a, n), gk_dot(t->b, n), gk_dot(t->c, n));
    return gk_vec_select(n, turned, t->turns);
}

// The front side's geometric normal from the traced one: of the world where the tracer has the
// mesh in the world, with its winding turned by a mirroring; else of the mesh.
GK_INLINE struct gk_vec gk_instance_front(const struct gk_turning *t, const struct gk_raw_hit *raw)
{
    const struct gk_vec baked = gk_vec_select(raw->ng, gk_negate(raw->ng), t->sign < 0.0f);
    return gk_vec_select(baked, gk_instance_normal(t, raw->ng), raw->instance != GK_NONE);
}

#ifdef GK_NORMAL_MAPS
// A vector along the surface, up to its length, zero if that is zero: the cofactors of the inverse
// transpose are the placement itself over its determinant.
GK_INLINE struct gk_vec gk_instance_vector(const struct gk_turning *turning, struct gk_vec t)
{
    const struct gk_vec a = turning->a, b = turning->b, c = turning->c;
    const struct gk_vec along = gk_normalise_any(
        gk_vec(gk_dot(gk_cross(b, c), t), gk_dot(gk_cross(c, a), t), gk_dot(gk_cross(a, b), t)));
    const struct gk_vec turned = gk_scale(along, turning->sign);
    return gk_vec_select(t, turned, turning->turns && gk_dot(t, t) > 0.0f);
}

// What a normal map is laid on.
struct gk_map_frame {
    struct gk_vec tangent; // interpolated, in the world
    gk_f32 side;           // of the bitangent
};

GK_INLINE struct gk_vec gk_tangent_at(const struct gk_resident *r, gk_u32 record, gk_f32 u,
                                      gk_f32 v)
{
    return gk_interpolate3(GK_TRIPLE(GK_TANGENT, r, record, tangent, 0),
                           GK_TRIPLE(GK_TANGENT, r, record, tangent, 4),
                           GK_TRIPLE(GK_TANGENT, r, record, tangent, 8), u, v);
}

GK_INLINE struct gk_map_frame gk_map_frame_at(const struct gk_resident *r, gk_u32 triangle,
                                              gk_u32 stride, const struct gk_raw_hit *raw,
                                              const struct gk_turning *turning)
{
    gk_u32 record = triangle;
    struct gk_vec tangent = gk_tangent_at(r, record, raw->u, raw->v);
#ifdef GK_MOTION
    record += raw->key * stride;
    const struct gk_vec from = gk_tangent_at(r, record, raw->u, raw->v);
    const struct gk_vec to = gk_tangent_at(r, record + stride, raw->u, raw->v);
    tangent = gk_along(from, gk_sub(to, from), raw->w);
#else
    (void)stride;
#endif
    struct gk_map_frame f;
    f.tangent = gk_instance_vector(turning, tangent);
    f.side = GK_TANGENT(r, record, tangent[3]) * turning->sign;
    return f;
}

// Shading normal from a normal map, in the frame of the interpolated tangents.
GK_INLINE struct gk_vec gk_mapped_normal(const struct gk_resident *r, const struct gk_hit *hit,
                                         const struct gk_map_frame *map, gk_u32 texture,
                                         gk_f32 scale)
{
    const struct gk_vec tangent =
        gk_normalise(gk_along(map->tangent, hit->ns, -gk_dot(map->tangent, hit->ns)));
    const struct gk_vec bitangent = gk_scale(gk_cross(hit->ns, tangent), map->side);
    const struct gk_texel n = gk_texture_at(&r->textures, texture, GK_TEXELS_NUMBERS, hit->at);
    const struct gk_vec inner = gk_vec((n.r * 2.0f - 1.0f) * scale, (n.g * 2.0f - 1.0f) * scale,
                                       gk_max(n.b * 2.0f - 1.0f, 0.0f));
    const struct gk_vec mapped = gk_normalise(
        gk_along(gk_along(gk_scale(tangent, inner.x), bitangent, inner.y), hit->ns, inner.z));
    const gk_i32 usable =
        texture != GK_NONE && gk_dot(tangent, tangent) > 0.5f && gk_dot(mapped, mapped) > 0.5f;
    return gk_vec_select(hit->ns, mapped, usable);
}
#endif

// A shading normal on the side of the ray.
GK_INLINE struct gk_vec gk_turned_normal(struct gk_vec n, struct gk_vec ng, struct gk_vec d)
{
    const struct gk_vec turned = gk_vec_select(n, gk_negate(n), gk_dot(n, ng) < 0.0f);
    // Seen from beyond its horizon a shading normal has no meaning: the geometric one serves.
    return gk_vec_select(turned, ng, gk_dot(turned, d) > -1e-4f);
}

// Records from a motion key to the next, 0 of a mesh that keeps its shape.
GK_INLINE gk_u32 gk_deforming_stride(const struct gk_resident *r, gk_u32 row)
{
#ifdef GK_MOTION
    const gk_u32 mover = GK_INSTANCE(r, row, mover);
    const gk_u32 stride = r->mover[mover == GK_NONE ? 0u : mover].stride;
    return mover == GK_NONE ? 0u : stride;
#else
    (void)r;
    (void)row;
    return 0u;
#endif
}

GK_INLINE struct gk_vec gk_triangle_normal(const struct gk_resident *r, gk_u32 triangle, gk_f32 u,
                                           gk_f32 v)
{
    return gk_interpolate3(GK_TRIPLE(GK_TRIANGLE, r, triangle, normal, 0),
                           GK_TRIPLE(GK_TRIANGLE, r, triangle, normal, 3),
                           GK_TRIPLE(GK_TRIANGLE, r, triangle, normal, 6), u, v);
}

// Interpolated over the triangle and between the keys, not normalised; zero: the mesh is flat.
GK_INLINE struct gk_vec gk_smooth_normal(const struct gk_resident *r, gk_u32 triangle,
                                         gk_u32 stride, const struct gk_raw_hit *raw)
{
#ifdef GK_MOTION
    const gk_u32 at = triangle + raw->key * stride;
    const struct gk_vec from = gk_triangle_normal(r, at, raw->u, raw->v);
    const struct gk_vec to = gk_triangle_normal(r, at + stride, raw->u, raw->v);
    return gk_along(from, gk_sub(to, from), raw->w);
#else
    (void)stride;
    return gk_triangle_normal(r, triangle, raw->u, raw->v);
#endif
}

// d: unit direction of the ray.
GK_INLINE struct gk_hit gk_hit_decode(const struct gk_resident *r, struct gk_raw_hit raw,
                                      struct gk_vec d)
{
    struct gk_hit hit;
    hit.instance = raw.instance != GK_NONE ? raw.instance : raw.geometry;
    const gk_u32 row = hit.instance;
    GK_CUT(r->textures.cut, row);
    hit.triangle = GK_INSTANCE(r, row, triangle) + raw.primitive;
    hit.material = GK_INSTANCE(r, row, material);
    hit.eta = 0.0f;
    hit.u = raw.u;
    hit.v = raw.v;
    hit.at = gk_coordinates_at(r, hit.triangle, raw.u, raw.v);

    // As long as its triangle is large: the square of a small one's would underflow.
    const struct gk_turning turning = gk_instance_turning(r, row, &raw);
    const struct gk_vec front = gk_normalise_any(gk_instance_front(&turning, &raw));
    hit.cos_g = gk_dot(front, d);
    hit.ng = gk_vec_select(front, gk_negate(front), hit.cos_g > 0.0f);
    const gk_u32 stride = gk_deforming_stride(r, row);
    const struct gk_vec smooth = gk_smooth_normal(r, hit.triangle, stride, &raw);
    const gk_i32 flat = gk_dot(smooth, smooth) == 0.0f;
    struct gk_vec ns = gk_normalise(gk_instance_normal(&turning, smooth));
    ns = gk_vec_select(ns, hit.ng, flat);
#ifdef GK_NORMAL_MAPS
    // The map is made for the side that the normals point to; turn afterwards.
    hit.ns = gk_vec_select(ns, front, flat);
    const struct gk_map_frame map = gk_map_frame_at(r, hit.triangle, stride, &raw, &turning);
    ns = gk_mapped_normal(r, &hit, &map, GK_MATERIAL(r, hit.material, normal_texture),
                          GK_MATERIAL(r, hit.material, normal_scale));
#endif
#ifdef GK_CLEARCOAT
#ifdef GK_NORMAL_MAPS
    const struct gk_vec nc =
        gk_mapped_normal(r, &hit, &map, GK_MATERIAL(r, hit.material, coat_normal_texture),
                         GK_MATERIAL(r, hit.material, coat_normal_scale));
#else
    const struct gk_vec nc = ns;
#endif
    hit.nc = gk_turned_normal(nc, hit.ng, d);
#endif
    hit.ns = gk_turned_normal(ns, hit.ng, d);
    return hit;
}

// Mean curvature of the surface where it was hit, 1/m; > 0: it bulges towards the ray.
GK_INLINE gk_f32 gk_hit_curvature(const struct gk_resident *r, const struct gk_hit *hit)
{
    const gk_f32 of_mesh = gk_as_f32(GK_TRIANGLE(r, hit->triangle, flags) & GK_TRIANGLE_CURVATURE);
    const gk_f32 curvature =
        of_mesh * GK_READ_ALONE(r->instance, gk_instance, hit->instance, shrink);
    return hit->cos_g > 0.0f ? -curvature : curvature;
}

#endif
