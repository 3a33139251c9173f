// view.c - what a render shows: made for its job and a scene, held by those who read its pixels.
#include "render/internal.h"

#include "kernels/gk_matte.h"

#include <stdlib.h>
#include <string.h>

static glint_status choose_camera(struct glint_view *v, struct glint_error *err)
{
    const struct glint_scene *s = glint_resident_scene(v->scene);
    if (v->job.has_camera) {
        v->camera = v->job.camera;
        v->camera_index = GLINT_NONE;
        return GLINT_OK;
    }
    for (uint32_t i = 0; i < s->cameras; i++)
        if (!v->job.camera_name || strcmp(s->camera[i].name, v->job.camera_name) == 0 ||
            strcmp(s->camera[i].id, v->job.camera_name) == 0) {
            v->camera = s->camera[i];
            v->camera_index = i;
            return GLINT_OK;
        }
    return glint_fail(err, GLINT_E_RANGE, "/camera", "the scene has no camera \"%s\"",
                      v->job.camera_name ? v->job.camera_name : "");
}

_Static_assert((int)GLINT_EVICTION_EXACT == GK_MATTE_EXACT &&
                   (int)GLINT_EVICTION_DROP == GK_MATTE_DROP &&
                   (int)GLINT_EVICTION_DIRECT_FIRST == GK_MATTE_DIRECT_FIRST &&
                   (int)GLINT_EVICTION_USS == GK_MATTE_USS &&
                   (int)GLINT_EVICTION_USS_DIRECT_FIRST == GK_MATTE_USS_DIRECT_FIRST &&
                   (int)GLINT_EVICTION_SPILL == GK_MATTE_SPILL,
               "settings of the dial are the kernels' policies");

static void fill_wave_job(struct glint_view *v)
{
    static const uint32_t parts_log2[] = {
        [GLINT_ESTIMATE_HALVES] = 1, [GLINT_ESTIMATE_BATCHES] = 4, [GLINT_ESTIMATE_NONE] = 0};
    v->wave_job.plan = &v->plan;
    v->wave_job.program = v->program;
    v->wave_job.scene = v->scene;
    v->wave_job.interrupted = &v->render->interrupted;
    v->wave_job.frame = v->frame;
    v->wave_job.matte_slots = glint_film_info_slots(&v->info);
    v->wave_job.matte_policy = v->job.dial[GLINT_DIAL_EVICTION];
    v->wave_job.matte_through = glint_plan_has(&v->plan, GLINT_PASS_COVERAGE) &&
                                v->job.dial[GLINT_DIAL_THROUGH] != GLINT_THROUGH_NONE;
    v->wave_job.watertight = v->job.dial[GLINT_DIAL_TRAVERSAL] == GLINT_TRAVERSAL_WATERTIGHT;
    v->wave_job.matte_shared = v->plan.on & glint_effect_bit(GLINT_EFFECT_SHARED_TABLES);
    v->wave_job.matte_rows = v->wave_job.matte_through ? glint_matte_rows(&v->job) : 0;
    v->wave_job.seed = v->job.seed;
    v->wave_job.parts_log2 = parts_log2[v->job.estimate];
}

static void fill_info(struct glint_view *v)
{
    struct glint_film_info *info = &v->info;
    info->job = &v->job;
    info->aovs = glint_plan_has(&v->plan, GLINT_PASS_AOVS);
    info->flow = v->plan.on & glint_effect_bit("motion vectors");
    info->batches = glint_plan_has(&v->plan, GLINT_PASS_BATCHES);
    info->coverage = glint_plan_has(&v->plan, GLINT_PASS_COVERAGE);
    info->software = "glint " PACKAGE_VERSION;
    info->revision = glint_resident_revision(v->scene);
    info->mattes = glint_resident_mattes(v->scene, &info->matte);
    glint_render_matrices(v, info->to_camera, info->to_ndc);
}

static glint_status find_geometry(struct glint_view *v, bool sketch, struct glint_error *err)
{
    bool robust;
    const enum glint_geometry_kind kind = glint_render_structure(&v->job, &robust);
    if (!sketch)
        return glint_resident_geometry(v->scene, kind, robust, &v->wave_job.geometry, err);
    const glint_status st = glint_resident_sketch(v->scene, robust, &v->sketch, err);
    v->wave_job.geometry = v->sketch;
    return st;
}

static glint_status prepare(struct glint_view *v, const struct glint_view_order *order,
                            struct glint_error *err)
{
    glint_devices *devices = v->render->devices;
    const struct glint_view *like = order->like;
    const struct glint_effect_input in = {glint_resident_facts(v->scene), &v->job, &v->camera,
                                          glint_render_camera_moves(v)};
    glint_plan_make(&v->plan, &in, order->force);
    fill_info(v);
    glint_status st = glint_matte_check(&v->job, v->info.mattes, "/mattes/eviction", err);
    if (!st)
        st = glint_program_get(&v->program, devices, v->plan.options, err);
    if (!st)
        st = find_geometry(v, order->sketch, err);
    if (!st)
        st = glint_buffer_create(&v->frame, devices, sizeof(struct gk_frame), err);
    if (st)
        return st;
    struct gk_frame *frame = glint_buffer_host(v->frame);
    glint_render_constants(v, frame);
    st = glint_render_inside(v, frame, err);
    if (st)
        return st;
    fill_wave_job(v);
    return like && like->program == v->program ? GLINT_OK
                                               : glint_wave_compile(devices, &v->wave_job, err);
}

glint_status glint_view_create(struct glint_view **out, glint_render *render,
                               const struct glint_view_order *order, struct glint_error *err)
{
    *out = NULL;
    struct glint_view *v = calloc(1, sizeof *v);
    if (!v)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a view");
    atomic_init(&v->references, 1);
    v->render = render;
    v->scene = glint_resident_retain(order->scene);
    v->pose = order->pose;
    glint_status st = glint_job_copy(&v->job, order->job, err);
    if (!st)
        st = choose_camera(v, err);
    if (!st)
        st = prepare(v, order, err);
    if (st)
        glint_view_release(&v);
    *out = v;
    return st;
}

struct glint_view *glint_view_hold(glint_render *r)
{
    pthread_mutex_lock(&r->mutex);
    struct glint_view *view = r->view;
    // Relaxed: the render's own reference cannot go before the mutex does.
    atomic_fetch_add_explicit(&view->references, 1, memory_order_relaxed);
    pthread_mutex_unlock(&r->mutex);
    return view;
}

void glint_view_release(struct glint_view **view)
{
    struct glint_view *v = *view;
    *view = NULL;
    // Acquire and release: the last to leave sees what the others did before they left.
    if (!v || atomic_fetch_sub_explicit(&v->references, 1, memory_order_acq_rel) != 1)
        return;
    glint_buffer_destroy(&v->frame);
    glint_program_release(&v->program);
    glint_geometry_destroy(&v->sketch);
    glint_resident_release(&v->scene);
    glint_arena_finish(&v->job.arena);
    free(v);
}
