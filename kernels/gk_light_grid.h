// gk_light_grid.h - choosing among very many lights by where they are needed.
//
// Lights lie in clusters. A regular grid of cells covers the scene (a point outside belongs to the
// nearest cell), and each cell holds an alias table over the clusters, each cluster one over its
// lights: p(light | point) = p(cluster | cell of the point) * p(light | cluster), which is one
// gather for any light, so that a BSDF ray that finds a light knows it too.
//
// The words of the table, n = clusters:
//   [cells][n] {keep << 16 | other, pdf}       keep in 1/65536, of the entry; pdf of the cluster
//   [n] {first, count}                         of its lights among the members
//   grid_members: [members] {keep, light, other}
//   grid_owners:  [lights] {cluster, share}    share: p(light | cluster), 0: never chosen
// pdf, keep (of members) and share are floats. Probabilities are those that the rounded tables
// really have.
//
// Of four lights chosen so, or of sixteen where clusters are many and points, spots or suns among them,
// one is kept in proportion to the unshadowed light that it brings (resampled importance sampling, Talbot et al. 2005). MIS weighs by
// the density of all of them, which is a function of the direction alone: any such weight is unbiased.
#ifndef GK_LIGHT_GRID_H
#define GK_LIGHT_GRID_H

#include "kernels/gk_light.h"

#define GK_GRID_ENTRY 2u
#define GK_GRID_CLUSTER 2u
#define GK_GRID_MEMBER 3u
#define GK_GRID_OWNER 2u
#define GK_GRID_KEEP 65536.0f
#define GK_GRID_MANY 1024u // clusters, from which on sixteen candidates may pay

struct gk_light_grid {
    const GK_GLOBAL gk_u32 *word;
    gk_u32 cell;     // first word of the point's entries
    gk_u32 clusters; // 0: there is no grid
    gk_u32 many;     // 1: sixteen candidates are drawn, and not four
    gk_u32 first_cluster, first_member, first_owner;
    struct gk_cut cut;
};

// Which light, and with what probability.
struct gk_light_pick {
    gk_u32 light;
    gk_f32 choice;
};

// Where a point looks for a light: x the place, n the normal (zero: no surface), behind the weight
// of light that comes from beyond it.
struct gk_light_receiver {
    struct gk_vec x, n;
    gk_f32 behind;
    struct gk_light_keys keys; // when
};

GK_INLINE gk_u32 gk_grid_axis(gk_f32 x, gk_f32 origin, gk_f32 scale, gk_u32 size)
{
    const gk_i32 last = gk_max_i32((gk_i32)size - 1, 0);
    const gk_f32 at = gk_clamp((x - origin) * scale, 0.0f, (gk_f32)last);
    return (gk_u32)gk_min_i32((gk_i32)at, last);
}

GK_INLINE struct gk_light_grid gk_light_grid_at(const GK_GLOBAL struct gk_frame *f,
                                                const GK_GLOBAL gk_u32 *words, struct gk_vec p,
                                                struct gk_cut cut)
{
    const gk_u32 x = gk_grid_axis(p.x, f->grid_origin[0], f->grid_scale[0], f->grid_size[0]);
    const gk_u32 y = gk_grid_axis(p.y, f->grid_origin[1], f->grid_scale[1], f->grid_size[1]);
    const gk_u32 z = gk_grid_axis(p.z, f->grid_origin[2], f->grid_scale[2], f->grid_size[2]);
    const gk_u32 cell = (z * f->grid_size[1] + y) * f->grid_size[0] + x;
    const gk_u32 cells = f->grid_size[0] * f->grid_size[1] * f->grid_size[2];
    struct gk_light_grid g;
    g.word = words;
    g.clusters = f->grid_clusters;
    g.many = f->grid_many;
    g.cell = cell * f->grid_clusters * GK_GRID_ENTRY;
    g.first_cluster = cells * f->grid_clusters * GK_GRID_ENTRY;
    g.first_member = f->grid_members;
    g.first_owner = f->grid_owners;
    g.cut = cut;
    GK_CUT(cut, g.cell);
    return g;
}

// Word `index` from `first` on, signed as GK_READ() has it.
GK_INLINE gk_u32 gk_grid_word(const struct gk_light_grid *g, gk_u32 first, gk_u32 index)
{
    return (g->word + first)[(gk_i32)index];
}

// It, and the next one.
GK_INLINE struct gk_two gk_grid_two(const struct gk_light_grid *g, gk_u32 first, gk_u32 index)
{
    return gk_two_at(g->word + first, (gk_i32)index);
}

