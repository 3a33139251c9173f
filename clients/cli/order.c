#include "order.h"
#include "download.h"
#include "output.h"
#include "upload.h"
#include "uri.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

// Texts of the command line as members of the job; NULL for what they cannot be.

static cJSON *to_text(const char *text)
{
    return cJSON_CreateString(text);
}

static cJSON *to_count(const char *text)
{
    uint64_t value;
    return glint_read_unsigned(text, 0, UINT32_MAX, &value) ? cJSON_CreateNumber((double)value)
                                                            : NULL;
}

static cJSON *to_count_or_text(const char *text)
{
    cJSON *count = to_count(text);
    return count ? count : to_text(text);
}

static cJSON *to_number(const char *text)
{
    double value;
    return glint_read_number(text, &value) ? cJSON_CreateNumber(value) : NULL;
}

static cJSON *to_numbers(const char *text, char separator, size_t count)
{
    uint32_t value[4];
    if (!glint_read_unsigneds(text, separator, value, count))
        return NULL;
    cJSON *list = cJSON_CreateArray();
    for (size_t i = 0; i < count; i++)
        cJSON_AddItemToArray(list, cJSON_CreateNumber(value[i]));
    return list;
}

static cJSON *to_size(const char *text)
{
    return to_numbers(text, 'x', 2);
}

static cJSON *to_region(const char *text)
{
    return to_numbers(text, ',', 4);
}

static cJSON *to_range(const char *text)
{
    return to_numbers(text, ',', 2);
}

// A,B of any numbers.
static cJSON *to_pair(const char *text)
{
    char first[64];
    double value[2];
    const char *comma = strchr(text, ',');
    if (!comma || (size_t)(comma - text) >= sizeof first)
        return NULL;
    snprintf(first, sizeof first, "%.*s", (int)(comma - text), text);
    if (!glint_read_number(first, &value[0]) || !glint_read_number(comma + 1, &value[1]))
        return NULL;
    return cJSON_CreateDoubleArray(value, 2);
}

static cJSON *to_list(const char *text)
{
    cJSON *list = cJSON_CreateArray();
    for (size_t n; *text; text += n + (text[n] == ',')) {
        char name[64];
        n = strcspn(text, ",");
        if (!n || n >= sizeof name) {
            cJSON_Delete(list);
            return NULL;
        }
        memcpy(name, text, n);
        name[n] = '\0';
        cJSON_AddItemToArray(list, cJSON_CreateString(name));
    }
    return list;
}

static const struct {
    const char *option, *parent, *member;
    cJSON *(*read)(const char *text);
    const char *want;
} members[] = {
    {"samples", "stop", "samples", to_count, "a whole number"},
    {"seconds", "stop", "seconds", to_number, "a number"},
    {"error", "stop", "error", to_number, "a number"},
    {"within", "accuracy", "time", to_number, "a number"},
    {"reach", "accuracy", "error", to_number, "a number"},
    {"resolution", NULL, "resolution", to_size, "WIDTHxHEIGHT"},
    {"region", NULL, "region", to_region, "X,Y,WIDTH,HEIGHT"},
    {"sample-range", NULL, "sample_range", to_range, "FIRST,END"},
    {"camera", NULL, "camera", to_text, "a name"},
    {"outputs", NULL, "outputs", to_list, "names with commas between them"},
    {"through", "mattes", "through", to_text, "a name"},
    {"levels", "mattes", "levels", to_count_or_text, "a whole number or auto"},
    {"max-bounces", NULL, "max_bounces", to_count, "a whole number"},
    {"seed", NULL, "seed", to_count, "a whole number"},
    {"frame", NULL, "frame", to_count, "a whole number"},
    {"fps", NULL, "fps", to_number, "a number"},
    {"shutter", NULL, "shutter", to_pair, "OPEN,CLOSE"},
    {"animation", NULL, "animation", to_text, "a name"},
    {"priority", NULL, "priority", to_number, "a number"},
    {"name", NULL, "name", to_text, "a name"},
};

