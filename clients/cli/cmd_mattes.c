// cmd_mattes.c - mattes and matte: what a frame holds by name, and one of it as an image.
#include "command.h"
#include "download.h"
#include "problem.h"
#include "table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_NAMES 32

// What a layer has of each class is a column, where the job has the class.
enum { FIXED = 2, DIRECT = FIXED, COLUMNS = 16 };
static const struct glint_column row[] = {
    {"NAME", "name", GLINT_COLUMN_TEXT},
    {"HASH", "hash", GLINT_COLUMN_TEXT},
    {"PIXELS", "coverage", GLINT_COLUMN_NUMBER},
    {"GLOSSY", "glossy", GLINT_COLUMN_NUMBER},
    {"REFLECTION", "reflection", GLINT_COLUMN_NUMBER},
    {"REFRACTION", "refraction", GLINT_COLUMN_NUMBER},
    {"DEPTH0", "depth0", GLINT_COLUMN_NUMBER},
    {"DEPTH1", "depth1", GLINT_COLUMN_NUMBER},
    {"DEPTH2", "depth2", GLINT_COLUMN_NUMBER},
    {"DEPTH3", "depth3", GLINT_COLUMN_NUMBER},
    {"DEPTH4", "depth4", GLINT_COLUMN_NUMBER},
    {"DEPTH5", "depth5", GLINT_COLUMN_NUMBER},
    {"DEPTH6", "depth6", GLINT_COLUMN_NUMBER},
    {"DEPTH7", "depth7", GLINT_COLUMN_NUMBER},
    {"DEPTH8", "depth8", GLINT_COLUMN_NUMBER},
    {"DEPTH9", "depth9", GLINT_COLUMN_NUMBER},
    {0},
};

static void choose_columns(const cJSON *names, struct glint_column out[COLUMNS + 1])
{
    const cJSON *first = cJSON_GetArrayItem(names, 0);
    size_t n = 0;
    for (size_t i = 0; row[i].title; i++)
        if (i <= DIRECT || cJSON_IsNumber(cJSON_GetObjectItemCaseSensitive(first, row[i].member)))
            out[n++] = row[i];
    out[n] = (struct glint_column){0};
}

static bool is_layer(const char *name)
{
    return strcmp(name, "object") == 0 || strcmp(name, "material") == 0 ||
           strcmp(name, "asset") == 0;
}

// The most that a name covers in one of the classes.
static double coverage(const void *name)
{
    const cJSON *object = *(const cJSON *const *)name;
    double most = 0;
    for (size_t i = FIXED; row[i].title; i++) {
        const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, row[i].member);
        most = cJSON_IsNumber(item) && item->valuedouble > most ? item->valuedouble : most;
    }
    return most;
}

static int by_coverage(const void *a, const void *b)
{
    return (coverage(a) < coverage(b)) - (coverage(a) > coverage(b));
}

// The daemon lists every name of the scene; people want those that are in the picture, the largest
// first. The list refers to `names`.
static cJSON *seen(const cJSON *names)
{
    cJSON *list = cJSON_CreateArray();
    const cJSON **order = calloc((size_t)cJSON_GetArraySize(names) + 1, sizeof *order), *name;
    size_t count = 0;
    cJSON_ArrayForEach(name, names)
        if (order && coverage(&name) > 0)
            order[count++] = name;
    if (order)
        qsort(order, count, sizeof *order, by_coverage);
    for (size_t i = 0; i < count; i++)
        cJSON_AddItemReferenceToArray(list, (cJSON *)(uintptr_t)order[i]);
    free(order);
    return list;
}

static void print_layers(const cJSON *layers, const char *wanted)
{
    const cJSON *layer;
    cJSON_ArrayForEach(layer, layers) {
        if (wanted && strcmp(layer->string, wanted) != 0)
            continue;
        const cJSON *names = cJSON_GetObjectItemCaseSensitive(layer, "names");
        struct glint_column column[COLUMNS + 1];
        choose_columns(names, column);
        cJSON *list = seen(names);
        glint_print_plain(stdout, layer->string);
        puts(":");
        glint_table_print(column, list);
        cJSON_Delete(list);
    }
}

