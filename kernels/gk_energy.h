// gk_energy.h - what a rough reflection keeps of the light, from a table.
//
// E(cos, alpha) is the directional albedo of single-scattering GGX with height-correlated masking.
// The table has a part for a reflectance of 1 and one for each interface that a scene has, the first
// of them of index 1.5, which is also a coat's. A part is E, then its hemispherical mean 2 Int E c dc
// for each alpha. A transmitting interface has further parts behind its own: of reflection and
// refraction together; of what it would pass on if no facet reflected less what it would reflect if
// all did, facets of total reflection left out; the three from inside; of a white reflector's facets
// that do not reflect totally from inside; and of what gk_scatter.h takes over the cosine in the
// thinner medium. Bilinear in sqrt(cos) and sqrt(alpha): within 0.009 of the integral for
// cos >= 1e-3, and within 0.002 for cos >= 0.05.
#ifndef GK_ENERGY_H
#define GK_ENERGY_H

#include "kernels/gk_cut.h"
#include "kernels/gk_math.h"

#define GK_ENERGY_SIDE 32 // entries for sqrt(cos), and for sqrt(alpha), from 0 to 1
#define GK_ENERGY_PART (GK_ENERGY_SIDE * (GK_ENERGY_SIDE + 1)) // entries
#define GK_ENERGY_WHITE 0
#define GK_ENERGY_COAT GK_ENERGY_PART
#define GK_ENERGY_BOTH GK_ENERGY_PART // behind a reflection's, from the same side
#define GK_ENERGY_SPARED (2 * GK_ENERGY_PART)
#define GK_ENERGY_INSIDE (3 * GK_ENERGY_PART)
#define GK_ENERGY_OPEN (6 * GK_ENERGY_PART)
#define GK_ENERGY_SCATTER (7 * GK_ENERGY_PART)
#define GK_ENERGY_PARTS 8 // of a transmitting interface

struct gk_energy_table {
    const GK_GLOBAL gk_f32 *entry;
    struct gk_cut cut;
};

// Place of x in 0..1 between entries: the lower one and the weight of the upper.
struct gk_energy_place {
    gk_i32 lower;
    gk_f32 weight;
};

GK_INLINE struct gk_energy_place gk_energy_find(gk_f32 x)
{
    const gk_f32 scaled = gk_sqrt(gk_saturate(x)) * (gk_f32)(GK_ENERGY_SIDE - 1);
    struct gk_energy_place p;
    p.lower = gk_min_i32((gk_i32)scaled, GK_ENERGY_SIDE - 2);
    p.weight = scaled - (gk_f32)p.lower;
    return p;
}

// Between entry `at` and the next.
GK_INLINE gk_f32 gk_energy_row(const GK_GLOBAL gk_f32 *entry, gk_i32 at, gk_f32 weight)
{
    const struct gk_two two = gk_two_at(entry, at);
    const gk_f32 a = gk_as_f32(two.first), b = gk_as_f32(two.second);
    return a + (b - a) * weight;
}

// part: offset of its first entry.
GK_INLINE gk_f32 gk_energy_albedo(const struct gk_energy_table *table, gk_i32 part, gk_f32 cosine,
                                  gk_f32 alpha)
{
    const struct gk_energy_place x = gk_energy_find(cosine), y = gk_energy_find(alpha);
    const gk_i32 at = part + y.lower * GK_ENERGY_SIDE + x.lower;
    GK_CUT(table->cut, (gk_u32)at);
    const gk_f32 a = gk_energy_row(table->entry, at, x.weight);
    const gk_f32 b = gk_energy_row(table->entry + GK_ENERGY_SIDE, at, x.weight);
    return a + (b - a) * y.weight;
}

GK_INLINE gk_f32 gk_energy_mean(const struct gk_energy_table *table, gk_i32 part, gk_f32 alpha)
{
    const struct gk_energy_place y = gk_energy_find(alpha);
    const gk_i32 at = part + GK_ENERGY_SIDE * GK_ENERGY_SIDE + y.lower;
    GK_CUT(table->cut, (gk_u32)at);
    return gk_energy_row(table->entry, at, y.weight);
}

#endif
