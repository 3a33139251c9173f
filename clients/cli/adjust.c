#include "adjust.h"
#include "output.h"
#include "uri.h"

#include <stdlib.h>
#include <string.h>

static const char *const options[] = {"priority", "pause", "resume", "samples",
                                      "seconds",  "error", "camera", NULL};

bool glint_adjust_is_meant(const struct glint_arguments *a)
{
    for (int i = 0; options[i]; i++)
        if (glint_options_flag(a, options[i]))
            return true;
    return false;
}

static glint_status add_number(struct glint_session *s, const struct glint_arguments *a,
                               const char *name, bool whole, cJSON *to, struct glint_error *err)
{
    const char *text = glint_options_text(a, name);
    double value;
    if (!text)
        return GLINT_OK;
    if (!glint_read_number(text, &value) || (whole && value != (double)(long long)value))
        return glint_session_usage(s, err, "--%s wants a %snumber, not '%s'", name,
                                   whole ? "whole " : "", text);
    cJSON_AddNumberToObject(to, name, value);
    return GLINT_OK;
}

static glint_status add_pause(struct glint_session *s, const struct glint_arguments *a, cJSON *to,
                              struct glint_error *err)
{
    const bool pause = glint_options_flag(a, "pause"), resume = glint_options_flag(a, "resume");
    if (pause && resume)
        return glint_session_usage(s, err, "--pause and --resume at once");
    if (pause || resume)
        cJSON_AddBoolToObject(to, "paused", pause);
    return GLINT_OK;
}

static glint_status add_stop(struct glint_session *s, const struct glint_arguments *a, cJSON *to,
                             struct glint_error *err)
{
    static const char *const name[] = {"samples", "seconds", "error"};
    cJSON *stop = cJSON_CreateObject();
    glint_status status = GLINT_OK;
    for (int i = 0; i < 3; i++) {
        const glint_status st = add_number(s, a, name[i], i == 0, stop, err);
        status = status ? status : st;
    }
    if (cJSON_GetArraySize(stop))
        cJSON_AddItemToObject(to, "stop", stop);
    else
        cJSON_Delete(stop);
    return status;
}

// A name, or a .json file with a camera.
static glint_status add_camera(struct glint_session *s, const struct glint_arguments *a, cJSON *to,
                               struct glint_error *err)
{
    const char *given = glint_options_text(a, "camera");
    struct glint_blob text;
    if (!given)
        return GLINT_OK;
    if (!glint_output_is(given, "json")) {
        cJSON_AddStringToObject(to, "camera", given);
        return GLINT_OK;
    }
    const glint_status status = glint_uri_read_file(given, &text, "", err);
    if (status)
        return status;
    cJSON *camera = cJSON_ParseWithLength((const char *)text.bytes, text.size);
    free(text.bytes);
    if (!cJSON_IsObject(camera)) {
        cJSON_Delete(camera);
        return glint_session_usage(s, err, "%s: no JSON object", given);
    }
    cJSON_AddItemToObject(to, "camera", camera);
    return GLINT_OK;
}

glint_status glint_adjust_read(struct glint_session *s, const struct glint_arguments *a,
                               cJSON **patch, struct glint_error *err)
{
    *patch = cJSON_CreateObject();
    const glint_status part[] = {add_number(s, a, "priority", true, *patch, err),
                                 add_pause(s, a, *patch, err), add_stop(s, a, *patch, err),
                                 add_camera(s, a, *patch, err)};
    for (size_t i = 0; i < sizeof part / sizeof *part; i++)
        if (part[i])
            return part[i];
    return cJSON_GetArraySize(*patch)
               ? GLINT_OK
               : glint_session_usage(s, err,
                                     "a scene wants a PATCH, a job wants what to change: "
                                     "--priority, --pause, --resume, --samples, --seconds, "
                                     "--error or --camera");
}
