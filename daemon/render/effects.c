#include "render/effects.h"

#include "kernels/gk_film.h"
#include "kernels/gk_matte.h"
#include "kernels/gk_wave.h"
#include "protocol/matte_types.h"

#include <string.h>

const char *const glint_pass_name[GLINT_PASSES] = {
    [GLINT_PASS_GENERATE] = "generate camera rays",
    [GLINT_PASS_TRACE] = "trace closest hits",
    [GLINT_PASS_SHADE] = "shade surfaces",
    [GLINT_PASS_SHADOW] = "trace shadow rays",
    [GLINT_PASS_UNOCCLUDED] = "add unoccluded light",
    [GLINT_PASS_COMPACT] = "compact survivors",
    [GLINT_PASS_COLOUR] = "accumulate colour",
    [GLINT_PASS_BATCHES] = "accumulate batches",
    [GLINT_PASS_AOVS] = "accumulate AOVs",
    [GLINT_PASS_CARRIED] = "deposit carried coverage",
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
CALLED_BY_FACT(solids)
CALLED_BY_FACT(nested)
CALLED_BY_FACT(medium)
CALLED_BY_FACT(culling)
CALLED_BY_FACT(blend)
CALLED_BY_FACT(motion)
CALLED_BY_FACT(uv1)
CALLED_BY_FACT(texture_transforms)
CALLED_BY_FACT(nearest_texels)
CALLED_BY_FACT(roughness_textures)
CALLED_BY_FACT(emission_textures)
CALLED_BY_FACT(layer_textures)
CALLED_BY_FACT(vertex_colours)
CALLED_BY_FACT(specular)
CALLED_BY_FACT(clearcoat)
CALLED_BY_FACT(collimation)
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

static bool calls_multiple_scattering(const struct glint_effect_input *in)
{
    return in->facts->rough && in->job->dial[GLINT_DIAL_MICROFACET] == 0;
}

static bool calls_next_event(const struct glint_effect_input *in)
{
    return (in->facts->light_table || in->facts->environment_image) && in->job->max_bounces > 0;
}

static bool calls_lens(const struct glint_effect_input *in)
{
    return in->camera->lens_radius > 0.0f;
}

static bool calls_camera_motion(const struct glint_effect_input *in)
{
    return in->camera_moves;
}

static bool calls_orthographic(const struct glint_effect_input *in)
{
    return in->camera->projection == GLINT_ORTHOGRAPHIC;
}

static bool calls_flow(const struct glint_effect_input *in)
{
    return in->job->outputs & GLINT_OUT_MOTION;
}

static bool calls_blackman_harris(const struct glint_effect_input *in)
{
    return in->job->filter == GLINT_FILTER_BLACKMAN_HARRIS;
}

static bool calls_aovs(const struct glint_effect_input *in)
{
    return in->job->outputs &
           (GLINT_OUT_DEPTH | GLINT_OUT_NORMAL | GLINT_OUT_ALBEDO | GLINT_OUT_MOTION);
}

static bool calls_coverage(const struct glint_effect_input *in)
{
    return in->job->outputs & GLINT_OUT_CRYPTO;
}

static bool calls_through(const struct glint_effect_input *in)
{
    return calls_coverage(in) && in->job->dial[GLINT_DIAL_THROUGH] != GLINT_THROUGH_NONE;
}

// At alpha 0 every weight is 1, whatever the cone.
static bool calls_glossy(const struct glint_effect_input *in)
{
    return calls_coverage(in) && in->job->dial[GLINT_DIAL_THROUGH] == GLINT_THROUGH_GLOSSY &&
           in->job->matte_alpha > 0.0f;
}

static bool calls_opaque_full(const struct glint_effect_input *in)
{
    return calls_through(in) && in->job->dial[GLINT_DIAL_COVERAGE] != 0;
}

static bool calls_path_list(const struct glint_effect_input *in)
{
    return calls_opaque_full(in) && in->job->dial[GLINT_DIAL_PATH_IDS] == GLINT_PATH_IDS_LIST;
}

// Of the devices that there are each worker has one, which runs its items one after the other.
static bool calls_shared_tables(const struct glint_effect_input *in)
{
    (void)in;
    return false;
}

static bool calls_uniform_lights(const struct glint_effect_input *in)
{
    return in->facts->light_table && in->job->dial[GLINT_DIAL_LIGHTS] == 2;
}

static bool calls_light_grid(const struct glint_effect_input *in)
{
    return in->facts->light_grid && in->job->dial[GLINT_DIAL_LIGHTS] == 0;
}

static bool calls_light_grid_many(const struct glint_effect_input *in)
{
    return in->facts->light_grid_many && calls_light_grid(in);
}

static bool calls_float64(const struct glint_effect_input *in)
{
    return in->job->dial[GLINT_DIAL_PRECISION] == 0;
}

static bool calls_batches(const struct glint_effect_input *in)
{
    return in->job->estimate == GLINT_ESTIMATE_BATCHES;
}

static size_t batch_bytes(const struct glint_job *job, const struct glint_scene_facts *facts)
{
    (void)job, (void)facts;
    return GK_PLANES_BATCHES * 4;
}

static size_t aov_bytes(const struct glint_job *job, const struct glint_scene_facts *facts)
{
    (void)job;
    (void)facts;
    return GK_PLANES_AOV * 4;
}

static size_t flow_bytes(const struct glint_job *job, const struct glint_scene_facts *facts)
{
    (void)job;
    (void)facts;
    return GK_PLANES_FLOW * 4;
}

static size_t coverage_bytes(const struct glint_job *job, const struct glint_scene_facts *facts)
{
    const uint32_t slots = glint_matte_slots(job, facts->mattes);
    return (size_t)gk_matte_words(slots, job->dial[GLINT_DIAL_EVICTION]) * 8;
}

#define NO_DIAL GLINT_DIAL_COUNT
#define PASS(p) (1u << GLINT_PASS_##p)
#define TABLE(t) (1u << GLINT_TABLE_##t)
#define CARRIES(c) (1u << GK_COL_##c)
#define POOLS (TABLE(POOL0) | TABLE(POOL1) | TABLE(POOL2) | TABLE(POOL3))

const struct glint_effect glint_effect_table[] = {
    {.name = GLINT_EFFECT_MICROFACET,
     .cause = "a material that is metallic or has an interface (ior other than 1)",
     .define = "GK_MICROFACET",
     .source = "Walter et al. 2007; Heitz 2014; Dupuy and Benyoub 2023",
     .dial = NO_DIAL,
     .called = calls_microfacet},
    {.name = "multiple scattering",
     .cause = "accuracy.microfacet multiple, and a rough surface",
     .define = "GK_MULTISCATTER",
     .source = "Kulla and Conty 2017; Turquin 2019",
     .dial = GLINT_DIAL_MICROFACET,
     .called = calls_multiple_scattering,
     .tables = TABLE(ENERGY)},
    {.name = GLINT_EFFECT_SPECULAR,
     .cause = "a material with specular or specular_color other than 1",
     .define = "GK_SPECULAR",
     .source = "KHR_materials_specular",
     .dial = NO_DIAL,
     .called = calls_specular},
    {.name = GLINT_EFFECT_CLEARCOAT,
     .cause = "a material with clearcoat > 0",
     .define = "GK_CLEARCOAT",
     .source = "KHR_materials_clearcoat",
     .dial = NO_DIAL,
     .called = calls_clearcoat,
     .tables = TABLE(ENERGY)},
    {.name = GLINT_EFFECT_COLLIMATION,
     .cause = "a material that transmits with collimation < 1",
     .define = "GK_COLLIMATION",
     .source = "Walter et al. 2007",
     .dial = NO_DIAL,
     .called = calls_collimation},
    {.name = GLINT_EFFECT_TRANSMISSION,
     .cause = "a material with transmission > 0",
     .define = "GK_TRANSMISSION",
     .source = "Walter et al. 2007, Eq. 17 and 21; KHR_materials_transmission",
     .dial = NO_DIAL,
     .called = calls_transmission},
    {.name = GLINT_EFFECT_TEXTURES,
     .cause = "a material with a texture",
     .define = "GK_TEXTURES",
     .source = "glTF 2.0, 3.9.2 and 5.26",
     .dial = NO_DIAL,
     .called = calls_textures,
     .tables = TABLE(TEXTURES) | TABLE(DECODE) | POOLS},
    {.name = "texture pools",
     .cause = "textures of more than 1 GiB",
     .define = "GK_TEXTURE_POOLS=4",
     .source = "ARCHITECTURE",
     .dial = NO_DIAL,
     .called = calls_texture_pools},
    {.name = GLINT_EFFECT_UV1,
     .cause = "a texture that reads the second coordinates",
     .define = "GK_UV1",
     .source = "glTF 2.0, 5.30",
     .dial = NO_DIAL,
     .called = calls_uv1,
     .tables = TABLE(UV1)},
    {.name = GLINT_EFFECT_TEXTURE_TRANSFORMS,
     .cause = "a texture with offset, rotation or scale",
     .define = "GK_TEXTURE_TRANSFORMS",
     .source = "KHR_texture_transform",
     .dial = NO_DIAL,
     .called = calls_texture_transforms},
    {.name = GLINT_EFFECT_NEAREST_TEXELS,
     .cause = "a texture that is not interpolated",
     .define = "GK_NEAREST_TEXELS",
     .source = "glTF 2.0, 3.8.4.2",
     .dial = NO_DIAL,
     .called = calls_nearest_texels},
    {.name = GLINT_EFFECT_ROUGHNESS_TEXTURES,
     .cause = "a texture of metalness and roughness",
     .define = "GK_ROUGHNESS_TEXTURES",
     .source = "glTF 2.0, 5.22.5",
     .dial = NO_DIAL,
     .called = calls_roughness_textures},
    {.name = GLINT_EFFECT_EMISSION_TEXTURES,
     .cause = "a surface that emits with a texture",
     .define = "GK_EMISSION_TEXTURES",
     .source = "glTF 2.0, 5.19.7",
     .dial = NO_DIAL,
     .called = calls_emission_textures},
    {.name = GLINT_EFFECT_LAYER_TEXTURES,
     .cause = "a texture of transmission, specular or clearcoat",
     .define = "GK_LAYER_TEXTURES",
     .source = "KHR_materials_transmission, _specular, _clearcoat",
     .dial = NO_DIAL,
     .called = calls_layer_textures},
    {.name = GLINT_EFFECT_VERTEX_COLOURS,
     .cause = "a mesh with vertex colours",
     .define = "GK_VERTEX_COLOURS",
     .source = "glTF 2.0, 3.7.2.1",
     .dial = NO_DIAL,
     .called = calls_vertex_colours,
     .tables = TABLE(COLOURS)},
    {.name = GLINT_EFFECT_NORMAL_MAPS,
     .cause = "a material with a normal texture",
     .define = "GK_NORMAL_MAPS",
     .source = "glTF 2.0, 3.9.3",
     .dial = NO_DIAL,
     .called = calls_normal_maps,
     .tables = TABLE(TANGENTS)},
    {.name = GLINT_EFFECT_SOLIDS,
     .cause = "a solid that transmits and absorbs, or stands in a medium",
     .define = "GK_SOLIDS",
     .source = "Beer's law; KHR_materials_volume",
     .dial = NO_DIAL,
     .called = calls_solids,
     .carries = CARRIES(SOLID)},
    {.name = GLINT_EFFECT_NESTED,
     .cause = "a solid that transmits and has a priority",
     .define = "GK_NESTED",
     .source = "Schmidt and Budge 2002",
     .dial = NO_DIAL,
     .called = calls_nested,
     .carries = CARRIES(NESTED0) | CARRIES(NESTED1) | CARRIES(NESTED2) | CARRIES(NESTED3)},
    {.name = GLINT_EFFECT_MEDIUM,
     .cause = "a medium with a density",
     .define = "GK_MEDIUM",
     .source = "Henyey and Greenstein 1941; Pharr et al. 2023, 11.2 and 11.3.1",
     .dial = NO_DIAL,
     .called = calls_medium},
    {.name = GLINT_EFFECT_CULLING,
     .cause = "a surface that is not double-sided",
     .define = "GK_CULL",
     .source = "glTF 2.0, 3.9.5: of camera rays only, so that light sees one scene",
     .dial = NO_DIAL,
     .called = calls_culling},
    {.name = GLINT_EFFECT_BLEND,
     .cause = "a visible material with alphaMode BLEND",
     .define = "GK_BLEND",
     .source = "Porter and Duff 1984, by chance; Enderton et al. 2010",
     .dial = GLINT_DIAL_TRANSPARENCY,
     .called = calls_blend,
     .carries = CARRIES(PASSAGE)},
    {.name = GLINT_EFFECT_MOTION,
     .cause = "something that moves or bends while the shutter is open",
     .define = "GK_MOTION",
     .source = "Cook et al. 1984",
     .dial = NO_DIAL,
     .called = calls_motion,
     .tables = TABLE(TURNS),
     .carries = CARRIES(TIME)},
    {.name = "camera motion",
     .cause = "a camera that moves while the shutter is open",
     .define = "GK_CAMERA_MOTION",
     .source = "Cook et al. 1984",
     .dial = NO_DIAL,
     .called = calls_camera_motion,
     .carries = CARRIES(TIME)},
    {.name = GLINT_EFFECT_INSTANCES,
     .cause = "an instance that is turned, scaled or mirrored",
     .define = "GK_INSTANCES",
     .source = "Embree instancing",
     .dial = NO_DIAL,
     .called = calls_instances},
    {.name = GLINT_EFFECT_CUTOUT,
     .cause = "a visible material with alphaMode MASK",
     .source = "glTF 2.0, 3.9.4",
     .dial = NO_DIAL,
     .called = calls_cutout},
    {.name = GLINT_EFFECT_EMISSION,
     .cause = "a visible surface that emits",
     .define = "GK_EMISSION",
     .source = "glTF 2.0, 3.9.5",
     .dial = NO_DIAL,
     .called = calls_emission},
    {.name = GLINT_EFFECT_LIGHT_TABLE,
     .cause = "emitting triangles or punctual lights",
     .define = "GK_LIGHT_TABLE",
     .source = "Veach 1997, chapter 9; Walker 1977",
     .dial = GLINT_DIAL_LIGHTS,
     .called = calls_light_table,
     .tables = TABLE(LIGHTS) | TABLE(ALIAS)},
    {.name = GLINT_EFFECT_LIGHT_GRID,
     .cause = "more than 16 emitters, and accuracy.lights spatial",
     .define = "GK_LIGHT_GRID",
     .source = "Talbot et al. 2005; Walker 1977; Ramamoorthi and Hanrahan 2001",
     .dial = GLINT_DIAL_LIGHTS,
     .called = calls_light_grid,
     .tables = TABLE(LIGHT_CELLS)},
    {.name = GLINT_EFFECT_LIGHT_GRID_MANY,
     .cause = "more than 1023 emitters, not all of them areas, and accuracy.lights spatial",
     .define = "GK_LIGHT_GRID_MANY",
     .source = "Talbot et al. 2005",
     .dial = GLINT_DIAL_LIGHTS,
     .called = calls_light_grid_many},
    {.name = "uniform light choice",
     .cause = "accuracy.lights uniform",
     .define = "GK_LIGHTS_UNIFORM",
     .source = "ACCURACY 3",
     .dial = GLINT_DIAL_LIGHTS,
     .called = calls_uniform_lights},
    {.name = "next-event estimation",
     .cause = "an emitter that can be sampled, and at least one bounce",
     .define = "GK_LIGHTS",
     .source = "Veach 1997, chapter 9",
     .dial = NO_DIAL,
     .passes = PASS(SHADOW) | PASS(UNOCCLUDED),
     .called = calls_next_event},
    {.name = GLINT_EFFECT_ENVIRONMENT_CONSTANT,
     .cause = "an environment of one radiance",
     .define = "GK_ENVIRONMENT_CONSTANT",
     .source = "-",
     .dial = NO_DIAL,
     .called = calls_environment_constant},
    {.name = GLINT_EFFECT_ENVIRONMENT_IMAGE,
     .cause = "an environment with an image",
     .define = "GK_ENVIRONMENT_IMAGE",
     .source = "Pharr et al. 2023, 12.5.2",
     .dial = NO_DIAL,
     .called = calls_environment_image,
     .tables = TABLE(ENV_TEXELS) | TABLE(ENV_CELLS)},
    {.name = "orthographic view",
     .cause = "an orthographic camera",
     .define = "GK_ORTHOGRAPHIC",
     .source = "glTF 2.0, 3.10.3",
     .dial = NO_DIAL,
     .called = calls_orthographic},
    {.name = "depth of field",
     .cause = "a camera with a lens radius",
     .define = "GK_LENS",
     .source = "Cook et al. 1984",
     .dial = NO_DIAL,
     .called = calls_lens},
    {.name = "Blackman-Harris filter",
     .cause = "filter.kind blackman_harris",
     .define = "GK_FILTER_BLACKMAN_HARRIS",
     .source = "Harris 1978; Ernst et al. 2006",
     .dial = NO_DIAL,
     .called = calls_blackman_harris},
    {.name = "float64 film",
     .cause = "accuracy.precision float64",
     .define = "GK_FILM_FP64",
     .source = "ACCURACY 3",
     .dial = GLINT_DIAL_PRECISION,
     .called = calls_float64},
    {.name = "first-hit AOVs",
     .cause = "an output depth, normal, albedo or motion",
     .define = "GK_AOVS",
     .source = "-",
     .dial = NO_DIAL,
     .passes = PASS(AOVS),
     .called = calls_aovs,
     .film_bytes = aov_bytes},
    {.name = "motion vectors",
     .cause = "an output motion",
     .define = "GK_FLOW",
     .source = "CONVENTIONS b",
     .dial = NO_DIAL,
     .called = calls_flow,
     .film_bytes = flow_bytes,
     .tables = TABLE(FLOWS)},
    {.name = "batch sums",
     .cause = "estimate batches",
     .source = "ACCURACY 5",
     .dial = NO_DIAL,
     .passes = PASS(BATCHES),
     .called = calls_batches,
     .film_bytes = batch_bytes},
    {.name = "ID coverage",
     .cause = "a Cryptomatte output",
     .source = "Cryptomatte 1.2.0; Yoshimura et al. 2022, Alg. 1",
     .dial = GLINT_DIAL_EVICTION,
     .passes = PASS(COVERAGE),
     .called = calls_coverage,
     .film_bytes = coverage_bytes},
    {.name = "mattes through bounces",
     .cause = "mattes.through delta or glossy, and a Cryptomatte output",
     .define = "GK_THROUGH",
     .source = "Yoshimura et al. 2022, Eq. 1",
     .dial = GLINT_DIAL_THROUGH,
     .passes = PASS(CARRIED),
     .called = calls_through,
     .carries = CARRIES(HELD) | CARRIES(WAITS) | CARRIES(CARRIED) | CARRIES(LAST) | CARRIES(WAY)},
    {.name = "mattes through glossy lobes",
     .cause = "mattes.through glossy with an alpha above 0, and a Cryptomatte output",
     .define = "GK_GLOSSY_MATTES",
     .source = "Yoshimura et al. 2022, Eq. 2 to 7",
     .dial = GLINT_DIAL_VARIANCE,
     .called = calls_glossy,
     .carries = CARRIES(SPREAD0) | CARRIES(SPREAD1) | CARRIES(SPREAD2) | CARRIES(SINCE) |
                CARRIES(RADIUS) | CARRIES(SLOPE)},
    {.name = "full mattes of opaque surfaces",
     .cause = "mattes.coverage opaque_full, and mattes through bounces",
     .define = "GK_OPAQUE_FULL",
     .source = "Yoshimura et al. 2022, Eq. 8",
     .dial = GLINT_DIAL_COVERAGE,
     .called = calls_opaque_full},
    {.name = "each matte once on a path",
     .cause = "mattes.path_ids list, and mattes.coverage opaque_full",
     .define = "GK_PATH_LIST",
     .source = "ALGORITHMS A, Eq. 8",
     .dial = GLINT_DIAL_PATH_IDS,
     .called = calls_path_list},
    {.name = GLINT_EFFECT_SHARED_TABLES,
     .cause = "a device that runs many samples of a pixel at a time, of which this daemon has none",
     .define = "GK_SHARED_TABLES",
     .source = "Yoshimura et al. 2022, Alg. 1, repaired",
     .dial = NO_DIAL,
     .called = calls_shared_tables},
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
