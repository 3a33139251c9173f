// cmd_get.c - get: a job's frame, or its film.
#include "command.h"
#include "download.h"
#include "output.h"

#include <stdlib.h>

static glint_status check(struct glint_session *s, const struct glint_arguments *a,
                          struct glint_error *err)
{
    const char *file = glint_options_text(a, "output"),
               *kind = file ? glint_download_kind(file) : NULL;
    if (!file)
        return glint_session_usage(s, err, "get wants -o FILE");
    if (!kind && !glint_output_is(file, "film"))
        return glint_session_usage(s, err, "%s: frames are .exr or .png, films .film", file);
    const char *exposure = glint_options_text(a, "exposure");
    double stops;
    if (exposure && !glint_read_number(exposure, &stops))
        return glint_session_usage(s, err, "--exposure wants a number of stops, not '%s'",
                                   exposure);
    return GLINT_OK;
}

static glint_status download_film(struct glint_session *s, const char *job, bool wait,
                                  const char *file, uint64_t *size, struct glint_error *err)
{
    char *path = glint_client_path("/v1/jobs/", job, "/film");
    path = glint_client_query(path, "wait", wait ? "done" : NULL);
    if (!path)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory");
    const glint_status status = glint_download_file(s, path, file, size, err);
    free(path);
    return status;
}

static glint_status run_get(struct glint_session *s, const struct glint_arguments *a,
                            struct glint_error *err)
{
    const char *file = glint_options_text(a, "output");
    const struct glint_frame_request frame = {
        .job = a->text[0],
        .outputs = glint_options_text(a, "outputs"),
        .exposure = glint_options_text(a, "exposure"),
        .wait = glint_options_flag(a, "wait"),
    };
    uint64_t size;
    glint_status status = check(s, a, err);
    if (!status)
        status = glint_session_open(s, a, false, err);
    if (!status)
        status = glint_output_is(file, "film")
                     ? download_film(s, frame.job, frame.wait, file, &size, err)
                     : glint_download_frame(s, &frame, file, &size, err);
    if (!status)
        glint_download_report(s, file, size);
    return status;
}

static const struct glint_option options[] = {
    {"output", 'o', "FILE", "where to, .exr, .png or .film"},
    {"outputs", 0, "A,B", "only these outputs; for a PNG the one to show"},
    {"exposure", 0, "STOPS", "of a PNG (0)"},
    {"wait", 'w', NULL, "until the job is done"},
    {0},
};

const struct glint_command glint_command_get = {
    .name = "get",
    .operands = "JOB",
    .summary = "Download a job's frame or film as it stands",
    .options = options,
    .least = 1,
    .most = 1,
    .run = run_get,
};
