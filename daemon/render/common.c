#include "render/common.h"

#include "protocol/job.h"
#include "render/plan.h"

#include <stdio.h>
#include <string.h>

// Surfaces as glTF files have them; lit by a lamp, by the sky, by a picture of it.
#define SURFACES .microfacet = true, .rough = true, .culling = true, .texture_pools = 1

static const struct glint_scene_facts common[] = {
    {SURFACES, .emission = true, .light_table = true},
    {SURFACES, .textures = true, .emission = true, .light_table = true},
    {SURFACES, .textures = true, .normal_maps = true, .light_table = true},
    {SURFACES, .textures = true, .normal_maps = true, .environment_image = true},
};
#define VARIANTS (sizeof common / sizeof *common)

// A job of which nothing is said but its scene.
size_t glint_common_variant(size_t index, char options[GLINT_COMMON_OPTIONS])
{
    static const char text[] = "{\"scene\":\"s\"}";
    struct glint_job *job;
    struct glint_plan plan;
    const struct glint_camera camera = {0};
    options[0] = 0;
    if (index >= VARIANTS || glint_job_parse(&job, text, sizeof text - 1, NULL))
        return VARIANTS;
    const struct glint_effect_input in = {&common[index], job, &camera, false};
    glint_plan_make(&plan, &in, 0);
    snprintf(options, GLINT_COMMON_OPTIONS, "%s", plan.options);
    glint_job_destroy(&job);
    return VARIANTS;
}
