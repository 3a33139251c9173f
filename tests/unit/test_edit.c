#include "scene/edit.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

// RFC 7396, appendix A, where both sides are objects; and members whose names differ in case only.
static const struct {
    const char *target, *patch, *result;
} vectors[] = {
    {"{\"a\":\"b\"}", "{\"a\":\"c\"}", "{\"a\":\"c\"}"},
    {"{\"a\":\"b\"}", "{\"b\":\"c\"}", "{\"a\":\"b\",\"b\":\"c\"}"},
    {"{\"a\":\"b\"}", "{\"a\":null}", "{}"},
    {"{\"a\":\"b\",\"b\":\"c\"}", "{\"a\":null}", "{\"b\":\"c\"}"},
    {"{\"a\":[\"b\"]}", "{\"a\":\"c\"}", "{\"a\":\"c\"}"},
    {"{\"a\":\"c\"}", "{\"a\":[\"b\"]}", "{\"a\":[\"b\"]}"},
    {"{\"a\":{\"b\":\"c\"}}", "{\"a\":{\"b\":\"d\",\"c\":null}}", "{\"a\":{\"b\":\"d\"}}"},
    {"{\"a\":[{\"b\":\"c\"}]}", "{\"a\":[1]}", "{\"a\":[1]}"},
    {"{\"e\":null}", "{\"a\":1}", "{\"e\":null,\"a\":1}"},
    {"{}", "{\"a\":{\"bb\":{\"ccc\":null}}}", "{\"a\":{\"bb\":{}}}"},
    {"{\"a\":\"foo\"}", "{\"a\":{\"b\":1,\"c\":null}}", "{\"a\":{\"b\":1}}"},
    {"{\"a\":1,\"A\":2}", "{\"A\":null}", "{\"a\":1}"},
    {"{\"a\":1,\"A\":2}", "{\"A\":3,\"a\":{\"x\":[null]}}", "{\"a\":{\"x\":[null]},\"A\":3}"},
};

static void patches_merge_as_the_rfc_shows(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof vectors / sizeof *vectors; i++) {
        cJSON *target = cJSON_Parse(vectors[i].target), *patch = cJSON_Parse(vectors[i].patch);
        assert_ptr_equal(glint_edit_merge(target, patch), target);
        char *text = cJSON_PrintUnformatted(target);
        assert_string_equal(text, vectors[i].result);
        free(text);
        cJSON_Delete(target);
        cJSON_Delete(patch);
    }
}

// ---- edits of a scene that an import might have given

static char base_text[] =
    "{\"cameras\":{\"c\":{\"yfov\":0.5}},\"materials\":{\"m\":{\"roughness\":0.5}},"
    "\"environment\":{\"radiance\":[1,1,1]}}";
static char *base_warning[] = {(char *)"KHR_x is not read"};

#define CAMERA_ADDED "the scene has no camera: \"camera\" was added, it frames what is visible"
#define EMPTY "the scene is empty: it has no instances"
#define SKY_ADDED "nothing in the scene emits: a constant environment of radiance 1 was added"

struct fixture {
    glint_assets *assets;
    struct glint_import base;
    struct glint_edit edit;
    struct glint_scene *before;
};

static void start(struct fixture *f)
{
    *f = (struct fixture){.base = {.text = base_text,
                                   .length = strlen(base_text),
                                   .warning = base_warning,
                                   .warnings = 1}};
    assert_int_equal(glint_assets_create(&f->assets, 1 << 20, NULL), GLINT_OK);
    assert_int_equal(glint_scene_parse(&f->before, base_text, strlen(base_text), NULL, 0, NULL),
                     GLINT_OK);
    f->edit = (struct glint_edit){.import = &f->base, .scene = f->before, .assets = f->assets};
}

static void finish(struct fixture *f)
{
    struct glint_assets_stats stats;
    glint_assets_stats(f->assets, &stats);
    assert_int_equal(stats.count, 0);
    glint_scene_destroy(&f->before);
    glint_assets_destroy(&f->assets);
}

static glint_status run(struct fixture *f, const char *patch, struct glint_import **import,
                        struct glint_scene **scene, struct glint_error *err)
{
    return glint_edit_run(&f->edit, patch, strlen(patch), import, scene, err);
}

static void an_edit_gives_a_scene_and_its_canonical_text(void **state)
{
    (void)state;
    struct fixture f;
    struct glint_import *import;
    struct glint_scene *scene, *again;
    start(&f);
    assert_int_equal(run(&f, "{\"materials\":{\"m\":{\"roughness\":0.25}}}", &import, &scene, NULL),
                     GLINT_OK);
    assert_true(scene->material[0].roughness == 0.25f);
    assert_int_equal(glint_scene_parse(&again, import->text, import->length, NULL, 0, NULL),
                     GLINT_OK);
    assert_true(again->material[0].roughness == 0.25f);
    glint_scene_destroy(&again);
    glint_scene_destroy(&scene);
    glint_import_destroy(&import);
    finish(&f);
}

