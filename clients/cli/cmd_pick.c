// cmd_pick.c - pick: what is under a pixel.
#include "command.h"
#include "problem.h"
#include "table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST_PIXELS 16383

static const struct glint_column row[] = {
    {"NAME", "name", GLINT_COLUMN_TEXT},
    {"HASH", "hash", GLINT_COLUMN_TEXT},
    {"COVERAGE", "coverage", GLINT_COLUMN_PERCENT},
    {0},
};

// Takes the layers but `wanted` out of every class of the answer (`primary` and what else there is).
static void keep_layer(cJSON *pick, const char *wanted)
{
    for (cJSON *class = pick->child; class && wanted; class = class->next) {
        cJSON *layer = cJSON_IsObject(class) ? class->child : NULL;
        for (cJSON *next; layer; layer = next) {
            next = layer->next;
            if (strcmp(layer->string, wanted) != 0)
                cJSON_Delete(cJSON_DetachItemViaPointer(class, layer));
        }
    }
}

static void print_pick(const cJSON *pick)
{
    const cJSON *class, *layer;
    cJSON_ArrayForEach(class, pick) {
        if (!cJSON_IsObject(class))
            continue;
        cJSON_ArrayForEach(layer, class) {
            if (strcmp(class->string, "primary") != 0)
                glint_print_plain(stdout, class->string), putchar(' ');
            glint_print_plain(stdout, layer->string);
            puts(cJSON_GetArraySize(layer) ? ":" : ": nothing");
            if (cJSON_GetArraySize(layer))
                glint_table_print(row, layer);
        }
    }
}

static glint_status fetch(struct glint_session *s, const struct glint_arguments *a, cJSON **pick,
                          struct glint_error *err)
{
    char *path = glint_client_path("/v1/jobs/", a->text[0], "/pick");
    path = glint_client_query(path, "x", a->text[1]);
    path = glint_client_query(path, "y", a->text[2]);
    if (!path)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory");
    const struct glint_request request = {.method = "GET", .path = path};
    const glint_status status = glint_client_json(s->client, &request, pick, err);
    free(path);
    return status;
}

static glint_status check(struct glint_session *s, const struct glint_arguments *a,
                          struct glint_error *err)
{
    uint64_t value;
    glint_status status = GLINT_OK;
    const char *layer = glint_options_text(a, "layer");
    if (layer && strcmp(layer, "object") != 0 && strcmp(layer, "material") != 0 &&
        strcmp(layer, "asset") != 0)
        status = glint_session_usage(s, err, "--layer wants object, material or asset");
    for (int i = 1; i < 3; i++)
        if (!glint_read_unsigned(a->text[i], 0, MOST_PIXELS, &value))
            status = glint_session_usage(s, err,
                                         "%c is a pixel, a whole number from 0 to %d, not "
                                         "'%s'",
                                         "XY"[i - 1], MOST_PIXELS, a -> text[i]);
    return status;
}

static glint_status run_pick(struct glint_session *s, const struct glint_arguments *a,
                             struct glint_error *err)
{
    cJSON *pick = NULL;
    glint_status status = check(s, a, err);
    if (!status)
        status = glint_session_open(s, a, false, err);
    if (!status)
        status = fetch(s, a, &pick, err);
    if (status)
        return status;
    keep_layer(pick, glint_options_text(a, "layer"));
    if (s->json) {
        glint_session_print(pick);
    } else {
        print_pick(pick);
        cJSON_Delete(pick);
    }
    return GLINT_OK;
}

static const struct glint_option options[] = {
    {"layer", 'l', "LAYER", "only object, material or asset"},
    {0},
};

const struct glint_command glint_command_pick = {
    .name = "pick",
    .operands = "JOB X Y",
    .summary = "Name what is under a pixel of a frame",
    .detail = "X counts from the left, Y from the top, from 0 on, in the whole frame also\n"
              "where only a region of it is rendered. Coverages are shares of the pixel.",
    .options = options,
    .least = 3,
    .most = 3,
    .run = run_pick,
};
