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

static void add_layer(cJSON *layers, const struct glint_job *job,
                      const struct glint_matte_totals *totals, int layer)
{
    cJSON *o = cJSON_AddObjectToObject(layers, layer_name[layer]);
    cJSON *names = cJSON_AddArrayToObject(o, "names");
    for (size_t i = 0; i < totals->count[layer]; i++) {
        const struct glint_matte_total *t = &totals->of[layer][i];
        cJSON *name = name_object(t->name, t->id, t->coverage[0]);
        for (uint32_t c = 1; c <= glint_matte_classes(job); c++)
            cJSON_AddNumberToObject(name, glint_matte_class_name(job, c), t->coverage[c]);
        cJSON_AddItemToArray(names, name);
    }
    cJSON_AddNumberToObject(o, "lost", totals->lost[0] + totals->lost[1]);
    cJSON_AddNumberToObject(o, "lost_bounced", totals->lost[1]);
}

// Of one layer, or of those that the job has, as bits.
static uint32_t layers_of(const struct glint_job *job, int only)
{
    uint32_t layers = 0;
    for (int i = 0; layer_name[i]; i++)
        layers |= (uint32_t)(i == only || (only < 0 && job->outputs & layer_output[i])) << i;
    return layers;
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
    struct glint_matte_totals totals;
    const uint32_t wanted = layers_of(view.job, only);
    if (glint_render_mattes(view.render, wanted, &totals, &err)) {
        glint_answer_error(r, &err);
    } else {
        cJSON *answer = cJSON_CreateObject();
        cJSON *layers = cJSON_AddObjectToObject(answer, "layers");
        for (int i = 0; layer_name[i]; i++)
            if (wanted >> i & 1)
                add_layer(layers, view.job, &totals, i);
        glint_answer_json(r, MHD_HTTP_OK, answer);
    }
    glint_matte_totals_finish(&totals);
    glint_jobs_release(r->http->jobs, &view);
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

// The list of a type, made where it is not there yet.
static cJSON *list_of(cJSON *out, const struct glint_job *job, const struct glint_matte_type *type)
{
    const char *class_name = glint_matte_class_name(job, type->class_of_it);
    cJSON *of_class = cJSON_GetObjectItemCaseSensitive(out, class_name);
    of_class = of_class ? of_class : cJSON_AddObjectToObject(out, class_name);
    cJSON *list = cJSON_GetObjectItemCaseSensitive(of_class, layer_name[type->layer]);
    return list ? list : cJSON_AddArrayToObject(of_class, layer_name[type->layer]);
}

static cJSON *pick_object(const struct glint_job *job, const struct glint_matte_found *found,
                          size_t count, uint64_t x, uint64_t y)
{
    struct glint_matte_type type[GLINT_MAX_MATTE_TYPES];
    const size_t types = glint_matte_types(job, job->outputs & GLINT_OUT_CRYPTO, type);
    cJSON *answer = cJSON_CreateObject();
    cJSON_AddNumberToObject(answer, "x", (double)x);
    cJSON_AddNumberToObject(answer, "y", (double)y);
    for (size_t t = 0; t < types; t++)
        list_of(answer, job, &type[t]);
    for (size_t i = 0; i < count; i++)
        cJSON_AddItemToArray(list_of(answer, job, &found[i].type),
                             name_object(found[i].name, found[i].id, found[i].coverage));
    return answer;
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
    struct glint_matte_found *found;
    size_t count;
    if (glint_render_pick(view.render, (uint32_t)x, (uint32_t)y, &found, &count, &err))
        glint_answer_error(r, &err);
    else
        glint_answer_json(r, MHD_HTTP_OK, pick_object(view.job, found, count, x, y));
    free(found);
    glint_jobs_release(r->http->jobs, &view);
}
