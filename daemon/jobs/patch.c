#include "jobs/patch.h"

#include "protocol/json.h"

// True when the patch names the member: with a value, or with null for the default that *out holds.
static bool named(const struct glint_json *at, bool (*read)(const struct glint_json *, void *),
                  void *out)
{
    if (!at->value)
        return false;
    return cJSON_IsNull(at->value) || read(at, out);
}

static bool read_priority(const struct glint_json *at, void *out)
{
    return glint_json_int(at, -100, 100, out);
}

static bool read_paused(const struct glint_json *at, void *out)
{
    return glint_json_bool(at, out);
}

static bool read_seconds(const struct glint_json *at, void *out)
{
    return glint_json_double(at, 1e-3, 1e9, out);
}

static void read_stop(const struct glint_json *stop, struct glint_job_patch *out)
{
    static const char *const known[] = {"samples", "seconds", "error", NULL};
    glint_json_only(stop, known);
    for (int i = 0; i < 3; i += 2) {
        const struct glint_json at = glint_json_member(stop, known[i]);
        if (at.value)
            glint_json_fault(&at, "\"%s\" is settled when a job is submitted", known[i]);
    }
    const struct glint_json seconds = glint_json_member(stop, "seconds");
    out->has_seconds = named(&seconds, read_seconds, &out->seconds);
}

glint_status glint_job_patch_parse(struct glint_job_patch *out, const char *text, size_t length,
                                   struct glint_error *err)
{
    static const char *const known[] = {"priority", "paused", "stop", "camera", NULL};
    *out = (struct glint_job_patch){0};
    struct glint_error faults = {0};
    cJSON *value;
    glint_status st = glint_json_parse(&value, text, length, &glint_json_request, err);
    if (st)
        return st;
    const struct glint_json root = glint_json_root(value, err ? err : &faults);
    glint_json_only(&root, known);
    const struct glint_json priority = glint_json_member(&root, "priority");
    const struct glint_json paused = glint_json_member(&root, "paused");
    const struct glint_json stop = glint_json_member(&root, "stop");
    out->has_priority = named(&priority, read_priority, &out->priority);
    out->has_paused = named(&paused, read_paused, &out->paused);
    read_stop(&stop, out);
    const struct glint_json camera = glint_json_member(&root, "camera");
    if (camera.value)
        glint_look_parse(&out->look, camera.value, root.err);
    st = root.err->status;
    cJSON_Delete(value);
    glint_error_finish(&faults);
    if (st)
        glint_job_patch_finish(out);
    return st;
}

void glint_job_patch_finish(struct glint_job_patch *patch)
{
    glint_look_release(&patch->look);
}
