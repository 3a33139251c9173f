#include "scene/posed.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// What a resident scene holds beside what it is made of.
struct held {
    struct glint_pose *pose;
    void (*gone)(void *user);
    void *user;
};

static void let_go(void *held)
{
    struct held *h = held;
    glint_pose_release(&h->pose);
    if (h->gone)
        h->gone(h->user);
    free(h);
}

static glint_status no_animation(const struct glint_scene *scene, const char *name,
                                 struct glint_error *err)
{
    char names[400] = "";
    for (uint32_t i = 0; i < scene->animations; i++) {
        const size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s\"%.60s\"", i ? ", " : "",
                 scene->animation[i].id);
    }
    return glint_fail(err, GLINT_E_RANGE, "/animation",
                      "the scene has no animation \"%.140s\"; it has %s%s", name,
                      *names ? names : "none", strlen(names) + 1 == sizeof names ? " ..." : "");
}

glint_status glint_posed_request(struct glint_pose_request *out, const struct glint_scene *scene,
                                 const struct glint_job *job, struct glint_error *err)
{
    const double fps = job->fps > 0 ? job->fps : scene->fps;
    const double open = job->frame + (double)job->shutter[0];
    const double close = job->frame + (double)job->shutter[1];
    // A frame from the middle of the shutter: the mean over the moments that samples see is a frame.
    const double middle = 0.5 * (open + close);
    *out = (struct glint_pose_request){.open = open / fps,
                                       .close = close / fps,
                                       .before = (middle - 1) / fps,
                                       .after = (middle + 1) / fps,
                                       .flow = job->outputs & GLINT_OUT_MOTION};
    if (glint_pose_animation(scene, job->animation, &out->animation))
        return GLINT_OK;
    return no_animation(scene, job->animation, err);
}

// Makes a resident scene in `pose`, which it takes always; NULL: as the scene has it.
static glint_status build(struct glint_posed *out, glint_devices *devices,
                          struct glint_resident_order order, struct glint_pose *pose,
                          struct glint_error *err)
{
    struct held *held = malloc(sizeof *held);
    *out = (struct glint_posed){0};
    if (!held) {
        glint_pose_release(&pose);
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a scene");
    }
    *held = (struct held){pose, order.free_assets, order.assets};
    order.pose = pose;
    order.free_assets = let_go;
    order.assets = held;
    const glint_status st = glint_resident_create(&out->resident, devices, &order, err);
    if (st) {
        glint_pose_release(&pose);
        free(held);
        return st;
    }
    out->pose = pose;
    return GLINT_OK;
}

glint_status glint_posed_create(struct glint_posed *out, glint_devices *devices,
                                const struct glint_resident_order *order, struct glint_error *err)
{
    struct glint_pose *pose = NULL;
    const struct glint_pose_request rest = glint_pose_rest();
    if (glint_pose_needed(order->scene)) {
        const glint_status st = glint_pose_create(&pose, order->scene, &rest, err);
        if (st)
            return st;
    }
    return build(out, devices, *order, pose, err);
}

glint_status glint_posed_move(struct glint_posed *out, glint_devices *devices,
                              const struct glint_posed *rest,
                              const struct glint_pose_request *request, void (*gone)(void *user),
                              void *user, struct glint_error *err)
{
    struct glint_scene *scene = (struct glint_scene *)glint_resident_scene(rest->resident);
    const struct glint_resident_order order = {
        .scene = scene, .free_assets = gone, .assets = user, .from = rest->resident};
    struct glint_pose *pose = NULL;
    *out = (struct glint_posed){0};
    glint_status st = glint_pose_create(&pose, scene, request, err);
    if (!st)
        st = build(out, devices, order, pose, err);
    if (!st)
        glint_resident_set_revision(out->resident, glint_resident_revision(rest->resident));
    return st;
}

glint_status glint_posed_for(struct glint_posed *out, glint_devices *devices,
                             const struct glint_posed *rest, const struct glint_job *job,
                             struct glint_error *err)
{
    const struct glint_scene *scene = glint_resident_scene(rest->resident);
    struct glint_pose_request request;
    *out = (struct glint_posed){0};
    glint_status st = glint_posed_request(&request, scene, job, err);
    if (!st && glint_pose_wanted(scene, &request))
        return glint_posed_move(out, devices, rest, &request, NULL, NULL, err);
    if (!st)
        *out = (struct glint_posed){glint_resident_retain(rest->resident), rest->pose};
    return st;
}
