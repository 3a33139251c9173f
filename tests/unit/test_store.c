#include "base/thread.h"
#include "fake_scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#define ITEMS                                                                                  \
    "\"cameras\": {\"c\": {\"name\": \"Front\", \"yfov\": 0.5}}, \"materials\": {\"m\": {}}, " \
    "\"meshes\": {\"q\": {\"primitive\": \"quad\"}}, "                                         \
    "\"instances\": {\"i\": {\"mesh\": \"q\", \"material\": \"m\"}}"
static const char one[] = "{" ITEMS ", \"environment\": {\"radiance\": [1, 1, 1]}}";
static const char two[] = "{" ITEMS ", \"environment\": {\"radiance\": [2, 2, 2]}}";
static const char dark[] = "{" ITEMS "}"; // gets an environment, with a warning

static glint_store *make(void)
{
    const struct glint_import_limits limits = {1 << 20, 1};
    glint_store *store;
    assert_int_equal(glint_store_create(&store, NULL, NULL, &limits, NULL, NULL), GLINT_OK);
    return store;
}

static void finish(glint_store *store)
{
    glint_store_destroy(&store);
    assert_null(store);
    assert_int_equal(fake_scene_residents(), 0);
    assert_int_equal(fake_scene_imports(), 0);
}

static glint_status put_if(glint_store *store, const char *name, const char *text,
                           const char *if_match, glint_revision **out, bool *created)
{
    struct glint_error err = {0};
    const glint_status st = glint_store_put(
        store, name,
        &(struct glint_import_source){
            .type = GLINT_SCENE_NATIVE, .bytes = (const uint8_t *)text, .size = strlen(text)},
        if_match, out, created, &err);
    assert_int_equal(err.status, st);
    glint_error_finish(&err);
    return st;
}

static glint_revision *put(glint_store *store, const char *name, const char *text)
{
    glint_revision *revision;
    bool created;
    assert_int_equal(put_if(store, name, text, NULL, &revision, &created), GLINT_OK);
    return revision;
}

static void drop(glint_revision *revision)
{
    glint_revision_release(&revision);
    assert_null(revision);
}

static glint_status delete (glint_store *store, const char *name, const char *if_match, bool force)
{
    return glint_store_delete(store, name, if_match, force, NULL);
}

static void the_revision_is_the_hash_of_the_canonical_text(void **state)
{
    (void)state;
    glint_store *store = make();
    glint_revision *revision = put(store, "a", "{}");
    // printf '{}' | sha256sum
    assert_string_equal(glint_revision_id(revision),
                        "44136fa355b3678a1146ad16f7e8649e94fb4fc21fe77e8310c060f61caaff8a");
    size_t length;
    assert_string_equal(glint_revision_native(revision, &length), "{}");
    assert_int_equal(length, 2);
    drop(revision);
    finish(store);
}

static void putting_says_whether_the_name_is_new(void **state)
{
    (void)state;
    glint_store *store = make();
    glint_revision *revision;
    bool created;
    assert_int_equal(put_if(store, "a", one, NULL, &revision, &created), GLINT_OK);
    assert_true(created);
    drop(revision);
    assert_int_equal(put_if(store, "a", two, NULL, &revision, &created), GLINT_OK);
    assert_false(created);
    drop(revision);
    finish(store);
}

static void an_equal_scene_keeps_its_revision_and_is_not_built_twice(void **state)
{
    (void)state;
    glint_store *store = make();
    glint_revision *first = put(store, "a", one);
    glint_revision *again = put(store, "a", one);
    assert_ptr_equal(first, again);
    assert_int_equal(fake_scene_residents(), 1);
    assert_int_equal(fake_scene_imports(), 1);
    drop(first);
    drop(again);
    finish(store);
}

