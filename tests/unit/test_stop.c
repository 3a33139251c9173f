// When a job stops, and how one that has stopped goes on: over stand-ins.
#include "jobs_fixture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>

#define WIDE "'resolution': [4, 1]"

static double stop_of(struct fixture *f, const char *id, const char *member)
{
    cJSON *job = glint_jobs_describe(f->jobs, id, NULL);
    const cJSON *stop = cJSON_GetObjectItem(cJSON_GetObjectItem(job, "job"), "stop");
    const cJSON *item = cJSON_GetObjectItem(stop, member);
    const double value = item ? item->valuedouble : NAN;
    cJSON_Delete(job);
    return value;
}

static glint_status forget_or_cancel(struct fixture *f, const char *id)
{
    bool forgotten;
    return glint_jobs_delete(f->jobs, id, &forgotten, NULL);
}

static void a_finished_job_goes_on_and_does_not_start_again(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 2);
    const char *id = fixture_submit(&f, "{'scene': 's', " WIDE ", 'stop': {'samples': 3}}");
    fixture_wait(&f, id, GLINT_JOB_DONE);
    assert_int_equal(fake_begun_now(), 12);
    assert_int_equal(fixture_patch(&f, id, "{'stop': {'samples': 5}}"), GLINT_OK);
    fixture_wait(&f, id, GLINT_JOB_DONE);
    assert_true(fixture_number(&f, id, "samples") == 5);
    assert_true(stop_of(&f, id, "samples") == 5);
    assert_int_equal(fake_begun_now(), 20); // two more of each, none twice
    assert_int_equal(fake_creates(), 1);
    fixture_stop(&f);
}

static void a_finished_job_keeps_its_scene_in_use_while_it_goes_on(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    const char *id = fixture_submit(&f, "{'scene': 's', " WIDE ", 'stop': {'samples': 1}}");
    fixture_wait(&f, id, GLINT_JOB_DONE);
    fake_close_gate();
    assert_int_equal(fixture_patch(&f, id, "{'stop': {'samples': 2}}"), GLINT_OK);
    assert_int_equal(glint_store_delete(f.store, "s", NULL, false, NULL), GLINT_E_CONFLICT);
    fake_open_gate();
    fixture_wait(&f, id, GLINT_JOB_DONE);
    assert_int_equal(glint_store_delete(f.store, "s", NULL, false, NULL), GLINT_OK);
    assert_int_equal(fixture_patch(&f, id, "{'stop': {'samples': 3}}"), GLINT_OK); // it has its own
    fixture_wait(&f, id, GLINT_JOB_DONE);
    fixture_stop(&f);
}

static void a_job_that_renders_takes_more_and_fewer_samples(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_close_gate();
    const char *id = fixture_submit(&f, "{'scene': 's', " WIDE ", 'stop': {'samples': 9}}");
    fake_let(5);
    fake_begun(6, NULL); // the second sample is under way
    assert_int_equal(fixture_patch(&f, id, "{'stop': {'samples': 1}}"), GLINT_E_CONFLICT);
    assert_true(stop_of(&f, id, "samples") == 9);
    assert_int_equal(fixture_patch(&f, id, "{'stop': {'samples': 3}}"), GLINT_OK);
    assert_true(fixture_number(&f, id, "target_samples") == 3);
    fake_open_gate();
    fixture_wait(&f, id, GLINT_JOB_DONE);
    assert_int_equal(fake_begun_now(), 12);
    fixture_stop(&f);
}

static void a_stop_given_in_the_queue_holds_for_the_film_that_is_made(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_hold_create(true);
    const char *id = fixture_submit(&f, "{'scene': 's', " WIDE ", 'stop': {'samples': 9}}");
    fake_wait_create();
    assert_int_equal(fixture_patch(&f, id, "{'stop': {'samples': 2}}"), GLINT_OK);
    fake_hold_create(false);
    fixture_wait(&f, id, GLINT_JOB_DONE);
    assert_int_equal(fake_begun_now(), 8);
    fixture_stop(&f);
}

static void a_cancelled_job_goes_on_when_it_is_given_a_stop(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_close_gate();
    const char *id = fixture_submit(&f, "{'scene': 's', " WIDE ", 'stop': {'samples': 2}}");
    fake_let(3);
    fake_begun(4, NULL);
    assert_int_equal(forget_or_cancel(&f, id), GLINT_OK);
    fixture_wait(&f, id, GLINT_JOB_CANCELLED);
    fake_open_gate();
    assert_int_equal(fixture_patch(&f, id, "{'paused': false}"), GLINT_E_CONFLICT);
    assert_int_equal(fixture_patch(&f, id, "{'stop': {'samples': 2}}"), GLINT_OK);
    fixture_wait(&f, id, GLINT_JOB_DONE);
    assert_int_equal(fake_begun_now(), 9); // the one that was given up is run again
    fixture_stop(&f);
}

