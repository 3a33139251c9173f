// cmd_recolor.c - recolor: another colour for what a matte names, in a file or in a job's frame.
#include "command.h"
#include "download.h"
#include "image_file.h"
#include "memory_file.h"
#include "output.h"
#include "problem.h"
#include "protocol/cryptomatte.h"
#include "protocol/exr.h"
#include "protocol/png.h"
#include "recolour.h"
#include "through.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define MAX_NAMES 64

// What is asked for, as the command line says it.
struct wish {
    const char *source, *layer, *through, *image, *output;
    const char *name[MAX_NAMES];
    size_t names;
    struct glint_rgb colour;
    double exposure;
};

// What was done.
struct outcome {
    const char *type;
    struct glint_recoloured name[MAX_NAMES];
};

static glint_status read_wish(struct wish *w, struct glint_session *s,
                              const struct glint_arguments *a, struct glint_error *err)
{
    const char *colour = glint_options_text(a, "color"),
               *exposure = glint_options_text(a, "exposure");
    *w = (struct wish){.source = a->text[0],
                       .layer = glint_options_text(a, "layer"),
                       .through = glint_options_text(a, "through"),
                       .image = glint_options_text(a, "image"),
                       .output = glint_options_text(a, "output")};
    w->names = glint_options_all(a, "name", w->name, MAX_NAMES);
    if (!w->names || !colour || !w->output)
        return glint_session_usage(s, err, "recolor wants --name NAME, --color COLOR and -o FILE");
    glint_status status = GLINT_OK;
    if (!glint_rgb_read(colour, &w->colour))
        status = glint_session_usage(s, err,
                                     "--color wants #rrggbb (sRGB) or r,g,b (scene-linear), not "
                                     "'%s'",
                                     colour);
    if (!glint_download_kind(w->output))
        status = glint_session_usage(s, err, "%s: pictures are .exr or .png", w->output);
    if (exposure &&
        (!glint_read_number(exposure, &w->exposure) || w->exposure < -64 || w->exposure > 64))
        status =
            glint_session_usage(s, err, "--exposure wants -64 to 64 stops, not '%s'", exposure);
    return status;
}

// A job's frame with all its outputs, as it stands.
static glint_status fetch(struct glint_session *s, const char *job, struct glint_image_file *file,
                          struct glint_error *err)
{
    struct glint_memory_file memory;
    char *path = glint_client_path("/v1/jobs/", job, "/frame.exr");
    glint_status status = path ? glint_memory_file_open(&memory, err)
                               : glint_fail(err, GLINT_E_NOMEM, "", "no memory");
    if (status) {
        free(path);
        return status;
    }
    const struct glint_request request = {
        .method = "GET", .path = path, .receive = glint_memory_file_write, .user = &memory};
    status = glint_client_send(s->client, &request, NULL, err);
    if (!status)
        status = glint_memory_file_map(&memory, err);
    if (!status)
        status = glint_image_file_parse(file, memory.bytes, memory.size, err);
    glint_memory_file_close(&memory);
    free(path);
    return status;
}

static glint_status read_source(struct glint_session *s, const struct glint_arguments *a,
                                struct glint_image_file *file, struct glint_error *err)
{
    struct stat info;
    const char *source = a->text[0];
    *file = (struct glint_image_file){0};
    if (stat(source, &info) == 0)
        return glint_image_file_read(file, source, err);
    if (glint_output_is(source, "exr") || strchr(source, '/'))
        return glint_fail(err, GLINT_E_IO, "", "%s: %s", source, strerror(errno));
    const glint_status status = glint_session_open(s, a, false, err);
    return status ? status : fetch(s, source, file, err);
}

