// opacity.c - the opacity test of holes: gk_surface_opacity of the kernels, compiled for the host.
#define GK_TEXTURES 1 // all that a scene may call for: records say what they have
#define GK_TEXTURE_POOLS 4
#define GK_TEXTURE_TRANSFORMS 1
#define GK_NEAREST_TEXELS 1
#define GK_UV1 1
#define GK_VERTEX_COLOURS 1
#include "kernels/gk_surface.h"
#include "scene/internal.h"

static struct gk_resident tables(const struct glint_resident *r)
{
    return (struct gk_resident){
        .triangle = glint_table_host(r, GLINT_TABLE_TRIANGLES),
        .uv1 = glint_table_host(r, GLINT_TABLE_UV1),
        .colour = glint_table_host(r, GLINT_TABLE_COLOURS),
        .instance = glint_table_host(r, GLINT_TABLE_INSTANCES),
        .material = glint_table_host(r, GLINT_TABLE_MATERIALS),
        .textures = {glint_table_host(r, GLINT_TABLE_TEXTURES),
                     glint_table_host(r, GLINT_TABLE_POOL0), glint_table_host(r, GLINT_TABLE_POOL1),
                     glint_table_host(r, GLINT_TABLE_POOL2), glint_table_host(r, GLINT_TABLE_POOL3),
                     glint_table_host(r, GLINT_TABLE_DECODE)}};
}

float glint_resident_opacity(const struct glint_resident *r, uint32_t row, uint32_t primitive,
                             float u, float v)
{
    const struct gk_resident t = tables(r);
    const struct gk_instance *in = t.instance + row;
    return gk_surface_opacity(&t, in->material, in->triangle + primitive, u, v);
}
