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

static bool read_samples(const struct glint_json *at, void *out)
{
    return glint_json_uint(at, 1, GLINT_MAX_SAMPLES, out);
}

static bool read_seconds(const struct glint_json *at, void *out)
{
    return glint_json_double(at, 1e-3, 1e9, out);
}

static bool read_error(const struct glint_json *at, void *out)
{
    return glint_json_double(at, 1e-9, 1e9, out);
}

static void read_stop(const struct glint_json *stop, struct glint_job_patch *out)
{
    static const char *const known[] = {"samples", "seconds", "error", NULL};
    out->stop = (struct glint_job_stop){.samples = GLINT_MAX_SAMPLES};
    if (stop->value && cJSON_IsNull(stop->value)) {
        out->stop.samples = GLINT_DEFAULT_SAMPLES;
        out->has_samples = out->has_seconds = out->has_error = true;
        return;
    }
    glint_json_only(stop, known);
    const struct glint_json samples = glint_json_member(stop, "samples");
    const struct glint_json seconds = glint_json_member(stop, "seconds");
    const struct glint_json error = glint_json_member(stop, "error");
    out->has_samples = named(&samples, read_samples, &out->stop.samples);
    out->has_seconds = named(&seconds, read_seconds, &out->stop.seconds);
    out->has_error = named(&error, read_error, &out->stop.error);
}

bool glint_job_patch_stops(const struct glint_job_patch *patch)
{
    return patch->has_samples || patch->has_seconds || patch->has_error;
}

struct glint_job_stop glint_job_patch_stop(const struct glint_job_patch *patch,
                                           const struct glint_job_stop *stop)
{
    struct glint_job_stop out = *stop;
    if (patch->has_samples)
        out.samples = patch->stop.samples;
    if (patch->has_seconds)
        out.seconds = patch->stop.seconds;
    if (patch->has_error)
        out.error = patch->stop.error;
    return out;
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
