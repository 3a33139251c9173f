// The published schemas against the tables that the parsers walk.
#include "protocol/job_parts.h"
#include "protocol/scene_parts.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct glint_json_limits roomy = {.bytes = 1u << 20, .depth = 64, .values = 1u << 16};

static char *slurp(const char *path)
{
    const char *top = getenv("top_srcdir");
    char full[4096];
    snprintf(full, sizeof full, "%s/protocol/%s", top ? top : ".", path);
    FILE *f = fopen(full, "rb");
    if (!f)
        fail_msg("cannot open %s", full);
    char *text = calloc(1, 1u << 20);
    assert_true(fread(text, 1, (1u << 20) - 1, f) > 0);
    fclose(f);
    return text;
}

static cJSON *load(const char *path)
{
    char *text = slurp(path);
    cJSON *tree;
    struct glint_error err = {0};
    if (glint_json_parse(&tree, text, strlen(text), &roomy, &err))
        fail_msg("%s: %s", path, glint_error_text(&err));
    free(text);
    return tree;
}

// Follows "a/b/c" down objects.
static const cJSON *at(const cJSON *tree, const char *path)
{
    char copy[256], *rest = copy;
    snprintf(copy, sizeof copy, "%s", path);
    for (char *key; (key = strsep(&rest, "/"));) {
        tree = cJSON_GetObjectItemCaseSensitive(tree, key);
        if (!tree)
            fail_msg("%s is not in the schema", path);
    }
    return tree;
}

static void assert_enum(const cJSON *schema, const char *path, const char *const *names)
{
    const cJSON *list = at(at(schema, path), "enum");
    size_t n = 0;
    for (const cJSON *c = list->child; c; c = c->next, n++) {
        assert_non_null(names[n]);
        assert_string_equal(c->valuestring, names[n]);
    }
    assert_null(names[n]);
}

static void dials_and_presets_are_those_of_the_table(void **state)
{
    (void)state;
    cJSON *job = load("schema/job.json");
    char path[128];
    int members = 3; // the preset, time and error
    for (int d = 0; d < GLINT_DIAL_COUNT; d++) {
        const struct glint_dial_row *row = &glint_dial_table[d];
        snprintf(path, sizeof path, "properties/%s/properties/%s", row->parent, row->name);
        assert_enum(job, path, row->setting);
        members += strcmp(row->parent, "accuracy") == 0;
    }
    assert_int_equal(cJSON_GetArraySize(at(job, "properties/accuracy/properties")), members);
    const char *presets[8] = {NULL};
    for (size_t i = 0; i < glint_preset_count; i++)
        presets[i] = glint_preset_table[i].name;
    assert_enum(job, "properties/accuracy/properties/preset", presets);
    cJSON_Delete(job);
}

static void outputs_are_those_that_have_a_name(void **state)
{
    (void)state;
    cJSON *job = load("schema/job.json");
    const char *names[33] = {NULL};
    for (int bit = 0, n = 0; bit < 32; bit++)
        if (glint_output_name(1u << bit))
            names[n++] = glint_output_name(1u << bit);
    assert_enum(job, "properties/outputs/items", names);
    cJSON_Delete(job);
}

static void assert_same_number(const cJSON *schema, const char *key, double value)
{
    const cJSON *number = cJSON_GetObjectItemCaseSensitive(schema, key);
    if (number && (float)number->valuedouble != (float)value)
        fail_msg("%s of %s: %g, %g", key, schema->string, number->valuedouble, value);
}

// The members are those of the table, and numbers have its bounds where they state their own.
static void assert_members(const cJSON *schema, const char *path, const struct glint_field *fields)
{
    const cJSON *properties = at(schema, path);
    int n = 0;
    for (; fields->kind; fields++, n++) {
        const cJSON *p = at(properties, fields->name);
        if (fields->choices) {
            assert_enum(properties, fields->name, fields->choices);
        } else if (fields->kind <= GLINT_FIELD_INT && !fields->count) {
            assert_same_number(p, "minimum", fields->low);
            assert_same_number(p, "maximum", fields->high);
        }
    }
    if (cJSON_GetArraySize(properties) != n)
        fail_msg("%s: %d members, %d in the table", path, cJSON_GetArraySize(properties), n);
}

static void members_are_those_that_the_parsers_know(void **state)
{
    (void)state;
    cJSON *job = load("schema/job.json"), *scene = load("schema/scene.json");
    assert_members(job, "properties", glint_job_fields);
    assert_members(job, "properties/filter/properties", glint_filter_fields);
    assert_members(job, "properties/stop/properties", glint_stop_fields);
    assert_members(scene, "$defs/material/properties", glint_material_fields);
    assert_members(scene, "$defs/texture/properties", glint_texture_fields);
    assert_members(scene, "$defs/object/properties", glint_object_fields);
    assert_members(scene, "$defs/instance/properties", glint_instance_fields);
    assert_members(scene, "$defs/light/properties", glint_light_fields);
    assert_members(scene, "$defs/camera/properties", glint_camera_fields);
    assert_members(scene, "$defs/node/properties", glint_node_fields);
    assert_members(scene, "$defs/skin/properties", glint_skin_fields);
    assert_members(scene, "$defs/animation/properties", glint_animation_fields);
    assert_members(scene, "$defs/channel/properties", glint_channel_fields);
    assert_members(scene, "$defs/medium/properties", glint_medium_fields);
    assert_members(scene, "$defs/environment/properties", glint_environment_fields);
    assert_members(scene, "properties", glint_scene_fields);
    cJSON_Delete(job);
    cJSON_Delete(scene);
}

// The fifth kind of mesh is an asset.
static void attributes_are_those_of_the_table(void **state)
{
    (void)state;
    cJSON *scene = load("schema/scene.json");
    const cJSON *mesh = cJSON_GetArrayItem(at(scene, "$defs/mesh/oneOf"), 4);
    assert_enum(mesh, "properties/attributes/items", glint_mesh_attribute_names);
    assert_enum(mesh, "properties/target_attributes/items", glint_target_attribute_names);
    cJSON_Delete(scene);
}

static void the_examples_are_accepted(void **state)
{
    (void)state;
    struct glint_error err = {0};
    struct glint_scene *scene;
    struct glint_job *job;
    char *text = slurp("examples/scene.json");
    if (glint_scene_parse(&scene, text, strlen(text), NULL, 0, &err))
        fail_msg("%s: %s", err.fault[0].pointer, err.fault[0].detail);
    assert_int_equal(scene->warnings, 0);
    free(text);
    text = slurp("examples/job.json");
    if (glint_job_parse(&job, text, strlen(text), &err))
        fail_msg("%s: %s", err.fault[0].pointer, err.fault[0].detail);
    assert_string_equal(job->camera_name, scene->camera[0].id);
    free(text);
    glint_scene_destroy(&scene);
    glint_job_destroy(&job);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(dials_and_presets_are_those_of_the_table),
        cmocka_unit_test(outputs_are_those_that_have_a_name),
        cmocka_unit_test(members_are_those_that_the_parsers_know),
        cmocka_unit_test(attributes_are_those_of_the_table),
        cmocka_unit_test(the_examples_are_accepted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
