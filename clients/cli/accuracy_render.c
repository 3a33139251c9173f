#include "accuracy_render.h"

#include "follow.h"
#include "interrupt.h"
#include "memory_file.h"
#include "protocol/exr.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const cJSON *member(const cJSON *object, const char *name)
{
    return cJSON_GetObjectItemCaseSensitive(object, name);
}

static double number(const cJSON *object, const char *name)
{
    const cJSON *item = member(object, name);
    return cJSON_IsNumber(item) ? item->valuedouble : NAN;
}

static glint_status no_memory(struct glint_error *err)
{
    return glint_fail(err, GLINT_E_NOMEM, "", "no memory");
}

// Sends a document; takes it. *answer may be NULL.
static glint_status send(struct glint_session *s, const char *method, const char *path,
                         cJSON *document, cJSON **answer, struct glint_error *err)
{
    char *text = cJSON_PrintUnformatted(document);
    cJSON_Delete(document);
    if (!text)
        return no_memory(err);
    const struct glint_body body = {
        .type = "application/json", .bytes = (const uint8_t *)text, .size = strlen(text)};
    cJSON *ignored = NULL;
    const glint_status st = glint_client_json(
        s->client,
        &(struct glint_request){.method = method, .path = path, .body = &body, .steady = true},
        answer ? answer : &ignored, err);
    cJSON_Delete(ignored);
    free(text);
    return st;
}

static cJSON *stop_at(unsigned samples)
{
    cJSON *object = cJSON_CreateObject();
    cJSON_AddNumberToObject(object, "samples", samples);
    return object;
}

static glint_status submit(struct glint_session *s, const struct glint_accuracy_order *o,
                           unsigned samples, char id[64], struct glint_error *err)
{
    cJSON *job = cJSON_Duplicate(o->job, true), *answer = NULL;
    cJSON_AddNumberToObject(job, "seed", o->seed);
    cJSON_AddItemToObject(job, "stop", stop_at(samples));
    glint_status st = send(s, "POST", "/v1/jobs", job, &answer, err);
    const char *given = cJSON_GetStringValue(member(answer, "id"));
    if (!st && (!given || strlen(given) >= 64))
        st = glint_fail(err, GLINT_E_INTERNAL, "", "the daemon gave no job");
    if (!st)
        strcpy(id, given);
    cJSON_Delete(answer);
    return st;
}

static glint_status extend(struct glint_session *s, const char *id, unsigned samples,
                           struct glint_error *err)
{
    char *path = glint_client_path("/v1/jobs/", id, "");
    cJSON *patch = cJSON_CreateObject();
    cJSON_AddItemToObject(patch, "stop", stop_at(samples));
    const glint_status st =
        path ? send(s, "PATCH", path, patch, NULL, err) : (cJSON_Delete(patch), no_memory(err));
    free(path);
    return st;
}

// Ends it where it has not, and has it forgotten.
static void forget(struct glint_session *s, const char *id)
{
    struct glint_error ignored = {0};
    char *path = glint_client_path("/v1/jobs/", id, "");
    const struct glint_request request = {.method = "DELETE", .path = path, .steady = true};
    const bool seen = glint_interrupt_pending();
    if (path && !glint_client_send(s->client, &request, NULL, &ignored) && seen)
        glint_client_send(s->client, &request, NULL, &ignored);
    glint_error_finish(&ignored);
    free(path);
}

static glint_status fetch_frame(struct glint_session *s, const char *id, struct glint_frame **frame,
                                struct glint_error *err)
{
    struct glint_memory_file file;
    glint_status st = glint_memory_file_open(&file, err);
    if (st)
        return st;
    char *path = glint_client_path("/v1/jobs/", id, "/frame.exr?wait=done&pixels=float");
    const struct glint_request request = {.method = "GET",
                                          .path = path,
                                          .receive = glint_memory_file_write,
                                          .user = &file,
                                          .stream = false};
    st = path ? glint_client_send(s->client, &request, NULL, err) : no_memory(err);
    if (!st)
        st = glint_memory_file_map(&file, err);
    if (!st)
        st = glint_exr_read(frame, file.bytes, file.size, err);
    glint_memory_file_close(&file);
    free(path);
    return st;
}

static void read_job(struct glint_accuracy_look *out, const cJSON *job)
{
    const cJSON *rays = member(job, "rays");
    out->rays[0] = number(rays, "camera");
    out->rays[1] = number(rays, "bounce");
    out->rays[2] = number(rays, "shadow");
    out->cpu = number(job, "cpu_seconds");
    out->wall = number(job, "seconds");
    out->error = number(job, "error");
}

// Waits for the job to be done with its samples, and shows it.
static glint_status look(struct glint_session *s, const struct glint_accuracy_order *o,
                         const char *id, unsigned samples, struct glint_error *err)
{
    struct glint_accuracy_look l = {.spp = samples};
    struct glint_frame *frame = NULL;
    cJSON *job = NULL;
    glint_status st = fetch_frame(s, id, &frame, err);
    if (!st)
        st = glint_client_get(s->client, "/v1/jobs/", id, "", &job, err);
    if (!st)
        st = glint_follow_verdict(s, job, err);
    if (!st) {
        read_job(&l, job);
        l.frame = frame;
        st = o->look(o->user, &l, err);
    }
    cJSON_Delete(job);
    glint_frame_destroy(&frame);
    return st;
}

glint_status glint_accuracy_render(struct glint_session *s,
                                   const struct glint_accuracy_order *order,
                                   struct glint_error *err)
{
    char id[64];
    glint_status st = submit(s, order, order->ladder[0], id, err);
    if (st)
        return st;
    for (size_t i = 0; i < order->steps && !st; i++) {
        if (i)
            st = extend(s, id, order->ladder[i], err);
        if (!st)
            st = look(s, order, id, order->ladder[i], err);
    }
    forget(s, id);
    return st;
}

glint_status glint_accuracy_ask_plan(struct glint_session *s, const cJSON *job, cJSON **plan,
                                     struct glint_error *err)
{
    const struct glint_accuracy_order order = {.job = job};
    char id[64];
    struct glint_frame *frame = NULL;
    *plan = NULL;
    glint_status st = submit(s, &order, 1, id, err);
    if (st)
        return st;
    st = fetch_frame(s, id, &frame, err);
    if (!st)
        st = glint_client_get(s->client, "/v1/jobs/", id, "/plan", plan, err);
    glint_frame_destroy(&frame);
    forget(s, id);
    return st;
}
