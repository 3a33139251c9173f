// posed.h - a resident scene as a job wants it: at rest, or as it is during a job's frame.
//
// Threads: any loader.
#ifndef GLINT_SCENE_POSED_H
#define GLINT_SCENE_POSED_H

#include "protocol/job.h"
#include "scene/pose.h"
#include "scene/resident.h"

struct glint_posed {
    glint_resident *resident;      // the owner's reference
    const struct glint_pose *pose; // lives as long as `resident`; NULL: as the scene has it
};

// The moments that a job asks for: its frame and shutter, of its animation.
//   GLINT_E_RANGE  there is no such animation, at /animation; names those that exist
glint_status glint_posed_request(struct glint_pose_request *out, const struct glint_scene *scene,
                                 const struct glint_job *job, struct glint_error *err);

// As glint_resident_create() for the scene at rest, with its pose where it needs one.
glint_status glint_posed_create(struct glint_posed *out, glint_devices *devices,
                                const struct glint_resident_order *order, struct glint_error *err);

// The scene of `rest` in another pose. `gone(user)`, which may be NULL, is called when the last
// reference goes.
glint_status glint_posed_move(struct glint_posed *out, glint_devices *devices,
                              const struct glint_posed *rest,
                              const struct glint_pose_request *request, void (*gone)(void *user),
                              void *user, struct glint_error *err);

// What `job` renders of a scene at rest: itself, retained, or the scene in its pose.
glint_status glint_posed_for(struct glint_posed *out, glint_devices *devices,
                             const struct glint_posed *rest, const struct glint_job *job,
                             struct glint_error *err);

#endif
