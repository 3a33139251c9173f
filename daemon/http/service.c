#include "http/answer.h"
#include "http/contract.h"
#include "http/media.h"
#include "http/resources.h"
#include "http/routes.h"
#include "protocol/dials.h"
#include "protocol/png.h"
#include "protocol/text.h"

#include <stdlib.h>
#include <string.h>

#define POLICY                                                                                    \
    "default-src 'none'; style-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors " \
    "'none'"

// Takes the text.
static void answer_page(struct glint_request *r, struct glint_text *t)
{
    size_t length;
    char *page = glint_text_take(t, &length);
    if (page) {
        glint_answer_text(r, MHD_HTTP_OK, "text/html; charset=utf-8", page, length);
        glint_answer_header(r, "Content-Security-Policy", "%s", POLICY);
    } else {
        glint_answer_response(r, 0, NULL);
    }
    free(page);
}

static void begin_page(struct glint_text *t, const char *title)
{
    glint_text_print(t,
                     "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\">"
                     "<title>%s</title>\n<link rel=\"stylesheet\" href=\"/viewer/page.css\">\n"
                     "<h1>%s</h1>\n",
                     title, title);
}

// The calls, for people.
void glint_http_service_calls(struct glint_request *r)
{
    struct glint_text t = {0};
    begin_page(&t, "glint");
    glint_text_add(&t,
                   "<p>A render daemon. The contract: "
                   "<a href=\"/openapi.yaml\">openapi.yaml</a>; what this one can do: "
                   "<a href=\"/v1\">/v1</a>; its <a href=\"/v1/scenes\">scenes</a> and "
                   "<a href=\"/v1/jobs\">jobs</a>; the <a href=\"/\">viewer</a>.</p>\n<table>\n");
    for (const struct glint_route *row = glint_route_table; row->method; row++)
        glint_text_print(&t, "<tr><td><code>%s</code><td><code>%s</code><td>%s\n", row->method,
                         row->pattern, row->summary);
    glint_text_add(&t, "</table></html>\n");
    answer_page(r, &t);
}

// What the type of a problem leads to.
void glint_http_service_problem(struct glint_request *r)
{
    struct glint_error err = {0};
    const glint_status st = glint_status_of_problem(r->argument[0]);
    if (!st) {
        glint_fail(&err, GLINT_E_NOT_FOUND, "", "there is no problem of that name");
        glint_answer_error(r, &err);
        return;
    }
    struct glint_text t = {0};
    begin_page(&t, glint_status_title(st));
    glint_text_print(&t, "<p>Status %d. %s</p></html>\n", glint_status_http(st),
                     glint_status_meaning(st));
    answer_page(r, &t);
}

void glint_http_service_health(struct glint_request *r)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "status", "ok");
    glint_answer_json(r, MHD_HTTP_OK, o);
}

void glint_http_service_ready(struct glint_request *r)
{
    struct glint_error err = {0};
    if (glint_http_draining(r->http))
        glint_fail(&err, GLINT_E_BUSY, "", "the server stops");
    if (!glint_devices_workers(r->http->devices))
        glint_fail(&err, GLINT_E_BUSY, "", "there is no worker");
    if (!glint_store_imports(r->http->store))
        glint_fail(&err, GLINT_E_BUSY, "", "the import helper is gone: no scene can be taken");
    if (err.count) {
        glint_answer_error(r, &err);
        return;
    }
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "status", "ready");
    glint_answer_json(r, MHD_HTTP_OK, o);
}

void glint_http_service_metrics(struct glint_request *r)
{
    size_t length;
    char *text = glint_metrics_text(r->http->metrics, &length);
    if (text)
        glint_answer_text(r, MHD_HTTP_OK, "text/plain; version=0.0.4; charset=utf-8", text, length);
    else
        glint_answer_response(r, 0, NULL);
    free(text);
}