const struct glint_option glint_order_options[] = {
    {"output", 'o', "FILE",
     "write the frame here, .exr or .png; may be repeated. A run of # in "
     "it is the frame's number"},
    {"progress", 0, "STYLE", "auto, bar, plain, openjd or none"},
    {"wait", 0, NULL, "return when the outputs are in place (it always does)"},
    {"no-spawn", 0, NULL, "start no private daemon"},
    {"tev", 0, "HOST:PORT", "show the picture in the viewer tev as it comes"},
    {"samples", 'n', "N", "stop at N samples per pixel"},
    {"seconds", 't', "S", "stop after S seconds of rendering"},
    {"error", 'e', "E", "stop at an estimated error of E"},
    {"within", 0, "S", "have the settings picked: the least error within S seconds of rendering"},
    {"reach", 0, "E", "have the settings picked: an error of E, known bias included, soonest"},
    {"resolution", 'r', "WxH", "size of the frame"},
    {"region", 0, "X,Y,W,H", "render only this part of it"},
    {"sample-range", 0, "A,B", "render only the samples from A on, without B; see glint merge"},
    {"camera", 'c', "NAME", "look through this camera"},
    {"outputs", 0, "A,B", "what to render: beauty, crypto_object, ..."},
    {"through", 0, "LOBES", "mattes through bounces: glossy, delta or none"},
    {"levels", 0, "N", "ranks of the mattes in files, or auto: as many as it takes"},
    {"max-bounces", 0, "N", "longest paths"},
    {"seed", 0, "N", "of the random numbers"},
    {"frame", 'f', "N", "number of the frame"},
    {"fps", 0, "F", "frames per second, the scene's where it is 0"},
    {"shutter", 0, "A,B", "it is open from A to B, in frames from the frame on"},
    {"animation", 0, "NAME", "of the scene; none: as it is at rest"},
    {"live", 0, NULL,
     "follow the scene and the job's camera without an end; prints the job and returns"},
    {"priority", 0, "N", "-100..100, higher is first"},
    {"name", 0, "NAME", "the job's name"},
    {"scene-name", 0, "NAME", "what an uploaded scene is called (as its file)"},
    {"job", 0, "FILE", "start from this job, a JSON document; options override it"},
    {"idempotency-key", 0, "KEY", "the same key again gives the same job"},
    {0},
};

static glint_status read_job_file(struct glint_order *o, struct glint_session *s, const char *file,
                                  struct glint_error *err)
{
    struct glint_blob text;
    const glint_status status = glint_uri_read_file(file, &text, "", err);
    if (status)
        return status;
    o->job = cJSON_ParseWithLength((const char *)text.bytes, text.size);
    free(text.bytes);
    return cJSON_IsObject(o->job) ? GLINT_OK
                                  : glint_session_usage(s, err, "%s: no JSON object", file);
}

static void set_member(cJSON *job, const char *parent, const char *name, cJSON *value)
{
    cJSON *in = parent ? cJSON_GetObjectItemCaseSensitive(job, parent) : job;
    if (!cJSON_IsObject(in)) {
        cJSON_DeleteItemFromObjectCaseSensitive(job, parent);
        in = cJSON_AddObjectToObject(job, parent);
    }
    cJSON_DeleteItemFromObjectCaseSensitive(in, name);
    cJSON_AddItemToObject(in, name, value);
}

static glint_status read_members(struct glint_order *o, struct glint_session *s,
                                 const struct glint_arguments *a, struct glint_error *err)
{
    glint_status status = GLINT_OK;
    for (size_t i = 0; i < sizeof members / sizeof *members; i++) {
        const char *text = glint_options_text(a, members[i].option);
        cJSON *value = text ? members[i].read(text) : NULL;
        if (value)
            set_member(o->job, members[i].parent, members[i].member, value);
        else if (text)
            status = glint_session_usage(s, err, "--%s wants %s, not '%s'", members[i].option,
                                         members[i].want, text);
    }
    return status;
}

