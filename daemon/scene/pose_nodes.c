// pose_nodes.c - where the nodes of a scene are at each moment.
#include "scene/pose_work.h"

#include <assert.h>
#include <string.h>

static glint_status no_memory(struct glint_error *err)
{
    return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the pose of the scene's nodes");
}

static const struct glint_animation *animation_of(const struct glint_scene *scene,
                                                  const struct glint_pose_request *request)
{
    return request->animation < scene->animations ? &scene->animation[request->animation] : NULL;
}

static void set_moments(struct glint_pose_nodes *n, const struct glint_pose_request *request)
{
    const double length = request->close - request->open;
    n->shutter = n->animation && length > 0 ? GLINT_POSE_MOMENTS : 1;
    for (uint32_t i = 0; i < n->shutter; i++)
        n->moment[i].time = request->open + length * i / (GLINT_POSE_MOMENTS - 1);
    if (n->shutter > 1)
        n->moment[n->shutter - 1] = (struct glint_pose_moment){request->close, true};
    n->moments = n->shutter;
    if (n->animation && request->flow) {
        n->moment[n->moments++] = (struct glint_pose_moment){request->before, false};
        n->moment[n->moments++] = (struct glint_pose_moment){request->after, false};
    }
}

static bool set_paths(struct glint_pose_nodes *n, struct glint_arena *arena)
{
    if (!n->animation)
        return true;
    n->path = glint_arena_array(arena, n->scene->nodes, sizeof *n->path);
    if (!n->path)
        return false;
    for (uint32_t i = 0; i < n->animation->channels; i++) {
        const struct glint_animation_channel *c = &n->animation->channel[i];
        assert(c->node < n->scene->nodes && c->keys);
        n->path[c->node][c->path] = c;
    }
    return true;
}

// Parents first, without recursion: the way up from a node is laid down in reverse. `slot` serves as
// the mark of what has its place.
static void set_order(struct glint_pose_nodes *n)
{
    uint32_t placed = 0;
    memset(n->slot, 0, n->scene->nodes * sizeof *n->slot);
    for (uint32_t i = 0; i < n->scene->nodes; i++) {
        uint32_t depth = 0;
        for (uint32_t at = i; at != GLINT_NONE && !n->slot[at]; at = n->scene->node[at].parent) {
            n->slot[at] = 1;
            depth++;
        }
        placed += depth;
        for (uint32_t at = i, k = 1; k <= depth; k++, at = n->scene->node[at].parent)
            n->order[placed - k] = at;
    }
}

static bool own_motion(const struct glint_pose_nodes *n, uint32_t node)
{
    if (!n->path || n->scene->node[node].matrix)
        return false;
    const struct glint_animation_channel *const *path = n->path[node];
    return path[GLINT_PATH_TRANSLATION] || path[GLINT_PATH_ROTATION] || path[GLINT_PATH_SCALE];
}

static void set_slots(struct glint_pose_nodes *n)
{
    memset(n->slot, 0xff, n->scene->nodes * sizeof *n->slot);
    for (uint32_t k = 0; k < n->scene->nodes; k++) {
        const uint32_t node = n->order[k], parent = n->scene->node[node].parent;
        const bool carried = parent != GLINT_NONE && n->slot[parent] != GLINT_NONE;
        if (carried || own_motion(n, node))
            n->slot[node] = n->touched++;
    }
}

glint_status glint_pose_nodes_prepare(struct glint_pose_nodes *n, struct glint_arena *arena,
                                      const struct glint_scene *scene,
                                      const struct glint_pose_request *request,
                                      struct glint_error *err)
{
    n->scene = scene;
    n->animation = animation_of(scene, request);
    set_moments(n, request);
    n->order = glint_arena_array(arena, scene->nodes, sizeof *n->order);
    n->slot = glint_arena_array(arena, scene->nodes, sizeof *n->slot);
    if (!n->order || !n->slot || !set_paths(n, arena))
        return no_memory(err);
    set_order(n);
    set_slots(n);
    return GLINT_OK;
}

static bool local(const struct glint_pose_nodes *n, uint32_t node, struct glint_pose_moment at,
                  double out[16])
{
    const struct glint_node *from = &n->scene->node[node];
    if (from->matrix) {
        glint_matrix_widen(out, from->transform);
        return true;
    }
    const float *rest[3] = {from->translation, from->rotation, from->scale};
    double value[3][4];
    bool fine = true;
    for (int p = 0; p < 3; p++) {
        const struct glint_animation_channel *c = n->path ? n->path[node][p] : NULL;
        for (int i = 0; !c && i < (p == GLINT_PATH_ROTATION ? 4 : 3); i++)
            value[p][i] = rest[p][i];
        if (c)
            fine &= glint_pose_channel(c, at, rest[p], value[p]);
    }
    glint_matrix_compose(out, value[0], value[1], value[2]);
    return fine;
}

static void place(struct glint_pose_nodes *n, uint32_t node)
{
    const uint32_t parent = n->scene->node[node].parent, slot = n->slot[node];
    const uint32_t moments = slot == GLINT_NONE ? 1 : n->moments;
    bool fine = true;
    for (uint32_t m = 0; m < moments; m++) {
        double *out =
            slot == GLINT_NONE ? n->still[node] : n->moving[(size_t)slot * n->moments + m];
        double own[16];
        fine &= local(n, node, n->moment[m], own);
        if (parent == GLINT_NONE)
            memcpy(out, own, sizeof own);
        else
            glint_matrix_multiply(out, glint_pose_world(n, parent, m), own);
    }
    n->vanished += !fine;
}

double glint_pose_nodes_bytes(const struct glint_pose_nodes *n)
{
    return sizeof(glint_pose_matrix) * (n->scene->nodes + (double)n->touched * n->moments);
}

glint_status glint_pose_nodes_place(struct glint_pose_nodes *n, struct glint_arena *arena,
                                    struct glint_error *err)
{
    n->still = glint_arena_array(arena, n->scene->nodes, sizeof *n->still);
    n->moving = glint_arena_array(arena, (size_t)n->touched * n->moments, sizeof *n->moving);
    if (!n->still || !n->moving)
        return no_memory(err);
    for (uint32_t k = 0; k < n->scene->nodes; k++)
        place(n, n->order[k]);
    return GLINT_OK;
}

const double *glint_pose_world(const struct glint_pose_nodes *n, uint32_t node, uint32_t moment)
{
    const uint32_t slot = n->slot[node];
    return slot == GLINT_NONE ? n->still[node] : n->moving[(size_t)slot * n->moments + moment];
}

bool glint_pose_touches(const struct glint_pose_nodes *n, uint32_t node)
{
    return node != GLINT_NONE && n->slot[node] != GLINT_NONE;
}
