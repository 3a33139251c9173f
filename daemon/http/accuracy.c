// accuracy.c - what accuracy costs: the fronts of scenes, and the table of knobs of GET /v1.
#include "http/answer.h"
#include "http/resources.h"
#include "protocol/accuracy_knobs.h"
#include "render/effects.h"

#include <string.h>

static void answer_front(struct glint_request *r, int status)
{
    struct glint_error err = {0};
    cJSON *front = glint_jobs_front(r->http->jobs, r->argument[0], &err);
    if (front)
        glint_answer_json(r, status, front);
    else
        glint_answer_error(r, &err);
}

void glint_http_front_get(struct glint_request *r)
{
    answer_front(r, MHD_HTTP_OK);
}

void glint_http_front_put(struct glint_request *r)
{
    struct glint_error err = {0};
    bool created = false;
    if (glint_jobs_put_front(r->http->jobs, r->argument[0], glint_body_text(r), r->body.length,
                             &created, &err)) {
        glint_answer_error(r, &err);
        return;
    }
    answer_front(r, created ? MHD_HTTP_CREATED : MHD_HTTP_OK);
    if (created && r->status == MHD_HTTP_CREATED)
        glint_answer_header(r, "Location", "/v1/scenes/%s/front", r->argument[0]);
}

// ---- the table

// Numbers and truth values of plain members, names of dials.
static cJSON *setting(const struct glint_knob *knob, const char *text)
{
    cJSON *value = knob->dial == GLINT_DIAL_COUNT ? cJSON_Parse(text) : NULL;
    return value ? value : cJSON_CreateString(text);
}

static void add_settings(cJSON *object, const struct glint_knob *knob)
{
    cJSON *ladder = cJSON_AddArrayToObject(object, "approximations");
    cJSON *unbiased = cJSON_AddArrayToObject(object, "unbiased");
    cJSON_AddItemToObject(object, "exact", setting(knob, glint_knob_setting(knob, 0)));
    cJSON_AddItemToObject(object, "twin", setting(knob, glint_knob_twin(knob)));
    for (size_t i = 1; glint_knob_setting(knob, i); i++) {
        cJSON_AddItemToArray(ladder, setting(knob, glint_knob_setting(knob, i)));
        if (glint_knob_unbiased(knob, i))
            cJSON_AddItemToArray(unbiased, setting(knob, glint_knob_setting(knob, i)));
    }
}

// The rows of the effects' table that the dial rules.
static void add_ruled(cJSON *object, enum glint_dial dial)
{
    cJSON *list = cJSON_AddArrayToObject(object, "effects");
    for (size_t i = 0; i < glint_effect_count; i++)
        if (dial != GLINT_DIAL_COUNT && glint_effect_table[i].dial == dial)
            cJSON_AddItemToArray(list, cJSON_CreateString(glint_effect_table[i].name));
}

static cJSON *describe_knob(const struct glint_knob *knob)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "name", glint_knob_name(knob));
    cJSON_AddStringToObject(o, "parent", glint_knob_parent(knob));
    cJSON_AddBoolToObject(o, "dial", knob->dial != GLINT_DIAL_COUNT);
    add_settings(o, knob);
    cJSON_AddBoolToObject(o, "other_question", knob->other_question);
    cJSON_AddStringToObject(o, "metric", glint_accuracy_metric_name[knob->metric]);
    add_ruled(o, knob->dial);
    cJSON *called = cJSON_AddArrayToObject(o, "called_for_by");
    for (size_t i = 0; i < sizeof knob->effects / sizeof *knob->effects && knob->effects[i]; i++)
        cJSON_AddItemToArray(called, cJSON_CreateString(knob->effects[i]));
    if (knob->with)
        cJSON_AddItemToObject(o, "with", cJSON_Parse(knob->with));
    if (knob->base)
        cJSON_AddItemToObject(o, "base", cJSON_Parse(knob->base));
    return o;
}

void glint_http_add_knobs(cJSON *object)
{
    cJSON *knobs = cJSON_AddArrayToObject(object, "knobs");
    for (size_t i = 0; i < glint_knob_count; i++)
        cJSON_AddItemToArray(knobs, describe_knob(&glint_knob_table[i]));
    cJSON *unbuilt = cJSON_AddArrayToObject(object, "unbuilt");
    for (const struct glint_unbuilt *u = glint_unbuilt_table; u->approximation; u++) {
        cJSON *o = cJSON_CreateObject();
        cJSON_AddStringToObject(o, "approximation", u->approximation);
        cJSON_AddStringToObject(o, "exact", u->exact);
        cJSON_AddStringToObject(o, "metric", u->metric);
        cJSON_AddItemToArray(unbuilt, o);
    }
}