static void one_cancelled_before_it_had_a_film_gets_one(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    const char *id = fixture_submit(&f, "{'scene': 's', 'seed': 1, " WIDE "}");
    fake_hold_create(true);
    const char *late =
        fixture_submit(&f, "{'scene': 's', 'seed': 2, " WIDE ", 'stop': {'samples': 2}}");
    fake_wait_create();
    assert_int_equal(forget_or_cancel(&f, late), GLINT_OK);
    assert_int_equal(fixture_state(&f, late), GLINT_JOB_CANCELLED);
    assert_int_equal(fixture_patch(&f, late, "{'stop': {'samples': 4}, 'priority': 3}"), GLINT_OK);
    assert_int_equal(fixture_state(&f, late), GLINT_JOB_QUEUED);
    fake_hold_create(false);
    fixture_wait(&f, late, GLINT_JOB_DONE);
    assert_true(fixture_number(&f, late, "samples") == 4);
    assert_true(fixture_number(&f, late, "priority") == 3);
    fixture_wait(&f, id, GLINT_JOB_DONE);
    fixture_stop(&f);
}

static void a_job_may_be_given_more_and_wait_in_one_patch(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    const char *id = fixture_submit(&f, "{'scene': 's', " WIDE ", 'stop': {'samples': 1}}");
    fixture_wait(&f, id, GLINT_JOB_DONE);
    assert_int_equal(fixture_patch(&f, id, "{'stop': {'samples': 2}, 'paused': true}"), GLINT_OK);
    assert_int_equal(fixture_state(&f, id), GLINT_JOB_PAUSED);
    assert_int_equal(fake_begun_now(), 4);
    assert_int_equal(fixture_patch(&f, id, "{'paused': false}"), GLINT_OK);
    fixture_wait(&f, id, GLINT_JOB_DONE);
    assert_int_equal(fake_begun_now(), 8);
    fixture_stop(&f);
}

static void the_same_stop_said_twice_is_no_fault(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    const char *id = fixture_submit(&f, "{'scene': 's', " WIDE ", 'stop': {'samples': 1}}");
    fixture_wait(&f, id, GLINT_JOB_DONE);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(fixture_patch(&f, id, "{'stop': {'samples': 2}}"), GLINT_OK);
        fixture_wait(&f, id, GLINT_JOB_DONE);
    }
    assert_int_equal(fake_begun_now(), 8);
    assert_int_equal(fixture_patch(&f, id, "{'stop': {'samples': 1}}"), GLINT_E_CONFLICT);
    assert_true(stop_of(&f, id, "samples") == 2);
    fixture_stop(&f);
}

static void a_failed_job_does_not_go_on(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_fail_slice(1);
    const char *id = fixture_submit(&f, "{'scene': 's', 'seed': 1, " WIDE "}");
    fixture_wait(&f, id, GLINT_JOB_FAILED);
    assert_int_equal(fixture_patch(&f, id, "{'stop': {'samples': 999}}"), GLINT_E_CONFLICT);
    fixture_stop(&f);
}

// Has one sample of four pixels, and each worker is at a pixel of the second.
static const char *late_job(struct fixture *f, uint32_t workers)
{
    fixture_start(f, workers);
    fake_close_gate();
    fake_deafen();
    const char *id = fixture_submit(f, "{'scene': 's', " WIDE ", 'stop': {'samples': 3}}");
    fake_let(4);
    fake_begun(4 + workers, NULL);
    assert_int_equal(fixture_patch(f, id, "{'stop': {'seconds': 1e-3}}"), GLINT_OK);
    fixture_wait(f, id, GLINT_JOB_DONE);
    return id;
}

static void time_is_over_without_a_worker_that_gets_no_processor(void **state)
{
    (void)state;
    struct fixture f;
    const char *id = late_job(&f, 1);
    assert_int_equal(fake_begun_now(), 5); // it is there still
    assert_true(fixture_number(&f, id, "samples") == 1);
    const double seconds = fixture_number(&f, id, "cpu_seconds");
    assert_int_equal(fixture_patch(&f, id, "{'stop': {'samples': 2, 'seconds': null}}"), GLINT_OK);
    fake_open_gate();
    fixture_wait(&f, id, GLINT_JOB_DONE);
    assert_int_equal(fake_begun_now(), 9); // what was taken away is run again
    assert_true(fixture_number(&f, id, "samples") == 2);
    assert_true(fixture_number(&f, id, "cpu_seconds") >= seconds);
    fixture_stop(&f);
}

static void a_job_may_be_forgotten_before_its_worker_notices(void **state)
{
    (void)state;
    struct fixture f;
    const char *id = late_job(&f, 1);
    assert_int_equal(forget_or_cancel(&f, id), GLINT_OK);
    assert_null(glint_jobs_describe(f.jobs, id, NULL));
    assert_int_equal(fake_renders(), 1);
    const char *next = fixture_submit(&f, "{'scene': 's', " WIDE ", 'stop': {'samples': 1}}");
    fake_open_gate();
    fixture_wait(&f, next, GLINT_JOB_DONE); // behind it, at the same worker
    fixture_stop(&f);
}

static void the_daemon_ends_while_a_worker_has_not_noticed(void **state)
{
    (void)state;
    struct fixture f;
    late_job(&f, 2);
    fixture_stop(&f);
}

