#include "render/effects.h"

#include "kernels/gk_film.h"

#include <string.h>

const char *const glint_pass_name[GLINT_PASSES] = {
    [GLINT_PASS_GENERATE] = "generate camera rays",
    [GLINT_PASS_TRACE] = "trace closest hits",
    [GLINT_PASS_SHADE] = "shade surfaces",
    [GLINT_PASS_SHADOW] = "trace shadow rays",
    [GLINT_PASS_UNOCCLUDED] = "add unoccluded light",
    [GLINT_PASS_COMPACT] = "compact survivors",
    [GLINT_PASS_COLOUR] = "accumulate colour",
    [GLINT_PASS_AOVS] = "accumulate AOVs",
    [GLINT_PASS_COVERAGE] = "deposit ID coverage",
};

#define CALLED_BY_FACT(fact)                                      \
    static bool calls_##fact(const struct glint_effect_input *in) \
    {                                                             \
        return in->facts->fact;                                   \
    }
CALLED_BY_FACT(microfacet)
CALLED_BY_FACT(transmission)
CALLED_BY_FACT(textures)
CALLED_BY_FACT(normal_maps)
CALLED_BY_FACT(instances)
CALLED_BY_FACT(cutout)
CALLED_BY_FACT(emission)
CALLED_BY_FACT(light_table)
CALLED_BY_FACT(environment_constant)
CALLED_BY_FACT(environment_image)

static bool calls_texture_pools(const struct glint_effect_input *in)
{
    return in->facts->texture_pools > 1;
}

static bool calls_next_event(const struct glint_effect_input *in)
{
    return (in->facts->light_table || in->facts->environment_image) && in->job->max_bounces > 0;
}

static bool calls_lens(const struct glint_effect_input *in)
{
    return in->camera->lens_radius > 0.0f;
}

static bool calls_blackman_harris(const struct glint_effect_input *in)
{
    return in->job->filter == GLINT_FILTER_BLACKMAN_HARRIS;
}

static bool calls_aovs(const struct glint_effect_input *in)
{
    return in->job->outputs & (GLINT_OUT_DEPTH | GLINT_OUT_NORMAL | GLINT_OUT_ALBEDO);
}

static bool calls_coverage(const struct glint_effect_input *in)
{
    return in->job->outputs & GLINT_OUT_CRYPTO;
}

static bool calls_uniform_lights(const struct glint_effect_input *in)
{
    return in->facts->light_table && in->job->dial[GLINT_DIAL_LIGHTS] == 1;
}

static bool calls_float64(const struct glint_effect_input *in)
{
    return in->job->dial[GLINT_DIAL_PRECISION] == 0;
}

static size_t aov_bytes(const struct glint_job *job)
{
    (void)job;
    return GK_PLANES_AOV * 4;
}

static size_t coverage_bytes(const struct glint_job *job)
{
    return (job->matte_slots + 1) * 8;
}

#define NO_DIAL GLINT_DIAL_COUNT
#define PASS(p) (1u << GLINT_PASS_##p)
#define TABLE(t) (1u << GLINT_TABLE_##t)
#define POOLS (TABLE(POOL0) | TABLE(POOL1) | TABLE(POOL2) | TABLE(POOL3))

