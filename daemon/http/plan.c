#include "http/answer.h"
#include "http/pixels.h"
#include "http/resources.h"
#include "jobs/outlook.h"

#include <math.h>

#define MAX_POINTS 64 // one for each power of two of samples, and some

void glint_http_job_plan(struct glint_request *r)
{
    struct glint_error err = {0};
    struct glint_job_view view;
    if (!glint_pixels_open(r, &view, &err))
        return;
    glint_answer_json(r, MHD_HTTP_OK, glint_render_plan(view.render));
    glint_jobs_release(r->http->jobs, &view);
}

// null where the number is not known
static void add_number(cJSON *object, const char *name, double value)
{
    if (isfinite(value))
        cJSON_AddNumberToObject(object, name, value);
    else
        cJSON_AddNullToObject(object, name);
}

static cJSON *describe_point(const struct glint_convergence_point *p)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddNumberToObject(o, "samples", p->samples);
    add_number(o, "seconds", p->seconds);
    cJSON_AddNumberToObject(o, "rays", (double)p->rays);
    add_number(o, "error", p->error);
    add_number(o, "spread", p->spread);
    return o;
}

void glint_http_job_convergence(struct glint_request *r)
{
    struct glint_error err = {0};
    struct glint_job_view view;
    if (!glint_pixels_open(r, &view, &err))
        return;
    struct glint_convergence_point point[MAX_POINTS];
    const size_t points = glint_render_convergence(view.render, point, MAX_POINTS);
    struct glint_render_state state;
    glint_render_state(view.render, &state);
    cJSON *answer = cJSON_CreateObject();
    cJSON *curve = cJSON_AddArrayToObject(answer, "curve");
    for (size_t i = 0; i < points; i++)
        cJSON_AddItemToArray(curve, describe_point(&point[i]));
    cJSON_AddNumberToObject(answer, "samples", state.samples);
    add_number(answer, "error", state.estimate.error);
    add_number(answer, "requested_error", view.stop.error > 0 ? view.stop.error : NAN);
    add_number(answer, "predicted_samples", state.forecast.samples[0]);
    cJSON_AddItemToObject(
        answer, "estimate",
        glint_outlook_describe(&state, view.job, view.parallel, glint_pixels_final(&view)));
    glint_answer_json(r, MHD_HTTP_OK, answer);
    glint_jobs_release(r->http->jobs, &view);
}
