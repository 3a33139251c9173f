#include "http/answer.h"
#include "http/auth.h"
#include "http/resources.h"
#include "protocol/json.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#define MAX_KEY 255

static bool is_state(const char *text, size_t length, enum glint_job_state state)
{
    const char *name = glint_job_state_name(state);
    return strlen(name) == length && !strncmp(name, text, length);
}

// Bits of the states named in a list with commas.
static void read_states(const struct glint_request *r, uint32_t *out, struct glint_error *err)
{
    const char *text = glint_request_query(r, "state");
    for (const char *p = text; p; p = p[strcspn(p, ",")] ? strchr(p, ',') + 1 : NULL) {
        const size_t length = strcspn(p, ",");
        int state = GLINT_JOB_QUEUED;
        while (state <= GLINT_JOB_CANCELLED && !is_state(p, length, (enum glint_job_state)state))
            state++;
        if (state > GLINT_JOB_CANCELLED)
            glint_fail(err, GLINT_E_RANGE, "",
                       "state: %.*s is none of queued, rendering, paused, done, failed, cancelled",
                       (int)(length < 40 ? length : 40), p);
        else
            *out |= 1u << state;
    }
}

static void read_filter(const struct glint_request *r, struct glint_jobs_filter *out,
                        struct glint_error *err)
{
    const char *tenant = glint_auth_tenant(r);
    uint64_t limit = 0;
    *out = (struct glint_jobs_filter){.client = glint_request_query(r, "client"),
                                      .after = glint_request_query(r, "after")};
    glint_query_check(r, err);
    read_states(r, &out->states, err);
    glint_query_integer(r, "limit", UINT32_MAX, &limit, err);
    out->limit = (uint32_t)limit;
    if (tenant && out->client && strcmp(tenant, out->client) != 0)
        glint_fail(err, GLINT_E_RANGE, "", "client: %.64s sees his own jobs only", tenant);
    if (tenant)
        out->client = tenant;
}

void glint_http_jobs_list(struct glint_request *r)
{
    struct glint_error err = {0};
    struct glint_jobs_filter filter;
    read_filter(r, &filter, &err);
    cJSON *list = err.count ? NULL : glint_jobs_list(r->http->jobs, &filter, &err);
    if (list)
        glint_answer_json(r, MHD_HTTP_OK, list);
    else
        glint_answer_error(r, &err);
}

void glint_http_jobs_get(struct glint_request *r)
{
    struct glint_error err = {0};
    cJSON *job = glint_jobs_describe(r->http->jobs, r->argument[0], &err);
    if (job)
        glint_answer_json(r, MHD_HTTP_OK, job);
    else
        glint_answer_error(r, &err);
}

static void answer_job(struct glint_request *r, int status, const char *id)
{
    struct glint_error err = {0};
    cJSON *job = glint_jobs_describe(r->http->jobs, id, &err);
    if (!job) { // another client has forgotten it already
        glint_answer_error(r, &err);
        return;
    }
    glint_answer_json(r, status, job);
    if (status == MHD_HTTP_ACCEPTED)
        glint_answer_header(r, "Location", "/v1/jobs/%s", id);
}

static bool is_key(const char *key)
{
    size_t n = 0;
    while (isgraph((unsigned char)key[n]))
        n++;
    return n && n <= MAX_KEY && !key[n];
}

// A job that is at fault may also name a scene that does not exist: that is told with the rest.
static void check_scene(struct glint_request *r, struct glint_error *err)
{
    cJSON *json = NULL;
    glint_revision *revision = NULL;
    if (glint_json_parse(&json, glint_body_text(r), r->body.length, &glint_json_request, NULL))
        return;
    const char *scene = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, "scene"));
    if (scene && glint_store_get(r->http->store, scene, &revision, NULL))
        glint_fail(err, GLINT_E_RANGE, "/scene", "there is no scene \"%.128s\"", scene);
    if (revision)
        glint_revision_release(&revision);
    cJSON_Delete(json);
}

void glint_http_jobs_post(struct glint_request *r)
{
    struct glint_error err = {0};
    struct glint_job *job = NULL;
    char id[GLINT_JOB_ID_BYTES];
    bool repeated = false;
    const struct glint_submission from = {.key = glint_request_header(r, "Idempotency-Key"),
                                          .client = r->client_name,
                                          .request = r->id};
    if (from.key && !is_key(from.key))
        glint_fail(&err, GLINT_E_RANGE, "",
                   "Idempotency-Key: 1 to %d visible ASCII characters are needed", MAX_KEY);
    glint_auth_check_name(r, &err);
    const glint_status st = glint_job_parse(&job, glint_body_text(r), r->body.length, &err);
    if (err.count && st != GLINT_E_SYNTAX && st != GLINT_E_TOO_LARGE)
        check_scene(r, &err);
    if (!err.count)
        glint_jobs_submit(r->http->jobs, job, &from, id, &repeated, &err);
    if (err.count) {
        glint_job_destroy(&job);
        glint_answer_error(r, &err);
        return;
    }
    strcpy(r->job, id);
    answer_job(r, MHD_HTTP_ACCEPTED, id);
    if (repeated)
        glint_answer_header(r, "Idempotent-Replayed", "true");
}

void glint_http_jobs_patch(struct glint_request *r)
{
    struct glint_error err = {0};
    if (glint_jobs_patch(r->http->jobs, r->argument[0], glint_body_text(r), r->body.length, &err))
        glint_answer_error(r, &err);
    else
        answer_job(r, MHD_HTTP_OK, r->argument[0]);
}

void glint_http_jobs_delete(struct glint_request *r)
{
    struct glint_error err = {0};
    bool forgotten = false;
    if (glint_jobs_delete(r->http->jobs, r->argument[0], &forgotten, &err))
        glint_answer_error(r, &err);
    else if (forgotten)
        glint_answer_empty(r, MHD_HTTP_NO_CONTENT);
    else
        answer_job(r, MHD_HTTP_ACCEPTED, r->argument[0]);
}
