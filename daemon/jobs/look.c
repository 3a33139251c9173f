#include "jobs/look.h"

#include <stdlib.h>
#include <string.h>

// A camera's JSON is that of a job which says nothing else.
static char *job_text(const cJSON *camera)
{
    cJSON *job = cJSON_CreateObject();
    cJSON_AddStringToObject(job, "scene", "any");
    if (!cJSON_IsNull(camera))
        cJSON_AddItemToObject(job, "camera", cJSON_Duplicate(camera, true));
    char *text = cJSON_PrintUnformatted(job);
    cJSON_Delete(job);
    return text;
}

glint_status glint_look_parse(struct glint_look **out, const cJSON *camera, struct glint_error *err)
{
    *out = NULL;
    struct glint_look *look = calloc(1, sizeof *look);
    char *text = job_text(camera);
    if (look) {
        atomic_init(&look->references, 1);
        look->camera = cJSON_Duplicate(camera, true);
    }
    glint_status st = look && text && look->camera
                          ? glint_job_parse(&look->job, text, strlen(text), err)
                          : glint_fail(err, GLINT_E_NOMEM, "", "no memory for a camera");
    free(text);
    if (st)
        glint_look_release(&look);
    *out = look;
    return st;
}

struct glint_look *glint_look_retain(struct glint_look *look)
{
    // Relaxed: who retains holds a reference already, or the table's mutex.
    if (look)
        atomic_fetch_add_explicit(&look->references, 1, memory_order_relaxed);
    return look;
}

void glint_look_release(struct glint_look **look)
{
    struct glint_look *l = *look;
    *look = NULL;
    // Acquire and release: the last to leave sees what the others did before they left.
    if (!l || atomic_fetch_sub_explicit(&l->references, 1, memory_order_acq_rel) != 1)
        return;
    glint_job_destroy(&l->job);
    cJSON_Delete(l->camera);
    free(l);
}

struct glint_job glint_look_apply(const struct glint_look *look, const struct glint_job *job)
{
    struct glint_job out = *job;
    if (look) {
        out.has_camera = look->job->has_camera;
        out.camera = look->job->camera;
        out.camera_name = look->job->camera_name;
    }
    return out;
}
