// cmd_accuracy.c - accuracy: what each approximation costs and saves, measured on one scene.
#include "accuracy_ask.h"
#include "accuracy_files.h"
#include "accuracy_render.h"
#include "accuracy_report.h"
#include "accuracy_same.h"
#include "command.h"
#include "upload.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// What the daemon says before anything is measured.
struct ground {
    cJSON *capabilities, *scene, *plan; // of GET /v1; the scene's resource; of the exact twin
    char build[64];
};

static const cJSON *member(const cJSON *object, const char *name)
{
    return cJSON_GetObjectItemCaseSensitive(object, name);
}

static const char *text_of(const cJSON *object, const char *name)
{
    const char *text = cJSON_GetStringValue(member(object, name));
    return text ? text : "";
}

static void ground_finish(struct ground *g)
{
    cJSON_Delete(g->capabilities);
    cJSON_Delete(g->scene);
    cJSON_Delete(g->plan);
}

// Commas would cut a row of the table.
static void name_build(struct ground *g)
{
    snprintf(g->build, sizeof g->build, "glint %.40s", text_of(g->capabilities, "version"));
    for (char *p = g->build; *p; p++)
        *p = *p == ',' ? ' ' : *p;
}

static glint_status find_ground(struct ground *out, struct glint_session *s,
                                const struct glint_accuracy_ask *ask, struct glint_error *err)
{
    glint_status st =
        ask->file ? glint_upload_scene(s, ask->file, ask->scene, &out->scene, err)
                  : glint_client_get(s->client, "/v1/scenes/", ask->scene, "", &out->scene, err);
    if (!st)
        st = glint_client_get(s->client, "/v1", NULL, "", &out->capabilities, err);
    if (st)
        return st;
    name_build(out);
    if (!member(out->capabilities, "knobs"))
        return glint_fail(err, GLINT_E_UNAVAILABLE, "", "the daemon tells nothing of its dials");
    cJSON *twin = glint_accuracy_twin(out->capabilities, ask->base, true);
    st = glint_accuracy_ask_plan(s, twin, &out->plan, err);
    cJSON_Delete(twin);
    return st;
}

static glint_status put_front(struct glint_session *s, const struct glint_accuracy_ask *ask,
                              cJSON *front, struct glint_error *err)
{
    char *path = glint_client_path("/v1/scenes/", ask->scene, "/front");
    char *text = cJSON_PrintUnformatted(front);
    glint_status st = GLINT_E_NOMEM;
    if (path && text) {
        const struct glint_body body = {
            .type = "application/json", .bytes = (const uint8_t *)text, .size = strlen(text)};
        const struct glint_request request = {.method = "PUT", .path = path, .body = &body};
        st = glint_client_send(s->client, &request, NULL, err);
    } else {
        glint_fail(err, st, "", "no memory for the front");
    }
    free(text);
    free(path);
    return st;
}

// Keeps the front beside the report and, where there are settings to pick from, puts it: to a daemon
// that stays.
static glint_status publish(struct glint_accuracy_run *run, const struct glint_accuracy_sum *sum,
                            const struct glint_accuracy_ask *ask, const struct ground *g,
                            struct glint_error *err)
{
    cJSON *front = glint_accuracy_front(run, sum, text_of(g->scene, "revision"));
    const bool some = cJSON_GetArraySize(member(front, "points")) > 0;
    char *text = cJSON_Print(front);
    struct glint_text out = {0};
    glint_text_add(&out, text ? text : "");
    glint_text_add(&out, "\n");
    glint_status st = glint_accuracy_save(ask->folder, "front.json", &out, err);
    if (!st && some && ask->publish && !run->session->daemon)
        st = put_front(run->session, ask, front, err);
    free(text);
    cJSON_Delete(front);
    return st;
}

static glint_status report(struct glint_accuracy_run *run, const struct glint_accuracy_ask *ask,
                           const struct ground *g, struct glint_error *err)
{
    struct glint_accuracy_sum *sum = NULL;
    cJSON *plots = NULL;
    glint_status st = glint_accuracy_sum_up(&sum, run, err);
    if (!st)
        st = glint_accuracy_add_means(run, sum, err);
    if (!st)
        st = glint_accuracy_table_write(&run->table, run->folder, err);
    if (!st)
        st = glint_accuracy_draw(run, sum, &plots, err);
    if (!st)
        st = glint_accuracy_show_differences(run, err);
    if (!st)
        st = glint_accuracy_write_pages(run, sum, g->capabilities, plots, err);
    if (!st)
        st = publish(run, sum, ask, g, err);
    cJSON_Delete(plots);
    free(sum);
    return st;
}