static glint_status run_mattes(struct glint_session *s, const struct glint_arguments *a,
                               struct glint_error *err)
{
    const char *layer = glint_options_text(a, "layer");
    if (layer && !is_layer(layer))
        return glint_session_usage(s, err, "--layer wants object, material or asset");
    cJSON *mattes = NULL;
    glint_status status = glint_session_open(s, a, false, err);
    if (!status)
        status = glint_client_get(s->client, "/v1/jobs/", a->text[0], "/mattes", &mattes, err);
    if (status)
        return status;
    if (s->json) {
        glint_session_print(mattes);
    } else {
        print_layers(cJSON_GetObjectItemCaseSensitive(mattes, "layers"), layer);
        cJSON_Delete(mattes);
    }
    return GLINT_OK;
}

static glint_status check(struct glint_session *s, const struct glint_arguments *a,
                          struct glint_error *err)
{
    const char *file = glint_options_text(a, "output"), *layer = glint_options_text(a, "layer");
    if (!file || !glint_options_text(a, "name"))
        return glint_session_usage(s, err, "matte wants --name NAME and -o FILE");
    if (!glint_download_kind(file))
        return glint_session_usage(s, err, "%s: mattes are .exr or .png", file);
    if (layer && !is_layer(layer))
        return glint_session_usage(s, err, "--layer wants object, material or asset");
    return GLINT_OK;
}

static char *matte_path(const struct glint_arguments *a)
{
    const char *name[MAX_NAMES];
    const char *file = glint_options_text(a, "output"), *layer = glint_options_text(a, "layer");
    const bool exr = strcmp(glint_download_kind(file), "exr") == 0;
    char *path = glint_client_path("/v1/jobs/", a->text[0], exr ? "/matte.exr" : "/matte.png");
    path = glint_client_query(path, "layer", layer ? layer : "object");
    const char *through = glint_options_text(a, "through");
    if (through)
        path = glint_client_query(path, "through", through);
    const size_t names = glint_options_all(a, "name", name, MAX_NAMES);
    for (size_t i = 0; i < names; i++)
        path = glint_client_query(path, "name", name[i]);
    return path;
}

static glint_status run_matte(struct glint_session *s, const struct glint_arguments *a,
                              struct glint_error *err)
{
    const char *file = glint_options_text(a, "output");
    uint64_t size;
    glint_status status = check(s, a, err);
    if (!status)
        status = glint_session_open(s, a, false, err);
    if (status)
        return status;
    char *path = matte_path(a);
    status = path ? glint_download_file(s, path, file, &size, err)
                  : glint_fail(err, GLINT_E_NOMEM, "", "no memory");
    free(path);
    if (!status)
        glint_download_report(s, file, size);
    return status;
}

static const struct glint_option mattes_options[] = {
    {"layer", 'l', "LAYER", "only object, material or asset"},
    {0},
};

static const struct glint_option matte_options[] = {
    {"layer", 'l', "LAYER", "object (the default), material or asset"},
    {"name", 'n', "NAME", "what to show; repeated, their union"},
    {"through", 0, "CLASSES",
     "with commas between: primary (the default), glossy, reflection, refraction, depth0, .."},
    {"output", 'o', "FILE", "where to, .exr or .png"},
    {0},
};

const struct glint_command glint_command_mattes = {
    .name = "mattes",
    .operands = "JOB",
    .summary = "List the names in a frame and their coverage",
    .detail = "What bounces bring has columns of its own, by class. Names that cover nothing\n"
              "are left out; --json has them all.",
    .options = mattes_options,
    .least = 1,
    .most = 1,
    .run = run_mattes,
};

const struct glint_command glint_command_matte = {
    .name = "matte",
    .operands = "JOB",
    .summary = "Download the matte of one or more names",
    .options = matte_options,
    .least = 1,
    .most = 1,
    .run = run_matte,
};
