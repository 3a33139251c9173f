#include "http/answer.h"
#include "http/frames.h"
#include "http/picture.h"
#include "http/pixels.h"
#include "http/resources.h"
#include "protocol/exr.h"
#include "protocol/png.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// One frame as a request wants it.
struct wish {
    uint32_t outputs; // 0: all of the job's
    int layout;       // enum glint_exr_layout
    int floats;       // colour as float, else half
    int tonemap;
    double exposure;
    bool picture;                  // PNG
    struct glint_matte_type shown; // of mattes, in a picture
};

static void read_output(const char *name, size_t length, const char *parameter, uint32_t *outputs,
                        struct glint_error *err)
{
    char text[32];
    snprintf(text, sizeof text, "%.*s", (int)(length < 31 ? length : 31), name);
    const uint32_t bit = glint_output_from_name(text);
    *outputs |= bit;
    if (!bit)
        glint_fail(err, GLINT_E_RANGE, "", "%s: there is no output \"%s\"", parameter, text);
}

static void read_outputs(struct glint_request *r, uint32_t *outputs, struct glint_error *err)
{
    const char *list = glint_request_query(r, "outputs");
    if (!list)
        return;
    for (;;) {
        const size_t n = strcspn(list, ",");
        read_output(list, n, "outputs", outputs, err);
        if (!list[n])
            break;
        list += n + 1;
    }
}

static bool check_outputs(struct glint_request *r, const struct glint_job *job, struct wish *wish,
                          const char *parameter)
{
    struct glint_error err = {0};
    for (uint32_t bit = 1; bit && bit <= wish->outputs; bit <<= 1)
        if (wish->outputs & bit & ~job->outputs)
            glint_fail(&err, GLINT_E_RANGE, "", "%s: the job does not have %s", parameter,
                       glint_output_name(bit));
    if (!wish->outputs)
        wish->outputs = job->outputs;
    if (!err.count)
        return true;
    glint_answer_error(r, &err);
    return false;
}

// The type that a picture of mattes shows: of the class that the query names, or seen directly.
static bool choose_type(struct glint_request *r, const struct glint_job *job, struct wish *wish)
{
    const char *through = glint_request_query(r, "through");
    struct glint_matte_type type[GLINT_MAX_MATTE_TYPES];
    const size_t types = glint_matte_types(job, wish->outputs & GLINT_OUT_CRYPTO, type);
    for (size_t t = 0; t < types; t++)
        if (!strcmp(glint_matte_class_name(job, type[t].class_of_it),
                    through ? through : "primary")) {
            wish->shown = type[t];
            return true;
        }
    if (!through)
        return true;
    struct glint_error err = {0};
    glint_fail(&err, GLINT_E_RANGE, "", "through: the output has no mattes of \"%.40s\"", through);
    glint_answer_error(r, &err);
    return false;
}

static glint_status encode_exr(const struct glint_frame *frame, const struct wish *wish,
                               uint8_t **bytes, size_t *size, struct glint_error *err)
{
    const struct glint_exr_options options = {.compression = GLINT_EXR_ZIP,
                                              .layout = (enum glint_exr_layout)wish->layout,
                                              .floats = wish->floats};
    return glint_exr_write(frame, &options, bytes, size, NULL, err);
}

// A snapshot, encoded; NULL: the answer says why.
static struct glint_blob *encode(struct glint_request *r, const struct glint_job_view *view,
                                 const struct wish *wish)
{
    struct glint_error err = {0};
    struct glint_frame *frame = NULL;
    uint8_t *bytes = NULL;
    size_t size = 0;
    glint_status st = glint_render_frame(view->render, wish->outputs, &frame, NULL, &err);
    if (!st && wish->picture)
        st = glint_picture_encode(frame,
                                  &(struct glint_picture){wish->outputs, wish->shown.name,
                                                          (float)wish->exposure,
                                                          (enum glint_tonemap)wish->tonemap},
                                  &bytes, &size, &err);
    else if (!st)
        st = encode_exr(frame, wish, &bytes, &size, &err);
    glint_frame_destroy(&frame);
    struct glint_blob *blob = st                         ? NULL
                              : glint_pixels_final(view) ? glint_blob_digest(bytes, size)
                                                         : glint_blob_take(bytes, size);
    if (st)
        glint_answer_error(r, &err);
    else if (!blob)
        glint_answer_response(r, 0, NULL);
    return blob;
}

static void answer(struct glint_request *r, const struct glint_job_view *view,
                   const struct wish *wish)
{
    char key[256];
    snprintf(key, sizeof key, "%s %llu %x %d %d %d %d %.17g %u", r->argument[0],
             (unsigned long long)view->sequence, wish->outputs, wish->picture, wish->layout,
             wish->floats, wish->tonemap, wish->exposure, wish->shown.class_of_it);
    struct glint_blob *blob =
        glint_pixels_final(view) ? glint_frames_find(r->http->frames, key) : NULL;
    if (!blob) {
        blob = encode(r, view, wish);
        if (!blob)
            return;
        if (*blob->etag)
            glint_frames_keep(r->http->frames, key, blob);
    }
    glint_answer_blob(r, MHD_HTTP_OK, wish->picture ? "image/png" : "image/x-exr", blob);
    if (r->status >= 300)
        return;
    glint_answer_header(r, "Content-Disposition", "inline; filename=\"%s.%s\"", r->argument[0],
                        wish->picture ? "png" : "exr");
    glint_answer_header(r, "Glint-Revision", "%s", view->revision);
    glint_answer_header(r, "Cache-Control", "%s",
                        glint_pixels_final(view) ? "no-cache" : "no-store");
}

void glint_http_frame_exr(struct glint_request *r)
{
    static const char *const layouts[] = {"single", "multipart", NULL};
    static const char *const pixels[] = {"half", "float", NULL};
    struct glint_error err = {0};
    struct glint_job_view view;
    struct wish wish = {.layout = GLINT_EXR_SINGLE};
    glint_query_check(r, &err);
    read_outputs(r, &wish.outputs, &err);
    glint_query_choice(r, "layout", layouts, &wish.layout, &err);
    glint_query_choice(r, "pixels", pixels, &wish.floats, &err);
    if (!glint_pixels_open(r, &view, &err))
        return;
    if (check_outputs(r, view.job, &wish, "outputs"))
        answer(r, &view, &wish);
    glint_jobs_release(r->http->jobs, &view);
}

void glint_http_frame_png(struct glint_request *r)
{
    const char *curves[GLINT_TONEMAP_COUNT + 1] = {NULL};
    for (int i = 0; i < GLINT_TONEMAP_COUNT; i++)
        curves[i] = glint_tonemap_table[i].name;
    struct glint_error err = {0};
    struct glint_job_view view;
    struct wish wish = {.picture = true};
    const char *output = glint_request_query(r, "output");
    if (!output)
        output = "beauty";
    glint_query_check(r, &err);
    read_output(output, strlen(output), "output", &wish.outputs, &err);
    glint_query_number(r, "exposure", -64, 64, &wish.exposure, &err);
    glint_query_choice(r, "tonemap", curves, &wish.tonemap, &err);
    if (!glint_pixels_open(r, &view, &err))
        return;
    if (check_outputs(r, view.job, &wish, "output") && choose_type(r, view.job, &wish))
        answer(r, &view, &wish);
    glint_jobs_release(r->http->jobs, &view);
}