static void tell(const struct glint_session *s, const struct glint_accuracy_ask *ask,
                 const struct glint_accuracy_run *run)
{
    if (!s->json) {
        printf("%s/index.html: %zu settings, %zu rows\n", ask->folder, run->plan->settings,
               run->table.rows);
        if (s->daemon && ask->publish)
            printf("%s/front.json was put to no daemon: the private one ends now\n", ask->folder);
        return;
    }
    cJSON *document = cJSON_CreateObject();
    cJSON_AddStringToObject(document, "folder", ask->folder);
    cJSON_AddStringToObject(document, "scene", ask->scene);
    cJSON_AddNumberToObject(document, "settings", (double)run->plan->settings);
    cJSON_AddNumberToObject(document, "rows", (double)run->table.rows);
    glint_session_print(document);
}

static unsigned workers_of(const cJSON *capabilities)
{
    const cJSON *devices = member(capabilities, "devices");
    const cJSON *workers = member(devices ? devices->child : NULL, "workers");
    return cJSON_IsNumber(workers) ? (unsigned)workers->valuedouble : 0;
}

// What all rows of a report have in common.
static glint_status check_folder(const struct glint_accuracy_ask *ask, const struct ground *g,
                                 struct glint_error *err)
{
    static const char *const parts[] = {"camera", "resolution"};
    cJSON *programme = cJSON_CreateObject();
    cJSON_AddStringToObject(programme, "scene", ask->scene);
    cJSON_AddStringToObject(programme, "revision", text_of(g->scene, "revision"));
    cJSON_AddStringToObject(programme, "build", g->build);
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        const cJSON *part = member(ask->base, parts[i]);
        cJSON_AddItemToObject(programme, parts[i],
                              part ? cJSON_Duplicate(part, true) : cJSON_CreateNull());
    }
    const glint_status st = glint_accuracy_same(ask->folder, programme, err);
    cJSON_Delete(programme);
    return st;
}

static glint_status measure(struct glint_session *s, const struct glint_accuracy_ask *ask,
                            const struct ground *g, const struct glint_accuracy_plan *plan,
                            struct glint_error *err)
{
    struct glint_accuracy_run run = {.session = s,
                                     .plan = plan,
                                     .folder = ask->folder,
                                     .scene = ask->scene,
                                     .build = g->build,
                                     .threads = workers_of(g->capabilities),
                                     .width = ask->width,
                                     .height = ask->height,
                                     .seeds = ask->seeds,
                                     .steps = ask->steps,
                                     .reference_samples = ask->reference_samples};
    memcpy(run.ladder, ask->ladder, sizeof run.ladder);
    glint_status st = glint_accuracy_folders(ask->folder, err);
    if (!st)
        st = check_folder(ask, g, err);
    if (!st)
        st = glint_accuracy_table_read(&run.table, ask->folder, err);
    if (!st)
        st = glint_accuracy_run(&run, err);
    if (!st)
        st = report(&run, ask, g, err);
    if (!st)
        tell(s, ask, &run);
    glint_accuracy_run_finish(&run);
    return st;
}

static glint_status programme(struct glint_session *s, const struct glint_accuracy_ask *ask,
                              struct glint_error *err)
{
    struct ground g = {0};
    struct glint_accuracy_plan plan = {0};
    glint_status st = find_ground(&g, s, ask, err);
    const struct glint_accuracy_wish wish = {g.capabilities, g.plan, ask->base, ask->dials};
    if (!st)
        st = glint_accuracy_plan_make(&plan, &wish, err);
    if (!st && !plan.settings)
        st = glint_fail(err, GLINT_E_RANGE, "", "the scene calls for none of these dials");
    if (!st)
        st = measure(s, ask, &g, &plan, err);
    glint_accuracy_plan_finish(&plan);
    ground_finish(&g);
    return st;
}

static glint_status run_accuracy(struct glint_session *s, const struct glint_arguments *a,
                                 struct glint_error *err)
{
    struct glint_accuracy_ask ask;
    glint_status st = glint_accuracy_ask(&ask, s, a, err);
    if (!st)
        st = glint_session_open(s, a, ask.spawn, err);
    if (!st)
        st = programme(s, &ask, err);
    glint_accuracy_ask_finish(&ask);
    return st;
}

const struct glint_command glint_command_accuracy = {
    .name = "accuracy",
    .operands = "SCENE",
    .summary = "Measure what each approximation costs and saves",
    .detail = "SCENE is a file, which is uploaded, or the name of a scene that the daemon has.\n"
              "Every dial that the scene calls for is rendered against its exact twin, and a\n"
              "report is written: tables, plots of error against cost, differences, failures.\n"
              "A run that was broken off goes on where it stopped. The front that is found is\n"
              "put to the daemon, which picks the settings of jobs from it that say what they\n"
              "may take or must reach (accuracy.time, accuracy.error).",
    .options = glint_accuracy_options,
    .least = 1,
    .most = 1,
    .run = run_accuracy,
};
