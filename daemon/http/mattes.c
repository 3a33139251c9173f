#include "http/answer.h"
#include "http/pixels.h"
#include "http/resources.h"
#include "protocol/exr.h"
#include "protocol/png.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const layer_name[] = {"object", "material", "asset", NULL};
static const uint32_t layer_output[] = {GLINT_OUT_CRYPTO_OBJECT, GLINT_OUT_CRYPTO_MATERIAL,
                                        GLINT_OUT_CRYPTO_ASSET};

static cJSON *name_object(const char *name, uint32_t id, double coverage)
{
    char hex[9];
    snprintf(hex, sizeof hex, "%08x", id);
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "name", name);
    cJSON_AddStringToObject(o, "hash", hex);
    cJSON_AddNumberToObject(o, "coverage", coverage);
    return o;
}

// Coverage by the names of a layer, of what the paths of one class have brought.
static glint_status add_class(cJSON *names, const struct glint_job_view *view,
                              enum glint_matte_layer layer, uint32_t class_of_it, double *lost,
                              struct glint_error *err)
{
    struct glint_matte_total *total = NULL;
    size_t count = 0;
    const glint_status st =
        glint_render_mattes(view->render, layer, 1u << class_of_it, &total, &count, lost, err);
    for (size_t i = 0; !st && i < count; i++) {
        if (class_of_it == 0)
            cJSON_AddItemToArray(names, name_object(total[i].name, total[i].id, total[i].coverage));
        else
            cJSON_AddNumberToObject(cJSON_GetArrayItem(names, (int)i),
                                    glint_matte_class_name(view->job, class_of_it),
                                    total[i].coverage);
    }
    free(total);
    return st;
}

static glint_status add_layer(cJSON *layers, const struct glint_job_view *view, int layer,
                              struct glint_error *err)
{
    double lost = 0;
    cJSON *o = cJSON_AddObjectToObject(layers, layer_name[layer]);
    cJSON *names = cJSON_AddArrayToObject(o, "names");
    glint_status st = GLINT_OK;
    for (uint32_t c = 0; !st && c <= glint_matte_classes(view->job); c++)
        st = add_class(names, view, (enum glint_matte_layer)layer, c, &lost, err);
    cJSON_AddNumberToObject(o, "lost", lost);
    return st;
}

// GET mattes: names, IDs and pixels covered, of one layer or of all that the job has.
void glint_http_mattes_list(struct glint_request *r)
{
    struct glint_error err = {0};
    struct glint_job_view view;
    int only = -1;
    glint_query_check(r, &err);
    glint_query_choice(r, "layer", layer_name, &only, &err);
    if (!glint_pixels_open(r, &view, &err))
        return;
    cJSON *answer = cJSON_CreateObject();
    cJSON *layers = cJSON_AddObjectToObject(answer, "layers");
    glint_status st = GLINT_OK;
    for (int i = 0; !st && layer_name[i]; i++)
        if (i == only || (only < 0 && view.job->outputs & layer_output[i]))
            st = add_layer(layers, &view, i, &err);
    glint_jobs_release(r->http->jobs, &view);
    if (st) {
        cJSON_Delete(answer);
        glint_answer_error(r, &err);
    } else {
        glint_answer_json(r, MHD_HTTP_OK, answer);
    }
}

// What was wrong with /layer and /name was wrong with the query, which has no pointers.
static void answer_query_error(struct glint_request *r, struct glint_error *render)
{
    struct glint_error err = {0};
    for (size_t i = 0; i < render->count; i++) {
        const struct glint_fault *f = &render->fault[i];
        const bool named = f->pointer[0] == '/';
        glint_fail(&err, render->status, "", "%s%s%s", named ? f->pointer + 1 : "",
                   named ? ": " : "", f->detail);
    }
    glint_error_finish(render);
    glint_answer_error(r, &err);
}

static uint32_t class_bit(const struct glint_job *job, const char *name, size_t length)
{
    for (uint32_t c = 0; c <= glint_matte_classes(job); c++) {
        const char *known = glint_matte_class_name(job, c);
        if (strlen(known) == length && !strncmp(known, name, length))
            return 1u << c;
    }
    return 0;
}

