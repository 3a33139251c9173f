// resources.h - the handlers, by the file that holds them.
#ifndef GLINT_HTTP_RESOURCES_H
#define GLINT_HTTP_RESOURCES_H

#include "http/request.h"

// scenes.c
void glint_http_scenes_list(struct glint_request *r);
void glint_http_scenes_get(struct glint_request *r);
void glint_http_scenes_put(struct glint_request *r);
void glint_http_scenes_patch(struct glint_request *r);
void glint_http_scenes_delete(struct glint_request *r);

// accuracy.c; the last adds "knobs" and "unbuilt" to what GET /v1 answers
void glint_http_front_get(struct glint_request *r);
void glint_http_front_put(struct glint_request *r);
void glint_http_add_knobs(cJSON *object);

// assets.c
void glint_http_assets_get(struct glint_request *r);
void glint_http_assets_put(struct glint_request *r);

// jobs.c
void glint_http_jobs_post(struct glint_request *r);
void glint_http_jobs_list(struct glint_request *r);
void glint_http_jobs_get(struct glint_request *r);
void glint_http_jobs_patch(struct glint_request *r);
void glint_http_jobs_delete(struct glint_request *r);

// film.c
void glint_http_film(struct glint_request *r);

// frame.c
void glint_http_frame_exr(struct glint_request *r);
void glint_http_frame_png(struct glint_request *r);

// tiles.c, events.c
void glint_http_tiles_stream(struct glint_request *r);
void glint_http_events_stream(struct glint_request *r);

// mattes.c
void glint_http_mattes_list(struct glint_request *r);
void glint_http_mattes_exr(struct glint_request *r);
void glint_http_mattes_png(struct glint_request *r);
void glint_http_mattes_pick(struct glint_request *r);

// plan.c
void glint_http_job_plan(struct glint_request *r);
void glint_http_job_convergence(struct glint_request *r);

// service.c
void glint_http_service_calls(struct glint_request *r);
void glint_http_service_problem(struct glint_request *r);
void glint_http_service_health(struct glint_request *r);
void glint_http_service_ready(struct glint_request *r);
void glint_http_service_metrics(struct glint_request *r);
void glint_http_service_contract(struct glint_request *r);
void glint_http_service_describe(struct glint_request *r);

// stats.c
void glint_http_service_stats(struct glint_request *r);

// viewer.c
void glint_http_viewer_index(struct glint_request *r);
void glint_http_viewer_file(struct glint_request *r);

#endif
