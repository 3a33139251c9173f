#include "render/common.h"

#include "protocol/job.h"
#include "render/plan.h"

#include <stdio.h>
#include <string.h>

// Surfaces as most scenes have them.
#define SURFACES .microfacet = true, .rough = true, .texture_pools = 1

struct common {
    struct glint_scene_facts facts;
    float lens_radius;
};

// The demo scene, which is what a new installation is tried with; then files of glTF: lit by a lamp,
// by the sun, by the picture of a sky.
static const struct common common[] = {
    {{SURFACES, .transmission = true, .instances = true, .emission = true, .light_table = true,
      .environment_image = true},
     1.0f},
    {{SURFACES, .culling = true, .emission = true, .light_table = true}, 0.0f},
    {{SURFACES, .culling = true, .textures = true, .emission = true, .light_table = true}, 0.0f},
    {{SURFACES, .culling = true, .textures = true, .normal_maps = true, .light_table = true}, 0.0f},
    {{SURFACES, .culling = true, .textures = true, .normal_maps = true, .environment_image = true},
     0.0f},
};
#define VARIANTS (sizeof common / sizeof *common)

// A job of which nothing is said but its scene.
size_t glint_common_variant(size_t index, char options[GLINT_COMMON_OPTIONS])
{
    static const char text[] = "{\"scene\":\"s\"}";
    struct glint_job *job;
    struct glint_plan plan;
    options[0] = 0;
    if (index >= VARIANTS || glint_job_parse(&job, text, sizeof text - 1, NULL))
        return VARIANTS;
    const struct glint_camera camera = {.lens_radius = common[index].lens_radius};
    const struct glint_effect_input in = {&common[index].facts, job, &camera, false};
    glint_plan_make(&plan, &in, 0);
    snprintf(options, GLINT_COMMON_OPTIONS, "%s", plan.options);
    glint_job_destroy(&job);
    return VARIANTS;
}