const struct glint_effect glint_effect_table[] = {
    {GLINT_EFFECT_MICROFACET, "a material that is metallic or has an interface (ior other than 1)",
     "GK_MICROFACET", "Walter et al. 2007; Heitz 2014; Dupuy and Benyoub 2023", NO_DIAL, 0,
     calls_microfacet, NULL, 0},
    {GLINT_EFFECT_TRANSMISSION, "a material with transmission > 0", "GK_TRANSMISSION",
     "Walter et al. 2007, Eq. 17 and 21; KHR_materials_transmission", NO_DIAL, 0,
     calls_transmission, NULL, 0},
    {GLINT_EFFECT_TEXTURES, "a material with a texture", "GK_TEXTURES", "glTF 2.0, 3.9.2 and 5.26",
     NO_DIAL, 0, calls_textures, NULL, TABLE(TEXTURES) | TABLE(DECODE) | POOLS},
    {"texture pools", "textures of more than 1 GiB", "GK_TEXTURE_POOLS=4", "ARCHITECTURE", NO_DIAL,
     0, calls_texture_pools, NULL, 0},
    {GLINT_EFFECT_NORMAL_MAPS, "a material with a normal texture", "GK_NORMAL_MAPS",
     "glTF 2.0, 3.9.3", NO_DIAL, 0, calls_normal_maps, NULL, TABLE(TANGENTS)},
    {GLINT_EFFECT_INSTANCES, "a large mesh drawn more than once", "GK_INSTANCES",
     "Embree instancing", NO_DIAL, 0, calls_instances, NULL, 0},
    {GLINT_EFFECT_CUTOUT, "a visible material with alphaMode MASK", NULL, "glTF 2.0, 3.9.4",
     NO_DIAL, 0, calls_cutout, NULL, 0},
    {GLINT_EFFECT_EMISSION, "a visible surface that emits", "GK_EMISSION", "glTF 2.0, 3.9.5",
     NO_DIAL, 0, calls_emission, NULL, 0},
    {GLINT_EFFECT_LIGHT_TABLE, "emitting triangles or punctual lights", "GK_LIGHT_TABLE",
     "Veach 1997, chapter 9; Walker 1977", GLINT_DIAL_LIGHTS, 0, calls_light_table, NULL,
     TABLE(LIGHTS) | TABLE(ALIAS)},
    {"uniform light choice", "accuracy.lights uniform", "GK_LIGHTS_UNIFORM", "ACCURACY 3",
     GLINT_DIAL_LIGHTS, 0, calls_uniform_lights, NULL, 0},
    {"next-event estimation", "an emitter that can be sampled, and at least one bounce",
     "GK_LIGHTS", "Veach 1997, chapter 9", NO_DIAL, PASS(SHADOW) | PASS(UNOCCLUDED),
     calls_next_event, NULL, 0},
    {GLINT_EFFECT_ENVIRONMENT_CONSTANT, "an environment of one radiance", "GK_ENVIRONMENT_CONSTANT",
     "-", NO_DIAL, 0, calls_environment_constant, NULL, 0},
    {GLINT_EFFECT_ENVIRONMENT_IMAGE, "an environment with an image", "GK_ENVIRONMENT_IMAGE",
     "Pharr et al. 2023, 12.5.2", NO_DIAL, 0, calls_environment_image, NULL,
     TABLE(ENV_TEXELS) | TABLE(ENV_CELLS)},
    {"depth of field", "a camera with a lens radius", "GK_LENS", "Cook et al. 1984", NO_DIAL, 0,
     calls_lens, NULL, 0},
    {"Blackman-Harris filter", "filter.kind blackman_harris", "GK_FILTER_BLACKMAN_HARRIS",
     "Harris 1978; Ernst et al. 2006", NO_DIAL, 0, calls_blackman_harris, NULL, 0},
    {"float64 film", "accuracy.precision float64", "GK_FILM_FP64", "ACCURACY 3",
     GLINT_DIAL_PRECISION, 0, calls_float64, NULL, 0},
    {"first-hit AOVs", "an output depth, normal or albedo", "GK_AOVS", "-", NO_DIAL, PASS(AOVS),
     calls_aovs, aov_bytes, 0},
    {"ID coverage", "a Cryptomatte output", NULL,
     "Cryptomatte 1.2.0; Yoshimura et al. 2022, Alg. 1", GLINT_DIAL_EVICTION, PASS(COVERAGE),
     calls_coverage, coverage_bytes, 0},
};
const size_t glint_effect_count = sizeof glint_effect_table / sizeof *glint_effect_table;

uint64_t glint_effects_called(const struct glint_effect_input *in)
{
    uint64_t bits = 0;
    for (size_t i = 0; i < glint_effect_count; i++)
        if (glint_effect_table[i].called(in))
            bits |= 1ull << i;
    return bits;
}

uint64_t glint_effect_bit(const char *name)
{
    for (size_t i = 0; i < glint_effect_count; i++)
        if (strcmp(glint_effect_table[i].name, name) == 0)
            return 1ull << i;
    return 0;
}