static void a_replaced_revision_lives_while_it_is_held(void **state)
{
    (void)state;
    glint_store *store = make();
    glint_revision *old = put(store, "a", one);
    drop(put(store, "a", two));
    assert_int_equal(fake_scene_residents(), 2);
    struct glint_store_stats stats;
    glint_store_stats(store, &stats);
    assert_int_equal(stats.scenes, 1);
    assert_int_equal(stats.resident_bytes, 2 * FAKE_RESIDENT_BYTES);
    drop(old);
    assert_int_equal(fake_scene_residents(), 1);
    glint_store_stats(store, &stats);
    assert_int_equal(stats.resident_bytes, FAKE_RESIDENT_BYTES);
    finish(store);
}

static void a_name_of_other_characters_is_refused_before_the_import(void **state)
{
    (void)state;
    static const char *const bad[] = {"", "a/b", "a b", "\xc3\xa9", "%41", "a\n"};
    char longest[130];
    memset(longest, 'x', sizeof longest);
    longest[129] = '\0';
    glint_store *store = make();
    glint_revision *revision;
    bool created;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(put_if(store, bad[i], one, NULL, &revision, &created), GLINT_E_RANGE);
    assert_int_equal(put_if(store, longest, one, NULL, &revision, &created), GLINT_E_RANGE);
    assert_null(revision);
    longest[128] = '\0';
    drop(put(store, longest, one));
    struct glint_store_stats stats;
    glint_store_stats(store, &stats);
    assert_int_equal(stats.imports, 1);
    finish(store);
}

static void a_failed_import_or_build_leaves_the_scene_as_it_was(void **state)
{
    (void)state;
    glint_store *store = make();
    glint_revision *revision, *before = put(store, "a", one);
    bool created;
    assert_int_equal(put_if(store, "a", "bad file", NULL, &revision, &created), GLINT_E_SYNTAX);
    assert_null(revision);
    assert_int_equal(put_if(store, "a", "{\"camera\": 1}", NULL, &revision, &created),
                     GLINT_E_RANGE);
    fake_scene_fail(GLINT_E_CAPACITY);
    assert_int_equal(put_if(store, "a", two, NULL, &revision, &created), GLINT_E_CAPACITY);
    assert_int_equal(put_if(store, "b", "bad file", NULL, &revision, &created), GLINT_E_SYNTAX);
    assert_int_equal(glint_store_get(store, "a", &revision, NULL), GLINT_OK);
    assert_ptr_equal(revision, before);
    drop(revision);
    assert_int_equal(glint_store_get(store, "b", &revision, NULL), GLINT_E_NOT_FOUND);
    assert_null(revision);
    struct glint_store_stats stats;
    glint_store_stats(store, &stats);
    assert_int_equal(stats.imports, 5);
    assert_int_equal(stats.import_failures, 4);
    drop(before);
    finish(store);
}

static void if_match_guards_against_lost_updates(void **state)
{
    (void)state;
    glint_store *store = make();
    glint_revision *revision, *old = put(store, "a", one);
    bool created;
    char id[65];
    strcpy(id, glint_revision_id(old));
    drop(old);
    assert_int_equal(put_if(store, "none", one, id, &revision, &created), GLINT_E_STALE);
    assert_int_equal(put_if(store, "a", two, id, &revision, &created), GLINT_OK);
    drop(revision);
    assert_int_equal(put_if(store, "a", one, id, &revision, &created), GLINT_E_STALE);
    assert_int_equal(delete (store, "a", id, false), GLINT_E_STALE);
    finish(store);
}

struct guarded {
    glint_store *store;
    const char *id;
    glint_status status;
};

static void *put_guarded(void *arg)
{
    struct guarded *g = arg;
    glint_revision *revision;
    bool created;
    g->status = put_if(g->store, "a", dark, g->id, &revision, &created);
    return NULL;
}

static void if_match_is_judged_again_when_the_import_is_over(void **state)
{
    (void)state;
    glint_store *store = make();
    glint_revision *old = put(store, "a", one);
    struct guarded guarded = {.store = store, .id = glint_revision_id(old)};
    pthread_t thread;
    fake_scene_hold(true);
    assert_int_equal(glint_thread_start(&thread, "put", put_guarded, &guarded, NULL), GLINT_OK);
    fake_scene_waiting(); // it has passed the first look and imports
    assert_int_equal(delete (store, "a", NULL, false), GLINT_OK);
    fake_scene_hold(false);
    pthread_join(thread, NULL);
    assert_int_equal(guarded.status, GLINT_E_STALE);
    drop(old);
    finish(store);
}