// The part before the last '.' of "ViewLayer.Combined.R", for the only colour of that kind.
static bool find_combined(const struct glint_frame *frame, float *plane[3])
{
    bool found = false;
    for (uint32_t i = 0; i < frame->channels && !found; i++) {
        const char *name = frame->channel[i].name, *end = strrchr(name, '.');
        char prefix[256];
        if (!end || end - name < 8 || strncmp(end - 8, "Combined", 8) != 0)
            continue;
        snprintf(prefix, sizeof prefix, "%.*s", (int)(end - name), name);
        found = glint_rgb_planes(frame, prefix, plane);
    }
    return found;
}

static glint_status find_picture(const struct wish *w, const struct glint_frame *frame,
                                 float *plane[3], struct glint_error *err)
{
    if (w->image && glint_rgb_planes(frame, w->image, plane))
        return GLINT_OK;
    if (!w->image && (glint_rgb_planes(frame, "", plane) || find_combined(frame, plane)))
        return GLINT_OK;
    return glint_fail(err, GLINT_E_NOT_FOUND, "", "%s: the picture has no channels %s%sR, G and B",
                      w->source, w->image ? w->image : "", w->image ? "." : "");
}

// Each name by itself: what one of them looked like says nothing of another.
static glint_status recolour_name(const struct wish *w, const struct glint_image_file *file,
                                  struct glint_recolour *r, size_t i, uint32_t id,
                                  struct outcome *o, struct glint_error *err)
{
    const size_t pixels = (size_t)r->width * r->height;
    float *matte = calloc(pixels, 2 * sizeof *matte);
    if (!matte)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a matte");
    r->matte = matte;
    r->direct = matte + pixels;
    glint_status status = glint_through_matte(file->frame, o->type, w->through, id, matte, err);
    if (!status)
        status = glint_through_matte(file->frame, o->type, NULL, id, matte + pixels, err);
    if (!status)
        status = glint_recolour(r, &o->name[i], err);
    if (status == GLINT_OK && o->name[i].covered <= 0)
        status =
            glint_fail(err, GLINT_E_NOT_FOUND, "", "nothing of '%s' is in the picture", w->name[i]);
    free(matte);
    return status;
}

static glint_status recolour(const struct wish *w, const struct glint_image_file *file,
                             struct outcome *o, struct glint_error *err)
{
    uint32_t id[MAX_NAMES];
    struct glint_recolour r = {
        .width = file->frame->width, .height = file->frame->height, .colour = w->colour};
    glint_status status = find_picture(w, file->frame, r.picture, err);
    if (!status)
        status = glint_image_file_type(file, w->layer, &o->type, err);
    if (!status)
        status = glint_image_file_ids(file, o->type, w->name, w->names, id, err);
    if (!glint_rgb_planes(file->frame, "albedo", r.albedo))
        r.albedo[0] = NULL;
    for (size_t i = 0; i < w->names && !status; i++)
        status = recolour_name(w, file, &r, i, id[i], o, err);
    return status;
}

static glint_status encode(const struct wish *w, const struct glint_frame *frame, uint8_t **bytes,
                           size_t *size, struct glint_error *err)
{
    if (strcmp(glint_download_kind(w->output), "exr") == 0) {
        const struct glint_exr_options options = {.compression = GLINT_EXR_ZIP, .foreign = true};
        return glint_exr_write(frame, &options, bytes, size, NULL, err);
    }
    float *plane[3];
    const glint_status status = find_picture(w, frame, plane, err);
    const struct glint_png_image image = {.width = frame->width,
                                          .height = frame->height,
                                          .red = plane[0],
                                          .green = plane[1],
                                          .blue = plane[2],
                                          .alpha = w->image ? NULL : glint_frame_find(frame, "A")};
    const struct glint_png_options options = {.exposure = (float)w->exposure};
    return status ? status : glint_png_color(&image, &options, bytes, size, err);
}

