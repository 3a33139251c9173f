#include "problem.h"

#include <string.h>

glint_status glint_problem_status(long http)
{
    if (http >= 200 && http < 300)
        return GLINT_OK;
    if (http == 429)
        return GLINT_E_BUSY;
    if (http == 500)
        return GLINT_E_INTERNAL;
    for (int s = GLINT_OK + 1; s < GLINT_STATUS_COUNT; s++)
        if (glint_status_http((glint_status)s) == http)
            return (glint_status)s;
    return http >= 400 && http < 500 ? GLINT_E_RANGE : GLINT_E_INTERNAL;
}

static const char *text_of(const cJSON *object, const char *name)
{
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(object, name));
    return text && *text ? text : NULL;
}

void glint_problem_faults(const cJSON *problem, glint_status status, struct glint_error *err)
{
    size_t named = 0;
    const cJSON *fault;
    cJSON_ArrayForEach(fault, cJSON_GetObjectItemCaseSensitive(problem, "errors")) {
        const char *pointer = text_of(fault, "pointer"), *detail = text_of(fault, "detail");
        if (!detail)
            continue;
        glint_fail(err, status, pointer ? pointer : "", "%s", detail);
        named++;
    }
    if (named)
        return;
    const char *detail = text_of(problem, "detail");
    const char *title = text_of(problem, "title");
    glint_fail(err, status, "", "%s", detail ? detail : title ? title : glint_status_title(status));
}

glint_status glint_problem_read(long http, const char *body, size_t length, struct glint_error *err)
{
    const glint_status status = glint_problem_status(http);
    cJSON *problem = cJSON_ParseWithLength(body, length);
    if (cJSON_IsObject(problem))
        glint_problem_faults(problem, status, err);
    else
        glint_fail(err, status, "", "the server answered %ld", http);
    cJSON_Delete(problem);
    return status;
}

cJSON *glint_problem_write(const struct glint_error *err)
{
    cJSON *problem = cJSON_CreateObject();
    cJSON_AddStringToObject(problem, "type", glint_status_problem(err->status));
    cJSON_AddStringToObject(problem, "title", glint_status_title(err->status));
    cJSON_AddNumberToObject(problem, "status", glint_status_http(err->status));
    cJSON_AddStringToObject(problem, "detail", glint_error_text(err));
    cJSON *errors = cJSON_AddArrayToObject(problem, "errors");
    for (size_t i = 0; i < err->count; i++) {
        cJSON *fault = cJSON_CreateObject();
        cJSON_AddStringToObject(fault, "pointer", err->fault[i].pointer);
        cJSON_AddStringToObject(fault, "detail", err->fault[i].detail);
        cJSON_AddItemToArray(errors, fault);
    }
    return problem;
}

void glint_problem_print(FILE *out, const struct glint_error *err)
{
    for (size_t i = 0; i < err->count; i++) {
        fputs("glint: ", out);
        if (err->fault[i].pointer[0]) {
            glint_print_plain(out, err->fault[i].pointer);
            fputs(": ", out);
        }
        glint_print_plain(out, err->fault[i].detail);
        fputc('\n', out);
    }
}

void glint_print_plain(FILE *out, const char *text)
{
    for (const unsigned char *c = (const unsigned char *)text; *c; c++) {
        // U+0080..U+009F are control characters too: C2 80..9F in UTF-8.
        if (c[0] == 0xc2 && c[1] >= 0x80 && c[1] <= 0x9f)
            fputc('?', out), c++;
        else
            fputc(*c < 0x20 || *c == 0x7f ? '?' : *c, out);
    }
}
