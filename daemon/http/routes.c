#include "http/routes.h"

#include "http/answer.h"
#include "http/resources.h"

#include <stdio.h>
#include <string.h>

#define JOB "/v1/jobs/{}"

const struct glint_route glint_route_table[] = {
    {"GET", "/", glint_http_viewer_index, GLINT_LANE_NOW, GLINT_BODY_NONE, "", "the viewer"},
    {"GET", "/viewer/{}", glint_http_viewer_file, GLINT_LANE_NOW, GLINT_BODY_NONE, "",
     "what its page loads"},
    {"GET", "/calls", glint_http_service_calls, GLINT_LANE_NOW, GLINT_BODY_NONE, "", "this page"},
    {"GET", "/problems/{}", glint_http_service_problem, GLINT_LANE_NOW, GLINT_BODY_NONE, "",
     "what a type of problem means"},
    {"GET", "/healthz", glint_http_service_health, GLINT_LANE_NOW, GLINT_BODY_NONE, "",
     "the process lives"},
    {"GET", "/readyz", glint_http_service_ready, GLINT_LANE_NOW, GLINT_BODY_NONE, "",
     "it takes work, or why not"},
    {"GET", "/metrics", glint_http_service_metrics, GLINT_LANE_NOW, GLINT_BODY_NONE, "",
     "Prometheus text"},
    {"GET", "/openapi.yaml", glint_http_service_contract, GLINT_LANE_NOW, GLINT_BODY_NONE, "",
     "the contract"},
    {"GET", "/v1", glint_http_service_describe, GLINT_LANE_NOW, GLINT_BODY_NONE, "",
     "version, devices, capabilities"},
    {"GET", "/v1/stats", glint_http_service_stats, GLINT_LANE_CALL, GLINT_BODY_NONE, "",
     "workers, queues, memory"},
    {"GET", "/v1/scenes", glint_http_scenes_list, GLINT_LANE_NOW, GLINT_BODY_NONE, "",
     "all scenes"},
    {"GET", "/v1/scenes/{}", glint_http_scenes_get, GLINT_LANE_FRAME, GLINT_BODY_NONE, "format ",
     "a scene; format=native: as JSON"},
    {"PUT", "/v1/scenes/{}", glint_http_scenes_put, GLINT_LANE_LOAD, GLINT_BODY_SCENE, "",
     "create or replace a scene: glTF, OBJ, PLY, STL or native JSON"},
    {"PATCH", "/v1/scenes/{}", glint_http_scenes_patch, GLINT_LANE_EDIT, GLINT_BODY_SCENE_PATCH, "",
     "change a scene: a merge patch of its native form"},
    {"DELETE", "/v1/scenes/{}", glint_http_scenes_delete, GLINT_LANE_LOAD, GLINT_BODY_NONE,
     "force ", "remove a scene"},
    {"GET", "/v1/scenes/{}/front", glint_http_front_get, GLINT_LANE_FRAME, GLINT_BODY_NONE, "",
     "what accuracy costs there: the scene's front, or that of its class"},
    {"PUT", "/v1/scenes/{}/front", glint_http_front_put, GLINT_LANE_CALL, GLINT_BODY_JOB, "",
     "the front that was measured of a scene"},
    {"GET", "/v1/assets/{}", glint_http_assets_get, GLINT_LANE_NOW, GLINT_BODY_NONE, "",
     "whether an asset is there"},
    {"PUT", "/v1/assets/{}", glint_http_assets_put, GLINT_LANE_LOAD, GLINT_BODY_ASSET, "",
     "bytes that native scenes name by their SHA-256"},
    {"GET", "/v1/jobs", glint_http_jobs_list, GLINT_LANE_CALL, GLINT_BODY_NONE,
     "after client limit state ", "jobs in order of submission"},
    {"POST", "/v1/jobs", glint_http_jobs_post, GLINT_LANE_CALL, GLINT_BODY_JOB, "", "submit a job"},
    {"GET", JOB, glint_http_jobs_get, GLINT_LANE_NOW, GLINT_BODY_NONE, "", "a job"},
    {"PATCH", JOB, glint_http_jobs_patch, GLINT_LANE_CALL, GLINT_BODY_PATCH, "",
     "change priority, paused, stop; camera of a live job"},
    {"DELETE", JOB, glint_http_jobs_delete, GLINT_LANE_CALL, GLINT_BODY_NONE, "",
     "cancel a job; once more: forget it"},
    {"GET", JOB "/frame.exr", glint_http_frame_exr, GLINT_LANE_FRAME, GLINT_BODY_NONE,
     "layout outputs pixels wait ", "the frame as it stands"},
    {"GET", JOB "/frame.png", glint_http_frame_png, GLINT_LANE_FRAME, GLINT_BODY_NONE,
     "exposure output through tonemap wait ", "one output for the eye"},
    {"GET", JOB "/film", glint_http_film, GLINT_LANE_FRAME, GLINT_BODY_NONE, "wait ",
     "its sums, counts and coverage, for glint merge"},
    {"GET", JOB "/tiles", glint_http_tiles_stream, GLINT_LANE_NOW, GLINT_BODY_NONE, "since ",
     "stream of tiles as they change"},
    {"GET", JOB "/events", glint_http_events_stream, GLINT_LANE_NOW, GLINT_BODY_NONE, "",
     "stream of events"},
    {"GET", JOB "/plan", glint_http_job_plan, GLINT_LANE_FRAME, GLINT_BODY_NONE, "",
     "what is simulated, why, at which cost"},
    {"GET", JOB "/convergence", glint_http_job_convergence, GLINT_LANE_FRAME, GLINT_BODY_NONE, "",
     "error over samples and time"},
    {"GET", JOB "/mattes", glint_http_mattes_list, GLINT_LANE_FRAME, GLINT_BODY_NONE, "layer ",
     "names with their coverage"},
    {"GET", JOB "/matte.exr", glint_http_mattes_exr, GLINT_LANE_FRAME, GLINT_BODY_NONE,
     "layer name* through ", "the matte of some names"},
    {"GET", JOB "/matte.png", glint_http_mattes_png, GLINT_LANE_FRAME, GLINT_BODY_NONE,
     "layer name* through ", "the same for the eye"},
    {"GET", JOB "/pick", glint_http_mattes_pick, GLINT_LANE_FRAME, GLINT_BODY_NONE, "x y ",
     "names under a pixel"},
    {0},
};