// A file that exists is a file; a name without a known extension may be that of a resident scene.
static glint_status read_scene(struct glint_order *o, struct glint_session *s,
                               const struct glint_arguments *a, struct glint_error *err)
{
    struct stat info;
    const char *scene = a->count ? a->text[0] : NULL, *name = glint_options_text(a, "scene-name");
    if (!scene)
        return cJSON_HasObjectItem(o->job, "scene")
                   ? GLINT_OK
                   : glint_session_usage(s, err, "a SCENE is wanted, or a job that names one");
    if (stat(scene, &info) == 0 && !S_ISDIR(info.st_mode))
        o->file = scene;
    else if (strchr(scene, '/') || glint_upload_type(scene))
        return glint_fail(err, GLINT_E_IO, "", "%s: no such file", scene);
    if (name && !o->file)
        return glint_session_usage(s, err, "--scene-name is for files, %s is none", scene);
    if (name)
        snprintf(o->scene, sizeof o->scene, "%s", name);
    else if (o->file)
        glint_upload_name(scene, o->scene);
    else
        snprintf(o->scene, sizeof o->scene, "%s", scene);
    set_member(o->job, NULL, "scene", cJSON_CreateString(o->scene));
    return GLINT_OK;
}

// shot.####.exr, frame 7 -> shot.0007.exr; malloc'd.
static char *number_frame(const char *pattern, const cJSON *frame)
{
    const char *run = strchr(pattern, '#');
    char *file = NULL;
    if (!run || !cJSON_IsNumber(frame))
        return strdup(pattern);
    const size_t width = strspn(run, "#");
    if (asprintf(&file, "%.*s%0*d%s", (int)(run - pattern), pattern, (int)width, frame->valueint,
                 run + width) < 0)
        return NULL;
    return file;
}

static glint_status read_output(struct glint_order *o, struct glint_session *s, const char *pattern,
                                struct glint_error *err)
{
    char *file = number_frame(pattern, cJSON_GetObjectItemCaseSensitive(o->job, "frame"));
    if (!file)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory");
    o->output[o->outputs++] = file;
    if (!glint_download_kind(file))
        return glint_session_usage(s, err, "%s: frames are .exr or .png", file);
    return glint_output_check(file, err);
}

static glint_status read_outputs(struct glint_order *o, struct glint_session *s,
                                 const struct glint_arguments *a, struct glint_error *err)
{
    const char *pattern[GLINT_MAX_FILES + 1];
    const size_t count = glint_options_all(a, "output", pattern, GLINT_MAX_FILES + 1);
    if (o->detached)
        return !count ? GLINT_OK
                      : glint_session_usage(s, err,
                                            "a live job has no end at which %s could be "
                                            "written: use glint get",
                                            pattern[0]);
    if (!count || count > GLINT_MAX_FILES)
        return glint_session_usage(s, err, "render wants -o FILE, at most %d times",
                                   GLINT_MAX_FILES);
    glint_status status = GLINT_OK;
    for (size_t i = 0; i < count; i++) {
        const glint_status st = read_output(o, s, pattern[i], err);
        status = status ? status : st;
    }
    return status;
}

glint_status glint_order_read(struct glint_order *out, struct glint_session *s,
                              const struct glint_arguments *a, struct glint_error *err)
{
    const char *file = glint_options_text(a, "job");
    const bool detached = out->detached;
    *out = (struct glint_order){.key = glint_options_text(a, "idempotency-key")};
    glint_status status = GLINT_OK;
    if (file)
        status = read_job_file(out, s, file, err);
    else
        out->job = cJSON_CreateObject();
    if (status)
        return status;
    if (glint_options_flag(a, "live"))
        set_member(out->job, NULL, "live", cJSON_CreateTrue());
    out->detached = detached || cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(out->job, "live"));
    out->tev = glint_options_text(a, "tev");
    if (!glint_progress_init(&s->progress, glint_options_text(a, "progress"), s->json))
        status = glint_session_usage(s, err, "--progress wants auto, bar, plain, openjd or none");
    glint_status (*const parts[])(struct glint_order *, struct glint_session *,
                                  const struct glint_arguments *,
                                  struct glint_error *) = {read_members, read_scene, read_outputs};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        const glint_status st = parts[i](out, s, a, err);
        status = status ? status : st;
    }
    return status;
}

void glint_order_finish(struct glint_order *order)
{
    for (size_t i = 0; i < order->outputs; i++)
        free(order->output[i]);
    cJSON_Delete(order->job);
    *order = (struct glint_order){0};
}
