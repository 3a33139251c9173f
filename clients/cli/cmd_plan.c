// cmd_plan.c - plan: what a job simulates, why, and what it costs.
#include "command.h"
#include "table.h"

#include <stdio.h>

static const struct glint_column row[] = {
    {"EFFECT", "effect", GLINT_COLUMN_TEXT}, {"ON", "on", GLINT_COLUMN_TEXT},
    {"TIME", "share", GLINT_COLUMN_PERCENT}, {"MEMORY", "bytes", GLINT_COLUMN_BYTES},
    {"REASON", "reason", GLINT_COLUMN_TEXT}, {0},
};

static const struct glint_column pass[] = {
    {"PASS", "pass", GLINT_COLUMN_TEXT},
    {"TIME", "share", GLINT_COLUMN_PERCENT},
    {"SECONDS", "seconds", GLINT_COLUMN_SECONDS},
    {0},
};

static const struct glint_column whole[] = {
    {"film", "film_bytes", GLINT_COLUMN_BYTES},
    {"program", "program", GLINT_COLUMN_TEXT},
    {0},
};

static void print_plan(const cJSON *plan)
{
    glint_table_print(row, cJSON_GetObjectItemCaseSensitive(plan, "effects"));
    putchar('\n');
    glint_table_print(pass, cJSON_GetObjectItemCaseSensitive(plan, "passes"));
    putchar('\n');
    glint_table_print_one(whole, plan);
}

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
        print_plan(plan);
        cJSON_Delete(plan);
    }
    return GLINT_OK;
}

const struct glint_command glint_command_plan = {
    .name = "plan",
    .operands = "JOB",
    .summary = "Show what a job simulates, why, and its cost",
    .least = 1,
    .most = 1,
    .run = run_plan,
};
