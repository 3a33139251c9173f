// pose.c - puts a pose together: nodes, then what they carry, then its vertices.
#include "scene/pose.h"

#include "base/memory.h"
#include "scene/pose_work.h"

#include <assert.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

static glint_status no_memory(struct glint_error *err)
{
    return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a pose of the scene");
}

static glint_status make_lists(struct glint_pose *p, const struct glint_scene *scene,
                               struct glint_error *err)
{
    p->instances = scene->instances;
    p->lights = scene->lights;
    p->cameras = scene->cameras;
    p->instance = glint_arena_array(&p->arena, p->instances, sizeof *p->instance);
    p->light = glint_arena_array(&p->arena, p->lights, sizeof *p->light);
    p->camera = glint_arena_array(&p->arena, p->cameras, sizeof *p->camera);
    return p->instance && p->light && p->camera ? GLINT_OK : no_memory(err);
}

static double bytes_with(const struct glint_pose_work *w, uint32_t keys)
{
    double bytes = w->still_bytes + w->key_bytes * keys;
    for (uint32_t i = 0; i < w->shapes; i++)
        bytes += glint_pose_shape_bytes(&w->shape[i], w->scene, keys);
    return bytes;
}

static uint32_t fewer(uint32_t keys)
{
    return keys / 2 + (keys > 3); // 9, 5, 3, 1
}

static uint64_t bytes_allowed(const struct glint_pose_work *w)
{
    const uint64_t asked = w->pose->request.max_bytes;
    return asked ? asked : glint_memory_total() / 2;
}

static glint_status check_bytes(const struct glint_pose_work *w, double bytes,
                                struct glint_error *err)
{
    if (bytes <= (double)bytes_allowed(w))
        return GLINT_OK;
    return glint_fail(err, GLINT_E_CAPACITY, "",
                      "a pose of the scene takes %.0f bytes, more than the %" PRIu64 " that it may",
                      bytes, bytes_allowed(w));
}

// As many keys as are needed, if there is room for them.
static glint_status settle_keys(struct glint_pose_work *w, struct glint_error *err)
{
    uint32_t keys = w->keys;
    while (keys > 1 && bytes_with(w, keys) > (double)bytes_allowed(w))
        keys = fewer(keys);
    w->pose->keys = keys;
    return check_bytes(w, bytes_with(w, keys), err);
}

static glint_status evaluate(struct glint_pose_work *w, struct glint_error *err)
{
    struct glint_pose *p = w->pose;
    glint_status st = make_lists(p, w->scene, err);
    if (!st)
        st = glint_pose_nodes_prepare(&w->nodes, &w->scratch, w->scene, &p->request, err);
    if (!st)
        st = check_bytes(w, glint_pose_nodes_bytes(&w->nodes), err);
    if (!st)
        st = glint_pose_nodes_place(&w->nodes, &w->scratch, err);
    if (!st)
        st = glint_pose_instances_measure(w, err);
    if (st)
        return st;
    glint_pose_placements_measure(w);
    st = settle_keys(w, err);
    if (!st)
        st = glint_pose_instances_fill(w, err);
    if (!st)
        st = glint_pose_placements_fill(w, err);
    p->collapsed += w->nodes.vanished;
    p->bytes = p->arena.bytes;
    return st;
}

glint_status glint_pose_create(struct glint_pose **out, const struct glint_scene *scene,
                               const struct glint_pose_request *request, struct glint_error *err)
{
    assert(out && scene && request && request->open <= request->close);
    *out = NULL;
    struct glint_pose *p = calloc(1, sizeof *p);
    if (!p)
        return no_memory(err);
    atomic_init(&p->references, 1);
    p->request = *request;
    struct glint_pose_work w = {.scene = scene, .pose = p, .keys = 1};
    const glint_status st = evaluate(&w, err);
    glint_arena_finish(&w.scratch);
    if (st)
        glint_pose_release(&p);
    *out = p;
    return st;
}

struct glint_pose *glint_pose_retain(const struct glint_pose *pose)
{
    struct glint_pose *p = (struct glint_pose *)pose;
    if (p)
        atomic_fetch_add_explicit(&p->references, 1, memory_order_relaxed);
    return p;
}

// Release orders this owner's reads before the free, acquire the free after those of the others.
void glint_pose_release(struct glint_pose **pose)
{
    struct glint_pose *p = *pose;
    *pose = NULL;
    if (!p || atomic_fetch_sub_explicit(&p->references, 1, memory_order_acq_rel) != 1)
        return;
    glint_arena_finish(&p->arena);
    free(p);
}

struct glint_pose_request glint_pose_rest(void)
{
    return (struct glint_pose_request){.animation = GLINT_NONE};
}

static void at_key(const double *transform, bool moves, const float *own, uint32_t key,
                   double out[16])
{
    if (transform)
        memcpy(out, transform + (moves ? (size_t)16 * key : 0), sizeof(double[16]));
    else
        glint_matrix_widen(out, own);
}

void glint_pose_instance_at(const struct glint_pose *pose, const struct glint_scene *scene,
                            uint32_t instance, uint32_t key, double out[16])
{
    const struct glint_pose_instance *p = pose ? &pose->instance[instance] : NULL;
    at_key(p ? p->transform : NULL, p && p->moves, scene->instance[instance].transform, key, out);
}

void glint_pose_light_at(const struct glint_pose *pose, const struct glint_scene *scene,
                         uint32_t light, uint32_t key, double out[16])
{
    const struct glint_pose_placement *p = pose ? &pose->light[light] : NULL;
    at_key(p ? p->transform : NULL, p && p->moves, scene->light[light].transform, key, out);
}

void glint_pose_camera_at(const struct glint_pose *pose, const struct glint_scene *scene,
                          uint32_t camera, uint32_t key, double out[16])
{
    const struct glint_pose_placement *p = pose ? &pose->camera[camera] : NULL;
    at_key(p ? p->transform : NULL, p && p->moves, scene->camera[camera].transform, key, out);
}
