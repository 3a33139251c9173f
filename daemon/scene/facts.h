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
#define GLINT_EFFECT_UV1 "second texture coordinates"
#define GLINT_EFFECT_TEXTURE_TRANSFORMS "texture transforms"
#define GLINT_EFFECT_NEAREST_TEXELS "nearest texels"
#define GLINT_EFFECT_LAYER_TEXTURES "layer textures"
#define GLINT_EFFECT_ROUGHNESS_TEXTURES "roughness textures"
#define GLINT_EFFECT_EMISSION_TEXTURES "emission textures"
#define GLINT_EFFECT_VERTEX_COLOURS "vertex colours"
#define GLINT_EFFECT_SPECULAR "specular"
#define GLINT_EFFECT_CLEARCOAT "clearcoat"
#define GLINT_EFFECT_COLLIMATION "collimation"
#define GLINT_EFFECT_SOLIDS "inside of solids"
#define GLINT_EFFECT_NESTED "nested dielectrics"
#define GLINT_EFFECT_MEDIUM "medium"
#define GLINT_EFFECT_CULLING "single-sided surfaces"
#define GLINT_EFFECT_BLEND "alpha blending"
#define GLINT_EFFECT_MOTION "motion"
#define GLINT_EFFECT_INSTANCES "instances"
#define GLINT_EFFECT_CUTOUT "alpha cut-outs"
#define GLINT_EFFECT_EMISSION "emission"
#define GLINT_EFFECT_LIGHT_TABLE "light table"
#define GLINT_EFFECT_LIGHT_GRID "light grid"
#define GLINT_EFFECT_LIGHT_GRID_MANY "light grid of many"
#define GLINT_EFFECT_ENVIRONMENT_CONSTANT "constant environment"
#define GLINT_EFFECT_ENVIRONMENT_IMAGE "environment image"

struct glint_scene_facts {
    bool microfacet, transmission, textures, normal_maps, instances, cutout;
    bool uv1, texture_transforms, nearest_texels, vertex_colours;
    bool roughness_textures, emission_textures;
    bool layer_textures; // of transmission, specular or coat
    bool specular, clearcoat, collimation;
    bool rough; // light can meet several facets
    bool solids, nested, medium, culling, blend, motion;
    bool emission, light_table, light_grid, light_grid_many;
    bool environment_constant, environment_image;
    uint32_t texture_pools;
    uint32_t mattes; // keys of ID coverage: 0, the background and every name
};

// Names of the effects that hold, static strings. Returns their number, at most `capacity`.
size_t glint_facts_effects(const struct glint_scene_facts *facts, const char **out,
                           size_t capacity);

#endif
