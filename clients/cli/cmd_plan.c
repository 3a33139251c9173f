// cmd_plan.c - plan: what a job simulates, why, and what it costs.
#include "command.h"
#include "table.h"

static const struct glint_column row[] = {
    {"EFFECT", "name", GLINT_COLUMN_TEXT},   {"ON", "on", GLINT_COLUMN_TEXT},
    {"TIME", "share", GLINT_COLUMN_PERCENT}, {"MEMORY", "bytes", GLINT_COLUMN_BYTES},
    {"REASON", "reason", GLINT_COLUMN_TEXT}, {0},
};

static glint_status run_plan(struct glint_session *s, const struct glint_arguments *a,
                             struct glint_error *err)
{
    cJSON *plan = NULL;
    glint_status status = glint_session_open(s, a, false, err);
    if (!status)
        status = glint_client_get(s->client, "/v1/jobs/", a->text[0], "/plan", &plan, err);
    if (status)
        return status;
    if (s->json) {
        glint_session_print(plan);
    } else {
        glint_table_print(row, cJSON_GetObjectItemCaseSensitive(plan, "effects"));
        cJSON_Delete(plan);
    }
    return GLINT_OK;
}

const struct glint_command glint_command_plan = {
    .name = "plan", .operands = "JOB", .summary = "Show what a job simulates, why, and its cost",
    .least = 1, .most = 1, .run = run_plan,
};