static void the_warnings_of_the_import_stay(void **state)
{
    (void)state;
    struct fixture f;
    struct glint_import *import;
    struct glint_scene *scene;
    start(&f);
    assert_int_equal(run(&f, "{}", &import, &scene, NULL), GLINT_OK);
    assert_int_equal(import->warnings, 2);
    assert_string_equal(import->warning[0], base_warning[0]);
    assert_string_equal(import->warning[1], EMPTY); // what the parse says
    glint_scene_destroy(&scene);
    glint_import_destroy(&import);
    finish(&f);
}

// What is left after the patch of the warnings of a scene whose camera and environment were added.
static void assert_warnings(const char *patch, size_t count, const char *const *warning)
{
    static char text[] =
        "{\"cameras\":{\"camera\":{\"yfov\":0.5}},\"materials\":{\"m\":{\"roughness\":0.5}},"
        "\"environment\":{\"radiance\":[1,1,1]}}";
    static char *given[] = {(char *)"KHR_x is not read", (char *)CAMERA_ADDED, (char *)SKY_ADDED};
    struct fixture f;
    struct glint_import *import;
    struct glint_scene *scene;
    start(&f);
    f.base = (struct glint_import){
        .text = text, .length = strlen(text), .warning = given, .warnings = 3};
    glint_scene_destroy(&f.before);
    assert_int_equal(glint_scene_parse(&f.before, text, strlen(text), NULL, 0, NULL), GLINT_OK);
    f.edit.scene = f.before;
    assert_int_equal(run(&f, patch, &import, &scene, NULL), GLINT_OK);
    assert_int_equal(import->warnings, count + 1);
    assert_string_equal(import->warning[count], EMPTY);
    for (size_t i = 0; i < count; i++)
        assert_string_equal(import->warning[i], warning[i]);
    glint_scene_destroy(&scene);
    glint_import_destroy(&import);
    finish(&f);
}

static void warnings_of_what_was_added_go_with_it(void **state)
{
    (void)state;
    static const char *const all[] = {"KHR_x is not read", CAMERA_ADDED, SKY_ADDED};
    static const char *const sky[] = {"KHR_x is not read", SKY_ADDED};
    assert_warnings("{\"materials\":{\"m\":{\"roughness\":1}}}", 3, all);
    assert_warnings("{\"environment\":null}", 3, all); // it is added again
    assert_warnings("{\"environment\":{\"rotation\":1}}", 2, all);
    assert_warnings("{\"environment\":{\"radiance\":[2,1,1]}}", 2, all);
    assert_warnings("{\"cameras\":{\"camera\":{\"yfov\":1}}}", 2, sky);
    assert_warnings("{\"cameras\":{\"camera\":null,\"eye\":{\"yfov\":1}}}", 2, sky);
}

static void a_mesh_that_an_edit_brings_becomes_an_asset_of_the_store(void **state)
{
    (void)state;
    struct fixture f;
    struct glint_import *import;
    struct glint_scene *scene;
    struct glint_assets_stats stats;
    start(&f);
    assert_int_equal(run(&f,
                         "{\"meshes\":{\"t\":{\"positions\":[0,0,0,1,0,0,0,1,0],\"indices\":[0,1,"
                         "2]}}}",
                         &import, &scene, NULL),
                     GLINT_OK);
    assert_int_equal(import->assets, 1);
    assert_string_equal(scene->mesh[0].asset, import->asset[0].sha256);
    glint_assets_stats(f.assets, &stats);
    assert_int_equal(stats.count, 1);
    glint_scene_destroy(&scene);
    glint_import_destroy(&import); // with the last reference the asset goes, which finish() checks
    finish(&f);
}

static void faults_point_into_the_edited_scene_and_leave_nothing(void **state)
{
    (void)state;
    static const struct {
        const char *patch, *pointer;
        glint_status status;
    } bad[] = {
        {"{", "", GLINT_E_SYNTAX},
        {"[]", "", GLINT_E_RANGE},
        {"null", "", GLINT_E_RANGE},
        {"{\"materials\":{\"m\":{\"roughness\":2}}}", "/materials/m/roughness", GLINT_E_RANGE},
        {"{\"materials\":7}", "/materials", GLINT_E_RANGE},
        {"{\"materials\":{\"m\":{\"a\":1},\"m\":{}}}", "/materials/m", GLINT_E_RANGE},
    };
    struct fixture f;
    start(&f);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct glint_error err = {0};
        struct glint_import *import;
        struct glint_scene *scene;
        assert_int_equal(run(&f, bad[i].patch, &import, &scene, &err), bad[i].status);
        assert_string_equal(err.fault[0].pointer, bad[i].pointer);
        assert_null(import);
        assert_null(scene);
        glint_error_finish(&err);
    }
    finish(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(patches_merge_as_the_rfc_shows),
        cmocka_unit_test(an_edit_gives_a_scene_and_its_canonical_text),
        cmocka_unit_test(the_warnings_of_the_import_stay),
        cmocka_unit_test(warnings_of_what_was_added_go_with_it),
        cmocka_unit_test(a_mesh_that_an_edit_brings_becomes_an_asset_of_the_store),
        cmocka_unit_test(faults_point_into_the_edited_scene_and_leave_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
