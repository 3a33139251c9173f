// pose_wanted.c - which animation, and whether it shows.
#include "scene/pose_work.h"

#include <string.h>

static bool weighs(const float *weight, uint32_t targets)
{
    for (uint32_t t = 0; weight && t < targets; t++)
        if (weight[t] != 0)
            return true;
    return false;
}

bool glint_pose_needed(const struct glint_scene *scene)
{
    for (uint32_t i = 0; i < scene->instances; i++) {
        const struct glint_instance *in = &scene->instance[i];
        const struct glint_mesh *mesh = &scene->mesh[in->mesh];
        if (in->node != GLINT_NONE || in->skin != GLINT_NONE ||
            weighs(in->weight ? in->weight : mesh->target_weight, mesh->targets))
            return true;
    }
    for (uint32_t i = 0; i < scene->lights; i++)
        if (scene->light[i].node != GLINT_NONE)
            return true;
    for (uint32_t i = 0; i < scene->cameras; i++)
        if (scene->camera[i].node != GLINT_NONE)
            return true;
    return false;
}

static bool skin_touched(const struct glint_pose_nodes *n, const struct glint_skin *skin)
{
    for (uint32_t j = 0; j < skin->joints; j++)
        if (glint_pose_touches(n, skin->joint[j]))
            return true;
    return false;
}

static bool instance_touched(const struct glint_pose_nodes *n, const struct glint_instance *in)
{
    const struct glint_mesh *mesh = &n->scene->mesh[in->mesh];
    if (!in->visible)
        return false;
    if (mesh->targets && in->node != GLINT_NONE && n->path[in->node][GLINT_PATH_WEIGHTS])
        return true;
    if (in->skin != GLINT_NONE && mesh->joint)
        return skin_touched(n, &n->scene->skin[in->skin]);
    return glint_pose_touches(n, in->node);
}

static bool anything_touched(const struct glint_pose_nodes *n)
{
    const struct glint_scene *scene = n->scene;
    for (uint32_t i = 0; i < scene->instances; i++)
        if (instance_touched(n, &scene->instance[i]))
            return true;
    for (uint32_t i = 0; i < scene->lights; i++)
        if (glint_pose_touches(n, scene->light[i].node))
            return true;
    for (uint32_t i = 0; i < scene->cameras; i++)
        if (glint_pose_touches(n, scene->camera[i].node))
            return true;
    return false;
}

// Without memory to find out: true, and who acts on it meets the lack of it.
bool glint_pose_wanted(const struct glint_scene *scene, const struct glint_pose_request *request)
{
    if (request->animation >= scene->animations)
        return false;
    struct glint_arena scratch = {0};
    struct glint_pose_nodes nodes = {0};
    const bool wanted = glint_pose_nodes_prepare(&nodes, &scratch, scene, request, NULL) ||
                        anything_touched(&nodes);
    glint_arena_finish(&scratch);
    return wanted;
}

bool glint_pose_animation(const struct glint_scene *scene, const char *name, uint32_t *out)
{
    *out = GLINT_NONE;
    if (!name) {
        *out = scene->animations ? 0 : GLINT_NONE;
        return true;
    }
    if (!*name || strcmp(name, "none") == 0)
        return true;
    for (uint32_t i = 0; i < scene->animations; i++)
        if (strcmp(scene->animation[i].id, name) == 0) {
            *out = i;
            return true;
        }
    for (uint32_t i = 0; i < scene->animations; i++)
        if (scene->animation[i].name && strcmp(scene->animation[i].name, name) == 0) {
            *out = i;
            return true;
        }
    return false;
}
