// facts.h - what a scene contains, as far as it calls for an effect by itself.
//
// The effects table asks these facts and takes its names from here, so that the scene resource and
// the plan of a job speak of the same thing.
#ifndef GLINT_SCENE_FACTS_H
#define GLINT_SCENE_FACTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define GLINT_EFFECT_MICROFACET "microfacet"
#define GLINT_EFFECT_TRANSMISSION "transmission"
#define GLINT_EFFECT_TEXTURES "textures"
#define GLINT_EFFECT_NORMAL_MAPS "normal maps"
#define GLINT_EFFECT_INSTANCES "instances"
#define GLINT_EFFECT_CUTOUT "alpha cut-outs"
#define GLINT_EFFECT_EMISSION "emission"
#define GLINT_EFFECT_LIGHT_TABLE "light table"
#define GLINT_EFFECT_ENVIRONMENT_CONSTANT "constant environment"
#define GLINT_EFFECT_ENVIRONMENT_IMAGE "environment image"

struct glint_scene_facts {
    bool microfacet, transmission, textures, normal_maps, instances, cutout;
    bool emission, light_table, environment_constant, environment_image;
    uint32_t texture_pools;
};

// Names of the effects that hold, static strings. Returns their number, at most `capacity`.
size_t glint_facts_effects(const struct glint_scene_facts *facts, const char **out,
                           size_t capacity);

#endif
