#include "accuracy_ask.h"

#include "accuracy_mean.h"
#include "upload.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#define MAX_SIDE 4096u
#define MAX_SAMPLES 65536u

const struct glint_option glint_accuracy_options[] = {
    {"output", 'o', "DIR", "folder of the report (accuracy); rows in it are not rendered again"},
    {"camera", 'c', "NAME", "the scene's camera (its first)"},
    {"resolution", 'r', "WxH", "pixels (320x180)"},
    {"seeds", 0, "N", "seeds of every setting, 2 to 30 (16)"},
    {"samples", 'n', "N", "most samples per pixel; smaller powers of two are looked at (16)"},
    {"reference-samples", 0, "N", "of each half of the references (16 times the most)"},
    {"dials", 'd', "A,B",
     "these only: names of dials and numbers, joint (all the scene calls for)"},
    {"no-front", 0, NULL, "do not put the front, from which the daemon picks settings"},
    {"no-spawn", 0, NULL, "fail where no daemon answers"},
    {0},
};

static void read_scene(struct glint_accuracy_ask *out, struct glint_session *s,
                       const struct glint_arguments *a, struct glint_error *err)
{
    struct stat info;
    const char *scene = a->text[0];
    if (stat(scene, &info) == 0 && !S_ISDIR(info.st_mode)) {
        out->file = scene;
        glint_upload_name(scene, out->scene);
    } else if (strchr(scene, '/') || glint_upload_type(scene) || strlen(scene) > 128) {
        glint_session_usage(s, err, "%s: no such file", scene);
    } else {
        strcpy(out->scene, scene);
    }
}

static unsigned read_count(struct glint_session *s, const struct glint_arguments *a,
                           const char *name, unsigned least, unsigned most, unsigned otherwise,
                           struct glint_error *err)
{
    const char *text = glint_options_text(a, name);
    uint64_t value = otherwise;
    if (text && !glint_read_unsigned(text, least, most, &value))
        glint_session_usage(s, err, "--%s: a number from %u to %u is expected, not '%s'", name,
                            least, most, text);
    return (unsigned)value;
}

static void read_size(struct glint_accuracy_ask *out, struct glint_session *s,
                      const struct glint_arguments *a, struct glint_error *err)
{
    const char *text = glint_options_text(a, "resolution");
    uint32_t size[2] = {320, 180};
    if (text && (!glint_read_unsigneds(text, 'x', size, 2) || size[0] < 8 || size[1] < 8 ||
                 size[0] > MAX_SIDE || size[1] > MAX_SIDE))
        glint_session_usage(s, err, "--resolution: WxH of 8 to %u pixels is expected, not '%s'",
                            MAX_SIDE, text);
    out->width = size[0];
    out->height = size[1];
}

// 1, 2, 4, ... and the most itself.
static void make_ladder(struct glint_accuracy_ask *out, unsigned most)
{
    for (unsigned n = 1; n < most; n *= 2)
        out->ladder[out->steps++] = n;
    out->ladder[out->steps++] = most;
}

static void make_base(struct glint_accuracy_ask *out, const char *camera)
{
    cJSON *size = cJSON_CreateArray();
    cJSON_AddItemToArray(size, cJSON_CreateNumber(out->width));
    cJSON_AddItemToArray(size, cJSON_CreateNumber(out->height));
    out->base = cJSON_CreateObject();
    cJSON_AddStringToObject(out->base, "scene", out->scene);
    cJSON_AddItemToObject(out->base, "resolution", size);
    if (camera)
        cJSON_AddStringToObject(out->base, "camera", camera);
}

glint_status glint_accuracy_ask(struct glint_accuracy_ask *out, struct glint_session *s,
                                const struct glint_arguments *a, struct glint_error *err)
{
    *out = (struct glint_accuracy_ask){.folder = glint_options_text(a, "output")};
    read_scene(out, s, a, err);
    read_size(out, s, a, err);
    out->seeds = read_count(s, a, "seeds", 2, GLINT_ACCURACY_SEEDS - 1, 16, err);
    make_ladder(out, read_count(s, a, "samples", 2, MAX_SAMPLES, 16, err));
    const unsigned most = out->ladder[out->steps - 1];
    out->reference_samples =
        read_count(s, a, "reference-samples", 2, 16 * MAX_SAMPLES, 16 * most, err);
    out->dials = glint_options_text(a, "dials");
    out->spawn = out->file && !glint_options_flag(a, "no-spawn");
    out->publish = !glint_options_flag(a, "no-front");
    make_base(out, glint_options_text(a, "camera"));
    if (!out->folder)
        out->folder = "accuracy";
    return err->count ? err->status : GLINT_OK;
}

void glint_accuracy_ask_finish(struct glint_accuracy_ask *ask)
{
    cJSON_Delete(ask->base);
}
