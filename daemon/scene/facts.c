#include "scene/facts.h"

size_t glint_facts_effects(const struct glint_scene_facts *facts, const char **out, size_t capacity)
{
    const struct {
        const char *name;
        bool holds;
    } effect[] = {
        {GLINT_EFFECT_MICROFACET, facts->microfacet},
        {GLINT_EFFECT_TRANSMISSION, facts->transmission},
        {GLINT_EFFECT_TEXTURES, facts->textures},
        {GLINT_EFFECT_NORMAL_MAPS, facts->normal_maps},
        {GLINT_EFFECT_UV1, facts->uv1},
        {GLINT_EFFECT_TEXTURE_TRANSFORMS, facts->texture_transforms},
        {GLINT_EFFECT_NEAREST_TEXELS, facts->nearest_texels},
        {GLINT_EFFECT_LAYER_TEXTURES, facts->layer_textures},
        {GLINT_EFFECT_ROUGHNESS_TEXTURES, facts->roughness_textures},
        {GLINT_EFFECT_EMISSION_TEXTURES, facts->emission_textures},
        {GLINT_EFFECT_VERTEX_COLOURS, facts->vertex_colours},
        {GLINT_EFFECT_SPECULAR, facts->specular},
        {GLINT_EFFECT_CLEARCOAT, facts->clearcoat},
        {GLINT_EFFECT_COLLIMATION, facts->collimation},
        {GLINT_EFFECT_SOLIDS, facts->solids},
        {GLINT_EFFECT_NESTED, facts->nested},
        {GLINT_EFFECT_MEDIUM, facts->medium},
        {GLINT_EFFECT_CULLING, facts->culling},
        {GLINT_EFFECT_BLEND, facts->blend},
        {GLINT_EFFECT_MOTION, facts->motion},
        {GLINT_EFFECT_INSTANCES, facts->instances},
        {GLINT_EFFECT_CUTOUT, facts->cutout},
        {GLINT_EFFECT_EMISSION, facts->emission},
        {GLINT_EFFECT_LIGHT_TABLE, facts->light_table},
        {GLINT_EFFECT_LIGHT_GRID, facts->light_grid},
        {GLINT_EFFECT_LIGHT_GRID_MANY, facts->light_grid_many},
        {GLINT_EFFECT_ENVIRONMENT_CONSTANT, facts->environment_constant},
        {GLINT_EFFECT_ENVIRONMENT_IMAGE, facts->environment_image},
    };
    size_t n = 0;
    for (size_t i = 0; i < sizeof effect / sizeof *effect; i++)
        if (effect[i].holds && n < capacity)
            out[n++] = effect[i].name;
    return n;
}