static void check_through(const struct glint_request *r, struct glint_error *err)
{
    for (const char *at = glint_request_query(r, "through"); at;) {
        const size_t length = strcspn(at, ",");
        if (!glint_matte_class_exists(at, length))
            glint_fail(err, GLINT_E_RANGE, "",
                       "through: %.*s is not one of primary, glossy, reflection, refraction, "
                       "depth0 to depth9",
                       (int)(length < 40 ? length : 40), at);
        at = at[length] ? at + length + 1 : NULL;
    }
}

// The classes that `through` lists, as bits; what is seen directly where it is not there.
static uint32_t read_through(const struct glint_request *r, const struct glint_job *job,
                             struct glint_error *err)
{
    const char *at = glint_request_query(r, "through");
    uint32_t classes = at ? 0 : 1;
    while (at) {
        const size_t length = strcspn(at, ",");
        const uint32_t bit = class_bit(job, at, length);
        if (!bit)
            glint_fail(err, GLINT_E_RANGE, "", "through: the job has no mattes of \"%.*s\"",
                       (int)(length < 40 ? length : 40), at);
        classes |= bit;
        at = at[length] ? at + length + 1 : NULL;
    }
    return classes;
}

// The union matte that the query asks for; NULL: there is an answer, or the request waits.
static struct glint_frame *open_matte(struct glint_request *r)
{
    struct glint_error err = {0};
    struct glint_job_view view;
    struct glint_frame *frame = NULL;
    const char *name[GLINT_MAX_PARAMETERS];
    size_t names = 0;
    int layer = GLINT_MATTE_OBJECT;
    glint_query_check(r, &err);
    glint_query_choice(r, "layer", layer_name, &layer, &err);
    check_through(r, &err);
    for (size_t i = 0; i < r->parameters; i++)
        if (!strcmp(r->parameter[i].name, "name"))
            name[names++] = r->parameter[i].value;
    if (!names)
        glint_fail(&err, GLINT_E_RANGE, "", "name: at least one is needed");
    if (!glint_pixels_open(r, &view, &err))
        return NULL;
    const uint32_t classes = read_through(r, view.job, &err);
    if (err.count)
        glint_answer_error(r, &err);
    else if (glint_render_matte(view.render, (enum glint_matte_layer)layer, classes, name, names,
                                &frame, &err))
        answer_query_error(r, &err);
    glint_jobs_release(r->http->jobs, &view);
    return frame;
}

static void answer_matte(struct glint_request *r, glint_status st, const char *type, uint8_t *bytes,
                         size_t size, struct glint_error *err)
{
    if (st)
        glint_answer_error(r, err);
    else
        glint_answer_blob(r, MHD_HTTP_OK, type, glint_blob_digest(bytes, size));
}

void glint_http_mattes_exr(struct glint_request *r)
{
    static const struct glint_exr_options options = {.compression = GLINT_EXR_ZIP,
                                                     .layout = GLINT_EXR_SINGLE};
    struct glint_error err = {0};
    struct glint_frame *frame = open_matte(r);
    uint8_t *bytes = NULL;
    size_t size = 0;
    if (!frame)
        return;
    const glint_status st = glint_exr_write(frame, &options, &bytes, &size, NULL, &err);
    glint_frame_destroy(&frame);
    answer_matte(r, st, "image/x-exr", bytes, size, &err);
}

void glint_http_mattes_png(struct glint_request *r)
{
    struct glint_error err = {0};
    struct glint_frame *frame = open_matte(r);
    uint8_t *bytes = NULL;
    size_t size = 0;
    if (!frame)
        return;
    const glint_status st = glint_png_coverage(frame->channel[0].plane, frame->width, frame->height,
                                               &bytes, &size, &err);
    glint_frame_destroy(&frame);
    answer_matte(r, st, "image/png", bytes, size, &err);
}

static const char *find_name(const struct glint_matte_total *total, size_t count, uint32_t id)
{
    for (size_t i = 0; i < count; i++)
        if (total[i].id == id)
            return total[i].name;
    return "";
}

