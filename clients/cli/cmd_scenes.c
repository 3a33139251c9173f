// cmd_scenes.c - put and scenes.
#include "command.h"
#include "problem.h"
#include "table.h"
#include "upload.h"

#include <stdlib.h>

static const struct glint_column row[] = {
    {"NAME", "name", GLINT_COLUMN_TEXT},
    {"REVISION", "revision", GLINT_COLUMN_HASH},
    {"TRIANGLES", "triangles", GLINT_COLUMN_TEXT},
    {"INSTANCES", "instances", GLINT_COLUMN_TEXT},
    {"MATERIALS", "materials", GLINT_COLUMN_TEXT},
    {"LIGHTS", "lights", GLINT_COLUMN_TEXT},
    {"MEMORY", "resident_bytes", GLINT_COLUMN_BYTES},
    {0},
};

static const struct glint_column one[] = {
    {"name", "name", GLINT_COLUMN_TEXT},
    {"revision", "revision", GLINT_COLUMN_TEXT},
    {"triangles", "triangles", GLINT_COLUMN_TEXT},
    {"instances", "instances", GLINT_COLUMN_TEXT},
    {"objects", "objects", GLINT_COLUMN_TEXT},
    {"materials", "materials", GLINT_COLUMN_TEXT},
    {"lights", "lights", GLINT_COLUMN_TEXT},
    {"memory", "resident_bytes", GLINT_COLUMN_BYTES},
    {0},
};

static void print_scene(struct glint_session *s, cJSON *scene)
{
    if (s->json) {
        glint_session_print(scene);
        return;
    }
    glint_table_print_one(one, scene);
    glint_table_print_texts("camera", cJSON_GetObjectItemCaseSensitive(scene, "cameras"));
    glint_table_print_texts("animation", cJSON_GetObjectItemCaseSensitive(scene, "animations"));
    glint_table_print_texts("warning", cJSON_GetObjectItemCaseSensitive(scene, "warnings"));
    cJSON_Delete(scene);
}

static glint_status run_put(struct glint_session *s, const struct glint_arguments *a,
                            struct glint_error *err)
{
    const char *name = glint_options_text(a, "name");
    char made[129];
    if (!name) {
        glint_upload_name(a->text[0], made);
        name = made;
    }
    cJSON *scene = NULL;
    glint_status status = glint_session_open(s, a, false, err);
    if (!status)
        status = glint_upload_scene(s, a->text[0], name, &scene, err);
    if (!status)
        print_scene(s, scene);
    return status;
}

static glint_status run_scenes(struct glint_session *s, const struct glint_arguments *a,
                               struct glint_error *err)
{
    cJSON *list, *scene;
    glint_status status = glint_session_open(s, a, false, err);
    if (status)
        return status;
    if (a->count) {
        status = glint_client_get(s->client, "/v1/scenes/", a->text[0], "", &scene, err);
        if (!status)
            print_scene(s, scene);
        return status;
    }
    status = glint_client_get(s->client, "/v1/scenes", NULL, NULL, &list, err);
    if (status)
        return status;
    if (s->json) {
        glint_session_print(list);
    } else {
        glint_table_print(row, cJSON_GetObjectItemCaseSensitive(list, "scenes"));
        cJSON_Delete(list);
    }
    return GLINT_OK;
}

static const struct glint_option put_options[] = {
    {"name", 'n', "NAME", "the scene's name (the file's, without extension)"},
    {0},
};

const struct glint_command glint_command_put = {
    .name = "put",
    .operands = "FILE",
    .summary = "Upload a scene, or replace it",
    .detail = "FILE is .glb, .gltf or .obj (with the files that it names), .ply, .stl or\n"
              "native .json.",
    .options = put_options,
    .least = 1,
    .most = 1,
    .run = run_put,
};

const struct glint_command glint_command_scenes = {
    .name = "scenes",
    .operands = "[SCENE]",
    .summary = "List the scenes, or describe one",
    .most = 1,
    .run = run_scenes,
};
