// Live jobs over stand-ins: when they idle, move, stay and end.
#include "jobs_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>

#define LIVE \
    "{'scene': 's', 'live': true, 'resolution': [4, 1], 'stop': {'samples': 3}, 'seed': %d}"

static void doze(void)
{
    nanosleep(&(struct timespec){.tv_nsec = 5000000}, NULL);
}

static void wait_idle(struct fixture *f, const char *id)
{
    while (fixture_number(f, id, "progress") != 1)
        doze();
}

static void edit(struct fixture *f, const char *text)
{
    glint_revision *revision;
    struct glint_patch_report report;
    assert_int_equal(
        glint_store_patch(f->store, "s", text, strlen(text), NULL, &revision, &report, NULL),
        GLINT_OK);
    glint_revision_release(&revision);
}

static void move(struct fixture *f, const char *id, double yfov)
{
    char text[64];
    snprintf(text, sizeof text, "{'camera': {'yfov': %g}}", yfov);
    assert_int_equal(fixture_patch(f, id, text), GLINT_OK);
}

static void a_live_job_idles_at_its_stop_and_is_not_done(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 2);
    const char *id = fixture_submit(&f, LIVE, 1);
    wait_idle(&f, id);
    assert_int_equal(fixture_state(&f, id), GLINT_JOB_RENDERING);
    assert_int_equal(fake_begun_now(), 12);
    const double seconds = fixture_number(&f, id, "seconds");
    doze();
    assert_true(fixture_number(&f, id, "seconds") == seconds);
    assert_true(fixture_number(&f, id, "eta_seconds") == 0);
    fixture_stop(&f);
}

static void a_camera_restarts_it_and_the_last_of_many_counts(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 2);
    const char *id = fixture_submit(&f, LIVE, 1);
    wait_idle(&f, id);
    fake_hold_move(true);
    move(&f, id, 0.25);
    fake_wait_moves(1);
    for (int i = 1; i <= 8; i++)
        move(&f, id, 0.25 + i / 16.0);
    fake_hold_move(false);
    assert_true(fake_wait_restarts(2) == 0.75f);
    assert_int_equal(fake_moves(), 2);
    wait_idle(&f, id);
    fixture_stop(&f);
}

static void a_new_revision_restarts_only_the_live_jobs_of_its_scene(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 2);
    fake_close_gate();
    const char *live = fixture_submit(&f, LIVE, 1);
    const char *batch = fixture_submit(&f, "{'scene': 's', 'resolution': [4, 1], 'seed': 2,"
                                           " 'stop': {'samples': 3}}");
    fake_begun(1, NULL);
    edit(&f, "{\"materials\": {\"m\": {\"roughness\": 0.25}}}");
    fake_open_gate();
    fake_wait_restarts(1);
    fixture_wait(&f, batch, GLINT_JOB_DONE);
    wait_idle(&f, live);
    assert_int_equal(fake_restarts(), 1);
    fixture_stop(&f);
}

static void the_old_view_is_refined_until_the_new_one_is_ready(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_close_gate();
    const char *id = fixture_submit(&f, LIVE, 1);
    fake_begun(1, NULL);
    fake_hold_move(true);
    move(&f, id, 0.75);
    fake_wait_moves(1);
    fake_let(6);
    fake_begun(7, NULL); // slices go on while the view is made
    assert_int_equal(fake_restarts(), 0);
    fake_hold_move(false);
    fake_open_gate();
    assert_true(fake_wait_restarts(1) == 0.75f);
    wait_idle(&f, id);
    fixture_stop(&f);
}

static void a_move_that_fails_leaves_it_where_it_is_with_a_warning(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 2);
    const char *id = fixture_submit(&f, LIVE, 1);
    wait_idle(&f, id);
    fake_fail_move(1);
    move(&f, id, 0.75);
    int warnings = 0;
    while (!warnings) {
        cJSON *job = glint_jobs_describe(f.jobs, id, NULL);
        warnings = cJSON_GetArraySize(cJSON_GetObjectItem(job, "warnings"));
        cJSON_Delete(job);
    }
    assert_int_equal(fake_restarts(), 0);
    move(&f, id, 0.5);
    assert_true(fake_wait_restarts(1) == 0.5f);
    wait_idle(&f, id);
    cJSON *job = glint_jobs_describe(f.jobs, id, NULL);
    assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(job, "warnings")), 0);
    cJSON_Delete(job);
    fixture_stop(&f);
}

