// opacity.c - textures as kernels read them, compiled for the host: the opacity test of holes, and what a
// triangle emits.
#define GK_TEXTURES 1 // all that a scene may call for: records say what they have
#define GK_TEXTURE_POOLS 4
#define GK_TEXTURE_TRANSFORMS 1
#define GK_NEAREST_TEXELS 1
#define GK_UV1 1
#define GK_VERTEX_COLOURS 1
#include "kernels/gk_surface.h"
#include "scene/internal.h"

// Before all is built: NULL for what the scene does not need.
static void *host(const struct glint_resident *r, enum glint_table table)
{
    return r->table[table] ? glint_table_host(r, table) : NULL;
}

static struct gk_resident tables(const struct glint_resident *r)
{
    return (struct gk_resident){.triangle = host(r, GLINT_TABLE_TRIANGLES),
                                .uv1 = host(r, GLINT_TABLE_UV1),
                                .colour = host(r, GLINT_TABLE_COLOURS),
                                .instance = host(r, GLINT_TABLE_INSTANCES),
                                .material = host(r, GLINT_TABLE_MATERIALS),
                                .textures = {host(r, GLINT_TABLE_TEXTURES),
                                             host(r, GLINT_TABLE_POOL0), host(r, GLINT_TABLE_POOL1),
                                             host(r, GLINT_TABLE_POOL2), host(r, GLINT_TABLE_POOL3),
                                             host(r, GLINT_TABLE_DECODE), gk_cut_none()}};
}

float glint_resident_opacity(const struct glint_resident *r, uint32_t row, uint32_t primitive,
                             float u, float v)
{
    const struct gk_resident t = tables(r);
    const struct gk_instance *in = t.instance + row;
    return gk_surface_opacity(&t, in->material, in->triangle + primitive, u, v);
}

#define LOOKS 64

static float fraction(float x)
{
    return x - gk_floor(x);
}

// At the points of an additive sequence (Roberts 2018), folded into the triangle (Heitz 2019).
double glint_resident_emission(const struct glint_resident *r, uint32_t texture, uint32_t triangle)
{
    const struct gk_resident t = tables(r);
    double sum = 0.0;
    for (int i = 0; i < LOOKS; i++) {
        const float u = fraction(0.5f + 0.7548777f * (float)i),
                    v = fraction(0.5f + 0.5698403f * (float)i);
        const float a = v > u ? u * 0.5f : u - v * 0.5f, b = v > u ? v - u * 0.5f : v * 0.5f;
        const struct gk_texel e = gk_texture_at(&t.textures, texture, GK_TEXELS_COLOUR,
                                                gk_coordinates_at(&t, triangle, a, b));
        sum += 0.2126 * e.r + 0.7152 * e.g + 0.0722 * e.b;
    }
    return sum / LOOKS;
}