void glint_http_service_contract(struct glint_request *r)
{
    glint_answer_text(r, MHD_HTTP_OK, "application/yaml", glint_contract[0].text,
                      glint_contract[0].length);
}

static void add_names(cJSON *object, const char *key, const char *const *name)
{
    cJSON *list = cJSON_AddArrayToObject(object, key);
    for (size_t i = 0; name[i]; i++)
        cJSON_AddItemToArray(list, cJSON_CreateString(name[i]));
}

static void add_outputs(cJSON *object)
{
    cJSON *list = cJSON_AddArrayToObject(object, "outputs");
    for (uint32_t bit = 1; bit; bit <<= 1)
        if (glint_output_name(bit))
            cJSON_AddItemToArray(list, cJSON_CreateString(glint_output_name(bit)));
}

static void add_dials(cJSON *object)
{
    cJSON *dials = cJSON_AddArrayToObject(object, "dials");
    for (int d = 0; d < GLINT_DIAL_COUNT; d++) {
        const struct glint_dial_row *row = &glint_dial_table[d];
        cJSON *o = cJSON_CreateObject();
        cJSON_AddStringToObject(o, "name", row->name);
        cJSON_AddStringToObject(o, "parent", row->parent);
        cJSON_AddStringToObject(o, "exact", row->setting[0]);
        add_names(o, "approximations", row->setting + 1);
        cJSON_AddItemToArray(dials, o);
    }
}

static void add_presets(cJSON *object)
{
    cJSON *presets = cJSON_AddArrayToObject(object, "presets");
    for (size_t p = 0; p < glint_preset_count; p++) {
        cJSON *o = cJSON_CreateObject();
        cJSON_AddStringToObject(o, "name", glint_preset_table[p].name);
        cJSON *settings = cJSON_AddObjectToObject(o, "settings");
        for (int d = 0; d < GLINT_DIAL_COUNT; d++)
            cJSON_AddStringToObject(settings, glint_dial_table[d].name,
                                    glint_dial_table[d].setting[glint_preset_table[p].setting[d]]);
        cJSON_AddItemToArray(presets, o);
    }
}

static void add_tonemaps(cJSON *object)
{
    cJSON *list = cJSON_AddArrayToObject(object, "tonemaps");
    for (int i = 0; i < GLINT_TONEMAP_COUNT; i++)
        cJSON_AddItemToArray(list, cJSON_CreateString(glint_tonemap_table[i].name));
}

void glint_http_service_describe(struct glint_request *r)
{
    glint_http *h = r->http;
    const struct glint_http_limits l = glint_http_limits(h);
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "name", "glint");
    cJSON_AddStringToObject(o, "version", h->version ? h->version : "");
    cJSON *device = cJSON_CreateObject();
    cJSON_AddStringToObject(device, "name", glint_devices_name(h->devices));
    cJSON_AddStringToObject(device, "version", glint_devices_version(h->devices));
    cJSON_AddNumberToObject(device, "workers", glint_devices_workers(h->devices));
    cJSON_AddItemToArray(cJSON_AddArrayToObject(o, "devices"), device);
    add_names(o, "scene_types", glint_media_scenes);
    add_outputs(o);
    add_tonemaps(o);
    add_dials(o);
    add_presets(o);
    glint_http_add_knobs(o);
    cJSON *limits = cJSON_AddObjectToObject(o, "limits");
    cJSON_AddNumberToObject(limits, "job_bytes", (double)l.job_bytes);
    cJSON_AddNumberToObject(limits, "scene_bytes", (double)l.scene_bytes);
    cJSON_AddNumberToObject(limits, "connections", l.connections);
    cJSON_AddNumberToObject(limits, "streams", l.streams);
    cJSON_AddNumberToObject(limits, "side_pixels", GLINT_MAX_SIDE);
    cJSON_AddNumberToObject(limits, "samples", GLINT_MAX_SAMPLES);
    glint_answer_json(r, MHD_HTTP_OK, o);
}
