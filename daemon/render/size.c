// size.c - what a job will need, before anything is compiled or allocated.
#include "kernels/gk_film.h"
#include "kernels/gk_matte.h"
#include "kernels/gk_wave.h"
#include "protocol/matte_types.h"
#include "render/plan.h"
#include "render/render.h"
#include "render/wave.h"

#include <string.h>

static const struct glint_camera *camera_of(const struct glint_scene *scene,
                                            const struct glint_job *job)
{
    if (job->has_camera)
        return &job->camera;
    for (uint32_t i = 0; job->camera_name && i < scene->cameras; i++)
        if (!strcmp(scene->camera[i].name, job->camera_name) ||
            !strcmp(scene->camera[i].id, job->camera_name))
            return &scene->camera[i];
    return &scene->camera[0];
}

enum glint_geometry_kind glint_render_structure(const struct glint_job *job, bool *robust)
{
    *robust = job->dial[GLINT_DIAL_TRAVERSAL] != GLINT_TRAVERSAL_FAST;
    return job->live ? GLINT_GEOMETRY_PLACED : GLINT_GEOMETRY_FLAT;
}

static uint64_t padded(uint32_t pixels)
{
    return ((uint64_t)pixels + GK_TILE_SIDE - 1) / GK_TILE_SIDE * GK_TILE_SIDE;
}

// Those of the tables that are copied while paths are on their way, and of what paths have met.
static uint64_t table_bytes(const struct glint_resident *scene, const struct glint_job *job)
{
    const uint32_t slots = glint_matte_slots(job, glint_resident_facts(scene)->mattes);
    const bool carried = job->outputs & GLINT_OUT_CRYPTO && glint_matte_classes(job) > 0;
    return carried
               ? GLINT_WAVE_LANES * (8ull * gk_matte_words(slots, job->dial[GLINT_DIAL_EVICTION]) +
                                     4ull * glint_matte_rows(job))
               : 0;
}

uint64_t glint_render_wave_bytes(const struct glint_resident *scene, const struct glint_job *job,
                                 uint32_t workers)
{
    const uint64_t columns = GLINT_WAVE_LANES * (GK_COLUMNS + 1) * 4;
    return workers * (columns + table_bytes(scene, job));
}

uint64_t glint_render_film_bytes(const struct glint_resident *scene, const struct glint_job *job)
{
    const struct glint_effect_input in = {glint_resident_facts(scene), job,
                                          camera_of(glint_resident_scene(scene), job), false};
    struct glint_plan plan;
    glint_plan_make(&plan, &in, 0);
    return padded(job->region[2]) * padded(job->region[3]) * plan.film_bytes;
}