// Probability with which a light of the table is chosen; 0 without a grid.
GK_INLINE gk_f32 gk_grid_choice(const struct gk_light_grid *g, gk_u32 light)
{
    const struct gk_two owner =
        gk_grid_two(g, g->first_owner, (g->clusters > 0u ? light : 0u) * GK_GRID_OWNER);
    const gk_u32 pdf = gk_grid_word(g, 1u, g->cell + owner.first * GK_GRID_ENTRY);
    return gk_as_f32(pdf) * gk_as_f32(owner.second);
}

// Takes the cluster and the light in it; what is left of the pair is for the point.
GK_INLINE struct gk_light_pick gk_grid_choose(const struct gk_light_grid *g,
                                              struct gk_light_pair *r)
{
    const gk_u32 slot = gk_light_pair_slot(r, g->clusters);
    const gk_u32 at = g->cell + slot * GK_GRID_ENTRY;
    GK_CUT(g->cut, at);
    const gk_u32 entry = gk_grid_word(g, 0u, at);
    const gk_f32 keep = (gk_f32)(gk_i32)(entry >> 16) * (1.0f / GK_GRID_KEEP);
    const gk_u32 cluster = gk_light_pair_below(r, keep) ? slot : entry & 0xffffu;
    const gk_u32 record = cluster * GK_GRID_CLUSTER;
    GK_CUT(g->cut, record);
    const struct gk_two members = gk_grid_two(g, g->first_cluster, record);
    const gk_u32 place = members.first + gk_light_pair_slot(r, members.second);
    const gk_u32 member = place * GK_GRID_MEMBER;
    GK_CUT(g->cut, member);
    const struct gk_two two = gk_grid_two(g, g->first_member, member);
    const gk_u32 other = gk_grid_word(g, g->first_member + 2u, member);
    struct gk_light_pick p;
    p.light = gk_light_pair_below(r, gk_as_f32(two.first)) ? two.second : other;
    GK_CUT(g->cut, p.light);
    const gk_u32 pdf = gk_grid_word(g, 1u, g->cell + cluster * GK_GRID_ENTRY);
    const gk_u32 share = gk_grid_word(g, g->first_owner + 1u, p.light * GK_GRID_OWNER);
    p.choice = gk_as_f32(pdf) * gk_as_f32(share); // the light belongs to the same cluster
    return p;
}

// Whether sixteen candidates are drawn, and not four.
GK_INLINE gk_i32 gk_grid_many(const struct gk_light_grid *g)
{
#ifdef GK_LIGHT_GRID_MANY
    return g->many != 0u;
#else
    (void)g;
    return 0;
#endif
}

// What gk_light_from_table() would bring from (u, v) of a light if nothing were in the way, over its
// density, less the lift off the emitter: one division, for there are many of these.
GK_INLINE gk_f32 gk_light_promise(const GK_GLOBAL struct gk_light *lights, gk_u32 index,
                                  const struct gk_light_receiver *to, gk_f32 choice, gk_f32 u,
                                  gk_f32 v)
{
    const struct gk_light_place at = gk_light_place_at(lights, index, to->keys);
    const gk_u32 flags = GK_LIGHT(lights, index, kind), kind = flags & GK_LIGHT_KIND;
    const gk_i32 triangle = kind == GK_LIGHT_TRIANGLE, sun = kind == GK_LIGHT_SUN;
    gk_f32 s, t;
    gk_light_point(u, v, &s, &t);
    const struct gk_vec point =
        gk_along(gk_along(at.p, at.a, triangle ? s : 0.0f), at.b, triangle ? t : 0.0f);
    const struct gk_vec way = gk_vec_select(gk_sub(point, to->x), at.p, sun);
    const gk_f32 d2 = gk_max(gk_dot(way, way), 1e-37f);
    const gk_f32 over = 1.0f / gk_max(d2 * choice, 1e-37f);
    const gk_f32 over_d = gk_sqrt(over * choice);

    const gk_f32 outward = -gk_dot(way, gk_cross(at.a, at.b)); // cosine, times way and twice area
    const gk_f32 shown = outward > 0.0f || (flags >> 4) != 0u ? 0.5f * gk_abs(outward) : 0.0f;
    const gk_f32 cone = gk_clamp((-gk_dot(way, at.a) * over_d - at.b.x) * at.b.y, 0.0f, 1.0f);
    const gk_f32 sent = triangle ? shown * over_d : sun ? 1.0f : cone * cone;
    const gk_f32 cosine = gk_dot(way, to->n) * over_d;
    const gk_f32 weight = cosine > 0.0f ? cosine : -cosine * to->behind;
    const gk_i32 surface = gk_dot(to->n, to->n) > 0.0f;
    const struct gk_vec L = GK_TRIPLE(GK_LIGHT, lights, index, L, 0);
    const gk_f32 promise = gk_mean3(L) * (surface ? weight : 1.0f) * sent * over;
    return promise > 0.0f ? gk_min(promise, 1e36f) : 0.0f; // NaN too
}