// One rank of one type at a pixel. False: the frame has no more ranks.
static bool read_rank(const struct glint_frame *frame, const char *type, int rank, size_t pixel,
                      uint32_t *id, float *coverage)
{
    char name[40];
    snprintf(name, sizeof name, "%.27s%02d.%c", type, rank / 2, "RB"[rank % 2]);
    const float *ids = glint_frame_find(frame, name);
    name[strlen(name) - 1] = "GA"[rank % 2];
    const float *coverages = glint_frame_find(frame, name);
    if (!ids || !coverages)
        return false;
    memcpy(id, &ids[pixel], sizeof *id);
    *coverage = coverages[pixel];
    return true;
}

static glint_status pick_type(cJSON *out, const struct glint_job_view *view,
                              const struct glint_frame *frame, const struct glint_matte_type *type,
                              size_t pixel, struct glint_error *err)
{
    struct glint_matte_total *total = NULL;
    size_t count = 0;
    double lost;
    const glint_status st =
        glint_render_mattes(view->render, type->layer, 1u, &total, &count, &lost, err);
    if (st)
        return st;
    const char *class_name = glint_matte_class_name(view->job, type->class_of_it);
    cJSON *of_class = cJSON_GetObjectItemCaseSensitive(out, class_name);
    of_class = of_class ? of_class : cJSON_AddObjectToObject(out, class_name);
    cJSON *list = cJSON_AddArrayToObject(of_class, layer_name[type->layer]);
    uint32_t id;
    float coverage;
    for (int rank = 0; read_rank(frame, type->name, rank, pixel, &id, &coverage); rank++)
        if (id && coverage > 0)
            cJSON_AddItemToArray(list, name_object(find_name(total, count, id), id, coverage));
    free(total);
    return GLINT_OK;
}

static glint_status pick(struct glint_request *r, const struct glint_job_view *view, uint64_t x,
                         uint64_t y, struct glint_error *err)
{
    const uint32_t outputs = view->job->outputs & GLINT_OUT_CRYPTO, *region = view->job->region;
    if (!outputs)
        return glint_fail(
            err, GLINT_E_RANGE, "",
            "the job has none of the outputs crypto_object, crypto_material, crypto_asset");
    if (x - region[0] >= region[2] || y - region[1] >= region[3])
        return glint_fail(err, GLINT_E_RANGE, "", "x, y: %llu, %llu is not in the region",
                          (unsigned long long)x, (unsigned long long)y);
    struct glint_frame *frame = NULL;
    glint_status st = glint_render_frame(view->render, outputs, &frame, NULL, err);
    if (st)
        return st;
    cJSON *answer = cJSON_CreateObject();
    cJSON_AddNumberToObject(answer, "x", (double)x);
    cJSON_AddNumberToObject(answer, "y", (double)y);
    struct glint_matte_type type[GLINT_MAX_MATTE_TYPES];
    const size_t types = glint_matte_types(view->job, outputs, type);
    const size_t pixel = (size_t)(y - region[1]) * frame->width + (size_t)(x - region[0]);
    for (size_t t = 0; !st && t < types; t++)
        st = pick_type(answer, view, frame, &type[t], pixel, err);
    glint_frame_destroy(&frame);
    if (!st)
        glint_answer_json(r, MHD_HTTP_OK, answer);
    else
        cJSON_Delete(answer);
    return st;
}

void glint_http_mattes_pick(struct glint_request *r)
{
    struct glint_error err = {0};
    struct glint_job_view view;
    uint64_t x = 0, y = 0;
    glint_query_check(r, &err);
    if (!glint_request_query(r, "x") || !glint_request_query(r, "y"))
        glint_fail(&err, GLINT_E_RANGE, "", "x, y: both are needed");
    glint_query_integer(r, "x", GLINT_MAX_SIDE - 1, &x, &err);
    glint_query_integer(r, "y", GLINT_MAX_SIDE - 1, &y, &err);
    if (!glint_pixels_open(r, &view, &err))
        return;
    if (pick(r, &view, x, y, &err))
        glint_answer_error(r, &err);
    glint_jobs_release(r->http->jobs, &view);
}