static void a_scene_in_use_is_deleted_only_by_force(void **state)
{
    (void)state;
    glint_store *store = make();
    glint_revision *revision = put(store, "a", one);
    glint_revision_use(revision, 1);
    assert_int_equal(delete (store, "a", NULL, false), GLINT_E_CONFLICT);
    drop(put(store, "a", two)); // the job stays on the revision before
    assert_int_equal(delete (store, "a", NULL, false), GLINT_E_CONFLICT);
    glint_revision_use(revision, -1);
    assert_int_equal(delete (store, "a", NULL, false), GLINT_OK);
    assert_int_equal(delete (store, "a", NULL, false), GLINT_E_NOT_FOUND);
    drop(revision);

    revision = put(store, "a", one);
    glint_revision_use(revision, 1);
    assert_int_equal(delete (store, "a", NULL, true), GLINT_OK);
    assert_int_equal(fake_scene_residents(), 1); // the job's
    glint_revision_use(revision, -1);
    drop(revision);
    finish(store);
}

static double number(const cJSON *object, const char *name)
{
    return cJSON_GetNumberValue(cJSON_GetObjectItemCaseSensitive(object, name));
}

static void the_resource_has_the_members_of_the_protocol(void **state)
{
    (void)state;
    glint_store *store = make();
    glint_revision *revision = put(store, "a", dark);
    cJSON *r = glint_revision_resource(revision);
    assert_string_equal(cJSON_GetObjectItem(r, "name")->valuestring, "a");
    assert_string_equal(cJSON_GetObjectItem(r, "revision")->valuestring,
                        glint_revision_id(revision));
    assert_true(number(r, "triangles") == 12);
    assert_true(number(r, "instances") == 1);
    assert_true(number(r, "objects") == 1);
    assert_true(number(r, "materials") == 1);
    assert_true(number(r, "lights") == 1);
    assert_true(number(r, "resident_bytes") == FAKE_RESIDENT_BYTES);
    const cJSON *cameras = cJSON_GetObjectItem(r, "cameras");
    assert_int_equal(cJSON_GetArraySize(cameras), 1);
    assert_string_equal(cJSON_GetArrayItem(cameras, 0)->valuestring, "Front");
    assert_string_equal(cJSON_GetArrayItem(cJSON_GetObjectItem(r, "effects"), 0)->valuestring,
                        "transmission");
    assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(r, "warnings")), 1);
    assert_true(number(cJSON_GetObjectItem(r, "seconds"), "import") == 0.25);
    cJSON_Delete(r);
    drop(revision);
    finish(store);
}

static void scenes_are_listed_by_name(void **state)
{
    (void)state;
    static const char *const name[] = {"b", "c", "a"};
    glint_store *store = make();
    for (int i = 0; i < 3; i++)
        drop(put(store, name[i], one));
    assert_int_equal(delete (store, "b", NULL, false), GLINT_OK);
    cJSON *list = glint_store_list(store);
    const cJSON *scenes = cJSON_GetObjectItem(list, "scenes");
    assert_int_equal(cJSON_GetArraySize(scenes), 2);
    for (int i = 0; i < 2; i++)
        assert_string_equal(cJSON_GetObjectItem(cJSON_GetArrayItem(scenes, i), "name")->valuestring,
                            i ? "c" : "a");
    cJSON_Delete(list);
    finish(store);
}

static void *put_and_get(void *store)
{
    for (int i = 0; i < 40; i++) {
        glint_revision *revision;
        drop(put(store, i % 3 ? "a" : "b", i % 2 ? one : two));
        if (!glint_store_get(store, "a", &revision, NULL))
            drop(revision);
        delete (store, i % 5 ? "c" : "a", NULL, false);
    }
    return NULL;
}