// Candidates seen so far: the one that is kept, and the sum of what all of them promise.
struct gk_light_fold {
    struct gk_light_pick pick;
    gk_f32 s, t; // the point on it
    gk_f32 promise, sum;
    gk_f32 u; // uniform still, whatever was kept
};

// Adds the candidate whose first number is turned by `turn`/2^32, if it counts; kept with probability
// promise / sum.
GK_INLINE struct gk_light_fold gk_grid_fold(struct gk_light_fold f, const struct gk_light_grid *g,
                                            const GK_GLOBAL struct gk_light *lights,
                                            const struct gk_light_receiver *to, gk_f32 share,
                                            const struct gk_light_pair *r, gk_u32 turn,
                                            gk_i32 counts)
{
    struct gk_light_pair pair;
    pair.u = r->u + turn;
    pair.v = r->v;
    pair.fine = r->fine;
    struct gk_light_pick c = gk_grid_choose(g, &pair);
    c.choice *= share;
    const gk_f32 s = gk_unit_float(pair.u), t = pair.v;
    const gk_f32 promise = gk_light_promise(lights, c.light, to, c.choice, s, t);
    const gk_f32 sum = f.sum + (counts ? promise : 0.0f);
    const gk_f32 at = f.u * sum;
    const gk_i32 take = counts && at < promise;
    struct gk_light_fold n;
    n.pick.light = take ? c.light : f.pick.light;
    n.pick.choice = take ? c.choice : f.pick.choice;
    n.s = take ? s : f.s;
    n.t = take ? t : f.t;
    n.promise = take ? promise : f.promise;
    n.sum = sum;
    const gk_f32 rest = (take ? at : at - promise) / (take ? promise : gk_max(f.sum, 1e-37f));
    n.u = counts && sum > 0.0f ? gk_clamp(rest, 0.0f, 1.0f - GK_UNIT) : f.u;
    return n;
}

// A light for the receiver, promise its own sum that of all; share: probability
// that the table is asked at all. r: which lights, and where on them; u: which of those.
GK_INLINE struct gk_light_fold gk_light_from_grid(const struct gk_light_grid *g,
                                                  const GK_GLOBAL struct gk_light *lights,
                                                  const struct gk_light_receiver *to, gk_f32 share,
                                                  const struct gk_light_pair *r, gk_f32 u)
{
    struct gk_light_fold f = {{0u, 0.0f}, 0.0f, 0.0f, 0.0f, 0.0f, u};
    f = gk_grid_fold(f, g, lights, to, share, r, 0x00000000u, 1);
    f = gk_grid_fold(f, g, lights, to, share, r, 0x40000000u, 1);
    f = gk_grid_fold(f, g, lights, to, share, r, 0x80000000u, 1);
    f = gk_grid_fold(f, g, lights, to, share, r, 0xc0000000u, 1);
#ifdef GK_LIGHT_GRID_MANY
    const gk_i32 many = gk_grid_many(g);
    f = gk_grid_fold(f, g, lights, to, share, r, 0x20000000u, many);
    f = gk_grid_fold(f, g, lights, to, share, r, 0x60000000u, many);
    f = gk_grid_fold(f, g, lights, to, share, r, 0xa0000000u, many);
    f = gk_grid_fold(f, g, lights, to, share, r, 0xe0000000u, many);
    f = gk_grid_fold(f, g, lights, to, share, r, 0x10000000u, many);
    f = gk_grid_fold(f, g, lights, to, share, r, 0x30000000u, many);
    f = gk_grid_fold(f, g, lights, to, share, r, 0x50000000u, many);
    f = gk_grid_fold(f, g, lights, to, share, r, 0x70000000u, many);
    f = gk_grid_fold(f, g, lights, to, share, r, 0x90000000u, many);
    f = gk_grid_fold(f, g, lights, to, share, r, 0xb0000000u, many);
    f = gk_grid_fold(f, g, lights, to, share, r, 0xd0000000u, many);
    f = gk_grid_fold(f, g, lights, to, share, r, 0xf0000000u, many);
#endif
    return f;
}

// What the light that is kept is multiplied by.
GK_INLINE gk_f32 gk_grid_weight(const struct gk_light_grid *g, const struct gk_light_fold *f)
{
    const gk_f32 each = gk_grid_many(g) ? 0.0625f : 0.25f;
    return f->promise > 0.0f ? each * (f->sum / f->promise) : 0.0f;
}

#endif
