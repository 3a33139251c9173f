#include "jobs/need.h"

#include "render/render.h"

// A triangle in a structure of high quality, measured on scenes of 0.1 to 1 million: 100 to 150.
#define STRUCTURE_BYTES 160

static uint64_t structure_bytes(const struct glint_resident_stats *s)
{
    return s->instanced_triangles * STRUCTURE_BYTES;
}

static bool has_structure(const struct glint_resident *scene, const struct glint_job *job)
{
    bool robust;
    const enum glint_geometry_kind kind = glint_render_structure(job, &robust);
    return glint_resident_has_geometry(scene, kind, robust);
}

void glint_need_estimate(struct glint_need *out, const struct glint_resident *scene,
                         const struct glint_pose_request *request, const struct glint_job *job,
                         uint32_t workers)
{
    struct glint_resident_stats s;
    glint_resident_stats(scene, &s);
    out->film = glint_render_film_bytes(scene, job) + glint_render_wave_bytes(scene, job, workers);
    if (glint_pose_wanted(glint_resident_scene(scene), request))
        out->scene = s.geometry_bytes + s.record_bytes + structure_bytes(&s);
    else // what is built already is the scene's
        out->scene = has_structure(scene, job) ? 0 : structure_bytes(&s);
}