static glint_status write_picture(const struct wish *w, const struct glint_frame *frame,
                                  struct glint_error *err)
{
    uint8_t *bytes = NULL;
    size_t size = 0;
    struct glint_output_file output;
    glint_status status = encode(w, frame, &bytes, &size, err);
    if (!status)
        status = glint_output_open(&output, w->output, err);
    if (!status) {
        glint_output_write(&output, bytes, size);
        status = glint_output_close(&output, true, err);
    }
    free(bytes);
    return status;
}

static void print_report(const struct wish *w, const struct outcome *o)
{
    const double *to = w->colour.c;
    for (size_t i = 0; i < w->names; i++) {
        const double *from = o->name[i].old.c;
        glint_print_plain(stdout, w->name[i]);
        printf(": %.4g pixels, %.3f,%.3f,%.3f is now %.3f,%.3f,%.3f\n", o->name[i].covered, from[0],
               from[1], from[2], to[0], to[1], to[2]);
    }
}

static void report(const struct glint_session *s, const struct wish *w, const struct outcome *o)
{
    if (!s->json) {
        print_report(w, o);
        return;
    }
    cJSON *document = cJSON_CreateObject();
    cJSON_AddStringToObject(document, "file", w->output);
    cJSON_AddStringToObject(document, "layer", o->type);
    cJSON_AddItemToObject(document, "color", cJSON_CreateDoubleArray(w->colour.c, 3));
    cJSON *names = cJSON_AddArrayToObject(document, "names");
    for (size_t i = 0; i < w->names; i++) {
        cJSON *name = cJSON_CreateObject();
        cJSON_AddStringToObject(name, "name", w->name[i]);
        cJSON_AddNumberToObject(name, "pixels", o->name[i].covered);
        cJSON_AddItemToObject(name, "old", cJSON_CreateDoubleArray(o->name[i].old.c, 3));
        cJSON_AddStringToObject(name, "old_from", o->name[i].by_albedo ? "albedo" : "picture");
        cJSON_AddItemToArray(names, name);
    }
    glint_session_print(document);
}

static glint_status run_recolor(struct glint_session *s, const struct glint_arguments *a,
                                struct glint_error *err)
{
    struct wish wish;
    struct outcome outcome = {0};
    struct glint_image_file file = {0};
    glint_status status = read_wish(&wish, s, a, err);
    if (!status)
        status = glint_output_check(wish.output, err);
    if (!status)
        status = read_source(s, a, &file, err);
    if (!status)
        status = recolour(&wish, &file, &outcome, err);
    if (!status)
        status = write_picture(&wish, file.frame, err);
    if (!status)
        report(s, &wish, &outcome);
    glint_image_file_finish(&file);
    return status;
}

static const struct glint_option options[] = {
    {"name", 'n', "NAME", "what gets the colour; repeated, all of these"},
    {"color", 'c', "COLOR", "#rrggbb as on the screen, or r,g,b in scene-linear numbers"},
    {"layer", 'l', "LAYER",
     "object (the default), material, asset, or a layer's full name; the only one need not be "
     "named"},
    {"through", 0, "CLASSES",
     "with commas between: primary (the default), glossy, reflection, refraction, depth0, .."},
    {"image", 0, "PREFIX", "recolour the channels PREFIX.R, G, B instead of R, G, B"},
    {"exposure", 0, "STOPS", "of a PNG (0)"},
    {"output", 'o', "FILE", "where to, .exr or .png"},
    {0},
};

const struct glint_command glint_command_recolor = {
    .name = "recolor",
    .operands = "FRAME|JOB",
    .summary = "Give what a matte names another colour",
    .detail = "FRAME is an EXR file with Cryptomatte layers, of glint or another renderer; JOB\n"
              "a job whose frame is downloaded. Hue and saturation become the new colour's,\n"
              "the light that falls on the surface stays, and so do edges. With albedo\n"
              "channels in the picture the old colour of what is seen directly is known\n"
              "from them; of anything else brightness is kept.",
    .options = options,
    .least = 1,
    .most = 1,
    .run = run_recolor,
};
