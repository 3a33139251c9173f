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
        {GLINT_EFFECT_INSTANCES, facts->instances},
        {GLINT_EFFECT_CUTOUT, facts->cutout},
        {GLINT_EFFECT_EMISSION, facts->emission},
        {GLINT_EFFECT_LIGHT_TABLE, facts->light_table},
        {GLINT_EFFECT_ENVIRONMENT_CONSTANT, facts->environment_constant},
        {GLINT_EFFECT_ENVIRONMENT_IMAGE, facts->environment_image},
    };
    size_t n = 0;
    for (size_t i = 0; i < sizeof effect / sizeof *effect; i++)
        if (effect[i].holds && n < capacity)
            out[n++] = effect[i].name;
    return n;
}