static void threads_put_get_and_delete_at_once(void **state)
{
    (void)state;
    glint_store *store = make();
    pthread_t thread[3];
    for (int i = 0; i < 3; i++)
        assert_int_equal(glint_thread_start(&thread[i], "put", put_and_get, store, NULL), GLINT_OK);
    for (int i = 0; i < 3; i++)
        pthread_join(thread[i], NULL);
    finish(store);
}

static glint_status patch(glint_store *store, const char *text, const char *if_match,
                          glint_revision **out, struct glint_patch_report *report)
{
    return glint_store_patch(store, "a", text, strlen(text), if_match, out, report, NULL);
}

static void a_patch_makes_a_revision_and_tells_of_it(void **state)
{
    (void)state;
    glint_store *store = make();
    glint_revision *old = put(store, "a", one), *new, *same;
    struct glint_patch_report report;
    assert_int_equal(patch(store, "{\"environment\": {\"radiance\": [2, 2, 2]}}",
                           glint_revision_id(old), &new, &report),
                     GLINT_OK);
    assert_true(report.changed);
    assert_string_not_equal(glint_revision_id(new), glint_revision_id(old));
    assert_int_equal(patch(store, "{}", glint_revision_id(old), &same, &report), GLINT_E_STALE);
    assert_int_equal(patch(store, "{}", NULL, &same, &report), GLINT_OK);
    assert_false(report.changed);
    assert_ptr_equal(same, new);
    cJSON *changes = glint_patch_describe(&report);
    assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(changes, "kept")), GLINT_PARTS);
    cJSON_Delete(changes);
    drop(same);
    drop(new);
    drop(old);
    finish(store);
}

#define PATCHES 24

static void *patch_often(void *arg)
{
    glint_store *store = arg;
    static atomic_int turn;
    for (int i = 0; i < PATCHES; i++) {
        char text[80];
        glint_revision *revision;
        struct glint_patch_report report;
        snprintf(text, sizeof text, "{\"materials\": {\"m%d\": {}}}", atomic_fetch_add(&turn, 1));
        assert_int_equal(patch(store, text, NULL, &revision, &report), GLINT_OK);
        assert_true(report.changed);
        drop(revision);
    }
    return NULL;
}

static void patches_of_several_threads_are_all_applied(void **state)
{
    (void)state;
    glint_store *store = make();
    pthread_t thread[3];
    glint_revision *revision;
    drop(put(store, "a", one));
    for (int i = 0; i < 3; i++)
        assert_int_equal(glint_thread_start(&thread[i], "patch", patch_often, store, NULL),
                         GLINT_OK);
    for (int i = 0; i < 3; i++)
        pthread_join(thread[i], NULL);
    assert_int_equal(glint_store_get(store, "a", &revision, NULL), GLINT_OK);
    assert_int_equal(glint_resident_scene(glint_revision_resident(revision))->materials,
                     1 + 3 * PATCHES);
    drop(revision);
    finish(store);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_patch_makes_a_revision_and_tells_of_it),
        cmocka_unit_test(patches_of_several_threads_are_all_applied),
        cmocka_unit_test(the_revision_is_the_hash_of_the_canonical_text),
        cmocka_unit_test(putting_says_whether_the_name_is_new),
        cmocka_unit_test(an_equal_scene_keeps_its_revision_and_is_not_built_twice),
        cmocka_unit_test(a_replaced_revision_lives_while_it_is_held),
        cmocka_unit_test(a_name_of_other_characters_is_refused_before_the_import),
        cmocka_unit_test(a_failed_import_or_build_leaves_the_scene_as_it_was),
        cmocka_unit_test(if_match_guards_against_lost_updates),
        cmocka_unit_test(if_match_is_judged_again_when_the_import_is_over),
        cmocka_unit_test(a_scene_in_use_is_deleted_only_by_force),
        cmocka_unit_test(the_resource_has_the_members_of_the_protocol),
        cmocka_unit_test(scenes_are_listed_by_name),
        cmocka_unit_test(threads_put_get_and_delete_at_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