static bool matches(const char *pattern, struct glint_request *r)
{
    size_t segment = 0, argument = 0;
    while (*pattern) {
        const size_t length = strcspn(++pattern, "/");
        if (segment == r->segments)
            return false;
        const char *given = r->segment[segment++];
        if (length == 2 && !strncmp(pattern, "{}", 2)) {
            if (!*given)
                return false;
            r->argument[argument++] = given;
        } else if (strlen(given) != length || strncmp(pattern, given, length)) {
            return false;
        }
        pattern += length;
    }
    return segment == r->segments;
}

// The answer 405 names every method of the path.
static void refuse_method(struct glint_request *r, const char *method)
{
    char allow[64] = "";
    for (const struct glint_route *row = glint_route_table; row->method; row++)
        if (matches(row->pattern, r)) {
            const size_t used = strlen(allow);
            snprintf(allow + used, sizeof allow - used, "%s%s%s", used ? ", " : "", row->method,
                     strcmp(row->method, "GET") ? "" : ", HEAD");
        }
    struct glint_error err = {0};
    if (!*allow) {
        glint_fail(&err, GLINT_E_NOT_FOUND, "", "nothing is here; GET /calls lists the calls");
        glint_answer_error(r, &err);
        return;
    }
    glint_fail(&err, GLINT_E_METHOD, "", "%.20s is not one of %s", method, allow);
    glint_answer_error(r, &err);
    glint_answer_header(r, "Allow", "%s", allow);
}

void glint_route_find(struct glint_request *r, const char *method)
{
    const char *wanted = r->head ? "GET" : method;
    for (const struct glint_route *row = glint_route_table; row->method; row++)
        if (!strcmp(row->method, wanted) && matches(row->pattern, r)) {
            r->route = row;
            return;
        }
    refuse_method(r, method);
}