static void before_the_first_whole_sample_what_is_out_is_waited_for(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_close_gate();
    const char *id = fixture_submit(&f, "{'scene': 's', " WIDE ", 'stop': {'samples': 3}}");
    fake_begun(1, NULL);
    assert_int_equal(fixture_patch(&f, id, "{'stop': {'seconds': 1e-3}}"), GLINT_OK);
    while (fixture_patch(&f, id, "{'priority': 1}") == GLINT_OK) // until it is about to be done
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    assert_int_equal(fixture_state(&f, id), GLINT_JOB_RENDERING);
    fake_open_gate();
    fixture_wait(&f, id, GLINT_JOB_DONE);
    assert_int_equal(fake_begun_now(), 1);
    assert_true(fixture_number(&f, id, "progress") > 0);
    fixture_stop(&f);
}

// What was being prepared when the time was over is taken away a little later.
static void a_slice_taken_away_while_the_job_ends_is_the_end_of_it(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_close_gate();
    fake_deafen();
    const char *id = fixture_submit(&f, "{'scene': 's', " WIDE ", 'stop': {'samples': 3}}");
    fake_let(3);
    fake_begun(4, NULL);
    fake_hold_prepare(true);
    fake_let(1);
    fake_begun(5, NULL); // the first of the second sample
    assert_int_equal(fixture_patch(&f, id, "{'stop': {'seconds': 1e-3}}"), GLINT_OK);
    while (fixture_patch(&f, id, "{'priority': 1}") == GLINT_OK) // until it is about to be done
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    assert_int_equal(fixture_state(&f, id), GLINT_JOB_RENDERING);
    fake_hold_prepare(false);
    for (int i = 0; i < 5000 && fixture_state(&f, id) != GLINT_JOB_DONE; i++) {
        fixture_patch(&f, id, "{'priority': 1}"); // has the scheduler look again
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    }
    assert_int_equal(fixture_state(&f, id), GLINT_JOB_DONE);
    assert_true(fixture_number(&f, id, "samples") == 1);
    fixture_stop(&f);
}

static void null_takes_a_limit_away(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    fake_close_gate();
    const char *id = fixture_submit(&f, "{'scene': 's', " WIDE ", 'stop': {'samples': 3,"
                                        " 'seconds': 500, 'error': 0.5}}");
    fixture_wait(&f, id, GLINT_JOB_RENDERING);
    assert_int_equal(fixture_patch(&f, id, "{'stop': {'samples': null, 'error': 0.25}}"), GLINT_OK);
    assert_true(isnan(stop_of(&f, id, "samples")));
    assert_true(isnan(fixture_number(&f, id, "target_samples")));
    assert_true(stop_of(&f, id, "seconds") == 500);
    assert_true(stop_of(&f, id, "error") == 0.25);
    assert_int_equal(fixture_patch(&f, id, "{'stop': null}"), GLINT_OK);
    assert_true(stop_of(&f, id, "samples") == GLINT_DEFAULT_SAMPLES);
    assert_true(isnan(stop_of(&f, id, "seconds")));
    assert_true(isnan(stop_of(&f, id, "error")));
    fixture_stop(&f);
}

static void a_live_job_refines_what_it_shows_when_it_is_given_more(void **state)
{
    (void)state;
    struct fixture f;
    fixture_start(&f, 1);
    const char *id =
        fixture_submit(&f, "{'scene': 's', 'live': true, " WIDE ", 'stop': {'samples': 2}}");
    fake_begun(8, NULL);
    while (fixture_number(&f, id, "progress") != 1)
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    assert_int_equal(fixture_patch(&f, id, "{'stop': {'samples': 5}}"), GLINT_OK);
    fake_begun(20, NULL);
    assert_int_equal(fake_restarts(), 0);
    fixture_stop(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_finished_job_goes_on_and_does_not_start_again),
        cmocka_unit_test(a_finished_job_keeps_its_scene_in_use_while_it_goes_on),
        cmocka_unit_test(a_job_that_renders_takes_more_and_fewer_samples),
        cmocka_unit_test(a_stop_given_in_the_queue_holds_for_the_film_that_is_made),
        cmocka_unit_test(a_cancelled_job_goes_on_when_it_is_given_a_stop),
        cmocka_unit_test(one_cancelled_before_it_had_a_film_gets_one),
        cmocka_unit_test(a_job_may_be_given_more_and_wait_in_one_patch),
        cmocka_unit_test(the_same_stop_said_twice_is_no_fault),
        cmocka_unit_test(a_failed_job_does_not_go_on),
        cmocka_unit_test(time_is_over_without_a_worker_that_gets_no_processor),
        cmocka_unit_test(a_job_may_be_forgotten_before_its_worker_notices),
        cmocka_unit_test(the_daemon_ends_while_a_worker_has_not_noticed),
        cmocka_unit_test(before_the_first_whole_sample_what_is_out_is_waited_for),
        cmocka_unit_test(a_slice_taken_away_while_the_job_ends_is_the_end_of_it),
        cmocka_unit_test(null_takes_a_limit_away),
        cmocka_unit_test(a_live_job_refines_what_it_shows_when_it_is_given_more),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
