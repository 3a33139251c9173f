// problem.c - one document for every error.
#include "protocol/problem.h"

#include "protocol/text.h"

#include <stdlib.h>

static void member(struct glint_text *t, const char *key, const char *value)
{
    if (!value)
        return;
    glint_text_key(t, key);
    glint_text_string(t, value);
}

static void write_faults(struct glint_text *t, const struct glint_error *err)
{
    glint_text_key(t, "errors");
    glint_text_add(t, "[");
    for (size_t i = 0; i < err->count; i++) {
        glint_text_item(t);
        glint_text_add(t, "{");
        member(t, "pointer", err->fault[i].pointer);
        member(t, "detail", err->fault[i].detail);
        glint_text_add(t, "}");
    }
    glint_text_add(t, "]");
}

// The sentence of the only fault; of several the first, with their number.
static void write_detail(struct glint_text *t, const struct glint_error *err)
{
    const struct glint_fault *first = err->fault;
    if (err->count < 2) {
        member(t, "detail", glint_error_text(err));
        return;
    }
    struct glint_text sentence = {0};
    glint_text_print(&sentence, "%zu faults; the first, at \"%s\": %s", err->count, first->pointer,
                     first->detail);
    char *text = glint_text_take(&sentence, NULL);
    t->failed |= !text;
    member(t, "detail", text);
    free(text);
}

char *glint_problem_text(const struct glint_error *err, const char *instance,
                         const char *request_id)
{
    struct glint_text t = {0};
    glint_text_add(&t, "{");
    member(&t, "type", glint_status_problem(err->status));
    member(&t, "title", glint_status_title(err->status));
    glint_text_key(&t, "status");
    glint_text_print(&t, "%d", glint_status_http(err->status));
    write_detail(&t, err);
    member(&t, "instance", instance);
    write_faults(&t, err);
    member(&t, "request_id", request_id);
    glint_text_add(&t, "}");
    return glint_text_take(&t, NULL);
}

cJSON *glint_problem_object(const struct glint_error *err, const char *instance,
                            const char *request_id)
{
    char *text = glint_problem_text(err, instance, request_id);
    cJSON *object = text ? cJSON_Parse(text) : NULL;
    free(text);
    return object;
}