static void a_camera_is_for_live_jobs_and_must_exist(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 2);
    const char *live = fixture_submit(&f, LIVE, 1);
    const char *batch = fixture_submit(&f, "{'scene': 's', 'seed': 2, 'stop': {'samples': 1}}");
    assert_int_equal(fixture_patch(&f, batch, "{'camera': 'Front'}"), GLINT_E_RANGE);
    assert_int_equal(fixture_patch(&f, live, "{'camera': 'Back'}"), GLINT_E_RANGE);
    assert_int_equal(fixture_patch(&f, live, "{'camera': 3}"), GLINT_E_RANGE);
    assert_int_equal(fixture_patch(&f, live, "{'stop': {'error': 0.1}}"), GLINT_E_RANGE);
    assert_int_equal(fixture_patch(&f, live, "{'camera': 'Front'}"), GLINT_OK);
    assert_int_equal(fixture_patch(&f, live, "{'camera': null}"), GLINT_OK);
    fixture_stop(&f);
}

static void it_ends_while_a_move_is_under_way(void **state)
{
    (void)state;
    struct fixture f;
    bool forgotten;
    fixture_start(&f, 2);
    const char *id = fixture_submit(&f, LIVE, 1);
    wait_idle(&f, id);
    fake_hold_move(true);
    move(&f, id, 0.75);
    fake_wait_moves(1);
    assert_int_equal(glint_jobs_delete(f.jobs, id, &forgotten, NULL), GLINT_OK);
    fixture_wait(&f, id, GLINT_JOB_CANCELLED);
    assert_int_equal(glint_jobs_delete(f.jobs, id, &forgotten, NULL), GLINT_OK);
    assert_true(forgotten);
    fake_hold_move(false);
    fixture_stop(&f);
}

static void a_paused_one_moves_and_renders_when_it_goes_on(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 2);
    const char *id = fixture_submit(&f, LIVE, 1);
    wait_idle(&f, id);
    assert_int_equal(fixture_patch(&f, id, "{'paused': true}"), GLINT_OK);
    move(&f, id, 0.75);
    fake_wait_restarts(1);
    assert_int_equal(fake_begun_now(), 12);
    assert_int_equal(fixture_patch(&f, id, "{'paused': false}"), GLINT_OK);
    fake_begun(24, NULL);
    wait_idle(&f, id);
    fixture_stop(&f);
}

static void edits_cameras_and_cancels_at_once_break_no_rule(void **state)
{
    (void)state;
    struct fixture f;
    char id[4][GLINT_JOB_ID_BYTES];
    fixture_start(&f, 3);
    for (int i = 0; i < 4; i++)
        strcpy(id[i], fixture_submit(&f, LIVE, i + 1));
    for (int i = 0; i < 100; i++) {
        char text[80];
        snprintf(text, sizeof text, "{\"materials\": {\"m\": {\"roughness\": %g}}}", i / 128.0);
        edit(&f, text);
        move(&f, id[i % 4], 0.5 + i / 256.0);
        if (i % 10 == 0)
            fixture_patch(&f, id[i / 10 % 4], i % 20 ? "{'paused': false}" : "{'paused': true}");
    }
    for (int i = 0; i < 4; i++) {
        fixture_patch(&f, id[i], "{'paused': false}");
        wait_idle(&f, id[i]);
    }
    bool forgotten;
    assert_int_equal(glint_jobs_delete(f.jobs, id[0], &forgotten, NULL), GLINT_OK);
    fixture_stop(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_live_job_idles_at_its_stop_and_is_not_done),
        cmocka_unit_test(a_camera_restarts_it_and_the_last_of_many_counts),
        cmocka_unit_test(a_new_revision_restarts_only_the_live_jobs_of_its_scene),
        cmocka_unit_test(the_old_view_is_refined_until_the_new_one_is_ready),
        cmocka_unit_test(a_move_that_fails_leaves_it_where_it_is_with_a_warning),
        cmocka_unit_test(a_camera_is_for_live_jobs_and_must_exist),
        cmocka_unit_test(it_ends_while_a_move_is_under_way),
        cmocka_unit_test(a_paused_one_moves_and_renders_when_it_goes_on),
        cmocka_unit_test(edits_cameras_and_cancels_at_once_break_no_rule),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
